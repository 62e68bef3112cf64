"""What a driven root does with its rod: thrust, lift, power, efficiency, tip path and phase lag, as cycle averages.

Thrust is the force of the fluid on the beam against the stream, or against x in still fluid; lift is that along y.
Power in comes from the drive at the root. What is averaged are whole periods of the drive, by the trapezoidal rule.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nervure.evaluate import statistics
from nervure.evaluate.statistics import Window
from nervure.recorder import Record
from nervure.scene import Scene
from nervure.scene.types import TimeLaw, TimeLawCosineRamp, TimeLawSteady

AXES = "xyz"

BALANCE = {"root": "root_power", "load": "load_power", "damping": "damping_power"}
ENERGIES = ("energy_elastic", "energy_kinetic", "energy_gravity")


@dataclass(frozen=True, kw_only=True)
class Flapping:
    """Cycle averages of a driven root and its rod; what there is no fluid for is None."""

    axis: str  # Along which the tip goes farthest
    window_s: tuple[float, float]  # Whole periods of the drive, s
    periods: int
    power_in: float  # W per metre of depth, or W in space
    thrust: float | None = None  # N/m
    lift: float | None = None  # N/m
    stream: tuple[float, float] | None = None  # Velocity, m/s; None in still fluid
    efficiency: float | None = None  # Thrust times stream by power; None in still fluid
    thrust_by_power: float | None = None  # s/m; in still fluid only
    tip_amplitude: float  # m
    tip_by_rigid_tip: float
    phase_lag_deg: float
    energy_balance: dict[str, float | None]  # Works, J per metre of depth, and the part that is missing


def main_axis(columns: Sequence[str], column: Callable[[str], np.ndarray]) -> str | None:
    """The axis along which the tip would go farthest on a rigid rod; None where no root is driven."""
    extents = {axis: np.ptp(column(name)) for axis in AXES if (name := f"rigid_tip_u{axis}") in columns}
    return max(extents, key=extents.__getitem__) if extents else None


def drive_window(record: Record, settled: Window) -> Window | None:
    """The last whole periods of the drive, as many as the tip has `settled`; None if there is none."""
    axis = main_axis(record.columns, record.column)
    if axis is None or settled.periods == 0:
        return None
    window = statistics.find_window(record.column("time"), record.column(f"rigid_tip_u{axis}"))
    return window.last(settled.periods) if window.periods else None


def stream(scene: Scene, window: Window) -> np.ndarray | None:
    """Velocity of the stream over `window`, m/s, `[2]`, where the scene drives one that is steady then; else None."""
    if scene.fluid is None:
        return None
    flow, inflow = scene.fluid.mean_flow, scene.fluid.inflow
    along = (
        [_steady(flow.x, window), _steady(flow.y, window)]
        if flow
        else [_steady(inflow.mean_velocity, window), 0.0]
        if inflow
        else []
    )
    velocity = [value for value in along if value is not None]
    return np.array(velocity) if len(velocity) == 2 and any(velocity) else None


def _steady(law: TimeLaw, window: Window) -> float | None:
    """Value of a law that is steady over `window`; None of another."""
    if isinstance(law, TimeLawSteady):
        return law.steady
    ramp = law.cosine_ramp if isinstance(law, TimeLawCosineRamp) else None
    return ramp.value if ramp and ramp.duration <= window.begin else None


def evaluate(scene: Scene, record: Record, settled: Window) -> Flapping | None:
    """What the root does with its rod, where the tip is `settled`; None without a drive or a whole period."""
    window = drive_window(record, settled)
    axis = main_axis(record.columns, record.column)
    if window is None or axis is None:
        return None
    time = record.column("time")

    def mean(name: str) -> float:
        return average(time, record.column(name), window)

    power = mean("root_power")
    fluid: dict[str, Any] = {}
    if "beam_drag" in record.columns:
        force, velocity = np.array([mean("beam_drag"), mean("beam_lift")]), stream(scene, window)
        ahead = np.array([-1.0, 0.0]) if velocity is None else -velocity / np.linalg.norm(velocity)
        fluid = {"thrust": float(force @ ahead), "lift": float(force[1])}
        if velocity is not None:
            fluid |= {
                "stream": tuple(velocity.tolist()),
                "efficiency": float(-force @ velocity) / power if power else None,
            }
        else:
            fluid["thrust_by_power"] = fluid["thrust"] / power if power else None
    tip, rigid = (harmonic(time, record.column(f"{name}_u{axis}"), window) for name in ("tip", "rigid_tip"))
    return Flapping(
        axis=axis,
        window_s=(window.begin, window.end),
        periods=window.periods,
        power_in=power,
        **fluid,
        tip_amplitude=statistics.extent(record.column(f"tip_u{axis}")[window.of(time)])[1],
        tip_by_rigid_tip=abs(tip) / abs(rigid),
        phase_lag_deg=float(-np.degrees(np.angle(tip / rigid))),
        energy_balance=balance(record, window),
    )


def balance(record: Record, window: Window) -> dict[str, float | None]:
    """Work over `window`, J: of the root, of the loads, what the damping took and what the rod's energy gained;
    `missing` is the first two less the last two, relative to the magnitudes of the root's."""
    time = record.column("time")
    length = window.end - window.begin
    work = {name: length * average(time, record.column(column), window) for name, column in BALANCE.items()}
    energy = sum(record.column(name) for name in ENERGIES)
    gained = float(np.diff(np.interp([window.begin, window.end], time, energy))[0])
    exchanged = length * average(time, np.abs(record.column("root_power")), window)
    missing = work["root"] + work["load"] - work["damping"] - gained
    found: dict[str, float | None] = {**work, "gained": gained, "missing": missing / exchanged if exchanged else None}
    if "beam_power" in record.columns:
        found["fluid"] = length * average(time, record.column("beam_power"), window)
    return found


def average(time: np.ndarray, values: np.ndarray, window: Window) -> float:
    """Mean of `values` over time within `window`, linear between the samples."""
    inside = time[(time > window.begin) & (time < window.end)]
    t = np.r_[window.begin, inside, window.end]
    return float(np.trapezoid(np.interp(t, time, values), t) / (window.end - window.begin))


def harmonic(time: np.ndarray, values: np.ndarray, window: Window) -> complex:
    """Complex amplitude of the part of `values` that goes with the periods of `window`."""
    phase = np.exp(-2j * np.pi * window.periods * (time - window.begin) / (window.end - window.begin))
    return 2 * (average(time, values * phase.real, window) + 1j * average(time, values * phase.imag, window))
