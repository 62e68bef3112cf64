"""Coefficients of a still cylinder in an inflow, as the benchmark defines them (Schäfer & Turek 1996).

    cD, cL = 2 F / (rho Ubar² D),   St = f D / Ubar,   dp = p at the front − p at the back of the cylinder

with the force F per metre of depth, the mean velocity Ubar of the inflow after its ramp, and the diameter D.
"""

from dataclasses import dataclass

import numpy as np

from nervure.evaluate import statistics
from nervure.evaluate.statistics import Series
from nervure.scene.facts import Facts
from nervure.scene.types import Reference

NAMES = ("cd_max", "cd_min", "cd_mean", "cl_max", "cl_min", "cl_mean", "cl_peak_to_peak", "st", "dp_mean")
"""Coefficients; a mean is (max + min) / 2. A steady flow has means alone; `dp_mean` needs probes at the front and the
back of the cylinder."""


@dataclass(frozen=True)
class Scale:
    """Scales of forces and frequencies."""

    force: float  # rho Ubar² D / 2, N/m
    frequency: float  # Ubar / D, Hz
    front: str | None
    back: str | None  # Columns of the pressure at the front and the back of the cylinder; None without probes


def scale(facts: Facts) -> Scale | None:
    """Return the scale of a scene; None unless it has one still cylinder in an inflow that becomes steady."""
    scene, fluid = facts.scene, facts.scene.fluid
    if scene.beam or scene.rods or fluid is None or len(fluid.cylinders) != 1 or fluid.inflow is None:
        return None
    (cylinder,), velocity = fluid.cylinders, facts.final_value("fluid.inflow.mean_velocity")
    if cylinder.motion or not velocity:
        return None
    (x, y), radius = cylinder.center, cylinder.radius

    def column(at: float) -> str | None:
        probes = ((probe.name, *probe.position) for probe in fluid.probes)
        near = (f"probe_{name}_p" for name, px, py in probes if np.hypot(px - at, py - y) < 1e-6 * radius)
        return next(near, None)

    ahead = np.sign(velocity) * radius
    return Scale(
        fluid.density * velocity**2 * radius, abs(velocity) / (2 * radius), column(x - ahead), column(x + ahead)
    )


def curves(scale: Scale, series: Series, width: float = 0.0) -> dict[str, np.ndarray]:
    """Return cD and cL over time, and with probes dp (Pa), under a box filter of `width` (s)."""
    time = series["time"]
    found = {name: series[force] / scale.force for name, force in (("cd", "drag"), ("cl", "lift"))}
    if scale.front and scale.back:
        found["dp"] = series[scale.front] - series[scale.back]
    return {name: statistics.box_filter(time, values, width) for name, values in found.items()}


def evaluate(
    scale: Scale,
    series: Series,
    window: statistics.Window,
    width: float,
    rounding: float = statistics.ROUNDING["double"],
) -> dict[str, float]:
    """Return the coefficients of a run over the last five periods of `window`: extremes of the drag show a growth that
    the window still allows the lift. `rounding` is the part of the largest force that rounding may move."""
    window = window.last(statistics.MIN_PERIODS)
    time = series["time"]
    forces = np.array([series["drag"], series["lift"]]) / scale.force
    smallest = statistics.smallest_amplitude(time, forces, rounding)
    result = {}
    for name, values in curves(scale, series, width).items():
        found = statistics.evaluate(time, values, window)
        result[f"{name}_mean"] = found.mean
        if window.periods and name != "dp":
            result |= {f"{name}_max": found.mean + found.amplitude, f"{name}_min": found.mean - found.amplitude}
        if window.periods and name == "cl":
            result["cl_peak_to_peak"] = 2 * found.amplitude
            if found.frequency_hz is not None and found.amplitude > smallest:
                result["st"] = found.frequency_hz / scale.frequency
    return {name: result[name] for name in NAMES if name in result}


def published(reference: Reference | None) -> dict[str, float]:
    """Return the published coefficients of a scene; a missing mean is the mean of the extremes."""
    given = reference.coefficients if reference else None
    values = {name: value for name in NAMES if given and (value := getattr(given, name)) is not None}
    if {"cd_max", "cd_min"} <= values.keys():
        values.setdefault("cd_mean", (values["cd_max"] + values["cd_min"]) / 2)
    return values
