"""The co-simulation master: one loop for a rod, a fluid or the two coupled.

Explicit scheme, from t to t + H:

    rod.step(loads of the fluid at t)  →  stations at t + H  →  fluid.step(stations)  →  loads for the next step

Iterated scheme: the same, but both units are rolled back to t and repeat the step until the stations that the rod
answers with are those that the fluid was given, with Aitken's relaxation between them (Küttler & Wall 2008).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from .recorder import Recorder
from .unit import Unit, UnitError

STEP_ROUNDING = 1e-9
"""Part of a step by which the end time may exceed a whole number of steps without one more step being made."""

FIRST_RELAXATION = (0.1, 0.5)
"""Range of the relaxation at the start of a step. Within it the last one of the step before is kept; 0.1 is what the
first step starts with, small enough for an added mass ten times the rod's own."""

STATION_ROUNDING = 1e-12
"""Residual relative to the stations' positions that counts as converged: a rod's own solver leaves about as much."""


class CouplingError(Exception):
    """The units do not fit each other, or the iteration between them did not converge."""


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


def connections(source: Unit, target: Unit) -> list[str]:
    """Names of the quantities that `source` gives to `target`; raises `CouplingError` where an input of `target`
    finds no output of the same name, number and unit."""
    names = [v.name for v in target.variables.values() if v.causality == "input"]
    for name in names:
        here, there = target.variables[name], source.variables.get(name)
        if there is None or there.causality != "output":
            raise CouplingError(f"the {target.name} has the input `{name}`, but the {source.name} has no such output")
        for what in ("kind", "size", "unit"):
            mine, theirs = getattr(here, what), getattr(there, what)
            if mine != theirs:
                raise CouplingError(
                    f"the {what} of `{name}` is {mine} at the {target.name}, but {theirs} at the {source.name}"
                )
    return names


class Single:
    """One unit alone: every input keeps its start value."""

    memory = ()
    """Names of the numbers that the scheme itself carries from step to step."""

    def __init__(self, unit: Unit):
        unit.connect([], [])
        self.unit = unit

    def start(self) -> None:
        self.unit.get()
        self.unit.start()

    def step(self, t: float, h: float) -> int:
        self.unit.step(t, h)
        return 1


class Explicit:
    """Rod and fluid with one exchange a step."""

    memory = ()

    def __init__(self, rod: Unit, fluid: Unit):
        self.rod, self.fluid = rod, fluid
        loads, stations = connections(fluid, rod), connections(rod, fluid)
        rod.connect(loads, stations)
        fluid.connect(stations, loads)
        self.loads, self.stations = fluid.exchanged, rod.exchanged

    def start(self) -> None:
        """Let both agree on the start values and leave initialization."""
        self.rod.get()
        self.fluid.inputs[:] = self.stations
        self.fluid.set()
        self.fluid.get()
        self.rod.inputs[:] = self.loads
        self.rod.set()
        self.rod.start()
        self.fluid.start()

    def step(self, t: float, h: float) -> int:
        """Step both from `t` to `t + h` (s); returns the number of iterations."""
        self.rod.inputs[:] = self.loads
        self.rod.step(t, h)
        self.fluid.inputs[:] = self.stations
        self.fluid.step(t, h)
        return 1


class Iterated(Explicit):
    """Rod and fluid with exchanges until they agree."""

    memory = ("relaxation",)

    def __init__(self, rod: Unit, fluid: Unit, tolerance: float, max_iterations: int):
        super().__init__(rod, fluid)
        for unit in (rod, fluid):
            if not unit.can_roll_back:
                raise CouplingError(f"the iterated scheme needs rollback, but the {unit.name} cannot restore its state")
        if "impedance" in fluid.slices:
            raise CouplingError(
                "the iterated scheme needs the load pressure_jump: the momentum load holds for stations that keep "
                "their velocity, so repeating the step with it would count the impedance twice"
            )
        self.tolerance, self.max_iterations = tolerance, max_iterations
        self.relaxation = FIRST_RELAXATION[0]
        self.displacement = np.r_[rod.slices["x"], rod.slices["y"]]

    def step(self, t: float, h: float) -> int:
        rod, fluid, stations, given = self.rod, self.fluid, self.stations, self.fluid.inputs
        before = stations[self.displacement].copy()
        rounding = STATION_ROUNDING * np.linalg.norm(before)
        rod.save()
        fluid.save()

        super().step(t, h)  # the fluid is given what the rod answers to the last loads
        relaxation = np.clip(self.relaxation, *FIRST_RELAXATION)
        last_residual = None
        for iteration in range(2, self.max_iterations + 1):
            rod.restore()
            rod.inputs[:] = self.loads
            rod.step(t, h)
            residual = stations - given
            error = np.linalg.norm(residual[self.displacement])
            limit = max(self.tolerance * np.linalg.norm(stations[self.displacement] - before), rounding)
            if error <= limit:
                return iteration
            if last_residual is not None:
                change = (residual - last_residual)[self.displacement]
                relaxation *= -(last_residual[self.displacement] @ change) / (change @ change)
            self.relaxation, last_residual = relaxation, residual
            given += relaxation * residual
            fluid.restore()
            fluid.step(t, h)
        raise CouplingError(
            f"the step from t = {t:g} s to {t + h:g} s did not converge in {self.max_iterations} iterations: the "
            f"residual of the stations is {error:.3g} m, but {limit:.3g} m is the limit"
        )


@dataclass
class Outcome:
    """How a run ended and what it cost."""

    steps: int
    simulated: float
    """Time reached, s."""
    wall: float
    """Wall time of the loop, s."""
    completed: bool
    error: str | None


def couple(units: dict[str, Unit], scheme: str | dict) -> Single | Explicit | Iterated:
    """The units of a scene under its `coupling.scheme`, which a unit alone does not need."""
    if len(units) == 1:
        return Single(*units.values())
    if scheme == "explicit":
        return Explicit(units["rod"], units["fluid"])
    return Iterated(units["rod"], units["fluid"], **scheme["iterated"])


def run(
    scheme: Single | Explicit | Iterated,
    clock: Clock,
    recorder: Recorder,
    watchers: Sequence[Callable[[int, float, float], None]] = (),
    stopping: Callable[[], bool] = lambda: False,
    done: int = 0,
    wall: float = 0.0,
) -> Outcome:
    """Step to the end of `clock`, or until `stopping` says so or a unit fails.

    A run that begins with step `done` > 0 goes on from there: its units are in that state, and it has cost `wall` (s)
    so far. Each of `watchers` is called at the start and after every step with the number of steps done, the
    simulated time and the wall time (s).
    """
    begin = perf_counter() - wall
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
    return Outcome(done, reached, perf_counter() - begin, done == clock.steps, error)
