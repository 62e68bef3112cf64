"""Coupling schemes: the exchange between units in one communication step, from t to t + H (`docs/theory/coupling.md`).

With several rods, x and the loads contain all rods. Explicit (serial), each unit once:

    rod.step(loads of the fluid at t)  →  stations at t + H  →  fluid.step(stations)  →  loads for the next step

Explicit, parallel: the same, but the fluid steps with the stations at t. The momentum load holds for one step of the
fluid. Where that must be shorter than H, both exchange several times in H.

Iterated: from a guess of the stations x at t + H,

    fluid.step(x)  →  loads  →  rod.step(loads)  →  stations x~,   residual r = x~ - x

until r is small; before each repetition all units return to t. Aitken's relaxation or IQN-ILS makes the next guess.
"""

import math
from array import array
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from nervure.coupling.acceleration import Aitken, IqnIls
from nervure.coupling.drive import WithinStep, driven_inputs, master_inputs
from nervure.coupling.foreign import RepeatedSteps, StationWatch
from nervure.coupling.guards import (
    LONGEST,
    ROUNDING,
    Balance,
    CouplingError,
    EnergyGuard,
    below,
    guarded_outputs,
    takes_momentum,
)
from nervure.scene.types import Guards, Iterated as Iteration
from nervure.units.fmu import WING, Unit, prefixes

LONGER = 1.1
"""Parts of a step for which loads have to hold before it has fewer exchanges: their number seldom changes."""

STATION_ROUNDING = 1e-12
"""Residual, relative to the positions of the stations, that counts as converged: about the error of a rod's solver."""

FALLING = 5
"""Last iterations within which a slowly converging iteration halves its least residual."""

FALL = 0.5
"""Fall of the residual in an iteration that is expected where the first ones show none."""

COARSEST_TOLERANCE = 1e-2
"""Largest residual, relative to the displacement in the step, that a user may want to accept."""


def connections(
    source: Unit, target: Unit, prefix_at_source: str = "", prefix_at_target: str = "", others: Sequence[str] = ()
) -> list[str]:
    """Return the names of the quantities that `source` gives to `target`, without the prefixes at both; inputs with one
    of the prefixes `others` are of other units. Raise `CouplingError` where an input of `target`, except a driven one,
    has no output of the same name, size and unit."""
    driven = master_inputs(target)
    inputs = [v.name for v in target.variables.values() if v.causality == "input" and v.name not in driven]
    inputs = [name for name in inputs if not name.startswith(tuple(others))]
    names = [name.removeprefix(prefix_at_target) for name in inputs if name.startswith(prefix_at_target)]
    for name in names:
        here, there = target.variables[prefix_at_target + name], source.variables.get(prefix_at_source + name)
        if there is None or there.causality != "output":
            such = "such output" if prefix_at_source == prefix_at_target else f"output `{prefix_at_source}{name}`"
            raise CouplingError(f"the {target.name} has the input `{here.name}`, but the {source.name} has no {such}")
        for what in ("kind", "size", "unit"):
            mine, theirs = getattr(here, what), getattr(there, what)
            if mine != theirs:
                raise CouplingError(
                    f"the {what} of `{here.name}` is {mine} at the {target.name}, but {theirs} at the {source.name}"
                )
    return names


@dataclass(frozen=True)
class Choice:
    """Load and scheme of a coupled run, with the reasons for them."""

    load: str
    load_reason: str
    scheme: str
    scheme_reason: str


def reason_of(rods: Sequence[Unit]) -> str | None:
    """Return the reason for the load of `rods`, in the words of the first rod that has one; else None."""
    reason = next((found for rod in rods if (found := rod.variables.get("load.reason"))), None)
    return reason.start[0] if reason else None


class Scheme:
    """How units exchange within a step; `guards` see each step after it is made."""

    choice: Choice | None = None
    """The choice made for the scene; None for a single unit."""
    guards: Sequence[EnergyGuard] = ()
    units: Sequence[Unit] = ()

    def start(self) -> None:
        """Exchange the start values and leave initialization."""
        raise NotImplementedError

    def step(self, t: float, h: float) -> int:
        """Step from `t` to `t + h` (s); return the number of iterations."""
        raise NotImplementedError

    def left(self, unit: Unit) -> list[str]:
        """Return the driven inputs of `unit` that the scheme leaves to the drive: all."""
        return driven_inputs(unit)

    def memory(self) -> dict[str, np.ndarray]:
        """Return what the scheme itself carries from step to step, for a checkpoint."""
        return {}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Restore what `memory` returned."""

    def logs(self) -> dict[str, np.ndarray]:
        """Return the scheme's own tables by name: `[rows]` with named columns."""
        return {}


