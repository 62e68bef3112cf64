"""How units exchange within one communication step, from t to t + H (`docs/coupling.md`).

Explicit (serial), each unit once:

    rod.step(loads of the fluid at t)  →  stations at t + H  →  fluid.step(stations)  →  loads for the next step

Explicit, parallel: the same, but the fluid steps with the stations at t.

Iterated: from a guess of the stations x at t + H,

    fluid.step(x)  →  loads  →  rod.step(loads)  →  stations x~,   residual r = x~ - x

until r is small; before every repetition both units are put back to t. What makes the next guess is Aitken's relaxation or
IQN-ILS.
"""

from array import array
from collections.abc import Callable, Sequence

import numpy as np

from nervure.errors import Refusal
from nervure.unit import Unit

STATION_ROUNDING = 1e-12
"""Residual relative to the stations' positions that counts as converged: a rod's own solver leaves about as much."""

FIRST_RELAXATION = 0.1
"""Part of the residual that is taken where nothing is known yet: small enough for an added mass ten times the rod's own."""

AITKEN_START = (FIRST_RELAXATION, 0.5)
"""Range of Aitken's relaxation at the start of a step. Within it the last one of the step before is kept."""

MOST_COLUMNS, WINDOWS_REUSED = 60, 15
"""Differences that IQN-ILS keeps at most, and for how many steps."""

FILTER = 1.2e-3
"""A difference of which less than this part is new, given the younger ones, is deleted (QR2 of preCICE)."""

WATCHED = 500
"""Steps over which the powers that cross the interface are watched."""

LARGEST_IMBALANCE = 0.5
"""Their difference by what went across, means of the magnitudes, from which a run is stopped: 0.04 in FSI3, 1 where it blows up."""

LARGEST_NOISE = 1.5
"""Second difference, from step to step, of the power that the rod takes under the pressure jump by the power, means of the magnitudes, from
which a run is stopped: 4 for a sawtooth, 2.4 for noise; below 0.8 in runs that hold."""

QUIET = 1e-9
"""Power below which nothing is watched for noise, W: a rod at rest takes nothing but rounding."""


class CouplingError(Refusal):
    """The units do not fit each other, or the iteration between them did not converge."""


Drive = Callable[[float], Sequence[float]]
"""Motion of a root that the master drives: the values at a time (s) of the rod's inputs `root.*`, in their order."""


def root_inputs(unit: Unit) -> list[str]:
    """Names of the inputs with which a master drives the root of `unit`."""
    return [v.name for v in unit.variables.values() if v.causality == "input" and v.name.startswith("root.")]


def connections(source: Unit, target: Unit) -> list[str]:
    """Names of the quantities that `source` gives to `target`; raises `CouplingError` where an input of `target`, but those
    of a driven root, finds no output of the same name, number and unit."""
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


