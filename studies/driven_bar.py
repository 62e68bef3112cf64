"""The bar of Turek and Hron in a prescribed motion, without a rod: forces of the flow, beside a moving mesh.

    y(x, t) = y_0 + A r(t) P(x) sin(2 pi f (t - t_0)),    r = (1 - cos(pi (t - t_0)/T))/2 up to t_0 + T, then 1

P is the second mode of a clamped beam, 1 at the tip; there is no motion along x. The forces are fitted with six
harmonics over the last five periods,

    F(t) = F_0 + sum_k a_k sin(2 pi f k (t - t_0)) + b_k cos(2 pi f k (t - t_0)),

so that a_1 is in phase with the displacement and b_1 with the velocity. The residual of the fit is noise of the grid.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nervure import coupling
from nervure.evaluate import statistics
from nervure.evaluate.statistics import Series
from nervure.scene import validate
from nervure.simulation.session import Session
from nervure.simulation.summary import RunStatus
from nervure.units.fmu import Unit
from studies import simulate
from studies.engine import FLUID, Case, Run, Study
from studies.simulate import SHALLOW, on_grid

SCENE = "cfd3-648x108"
ROOT_X, TIP_X, AXIS_Y = 0.2 + np.sqrt(0.05**2 - 0.01**2), 0.6, 0.2
"""The faces of the bar at the cylinder, the tip, and the axis, m."""
WAVE_NUMBER = 4.694091132974  # Second root of cos(b) cosh(b) = -1
FREQUENCY, AMPLITUDE = 5.5, 0.035  # Of FSI3: Hz, m
HARMONICS, PERIODS = 6, 5  # Number of fitted harmonics, and of fitted periods
WIDTH = 4e-3  # Of the box filter over the lift, before its extremes are taken, s
GRIDS = {(324, 54): 4e-4, (648, 108): 2e-4, (972, 162): 1.3e-4}  # Step by cells, s
STREAM = {"time.end": 5.0}
"""Changes for the flow of CFD3, whose ramp ends at 2 s."""
STILL = {"fluid.inflow.mean_velocity": {"constant": 0.0}, "time.end": 1.5}
"""Changes for fluid at rest."""
SOON: dict[str, float] = {"begin": 0.0, "ramp": 0.3}
"""Motion in fluid at rest, which begins at once."""
COMPARED = ("bar.in_phase", "bar.with_velocity", "drag.mean", "drag.second")
LISTED: dict[str, Any] = simulate.LISTED["driven-bar"]


def mode(x: np.ndarray) -> np.ndarray:
    """Return P at `x` (m), `[stations]`."""

    def shape(z: np.ndarray | float) -> Any:
        b = WAVE_NUMBER
        share = (np.sinh(b) - np.sin(b)) / (np.cosh(b) + np.cos(b))
        return np.cosh(b * z) - np.cos(b * z) - share * (np.sinh(b * z) - np.sin(b * z))

    return np.asarray(shape((x - ROOT_X) / (TIP_X - ROOT_X)) / shape(1.0))


@dataclass(frozen=True)
class Motion:
    """Displacement of the tip, m, over time, s."""

    amplitude: float = AMPLITUDE
    frequency: float = FREQUENCY  # Hz
    begin: float = 2.0  # t_0
    ramp: float = 0.5  # T

    def at(self, t: float) -> tuple[float, float]:
        """Return displacement (m) and velocity (m/s)."""
        omega, past = 2 * np.pi * self.frequency, max(t - self.begin, 0.0)
        part = np.pi * min(past / self.ramp, 1.0)
        share, growth = (1 - np.cos(part)) / 2, np.pi / self.ramp * np.sin(part) / 2
        sin, cos = np.sin(omega * past), np.cos(omega * past)
        return self.amplitude * share * sin, self.amplitude * (share * omega * cos + growth * sin)


class Driven(coupling.SingleUnit):
    """A fluid whose stations follow a prescribed motion."""

    def __init__(self, fluid: Unit, motion: Motion, x: np.ndarray):
        super().__init__(fluid)
        fluid.connect(["x", "y", "vx", "vy"], [])
        self.motion, self.x, self.mode = motion, x, mode(x)
        self.unit.inputs[:] = np.r_[x, np.full_like(x, AXIS_Y), 0 * x, 0 * x]

    def step(self, t: float, h: float) -> int:
        displacement, velocity = self.motion.at(t + h)
        _, y, _, v = np.split(self.unit.inputs, 4)
        y[:] = AXIS_Y + displacement * self.mode
        v[:] = velocity * self.mode
        return super().step(t, h)


def run(case: Case, folder: Path) -> dict[str, Any]:
    """Run the fluid of a case with its motion; return the fitted forces, and the times, s."""
    series, outcome = record(case.built(), Motion(**case.options["motion"]), folder)
    if outcome.error:
        return {"error": outcome.error}
    times = {"wall_s": outcome.wall, "cpu_s": outcome.cpu}
    return {"values": evaluate(series, Motion(**case.options["motion"])), "times": times}


def record(scene: dict[str, Any], motion: Motion, folder: Path) -> tuple[Series, RunStatus]:
    """Return the scalar outputs of the fluid of `scene` over time, with its beam in `motion`."""
    beam = scene["beam"]
    stations = TIP_X - beam["length"] + np.linspace(0, beam["length"], beam["segments"] + 1)
    with Session(validate(scene), folder, scheme=lambda units: Driven(units["fluid"], motion, stations)) as session:
        status = session.run()
        return {name: values.copy() for name, values in session.recorder.series.items()}, status


def evaluate(series: Series, motion: Motion) -> dict[str, float]:
    """Return forces over the last periods, N/m: the bar's lift in phase with displacement and velocity, the same of bar
    and cylinder, the extremes of the lift, mean and second harmonic of the drag; the rms of the residual of the fits,
    by the fundamental of the lift and by the mean drag; and the work of the fluid on the bar in a cycle, J/m."""
    end, period = series["time"][-1], 1 / motion.frequency
    part = statistics.Window(end - PERIODS * period, end, PERIODS).of(series["time"])
    past = series["time"][part] - motion.begin

    def fitted(name: str) -> tuple[np.ndarray, float]:
        return harmonics(past, series[name][part], motion.frequency)

    bar, bar_rest = fitted("beam_lift")
    lift, _ = fitted("lift")
    drag, drag_rest = fitted("drag")
    smooth = statistics.box_filter(past, series["lift"][part], WIDTH)
    return {
        "bar.in_phase": bar[1].real,
        "bar.with_velocity": bar[1].imag,
        "lift.in_phase": lift[1].real,
        "lift.with_velocity": lift[1].imag,
        "lift.amplitude": statistics.extent(smooth)[1],
        "drag.mean": drag[0].real,
        "drag.second": abs(drag[2]),
        "rest": bar_rest / abs(bar[1]),
        "drag.rest": drag_rest,
        "work": float(np.trapezoid(series["beam_power"][part], past)) / PERIODS,
    }


def harmonics(time: np.ndarray, values: np.ndarray, frequency: float) -> tuple[np.ndarray, float]:
    """Return a_k + i b_k of the fit, `[HARMONICS + 1]`, with the mean first, and the rms of its residual."""
    order = np.arange(1, HARMONICS + 1)
    phases = np.outer(time, 2 * np.pi * frequency * order)
    matrix = np.column_stack([np.ones_like(time), np.sin(phases), np.cos(phases)])
    found = np.linalg.lstsq(matrix, values, rcond=None)[0]
    a, b = np.split(found[1:], 2)
    return np.r_[found[0], a + 1j * b], float(np.std(values - matrix @ found))


def cases() -> Iterator[Case]:
    for group, changes, motion in (("stream", STREAM, {}), ("small", STILL, {"amplitude": AMPLITUDE / 10, **SOON})):
        expected = LISTED[group]["moving mesh"]
        about = {"expected": {name: expected[name] for name in COMPARED if name in expected}}
        for (nx, ny), step in GRIDS.items():
            finer = changes | on_grid(nx, ny, step) | (SHALLOW if nx == 324 else {})
            sources, named = (*FLUID, "driven bar"), about | {"grid": f"{nx} x {ny}"}
            yield Case(f"{group}/{nx}x{ny}", sources, SCENE, finer, {"motion": motion}, run, named)


def extract(case: Case, run: Run) -> dict[str, Any]:
    return {part: run.found[part] for part in ("values", "times")}


STUDY = Study("driven-bar", cases, extract)
