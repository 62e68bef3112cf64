"""Cycle averages of a driven root and its rod or wing: thrust, lift, side, power, efficiency, tip path and phase lag.

Thrust is the force of the fluid against the drag direction of `scene.facts`: against the stream, or in still fluid from
the tip towards the root at rest. Lift and side are along the other two directions. Power in comes from the drive at the
root. Averages are over the window, by the trapezoidal rule.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from nervure.evaluate import statistics
from nervure.evaluate.statistics import Series, Window
from nervure.scene.facts import Facts, Scales

AXES = "xyz"
FORCES = ("drag", "lift", "side")  # Ends of the columns of forces along x, y and z

BALANCE = {"root": "root_power", "load": "load_power", "damping": "damping_power"}
ENERGIES = ("energy_elastic", "energy_kinetic", "energy_gravity")


@dataclass(frozen=True, kw_only=True)
class Flapping:
    """Cycle averages of a driven root and its rod or wing; without a fluid, its values are None."""

    axis: str  # Coordinate nearest to `direction`
    direction: tuple[float, ...]  # Along which the tip of a rigid rod goes farthest
    window_s: tuple[float, float]  # The window of the run, s
    periods: int
    power_in: float  # W per metre of depth, or W in space
    thrust: float | None = None  # N/m, or N in space
    lift: float | None = None  # N/m, or N in space
    side: float | None = None  # N; in space only
    stream: tuple[float, ...] | None = None  # Velocity, m/s; None in still fluid
    efficiency: float | None = None  # Thrust times stream by power; None in still fluid
    thrust_by_power: float | None = None  # s/m; in still fluid only
    tip_amplitude: float  # m
    tip_by_rigid_tip: float
    phase_lag_deg: float
    energy_balance: dict[str, float | None]  # Works, J per metre of depth, and the missing part


def path(series: Series, name: str) -> np.ndarray | None:
    """Return the displacement of a tip, `[axes, samples]` (m), from the columns `NAME_ux` …; None without columns."""
    columns = [series[column] for axis in AXES if (column := f"{name}_u{axis}") in series]
    return np.array(columns) if columns else None


def forces(series: Series, name: str) -> np.ndarray | None:
    """Return the force of the fluid on a part, `[axes, samples]` (N, per metre of depth in the plane); None without
    columns."""
    columns = [series[column] for end in FORCES if (column := f"{name}_{end}") in series]
    return np.array(columns) if columns else None


def evaluate(facts: Facts, scales: Scales | None, series: Series, window: Window) -> Flapping | None:
    """Return the averages over `window` for a rod or a wing with these scales, whose columns are `series`; None without
    a drive or a whole period."""
    time, rigid_path, tip_path = series["time"], path(series, "rigid_tip"), path(series, "tip")
    if rigid_path is None or tip_path is None or window.periods == 0:
        return None
    if not np.ptp(rigid_path[:, window.of(time)], axis=1).any():
        return None
    direction = statistics.principal_direction(time, rigid_path)
    power = average(time, series["root_power"], window)
    fluid: dict[str, Any] = {}
    if scales and (on_beam := forces(series, "beam")) is not None:
        force = np.array([average(time, values, window) for values in on_beam])
        drag, lift, side = (float(axis @ force) for axis in scales.directions(force.size))
        fluid = {"thrust": -drag, "lift": lift, "side": side if force.size > 2 else None}
        if facts.stream is None:
            fluid["thrust_by_power"] = -drag / power if power else None
        else:
            velocity = facts.stream[: force.size]
            fluid["stream"] = tuple(velocity.tolist())
            fluid["efficiency"] = float(-force @ velocity) / power if power else None
    along = direction @ tip_path
    tip, rigid = (harmonic(time, values, window) for values in (along, direction @ rigid_path))
    return Flapping(
        axis=AXES[int(np.argmax(np.abs(direction)))],
        direction=tuple(direction.tolist()),
        window_s=(window.begin, window.end),
        periods=window.periods,
        power_in=power,
        **fluid,
        tip_amplitude=statistics.extent(along[window.of(time)])[1],
        tip_by_rigid_tip=abs(tip) / abs(rigid),
        phase_lag_deg=float(-np.degrees(np.angle(tip / rigid))),
        energy_balance=balance(series, window),
    )


def balance(series: Series, window: Window) -> dict[str, float | None]:
    """Return the works over `window`, J: of the root, of the loads, of the damping, and the gain of the rod's energy;
    `missing` is the sum of the first two less the last two, relative to the magnitude of the root's work."""
    time = series["time"]
    length = window.end - window.begin
    work = {name: length * average(time, series[column], window) for name, column in BALANCE.items()}
    energy = sum(series[name] for name in ENERGIES)
    gained = float(np.diff(np.interp([window.begin, window.end], time, energy))[0])
    exchanged = length * average(time, np.abs(series["root_power"]), window)
    missing = work["root"] + work["load"] - work["damping"] - gained
    found: dict[str, float | None] = {**work, "gained": gained, "missing": missing / exchanged if exchanged else None}
    if "beam_power" in series:
        found["fluid"] = length * average(time, series["beam_power"], window)
    return found


def average(time: np.ndarray, values: np.ndarray, window: Window) -> float:
    """Return the mean of `values` over time within `window`, linear between the samples."""
    inside = time[(time > window.begin) & (time < window.end)]
    t = np.r_[window.begin, inside, window.end]
    return float(np.trapezoid(np.interp(t, time, values), t) / (window.end - window.begin))


def harmonic(time: np.ndarray, values: np.ndarray, window: Window) -> complex:
    """Return the complex amplitude of `values` at the frequency of the periods of `window`."""
    phase = np.exp(-2j * np.pi * window.periods * (time - window.begin) / (window.end - window.begin))
    return 2 * (average(time, values * phase.real, window) + 1j * average(time, values * phase.imag, window))