class SingleUnit(Scheme):
    """One unit alone: every input keeps its start value, except the driven ones."""

    def __init__(self, unit: Unit):
        unit.connect(master_inputs(unit), [])
        self.unit, self.units = unit, [unit]

    def start(self) -> None:
        self.unit.get()
        self.unit.start()

    def step(self, t: float, h: float) -> int:
        self.unit.step(t, h)
        return 1


@dataclass(frozen=True)
class Link:
    """A rod, with its buffers and its parts of the fluid's buffers."""

    rod: Unit
    stations: np.ndarray  # Outputs of the rod
    fluid_stations: np.ndarray  # Stations as inputs of the fluid
    loads: np.ndarray  # Outputs of the fluid
    rod_loads: np.ndarray  # Loads as inputs of the rod


def _parts(length: float, holds: float) -> int:
    """Return in how many equal exchanges loads that hold for `holds` (s) cover `length` (s)."""
    return max(1, math.ceil(length / holds - ROUNDING))


class Explicit(Scheme):
    """One exchange for each step of the fluid: the rods step first, then the fluid. A wing is exchanged as a rod."""

    parallel = False
    """Whether the fluid steps with the stations at the beginning of the step."""
    foreign: Collection[Unit] = ()
    """Units from elsewhere, which are watched."""
    watches: Sequence[StationWatch] = ()
    longest: int | None = None
    """Place among the outputs of the fluid of the longest step for which the announced loads hold, s; None where none
    are announced."""
    last = 0.0
    """Length of the last exchange, s; 0 before the first."""

    def __init__(self, rods: Sequence[Unit], fluid: Unit, guards: Guards | None = None):
        self.rods, self.fluid = list(rods), fluid
        self.units = [*self.rods, fluid]
        wings = sum(WING.fullmatch(name) is not None for name in fluid.variables)
        self.prefixes = prefixes(len(self.rods) - wings, wings)
        self.links = self._connect(guards)
        if guards:
            self.guards = [
                EnergyGuard(guards, rod, fluid, beam.removesuffix(".") or "beam", self.parallel)
                for rod, beam in zip(self.rods, self.prefixes, strict=True)
            ]
        self.driven = WithinStep(self.units, self.left)

    def _connect(self, guards: Guards | None) -> list[Link]:
        """Connect the units; the fluid's buffers hold one rod after the other."""
        places = self.prefixes
        stations: list[list[str]] = []
        loads: list[list[str]] = []
        powers: list[str] = []  # Of the fluid
        for rod, beam in zip(self.rods, places, strict=True):
            loads.append(connections(self.fluid, rod, prefix_at_source=beam))
            others = [other for other in places if other not in ("", beam)]
            stations.append(connections(rod, self.fluid, prefix_at_target=beam, others=others))
            on_rod, from_fluid = guarded_outputs(rod, beam or "beam.") if guards else ([], [])
            on_rod = [name for name in on_rod if name in rod.variables] + self.watched(rod)
            rod.connect(loads[-1] + master_inputs(rod), stations[-1], on_rod)
            powers += [name for name in from_fluid if name in self.fluid.variables]
        here = [[beam + name for name in names] for beam, names in zip(places, stations, strict=True)]
        there = [[beam + name for name in names] for beam, names in zip(places, loads, strict=True)]
        known = [name for names in here for name in names]
        driven = master_inputs(self.fluid)
        inputs = [v.name for v in self.fluid.variables.values() if v.causality == "input"]
        if lost := next((name for name in inputs if name not in [*known, *driven]), None):
            raise CouplingError(f"the {self.fluid.name} has the input `{lost}`, but there is no rod for it")
        announces = any(v.causality == "output" and "impedance" in v.name for v in self.fluid.variables.values())
        watched = [LONGEST] if announces and LONGEST in self.fluid.variables else []
        self.fluid.connect(known + driven, [name for names in there for name in names], powers + watched)
        if watched:
            self.longest = self.fluid.slices[LONGEST].start

        def parts(values: np.ndarray, names: list[list[str]]) -> list[np.ndarray]:
            sizes = [sum(self.fluid.variables[name].size for name in part) for part in names]
            return np.split(values, np.cumsum(sizes))[:-1]

        self.fluid_stations = self.fluid.inputs[: self.fluid.inputs.size - len(driven)]
        pairs = zip(self.rods, parts(self.fluid_stations, here), parts(self.fluid.exchanged, there), strict=True)
        return [Link(rod, rod.exchanged, stations, loads, rod.inputs[: loads.size]) for rod, stations, loads in pairs]

    def watched(self, _rod: Unit) -> list[str]:
        """Return further outputs of a rod that every step fetches."""
        return []

    def give_stations(self) -> None:
        """Copy the stations of the rods to the fluid."""
        for link in self.links:
            link.fluid_stations[:] = link.stations

    def take_loads(self) -> None:
        """Copy the loads of the fluid to the rods."""
        for link in self.links:
            link.rod_loads[:] = link.loads

    def start(self) -> None:
        for rod in self.rods:
            rod.get()
        self.watches = [StationWatch(rod) for rod in self.rods if rod in self.foreign]
        self.give_stations()
        self.fluid.set()
        self.fluid.get()
        self.take_loads()
        for rod in self.rods:
            rod.set()
            rod.start()
        self.fluid.start()

    def step_rods(self, t: float, h: float) -> None:
        """Step the rods from `t` to `t + h` (s) with the loads of the fluid."""
        self.take_loads()
        for rod in self.rods:
            rod.step(t, h)
        for watch in self.watches:
            watch.check(t + h)

    def exchange(self, t: float, h: float) -> None:
        """Step all units from `t` to `t + h` (s)."""
        if self.parallel:
            self.give_stations()
        self.step_rods(t, h)
        if not self.parallel:
            self.give_stations()
        self.fluid.step(t, h)

    def step(self, t: float, h: float) -> int:
        exchanges, left, part = 0, h, self.last or h
        while left > 0.0:
            holds = math.inf if self.longest is None else self.fluid.outputs.item(self.longest)
            # The fluid announces the loads of a step as long as the last one, or divided: longer ones are seldom.
            if not exchanges and 2 * _parts(LONGER * h, holds) <= h / part * (1 + ROUNDING):
                part = h
            count = max(1, math.ceil(left / part * _parts(part, holds) - ROUNDING))
            if count == 1 and not exchanges:  # The driven inputs are at the end of the step already
                part, left = h, 0.0
                self.exchange(t, h)
            else:
                if not exchanges:
                    self.driven.aim()
                part = left / count
                begin, left = h - left, left - part if count > 1 else 0.0
                self.driven.move(1.0 - left / h, h)
                self.exchange(t + begin, part)
            exchanges += 1
        self.driven.keep()
        self.last = part
        return exchanges

    def memory(self) -> dict[str, np.ndarray]:
        own = {"last": np.array([self.last])} if self.longest is not None else {}
        return own | {"balance": np.array([guard.balance for guard in self.guards])} if self.guards else own

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        self.driven.keep()
        self.last = memory["last"].item() if self.longest is not None else 0.0
        for guard, balance in zip(self.guards, memory.get("balance", ()), strict=True):
            guard.balance = Balance(*balance.tolist())