class Single:
    """One unit alone: every input keeps its start value, but those of a root that `drive` moves."""

    choice = None
    """What was chosen for the scene, and why, as summary.json shows it."""

    def __init__(self, unit: Unit, drive: Drive | None = None):
        unit.connect(root_inputs(unit) if drive else [], [])
        self.unit, self.drive, self.root = unit, drive, unit.inputs

    def start(self) -> None:
        self.unit.get()
        self.unit.start()

    def step(self, t: float, h: float) -> int:
        if self.drive:
            self.root[:] = self.drive(t + h)
        self.unit.step(t, h)
        return 1

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

    def __init__(self, rod: Unit, fluid: Unit, drive: Drive | None = None):
        self.rod, self.fluid, self.drive = rod, fluid, drive
        loads, stations, root = connections(fluid, rod), connections(rod, fluid), root_inputs(rod)
        if root and drive is None:
            raise CouplingError(
                "the scene leaves the root to the master (rod.root_motion), but nothing drives it: give laws of time, or couple the "
                "units from Python with a drive"
            )
        rod.connect(loads + root, stations)
        fluid.connect(stations, loads)
        self.loads, self.stations = fluid.exchanged, rod.exchanged
        self.taken, self.root = np.split(rod.inputs, [self.loads.size])
        took, gave = rod.slices.get("load.power"), fluid.slices.get("beam.power")
        # Under the pressure jump the two are not the same: it lacks the fluid inside the mask and the viscous traction.
        self.powers = [power.start for power in (took, gave if takes_momentum(rod) else None) if power]
        """Where the outputs have the powers that are watched: that of the rod, and under the momentum load that of the fluid."""
        self.balance = [0.0] * 5
        """Steps, fading sums of the magnitudes of what is watched and of what went across, W, and the rod's last two powers."""

    def start(self) -> None:
        """Let both agree on the start values and leave initialization."""
        self.rod.get()
        self.fluid.inputs[:] = self.stations
        self.fluid.set()
        self.fluid.get()
        self.taken[:] = self.loads
        self.rod.set()
        self.rod.start()
        self.fluid.start()

    def step(self, t: float, h: float) -> int:
        """Step both from `t` to `t + h` (s); returns the number of iterations."""
        self.take(t + h)
        self.rod.step(t, h)
        self.fluid.inputs[:] = self.stations
        self.fluid.step(t, h)
        self.watch(t + h)
        return 1

    def take(self, t: float) -> None:
        """Inputs of the rod for its step to `t` (s)."""
        self.taken[:] = self.loads
        if self.drive:
            self.root[:] = self.drive(t)

    def watch(self, t: float) -> None:
        """Stop a run whose two sides have come apart, or whose load is noise: what is unstable may well stay finite."""
        if not self.powers:
            return
        took = self.rod.outputs.item(self.powers[0])
        steps, watched, crossed, last, last_but_one = self.balance
        momentum = len(self.powers) > 1
        gave = self.fluid.outputs.item(self.powers[1]) if momentum else took
        watched += (abs(took - gave) if momentum else abs(took - 2 * last + last_but_one)) - watched / WATCHED
        crossed += abs(gave) - crossed / WATCHED
        self.balance = [steps + 1, watched, crossed, took, last]
        if steps < WATCHED:
            return
        if momentum and watched > LARGEST_IMBALANCE * crossed:
            reason = f"the power that the rod took and that the fluid gave differ by {watched / crossed:.0%} of what went across"
        elif not momentum and watched > LARGEST_NOISE * crossed > LARGEST_NOISE * QUIET * WATCHED:
            reason = f"the power that the rod took is noise, {watched / crossed:.2g} of it from step to step; iterate, or take shorter steps"
        else:
            return
        raise CouplingError(f"the coupling is unstable at t = {t:g} s: over the last {WATCHED} steps {reason}")

    def memory(self) -> dict[str, np.ndarray]:
        return {"balance": np.array(self.balance)}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        self.balance = memory["balance"].tolist()


class ParallelExplicit(Explicit):
    """Rod and fluid with one exchange a step, each with what the other gave at its beginning."""

    def step(self, t: float, h: float) -> int:
        self.take(t + h)
        self.fluid.inputs[:] = self.stations
        self.rod.step(t, h)
        self.fluid.step(t, h)
        self.watch(t + h)
        return 1


class Aitken:
    """Relaxation by the secant of the last two residuals (Küttler & Wall 2008, Comput. Mech. 43, 61)."""

    columns = deleted = dropped = 0

    def __init__(self):
        self.relaxation = FIRST_RELAXATION
        self.last_residual = None

    def begin(self) -> None:
        """A new step begins."""
        self.relaxation = float(np.clip(self.relaxation, *AITKEN_START))
        self.last_residual = None

    def learn(self, residual: np.ndarray, _answer: np.ndarray) -> None:
        """Take up the residual of the displacements, `[2n]`, and the answer that it belongs to, `[4n]`."""
        if self.last_residual is not None:
            change = residual - self.last_residual
            self.relaxation *= -float(self.last_residual @ change) / float(change @ change)
        self.last_residual = residual

    def guess(self, given: np.ndarray, answer: np.ndarray) -> np.ndarray:
        """The next guess of the stations."""
        return given + self.relaxation * (answer - given)

    def memory(self) -> dict[str, np.ndarray]:
        return {"relaxation": np.array([self.relaxation])}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        self.relaxation = float(memory["relaxation"][0])


