"""What a driven root does with its rod: thrust, lift, power, efficiency, tip path and phase lag, as cycle averages.

Thrust is the force of the fluid on the beam against the stream, or against x in still fluid; lift is that along y. Power
in comes from the drive at the root. What is averaged are whole periods of the drive, by the trapezoidal rule.
"""

from collections.abc import Callable, Sequence

import numpy as np

from nervure.evaluate import statistics
from nervure.recorder import Recorder
from nervure.evaluate.statistics import Window

AXES = "xyz"

BALANCE = {"root": "root_power", "load": "load_power", "damping": "damping_power"}
ENERGIES = ("energy_elastic", "energy_kinetic", "energy_gravity")


def main_axis(columns: Sequence[str], column: Callable[[str], np.ndarray]) -> str | None:
    """The axis along which the tip would go farthest on a rigid rod; None where no root is driven."""
    extents = {axis: np.ptp(column(name)) for axis in AXES if (name := f"rigid_tip_u{axis}") in columns}
    return max(extents, key=extents.get) if extents else None


def drive_window(recorder: Recorder, settled: Window) -> Window | None:
    """The last whole periods of the drive, as many as the tip has `settled`; None if there is none."""
    axis = main_axis(recorder.columns, recorder.column)
    if axis is None or settled.periods == 0:
        return None
    window = statistics.find_window(recorder.column("time"), recorder.column(f"rigid_tip_u{axis}"))
    return window.last(settled.periods) if window.periods else None


def stream(scene: dict, window: Window) -> np.ndarray | None:
    """Velocity of the stream over `window`, m/s, `[2]`, where the scene drives one that is steady then; else None."""
    fluid = scene.get("fluid") or {}
    flow = fluid.get("mean_flow") or {"x": (fluid.get("inflow") or {}).get("mean_velocity", {})}

    def value(law) -> float | None:
        if not law:
            return 0.0
        ramp = law.get("cosine_ramp")
        return law.get("steady", ramp["value"] if ramp and ramp["duration"] <= window.begin else None)

    velocity = [value(flow.get(axis)) for axis in "xy"]
    return None if None in velocity or not any(velocity) else np.array(velocity)


def evaluate(scene: dict, recorder: Recorder, window: Window | None) -> dict | None:
    """`flapping` of the summary, where the tip is settled over `window`; None where no root is driven or over less than
    a period."""
    window = drive_window(recorder, window) if window else None
    if window is None:
        return None
    time, axis = recorder.column("time"), main_axis(recorder.columns, recorder.column)

    def mean(name: str) -> float:
        return average(time, recorder.column(name), window)

    power = mean("root_power")
    found = {"axis": axis, "window_s": [window.begin, window.end], "periods": window.periods, "power_in": power}
    if "beam_drag" in recorder.columns:
        force, velocity = np.array([mean("beam_drag"), mean("beam_lift")]), stream(scene, window)
        ahead = np.array([-1.0, 0.0]) if velocity is None else -velocity / np.linalg.norm(velocity)
        found |= {"thrust": float(force @ ahead), "lift": float(force[1])}
        if velocity is not None:
            found |= {"stream": velocity.tolist(), "efficiency": float(-force @ velocity) / power if power else None}
        else:
            found["thrust_by_power"] = found["thrust"] / power if power else None
    tip, rigid = (harmonic(time, recorder.column(f"{name}_u{axis}"), window) for name in ("tip", "rigid_tip"))
    found |= {
        "tip_amplitude": statistics.extent(recorder.column(f"tip_u{axis}")[window.of(time)])[1],
        "tip_by_rigid_tip": abs(tip) / abs(rigid),
        "phase_lag_deg": float(-np.degrees(np.angle(tip / rigid))),
        "energy_balance": balance(recorder, window),
    }
    return found


def balance(recorder: Recorder, window: Window) -> dict[str, float]:
    """Work over `window`, J: of the root, of the loads, what the damping took and what the rod's energy gained; `missing` is
    the first two less the last two, relative to the magnitudes of the root's."""
    time = recorder.column("time")
    length = window.end - window.begin
    work = {name: length * average(time, recorder.column(column), window) for name, column in BALANCE.items()}
    energy = sum(recorder.column(name) for name in ENERGIES)
    gained = float(np.diff(np.interp([window.begin, window.end], time, energy))[0])
    exchanged = length * average(time, np.abs(recorder.column("root_power")), window)
    missing = work["root"] + work["load"] - work["damping"] - gained
    found = work | {"gained": gained, "missing": missing / exchanged if exchanged else None}
    if "beam_power" in recorder.columns:
        found["fluid"] = length * average(time, recorder.column("beam_power"), window)
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