class ParallelExplicit(Explicit):
    """One exchange a step: all units step with the outputs at its beginning."""

    parallel = True


ITERATIONS = ("step", "total_iterations", "iterations", "columns", "deleted", "dropped")
CONVERGENCE = ("step", "iteration", "residual")
"""Columns of iterations.csv and convergence.csv; the residual is relative to the displacement in the step."""


class Iterated(Explicit):
    """Exchanges until all units agree: guess, residual and limit are of all rods together."""

    def __init__(self, rods: Sequence[Unit], fluid: Unit, options: Iteration):
        super().__init__(rods, fluid)
        for unit in (*self.rods, fluid):
            if not unit.can_roll_back:
                raise CouplingError(f"the iterated scheme needs rollback, but the {unit.name} cannot restore its state")
        if any(map(takes_momentum, self.rods)):
            raise CouplingError(
                "the iterated scheme needs the load pressure_jump: the momentum load holds for stations that keep "
                "their velocity, so repeating the step with it would count the impedance twice"
            )
        self.tolerance, self.max_iterations = options.tolerance, options.max_iterations
        # The stations of one rod are its outputs; of several rods they are gathered.
        self.stations = self.rods[0].exchanged if len(self.rods) == 1 else np.zeros(self.fluid_stations.size)
        sizes = [link.stations.size for link in self.links]
        places = [np.r_[rod.slices["x"], rod.slices["y"]] for rod in self.rods]
        self.displacement = np.concatenate(
            [place + begin for place, begin in zip(places, np.cumsum([0, *sizes[:-1]]), strict=True)]
        )
        newton = IqnIls(self.displacement.size, self.stations.size)
        self.acceleration = Aitken() if options.acceleration == "aitken" else newton
        self.last_stations: np.ndarray | None = None
        self.iterations, self.convergence = array("d"), array("d")
        self.repeated: RepeatedSteps | None = None

    def gather(self) -> None:
        """Gather the stations of several rods in one array."""
        if len(self.links) > 1:
            np.concatenate([link.stations for link in self.links], out=self.stations)

    def step(self, t: float, h: float) -> int:
        rods, fluid, stations, given, a = self.rods, self.fluid, self.stations, self.fluid_stations, self.acceleration
        self.gather()
        before = stations.copy()
        rounding = STATION_ROUNDING * float(np.linalg.norm(before[self.displacement]))
        number = len(self.iterations) // len(ITERATIONS) + 1
        a.begin()
        for unit in (*rods, fluid):
            unit.save()

        # The first guess is the straight line through the last two.
        given[:] = before if self.last_stations is None else 2 * before - self.last_stations
        if self.foreign:
            self.repeated = self.repeated or RepeatedSteps([unit for unit in self.units if unit in self.foreign])
            self.repeated.test(t, h)
        for iteration in range(1, self.max_iterations + 1):
            if iteration > 1:
                for unit in (*rods, fluid):
                    unit.restore()
            fluid.step(t, h)
            self.step_rods(t, h)
            self.gather()
            residual = (stations - given)[self.displacement]
            change = float(np.linalg.norm((stations - before)[self.displacement]))
            error = float(np.linalg.norm(residual))
            limit = max(self.tolerance * change, rounding)
            self.convergence.extend((number, iteration, error / change if change > 0.0 else 0.0))
            a.learn(residual, stations)
            if error <= limit:
                total = iteration + (self.iterations[-len(ITERATIONS) + 1] if self.iterations else 0.0)
                self.iterations.extend((number, total, iteration, a.columns, a.deleted, a.dropped))
                self.last_stations = before
                return iteration
            if not np.isfinite(error):
                break
            given[:] = a.guess(given, stations)
        advice = self._advice(error, limit, iteration, h)
        raise CouplingError(
            f"the step from t = {t:g} s to {t + h:g} s did not converge in {iteration} iterations: the "
            f"residual of the stations is {error:.3g} m, but {limit:.3g} m is the limit; {advice}"
        )

    def _advice(self, error: float, limit: float, iterations: int, h: float) -> str:
        """Return advice after `iterations` iterations of a step of `h` (s) that did not converge, with the residual
        `error` and its limit (m)."""
        residuals = np.array(self.convergence).reshape(-1, len(CONVERGENCE))[-iterations:, 2]
        least, fall = residuals.min(), float(residuals[-1] / residuals[0]) ** (1 / max(iterations - 1, 1))
        if not np.isfinite(error):
            advice = f"the stations became no numbers: take a `time.communication_step` of {below(h / 2)} s"
        elif isinstance(self.acceleration, Aitken):
            advice = "`acceleration` iqn_ils holds where aitken does not"
        elif residuals[-FALLING:].min() < 0.5 * residuals[:-FALLING].min(initial=np.inf):
            more = int(np.ceil(np.log(limit / error) / np.log(fall if fall < 1.0 else FALL)))
            advice = f"it was still falling: take a `max_iterations` of {iterations + max(1, more)}"
        elif least < COARSEST_TOLERANCE:
            advice = f"at best it was {least:.2g} of the step's displacement, which a `tolerance` above that accepts"
        else:
            advice = (
                f"at best it was {least:.2g} of the step's displacement: take a `time.communication_step` of "
                f"{below(h / 2)} s, a heavier rod or a larger `c_eta`"
            )
        why = reason_of(self.rods)
        return advice if why is None else f"{advice} (it iterates under the load pressure_jump: {why})"

    def memory(self) -> dict[str, np.ndarray]:
        own = {"iterations": np.array(self.iterations), "convergence": np.array(self.convergence)}
        if self.last_stations is not None:
            own["last_stations"] = self.last_stations
        return own | self.acceleration.memory()

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        self.iterations, self.convergence = (array("d", memory[name]) for name in ("iterations", "convergence"))
        self.last_stations = memory.get("last_stations")
        self.acceleration.remember(memory)

    def logs(self) -> dict[str, np.ndarray]:
        """Return a row for each step, and one for each iteration, also of a step that did not converge."""
        tables = ("iterations", ITERATIONS, self.iterations), ("convergence", CONVERGENCE, self.convergence)
        return {
            name: np.array(rows).reshape(-1, len(columns)).view([(column, float) for column in columns]).ravel()
            for name, columns, rows in tables
        }
