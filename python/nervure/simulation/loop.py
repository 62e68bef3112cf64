"""The time loop of a run: a coupling scheme, stepped along a time grid, recorded and observed."""

import math
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter, process_time

from nervure.coupling import CouplingError, Scheme
from nervure.errors import UnitError
from nervure.simulation.recorder import Recorder
from nervure.simulation.results import Results
from nervure.simulation.summary import RunStatus

STEP_ROUNDING = 1e-9
"""Part of a step by which the end time may differ from a whole number of steps."""


@dataclass(frozen=True)
class TimeGrid:
    """Communication points i · H for i = 0 … steps - 1, and the end time, s; the last step may be shorter."""

    end: float
    communication_step: float

    @cached_property
    def steps(self) -> int:
        """Number of communication steps."""
        return max(1, math.ceil(self.end / self.communication_step - STEP_ROUNDING))

    def stride(self, interval: float) -> int:
        """Return an interval (s) in steps: at least one, and at most all."""
        return max(1, round(min(interval / self.communication_step, self.steps)))

    def rounded(self, name: str, interval: float | None) -> str | None:
        """Return a warning where an interval (s) within the run is rounded to other steps; 0 is every step."""
        given, made = f"{interval or 0.0:g}", f"{self.stride(interval or 0.0) * self.communication_step:g}"
        if not interval or interval > self.end or given == made:
            return None
        return (
            f"`{name}` is {given} s, but a multiple of the {self.communication_step:g} s of a step is taken: {made} s"
        )

    def step(self, i: int) -> tuple[float, float]:
        """Return the time at the beginning of step `i` and the length of the step, s."""
        t, whole = i * self.communication_step, self.communication_step
        left = self.end - t
        return t, left if left < whole * (1 - STEP_ROUNDING) else whole  # so that a later end changes no bit


class Observer:
    """Watches a run. Each method does nothing here."""

    def step(self, loop: "TimeLoop") -> None:
        """See the start of the run, and every step after it is recorded."""

    def end(self, status: RunStatus | None) -> None:
        """See the end of the loop; `status` is None where an exception leaves it."""

    def finish(self, results: Results) -> None:
        """See the results, which are written."""


class TimeLoop:
    """Steps `scheme` along `grid` into `recorder`; `observers` watch. `run` does all of it, or `start` and `step`."""

    def __init__(self, scheme: Scheme, grid: TimeGrid, recorder: Recorder):
        self.scheme, self.grid, self.recorder = scheme, grid, recorder
        self.observers: list[Observer] = []
        self.steps, self.time = 0, 0.0  # Steps done, and the time reached, s
        self.error: str | None = None
        self._started = False
        self._begin = perf_counter()
        self._cpu: float | None = None  # Processor time at the start, s; None after a resumption

    @property
    def wall(self) -> float:
        """Wall time since the start, s, with the time before a resumption."""
        return perf_counter() - self._begin

    def status(self) -> RunStatus:
        """Return how far the run has come, and at what cost."""
        cpu = None if self._cpu is None else process_time() - self._cpu
        return RunStatus(self.steps, self.time, self.wall, cpu, self.steps == self.grid.steps, self.error)

    def start(self) -> None:
        """Exchange the start values and record them."""
        self._started, self._begin, self._cpu = True, perf_counter(), process_time()
        self.scheme.start()
        for unit in self.scheme.units:
            unit.check_outputs(0.0)
        self.recorder.record(0, 0.0, 0)

    def resume_at(self, steps: int, wall: float) -> None:
        """Continue after `steps` steps, which took the wall time `wall` (s)."""
        self._started, self._begin, self.steps = True, perf_counter() - wall, steps
        self.time = sum(self.grid.step(steps - 1)) if steps else 0.0

    def step(self) -> None:
        """Make the next step and record it."""
        t, h = self.grid.step(self.steps)
        iterations = self.scheme.step(t, h)
        for guard in self.scheme.guards:
            guard.check(t + h, h)
        self.steps, self.time = self.steps + 1, t + h
        self.recorder.record(self.steps, self.time, iterations)

    def run(self, stopping: Callable[[], bool] = lambda: False) -> RunStatus:
        """Step to the end of the grid, or until `stopping` returns True or a unit fails; return how it ended. Raise
        `UnitError` or `CouplingError` where a unit fails before the first step."""
        steps, status, fresh = self.grid.steps, None, not self._started
        try:
            if fresh:
                self.start()
            try:
                if fresh:
                    self._notify()
                while self.steps < steps and not stopping():
                    self.step()
                    self._notify()
                if self.steps == steps:
                    for unit in self.scheme.units:
                        unit.terminate()
            except (UnitError, CouplingError) as failure:
                self.error = str(failure)
            status = self.status()
        finally:
            for observer in self.observers:
                observer.end(status)
        return status

    def _notify(self) -> None:
        for observer in self.observers:
            observer.step(self)


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """Yield a function that returns True after the first Ctrl-C or SIGTERM; the second one kills. Threads other than
    the main one get no signals: there the function always returns False."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    asked = threading.Event()
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def ask(*_: object) -> None:
        asked.set()
        restore()

    for number in before:
        signal.signal(number, ask)
    try:
        yield asked.is_set
    finally:
        restore()