class IqnIls:
    """Interface quasi-Newton by least squares (Degroote, Bathe & Vierendeels 2009, Comput. Struct. 87, 793).

    With differences of neighbouring iterations V = [r_i - r_{i-1}] and W = [x~_i - x~_{i-1}], those of former steps too, the
    next guess is x~ + c W where c makes |r + c V| least. V holds displacements only: they are all that is asked
    to agree, and a velocity is no length. A QR decomposition, youngest differences first, finds c and those that say nothing
    new, which are deleted (Haelterman et al. 2016, Comput. Struct. 171, 9).
    """

    def __init__(self, displacements: int, stations: int):
        self.v, self.w = np.empty((0, displacements)), np.empty((0, stations))
        self.most_columns = min(MOST_COLUMNS, displacements)
        self.step_of = np.empty(0, int)
        """Step in which each difference was found."""
        self.step = 0
        self.deleted = self.dropped = 0

    @property
    def columns(self) -> int:
        return len(self.v)

    def begin(self) -> None:
        self.step += 1
        self.last = None
        self.deleted = 0
        self.dropped = self._keep(self.step_of >= self.step - WINDOWS_REUSED)

    def learn(self, residual: np.ndarray, answer: np.ndarray) -> None:
        if self.last is not None:
            last_residual, last_answer = self.last
            self.v = np.vstack([residual - last_residual, self.v])
            self.w = np.vstack([answer - last_answer, self.w])
            self.step_of = np.r_[self.step, self.step_of]
            self.dropped += self._keep(np.arange(self.columns) < self.most_columns)
        self.last = residual, answer.copy()

    def guess(self, given: np.ndarray, answer: np.ndarray) -> np.ndarray:
        residual, _ = self.last
        while self.columns:
            q, r = np.linalg.qr(self.v.T)
            new = np.abs(np.diagonal(r)) > FILTER * np.linalg.norm(self.v, axis=1)
            if new.all():
                return answer + np.linalg.solve(r, -(q.T @ residual)) @ self.w
            self.deleted += self._keep(new)
        return given + FIRST_RELAXATION * (answer - given)

    def _keep(self, kept: np.ndarray) -> int:
        """Forget the other differences; returns their number."""
        if kept.all():
            return 0
        self.v, self.w, self.step_of = self.v[kept], self.w[kept], self.step_of[kept]
        return int(np.count_nonzero(~kept))

    def memory(self) -> dict[str, np.ndarray]:
        return {"v": self.v, "w": self.w, "step_of": self.step_of, "step": np.array([self.step])}

    def remember(self, memory: dict[str, np.ndarray]) -> None:
        self.v, self.w, self.step_of = memory["v"], memory["w"], memory["step_of"]
        self.step = int(memory["step"][0])


ITERATIONS = ("step", "total_iterations", "iterations", "columns", "deleted", "dropped")
CONVERGENCE = ("step", "iteration", "residual")
"""Columns of iterations.csv and convergence.csv; the residual is relative to the change of the displacements in the step."""


