"""How units exchange within one communication step, from t to t + H (`docs/coupling.md`).

Explicit (serial), each unit once:

    rod.step(loads of the fluid at t)  →  stations at t + H  →  fluid.step(stations)  →  loads for the next step

Explicit, parallel: the same, but the fluid steps with the stations at t.

Iterated: from a guess of the stations x at t + H,

    fluid.step(x)  →  loads  →  rod.step(loads)  →  stations x~,   residual r = x~ - x

until r is small; before every repetition both units are put back to t. What makes the next guess is Aitken's relaxation
or IQN-ILS.
"""

from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from nervure.coupling.acceleration import Aitken, IqnIls
from nervure.coupling.watch import CouplingError, Watch, takes_momentum, watched
from nervure.scene.types import Guards, Iterated as Iteration
from nervure.unit import Unit

STATION_ROUNDING = 1e-12
"""Residual relative to the stations' positions that counts as converged: a rod's own solver leaves about as much."""

FALLING = 5
"""Iterations at the end in which an iteration that converges slowly has halved the least of its residuals."""

COARSEST_TOLERANCE = 1e-2
"""A residual of less than this part of the step's displacement may be worth accepting."""

Drive = Callable[[float], Sequence[float]]
"""Motion of a root that the master drives: the values at a time (s) of the rod's inputs `root.*`, in their order."""


def root_inputs(unit: Unit) -> list[str]:
    """Names of the inputs with which a master drives the root of `unit`."""
    return [v.name for v in unit.variables.values() if v.causality == "input" and v.name.startswith("root.")]


def connections(source: Unit, target: Unit) -> list[str]:
    """Names of the quantities that `source` gives to `target`; raises `CouplingError` where an input of `target`, but
    those of a driven root, finds no output of the same name, number and unit."""
    names = [v.name for v in target.variables.values() if v.causality == "input" and not v.name.startswith("root.")]
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


@dataclass(frozen=True)
class Choice:
    """How two units are coupled, and why so."""

    load: str
    load_reason: str
    scheme: str
    scheme_reason: str


class Single:
    """One unit alone: every input keeps its start value, but those of a root that `drive` moves."""

    choice: Choice | None = None
    """What was chosen for the scene; None where there is nothing to choose."""

    def __init__(self, unit: Unit, drive: Drive | None = None):
        unit.connect(root_inputs(unit) if drive else [], [])
        self.unit, self.drive, self.root = unit, drive, unit.inputs

    def start(self) -> None:
        """Let all agree on the start values and leave initialization."""
        self.unit.get()
        self.unit.start()

    def step(self, t: float, h: float) -> int:
        """Step from `t` to `t + h` (s); returns the number of iterations."""
        self.move_root(t + h)
        self.unit.step(t, h)
        return 1

    def move_root(self, t: float) -> None:
        """Put a driven root where it is at `t` (s)."""
        if self.drive:
            self.root[:] = self.drive(t)

    def memory(self) -> dict[str, np.ndarray]:
        """What the scheme itself carries from step to step, for a checkpoint."""
        return {}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        """Take up what `memory` gave."""

    def logs(self) -> dict[str, np.ndarray]:
        """Tables that the scheme leaves besides the series, by name: `[rows]` with named columns."""
        return {}


class Explicit(Single):
    """Rod and fluid with one exchange a step, the rod first."""

    parallel = False
    """Whether the fluid steps with the stations at the beginning of the step."""

    def __init__(self, rod: Unit, fluid: Unit, drive: Drive | None = None, guards: Guards | None = None):
        self.rod, self.fluid, self.drive = rod, fluid, drive
        loads, stations, root = connections(fluid, rod), connections(rod, fluid), root_inputs(rod)
        if root and drive is None:
            raise CouplingError(
                "the scene leaves the root to the master (rod.root_motion), but nothing drives it: give laws of time, "
                "or couple the units from Python with a drive"
            )
        powers = watched(rod, fluid) if guards else ([], [])
        rod.connect(loads + root, stations, [name for name in powers[0] if name in rod.variables])
        fluid.connect(stations, loads, [name for name in powers[1] if name in fluid.variables])
        self.loads, self.stations = fluid.exchanged, rod.exchanged
        self.taken, self.root = np.split(rod.inputs, [self.loads.size])
        self.watch = Watch(guards, rod, fluid, self.parallel) if guards else None

    def start(self) -> None:
        self.rod.get()
        self.fluid.inputs[:] = self.stations
        self.fluid.set()
        self.fluid.get()
        self.taken[:] = self.loads
        self.rod.set()
        self.rod.start()
        self.fluid.start()

    def step(self, t: float, h: float) -> int:
        self.taken[:] = self.loads
        self.move_root(t + h)
        if self.parallel:
            self.fluid.inputs[:] = self.stations
        self.rod.step(t, h)
        if not self.parallel:
            self.fluid.inputs[:] = self.stations
        self.fluid.step(t, h)
        if self.watch:
            self.watch.check(t + h, h)
        return 1

    def memory(self) -> dict[str, np.ndarray]:
        return {"balance": np.array(self.watch.balance)} if self.watch else {}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        if self.watch:
            self.watch.balance = memory["balance"].tolist()


