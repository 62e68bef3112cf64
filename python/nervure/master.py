"""The co-simulation master: one loop for a rod, a fluid, or a fluid with one or several rods.

`coupling` has what happens in a step.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time

from nervure.coupling import CouplingError, Drive, Single, couple
from nervure.recorder import Recorder
from nervure.scene import Scene, unit_label
from nervure.units.fmu import Unit, UnitError

Watcher = Callable[[int, float, float], None]
"""Called at the start and after every step with the number of steps done, the simulated time and the wall time (s)."""

STEP_ROUNDING = 1e-9
"""Part of a step by which the end time may exceed a whole number of steps without one more step being made."""


@dataclass(frozen=True)
class Clock:
    """Communication points i · H for i = 0 … steps - 1, and the end time itself, s; the last step may be shorter."""

    end: float
    communication_step: float

    @property
    def steps(self) -> int:
        return max(1, math.ceil(self.end / self.communication_step - STEP_ROUNDING))

    def step(self, i: int) -> tuple[float, float]:
        """Time at the beginning of step `i` and its length, s."""
        t = i * self.communication_step
        return t, self.end - t if i == self.steps - 1 else self.communication_step


@dataclass
class RunStatus:
    """How a run ended and what it cost."""

    steps: int
    simulated: float  # Time reached, s
    wall: float  # Wall time of the loop, s
    cpu: float | None  # Its processor time, s; None of a run that was resumed
    completed: bool
    error: str | None

    @property
    def stopped(self) -> bool:
        """Whether it was asked to stop."""
        return not self.completed and self.error is None


def assemble(
    scene: Scene,
    fmus: Mapping[str, Path],
    stack: ExitStack,
    drive: Drive | None = None,
    foreign: bool = False,
    series_every: float | None = None,
) -> tuple[dict[str, Unit], Single, Clock, Recorder]:
    """The packed units of `scene`, coupled and ready to step, with clock and recorder; `stack` closes them. `drive`
    moves a root that the scene leaves to the master; `foreign` says that a unit is not ours; `series_every` is the
    time between two rows of the recorder, s, rounded to whole steps."""
    clock = Clock(scene.time.end, scene.time.communication_step)
    units = {}
    for kind, path in fmus.items():
        units[kind] = Unit(path, unit_label(kind), clock.end)
        stack.callback(units[kind].close)
    scheme = couple(units, scene.coupling, drive, foreign)
    stride = max(1, round(series_every / clock.communication_step)) if series_every else 1
    return units, scheme, clock, Recorder(units, clock.steps, stride)


def run(
    scheme: Single,
    clock: Clock,
    recorder: Recorder,
    watchers: Sequence[Watcher] = (),
    stopping: Callable[[], bool] = lambda: False,
    done: int = 0,
    wall: float = 0.0,
) -> RunStatus:
    """Step to the end of `clock`, or until `stopping` says so or a unit fails.

    A run that begins with step `done` > 0 goes on from there: its units are in that state, and it has cost `wall` (s)
    so far.
    """
    begin, cpu = perf_counter() - wall, process_time() if done == 0 else None
    reached, error = clock.step(done)[0] if done < clock.steps else clock.end, None
    try:
        if done == 0:
            scheme.start()
            recorder.record(0, 0.0, 0)
            for watch in watchers:
                watch(0, 0.0, perf_counter() - begin)
        for i in range(done, clock.steps):
            if stopping():
                break
            t, h = clock.step(i)
            iterations = scheme.step(t, h)
            done, reached = i + 1, t + h
            recorder.record(done, reached, iterations)
            for watch in watchers:
                watch(done, reached, perf_counter() - begin)
    except (UnitError, CouplingError) as failure:
        error = str(failure)
    used = None if cpu is None else process_time() - cpu
    return RunStatus(done, reached, perf_counter() - begin, used, done == clock.steps, error)