class Iterated(Explicit):
    """Rod and fluid with exchanges until they agree."""

    def __init__(
        self,
        rod: Unit,
        fluid: Unit,
        drive: Drive | None = None,
        tolerance: float = 1e-4,
        max_iterations: int = 50,
        acceleration: str = "iqn_ils",
    ):
        super().__init__(rod, fluid, drive)
        for unit in (rod, fluid):
            if not unit.can_roll_back:
                raise CouplingError(f"the iterated scheme needs rollback, but the {unit.name} cannot restore its state")
        if takes_momentum(rod):
            raise CouplingError(
                "the iterated scheme needs the load pressure_jump: the momentum load holds for stations that keep "
                "their velocity, so repeating the step with it would count the impedance twice"
            )
        self.tolerance, self.max_iterations = tolerance, max_iterations
        self.displacement = np.r_[rod.slices["x"], rod.slices["y"]]
        if acceleration == "aitken":
            self.acceleration = Aitken()
        else:
            self.acceleration = IqnIls(self.displacement.size, self.stations.size)
        self.last_stations = None
        self.iterations, self.convergence = array("d"), array("d")

    def step(self, t: float, h: float) -> int:
        rod, fluid, stations, given = self.rod, self.fluid, self.stations, self.fluid.inputs
        before = stations.copy()
        rounding = STATION_ROUNDING * np.linalg.norm(before[self.displacement])
        number = len(self.iterations) // len(ITERATIONS) + 1
        self.acceleration.begin()
        rod.save()
        fluid.save()

        # The first guess is the straight line through the last two.
        given[:] = before if self.last_stations is None else 2 * before - self.last_stations
        for iteration in range(1, self.max_iterations + 1):
            if iteration > 1:
                rod.restore()
                fluid.restore()
            fluid.step(t, h)
            self.take(t + h)
            rod.step(t, h)
            residual = (stations - given)[self.displacement]
            change = float(np.linalg.norm((stations - before)[self.displacement]))
            error = float(np.linalg.norm(residual))
            limit = max(self.tolerance * change, rounding)
            self.convergence.extend((number, iteration, error / change if change > 0.0 else 0.0))
            self.acceleration.learn(residual, stations)
            if error <= limit:
                self._log(number, iteration)
                self.last_stations = before
                return iteration
            if not np.isfinite(error):
                break
            given[:] = self.acceleration.guess(given, stations)
        raise CouplingError(
            f"the step from t = {t:g} s to {t + h:g} s did not converge in {iteration} iterations: the "
            f"residual of the stations is {error:.3g} m, but {limit:.3g} m is the limit"
        )

    def _log(self, number: int, iterations: int) -> None:
        total = self.iterations[-len(ITERATIONS) + 1] if self.iterations else 0.0
        a = self.acceleration
        self.iterations.extend((number, total + iterations, iterations, a.columns, a.deleted, a.dropped))

    def memory(self) -> dict[str, np.ndarray]:
        own = {name: np.array(log) for name, log in (("iterations", self.iterations), ("convergence", self.convergence))}
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
            name: np.rec.fromarrays(np.array(rows).reshape(-1, len(columns)).T, names=",".join(columns))
            for name, columns, rows in tables
        }


def takes_momentum(rod: Unit) -> bool:
    """Whether `rod` takes the momentum load, which comes with an impedance."""
    impedance = rod.variables.get("impedance")
    return impedance is not None and impedance.causality == "input"


def couple(units: dict[str, Unit], coupling: dict | None, drive: Drive | None = None) -> Single:
    """The units of a scene under its `coupling`; `choice` of what is returned says what was chosen where it does not say.
    `drive` moves a root that the scene leaves to the master.

    The load is chosen by the units, when they are packed. The scheme follows from it: explicit under the momentum load,
    which is implicit by itself; iterated under the pressure jump, which is not.
    """
    if len(units) == 1:
        return Single(*units.values(), drive)
    rod, fluid = units["rod"], units["fluid"]
    load = "momentum" if takes_momentum(rod) else "pressure_jump"
    scheme, reason = (coupling or {}).get("scheme"), "the scene says so"
    if scheme is None and load == "momentum":
        scheme, reason = "explicit", "the momentum load with its impedance is implicit by itself"
    elif scheme is None:
        scheme, reason = {"iterated": {}}, "the pressure jump holds the added mass, which an explicit scheme leaves a step late"
    if scheme == "explicit":
        made = Explicit(rod, fluid, drive)
    elif scheme == "parallel_explicit":
        made = ParallelExplicit(rod, fluid, drive)
    else:
        made = Iterated(rod, fluid, drive, **scheme["iterated"])
    name = scheme if isinstance(scheme, str) else f"iterated, {scheme['iterated'].get('acceleration', 'iqn_ils')}"
    why = rod.variables.get("load.reason")
    made.choice = {
        "load": load,
        "load_reason": why.start[0] if why else "the rod has no other input",
        "scheme": name,
        "scheme_reason": reason,
    }
    return made