class ParallelExplicit(Explicit):
    """Rod and fluid with one exchange a step, each with what the other gave at its beginning."""

    parallel = True


ITERATIONS = ("step", "total_iterations", "iterations", "columns", "deleted", "dropped")
CONVERGENCE = ("step", "iteration", "residual")
"""Columns of iterations.csv and convergence.csv; the residual is relative to the displacement in the step."""


class Iterated(Explicit):
    """Rod and fluid with exchanges until they agree."""

    def __init__(self, rod: Unit, fluid: Unit, options: Iteration, drive: Drive | None = None):
        super().__init__(rod, fluid, drive)
        for unit in (rod, fluid):
            if not unit.can_roll_back:
                raise CouplingError(f"the iterated scheme needs rollback, but the {unit.name} cannot restore its state")
        if takes_momentum(rod):
            raise CouplingError(
                "the iterated scheme needs the load pressure_jump: the momentum load holds for stations that keep "
                "their velocity, so repeating the step with it would count the impedance twice"
            )
        self.tolerance, self.max_iterations = options.tolerance, options.max_iterations
        self.displacement = np.r_[rod.slices["x"], rod.slices["y"]]
        newton = IqnIls(self.displacement.size, self.stations.size)
        self.acceleration = Aitken() if options.acceleration == "aitken" else newton
        self.last_stations: np.ndarray | None = None
        self.iterations, self.convergence = array("d"), array("d")

    def step(self, t: float, h: float) -> int:
        rod, fluid, stations, given, a = self.rod, self.fluid, self.stations, self.fluid.inputs, self.acceleration
        before = stations.copy()
        rounding = STATION_ROUNDING * float(np.linalg.norm(before[self.displacement]))
        number = len(self.iterations) // len(ITERATIONS) + 1
        a.begin()
        rod.save()
        fluid.save()

        # The first guess is the straight line through the last two.
        given[:] = before if self.last_stations is None else 2 * before - self.last_stations
        for iteration in range(1, self.max_iterations + 1):
            if iteration > 1:
                rod.restore()
                fluid.restore()
            fluid.step(t, h)
            self.taken[:] = self.loads
            self.move_root(t + h)
            rod.step(t, h)
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
        remedy = self._remedy(error, iteration, h)
        raise CouplingError(
            f"the step from t = {t:g} s to {t + h:g} s did not converge in {iteration} iterations: the "
            f"residual of the stations is {error:.3g} m, but {limit:.3g} m is the limit; {remedy}"
        )

    def _remedy(self, error: float, iterations: int, h: float) -> str:
        """What helps after so many iterations of a step of `h` seconds that did not converge, the residual being
        `error` (m): by how they went, and by why there is an iteration at all."""
        residuals = np.array(self.convergence).reshape(-1, len(CONVERGENCE))[-iterations:, 2]
        least = residuals.min()
        if not np.isfinite(error):
            said = f"the stations became no numbers: take a `time.communication_step` shorter than {h:g} s"
        elif isinstance(self.acceleration, Aitken):
            said = "`acceleration` iqn_ils holds where aitken does not"
        elif residuals[-FALLING:].min() < 0.5 * residuals[:-FALLING].min(initial=np.inf):
            said = f"it was still falling: a `max_iterations` above {self.max_iterations} lets it go on"
        elif least < COARSEST_TOLERANCE:
            said = f"at best it was {least:.2g} of the step's displacement, which a `tolerance` above that accepts"
        else:
            said = (
                f"at best it was {least:.2g} of the step's displacement: take a `time.communication_step` shorter than "
                f"{h:g} s, a heavier rod or a larger `c_eta`"
            )
        reason = self.rod.variables.get("load.reason")
        why = reason.start[0] if reason else None
        return said if why is None else f"{said} (it iterates under the load pressure_jump: {why})"

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
        """The steps that were made, and every iteration, one that did not converge included."""
        tables = ("iterations", ITERATIONS, self.iterations), ("convergence", CONVERGENCE, self.convergence)
        return {
            name: np.array(rows).reshape(-1, len(columns)).view([(column, float) for column in columns]).ravel()
            for name, columns, rows in tables
        }
