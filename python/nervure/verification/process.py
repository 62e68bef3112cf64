"""A verification: runs in rounds, from the cheap ones on, until the bars are narrow enough or the budget ends."""

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from dataclasses import MISSING, dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from time import process_time, time

from nervure.catalogue import hint
from nervure.errors import InputError, SceneError, UnitError
from nervure.evaluate import coefficients, statistics
from nervure.evaluate.flapping import Flapping
from nervure.output import console as shown, forecast
from nervure.scene import Scene, document
from nervure.scene.facts import Facts
from nervure.simulation import results, sweep
from nervure.simulation.session import Session
from nervure.simulation.summary import Summary, is_force, quantities
from nervure.simulation.sweep import FAILED, FINISHED, Case, Row
from nervure.simulation.verified import Quantity, Share, Verified, is_part, physics, sizes
from nervure.terminal import Console
from nervure.verification.estimate import bars, combine, estimate, noise_of
from nervure.verification.plan import PARAMETERS, ROOT2, Factors, Parameter, Plan, Setting

START = 3.0  # Wall time that workers take to start, s, until it is measured
WORTH = 3  # Ratio to it of the wall time of runs from which on workers make them, not this process in turn
TRIAL = 0.25  # Largest part of the budget that the first run may take
ALIKE, MAIN = 0.3, 3  # Largest relative difference of runs of the same flow, in so many of the first quantities
REGULAR = 0.1  # Largest relative statistical error of a run beside which others change
LEAST = 3  # Runs of the first parameter that are enough
ROUNDS = 10  # Most rounds of a verification
TRIED = 0.15  # Wall time of the steps that measure the pace, s
TOPS = [2 ** (i / 4) for i in range(9)]  # Sizes of the finest run where the scene itself costs too much
EFFORT = ("wall_s", "cpu_s", "simulated_s", "iterations_mean", "amplitude_drift", *(one.name for one in PARAMETERS))
"""Numbers of a run that are no results."""
MINOR = 0.01  # Part of the largest quantity of its unit below which one is left out
MEAN = 0.1  # The same of a mean beside its own amplitude
UNSETTLED = 0.3  # Part by which an amplitude changes over the window from which on a swing has no limit
SAME = 0.1  # Largest relative difference of a frequency from that of the window
SHARED = 0.5  # Part of the tolerance that a recommended setting leaves to all parameters but the first
FINEST, FINER = 0.1, 2**0.25  # Smallest recommended size, and ratio of two that are tried
STATISTICS = ("mean", "amplitude", "frequency_hz")


@dataclass
class Costs:
    """Wall times of runs, s, from their work: by the finished run that is nearest to it, or the pace of first steps."""

    finished: list[tuple[float, float]] = field(default_factory=list)  # Work and wall time, s
    paces: list[tuple[float, float]] = field(default_factory=list)  # The same, expected

    def measure(self, setting: Setting, now: Callable[[], float]) -> None:
        """Measure the pace of a setting by its first steps, with the time until these begin."""
        begin, wall = now(), time()
        with suppress(UnitError), Session(setting.scene) as session:  # A run that fails at once says so later
            ready = now() - begin
            expected = forecast.measured(session, TRIED)
            self.paces.append((setting.work, ready + expected * (now() - begin) / (time() - wall)))

    def of(self, work: float) -> float:
        """Return the expected wall time of a run, s."""
        if not (known := self.finished or self.paces):
            return 0.0
        nearest = min(known, key=lambda one: abs(math.log(one[0] / work)))
        return nearest[1] * work / nearest[0]


@dataclass(frozen=True)
class Outcome:
    """A finished verification: what is known, and the settings with the rows of their runs."""

    verified: Verified | None  # None where no run gave a value
    plan: Plan
    runs: list[tuple[Setting, Row]]
    recommended: Scene | None
    front: list[tuple[float, float]]  # Expected wall time, s, and largest relative error of finer and coarser settings
    problems: list[str]  # Why something is missing, in sentences

    @property
    def reached(self) -> bool:
        """Whether all bars are within the tolerance."""
        return self.verified is not None and self.verified.reached


@dataclass
class Verification:
    """Finds the errors of a scene by runs into a folder until all bars are narrow enough, or for a time."""

    scene: Scene
    folder: Path
    within: float
    budget: float  # Time, s
    quantities: Sequence[str] = ()
    parameters: Sequence[str] = ()
    workers: int | None = None
    scheduler: str | None = None
    force: bool = False
    console: Console = field(default_factory=partial(shown.text_console, quiet=True))
    cpu: bool = False  # Whether times are those of this process, which makes all runs in turn, not of the wall

    def __post_init__(self) -> None:
        self.now, self.clock = (process_time, "cpu_s") if self.cpu else (time, "wall_s")
        self.begin = self.now()
        self.plan, self.costs = Plan(self.scene, self.parameters), Costs()
        self.settings: dict[str, Setting] = {}
        self.rows: dict[str, Row] = {}
        self.noise: dict[tuple[str, str], float] = {}  # By folder and column
        self.names: list[str] = []
        self.units: dict[str, str] = {}
        self.drift: float | None = None  # Of a finest run that is not settled
        self.problems: list[str] = []
        self.start = START  # Wall time that workers take to start, s
        self.at_once = 1 if self.cpu else sweep.at_once(self.scheduler, self.workers)
        self.refused: dict[str, str] = {}  # Why the budget does not allow a run, by name

    @property
    def left(self) -> float:
        """Time that is left, s."""
        return self.begin + self.budget - self.now()

    def _say(self, line: str) -> None:
        self.console.print(line, markup=False, soft_wrap=True)

    def run(self) -> Outcome:
        """Make the runs, the cheap ones first, and return what they show."""
        sweep.check_drives([document(self.scene)], "a verification")
        todo = self._first_round()
        for _ in range(ROUNDS):
            self._make(todo)
            self._choose_quantities()
            if self._reached(found := self._found()):
                break
            wanted = self._next_round(found)
            if not (todo := [one for one in wanted if self._allowed(one)]):
                self.problems += [] if wanted or not found else [self._too_wide(found, "no further run narrows that")]
                break
        else:
            self.problems.append(self._too_wide(found, f"there are at most {ROUNDS} rounds of runs"))
        return self._outcome()

    def _too_wide(self, found: dict[str, Quantity], why: str) -> str:
        """Return why runs end within the budget and before the tolerance is reached."""
        if not found or all(one.uncertainty <= self.within * one.scale for one in found.values()):
            return f"fewer than {LEAST} runs of {self.plan.first.name} gave values: {why}"
        name, widest = max(found.items(), key=lambda own: own[1].uncertainty / own[1].scale)
        made_by = bars(widest.shares)
        return (
            f"the budget is not used up: ± {widest.uncertainty / widest.scale:.2g} of {name} comes mostly from "
            f"{max(made_by, key=lambda own: made_by[own])}, and {why}"
        )

    def _first_round(self) -> list[Setting]:
        """Return the first settings: those of the scene, or of coarser ones where these cost too much. The cheapest one
        is made at once, if the budget allows it, and shows what the others cost."""
        while len(self._in_sequence(settings := list(self.plan.first_settings()))) < 2:
            self.plan.skip_first()
        if self.quantities:
            with suppress(UnitError), Session(settings[0].scene) as session:  # A run that fails at once says so later
                check_names(self.quantities, session.facts, session.recorder.columns)
        if not any(map(self._known, settings)):
            self.costs.measure(settings[0], self.now)
        self._announce(settings)
        if self._cost(settings[0]) <= TRIAL * self.left:
            self._make(settings[:1])
        cheapest = math.inf
        for top in TOPS:
            settings = list(self.plan.first_settings(top))
            costs = sorted(map(self._cost, settings))
            if len(costs) > 1:
                cheapest = min(cheapest, sum(costs[:2]))
                if self._together(costs) <= self.left:
                    break
        else:
            settings = self._in_sequence(settings)
            if self.rows and self.left <= 0:
                return []
            if sum(map(self._cost, settings[:2])) > self.left or len(settings) < 2:
                used, left = "a first run" if self.rows else "the first steps", forecast.duration(max(self.left, 0.0))
                raise InputError(
                    f"the budget of {forecast.duration(self.budget)}, of which {used} left {left}, is too small "
                    f"for two runs of {self.scene.name}: the cheapest two take about {forecast.duration(cheapest)}"
                )
        if top > 1.0:
            self._announce(settings)
        return sorted(settings, key=lambda one: one.work)

    def _announce(self, settings: Sequence[Setting]) -> None:
        total = forecast.duration(self._together([*map(self._cost, settings)]))
        names = "; ".join(one.name for one in settings)
        self._say(f"{len(settings)} runs, about {total} of a budget of {forecast.duration(self.budget)}: {names}")

    def _cost(self, setting: Setting) -> float:
        """Return the expected wall time of a run, s; 0 for one that was made before."""
        return 0.0 if self._known(setting) else self.costs.of(setting.work)

    def _together(self, costs: Sequence[float]) -> float:
        """Return the expected wall time of runs, in turn or by workers where these are worth their start, s."""
        total = sum(costs)
        if self.at_once == 1 or (total < WORTH * self.start and self.scheduler is None):
            return total
        return self.start + max([*costs, total / self.at_once])

    def _in_sequence(self, settings: Iterable[Setting]) -> list[Setting]:
        """Return the settings in which only the first parameter differs from the scene."""
        return [one for one in settings if one.factors.keys() == {self.plan.first.name}]

    def _known(self, setting: Setting) -> bool:
        """Return whether an earlier verification made a run."""
        row = sweep.earlier_row(self._case(setting), self.folder)
        return row is not None and row["status"] in (FINISHED, FAILED)

    def _case(self, setting: Setting) -> Case:
        scene = document(setting.scene)
        return Case(scene, dict(setting.factors), sweep.key_of(scene), setting.name)

    def _allowed(self, setting: Setting) -> bool:
        """Return whether a run fits into what is left of the budget."""
        if (cost := self._cost(setting)) <= self.left:
            return True
        left = forecast.duration(max(0.0, self.left))
        self.refused[setting.name] = f"{setting.name} would take about {forecast.duration(cost)}, and {left} are left"
        return False

    def _make(self, todo: Iterable[Setting]) -> None:
        """Make the runs `todo` that have no row, the cheap ones first, and read what they found."""
        for setting in todo:
            self.settings[setting.name] = setting
        cases = {name: self._case(setting) for name, setting in self.settings.items()}
        missing = [cases[name] for name, setting in self.settings.items() if not self._known(setting)]
        expected = sum(self.costs.of(self.settings[case.folder].work) for case in missing)
        short = len(missing) == 1 or expected < WORTH * self.start or self.cpu
        in_turn = short or self.at_once == 1
        begin = time()
        with shown.sweep_progress(self.console, len(missing), sum(case.steps for case in missing)) as count:
            rows = sweep.run(
                list(cases.values()),
                self.folder,
                self.scheduler,
                missing,
                self.force,
                self._say,
                count,
                1 if in_turn and self.scheduler is None else self.workers,
                lambda case: self._allowed(self.settings[case.folder]),
                self.begin + self.budget,
                self.cpu,
            )
        spent = sum(row[self.clock] for row in rows if row["folder"] not in self.rows)
        self.start = self.start if in_turn else max(self.start, time() - begin - spent)
        for row in rows:
            setting = self.settings[row["folder"]]
            if row["status"] == FINISHED and row["folder"] not in self.rows:
                self.costs.finished.append((setting.work, row[self.clock]))
            elif row["folder"] not in self.rows:
                self.problems.append(f"the run {setting.name} {row['status']}: {row['reason']}")
            self.rows[row["folder"]] = row

    def _finished(self) -> dict[str, Row]:
        return {name: row for name, row in self.rows.items() if row["status"] == FINISHED}

    def _sequence(self) -> list[Setting]:
        """Return the finished settings of the first parameter, the finest first."""
        first = self.plan.first.name
        found = [self.settings[name] for name in self._finished() if self.settings[name].factors.keys() <= {first}]
        return sorted(found, key=lambda one: one.sizes[first])

    def _choose_quantities(self) -> None:
        """Choose the quantities by the finest run, and read the statistical errors of new runs."""
        if not (sequence := self._sequence()):
            return
        finest = results.read(self.folder / sequence[0].name).summary
        self.names = chosen(finest, self.rows[sequence[0].name], self.quantities)
        self.units = {name: unit_of(name, finest) for name in self.names}
        self.drift = finest.amplitude_drift if unsettles(finest) else None
        for folder in self._finished():
            if missing := [name for name in self.names if (folder, name) not in self.noise]:
                made = results.read(self.folder / folder)
                window = made.summary.window
                width = statistics.force_filter_width(window) if window else 0.0
                for name in missing:
                    self.noise[folder, name] = noise_of(name, made.series, window, width)

    def _share(self, name: str, settings: Sequence[Setting], parameter: str) -> Share | None:
        """Return the error of a quantity by a parameter from the runs that have it."""
        having = [one for one in settings if isinstance(self.rows[one.name].get(name), int | float)]
        if not having:
            return None
        values = [float(self.rows[one.name][name]) for one in having]
        if parameter == self.plan.first.name:
            noise = [self.noise.get((one.name, name), 0.0) for one in having]
        else:  # They differ little, so their statistical errors are the same, and relative changes hold on finer cells
            noise, pair = [0.0 for _ in having], (min(having, key=lambda one: len(one.factors)), self._sequence()[0])
            own, finest = (abs(self.rows[one.name].get(name) or 0.0) for one in pair)
            values = [value * min(1.0, finest / own) if own else value for value in values]
        return estimate([one.sizes[parameter] for one in having], values, noise)

    def _found(self) -> dict[str, Quantity]:
        """Return what is known of each quantity; nothing before two runs of the first parameter."""
        sequence = self._sequence()
        if len(sequence) < 2:
            return {}
        found = {}
        for name in self.names:
            first = self._share(name, sequence, self.plan.first.name)
            if first is None or len(first.values) < 2:
                continue
            shares = {self.plan.first.name: first}
            for parameter in self.plan.others:
                beside = self._beside(parameter)
                if len(beside) > 1 and (share := self._share(name, beside, parameter.name)):
                    shares[parameter.name] = share
            row = self.rows[sequence[0].name]
            value, limit, uncertainty = combine(shares)
            amplitude = row.get(f"{name.removesuffix('_mean')}_amplitude") if name.endswith("_mean") else None
            found[name] = Quantity(
                value=value,
                limit=limit,
                uncertainty=uncertainty,
                scale=max(abs(value), abs(amplitude or 0.0)),
                unit=self.units[name],
                shares=shares,
            )
        return found

    def _base(self) -> Setting | None:
        """Return the setting beside which the other parameters vary: the coarsest one with a run for them already, or
        else the coarsest one, whose values are `ALIKE` those of the finest run and regular; None before any run."""
        if not (sequence := self._sequence()):
            return None
        coarse = [one for one in reversed(sequence) if one.sizes[self.plan.first.name] >= 1.0] or sequence[:1]
        alike = [one for one in coarse if self._is_alike(one, sequence[0])] or coarse
        first = self.plan.first.name
        beside = [one.factors.get(first) for one in self.settings.values() if len(one.factors) > 1]
        used = [one for one in alike if one.factors.get(first) in beside]
        return (used or alike)[0]

    def _is_alike(self, setting: Setting, finest: Setting) -> bool:
        """Return whether the main values of two runs are of the same flow, and their scatter in the first is small."""
        row, best = self.rows[setting.name], self.rows[finest.name]
        main = [name for name in self.names if best.get(name) is not None][:MAIN]
        return all(
            row.get(name) is not None
            and abs(row[name] - best[name]) <= ALIKE * abs(best[name])
            and self.noise.get((setting.name, name), 0.0) <= REGULAR * abs(best[name])
            for name in main
        )

    def _beside(self, parameter: Parameter) -> list[Setting]:
        """Return the finished settings in which at most `parameter` differs from the coarse one, or where it did not
        change there, from a coarser one where it did."""
        base, first = self._base(), self.plan.first.name
        done = [self.settings[name] for name in self._finished()]
        found = list[list[Setting]]()
        for origin in [one for one in self._sequence() if base and one.sizes[first] >= base.sizes[first]]:
            differ = ({k: v for k, v in one.factors.items() if k != parameter.name} == origin.factors for one in done)
            found.append([one for one, same in zip(done, differ, strict=True) if same])
        return next((runs for runs in found if len(runs) > 1), found[0] if found else [])

    def _reached(self, found: dict[str, Quantity]) -> bool:
        first = self.plan.first.name
        return bool(found) and all(
            one.uncertainty <= self.within * one.scale and len(one.shares[first].sizes) >= LEAST
            for one in found.values()
        )

    def _next_round(self, found: dict[str, Quantity]) -> list[Setting]:
        """Return the next settings: of parameters without a second run, and finer ones of those that make most of the
        bars that are too wide."""
        base, first, wanted = self._base(), self.plan.first, list[Setting]()
        wide = [one for one in found.values() if one.uncertainty > self.within * one.scale]
        costly = base is not None and base.factors.get(first.name, 1.0) < self.plan.levels[1]
        for parameter in self.plan.parameters:
            part, beside = is_part(parameter.name, self.plan.sizes), self._beside(parameter)
            few = len(self._sequence() if parameter is first else beside) < (LEAST if parameter is first else 2)
            again = base is not None and parameter is not first and base not in beside
            if not few and (part or not _matters(wide, parameter.name, self.within / ROOT2, again)):
                continue
            if base and parameter is not first and (few or again):
                known = parameter.name in self.plan.left_out or (part and costly)
                wanted += [] if known else self.plan.beside(base, [parameter])
            elif finer := self._finer(parameter):
                wanted.append(finer)
        made = [one.sizes for one in self.settings.values()]
        return [one for one in wanted if one.name not in self.settings and one.sizes not in made]

    def _finer(self, parameter: Parameter) -> Setting | None:
        """Return the next finer setting of a parameter; None where the scene cannot have it."""
        try:
            if parameter is self.plan.first:
                made = [one for one in self.settings.values() if one.factors.keys() <= {parameter.name}]
                last = min(made, key=lambda one: one.factors.get(parameter.name, 1.0))
                if last.name not in self._finished():
                    return None  # Finer ones would fail too
                finer = round(last.factors.get(parameter.name, 1.0) / self.plan.ratio, 6)
                return self.plan.setting({parameter.name: finer})
            if (base := self._base()) is None:
                return None
            beside = [one.factors.get(parameter.name, 1.0) for one in self._beside(parameter)]
            outward = parameter.outward ** (1 + sum(factor <= parameter.outward for factor in beside))
            return self.plan.setting({**base.factors, parameter.name: outward})
        except SceneError as error:
            self.problems.append(f"{parameter.name} cannot be finer: {error}")
            return None

    def _outcome(self) -> Outcome:
        found, rows = self._found(), self._finished()
        runs = [(self.settings[name], row) for name, row in self.rows.items()]
        self.problems += [f"not varied: {name}: {why}" for name, why in self.plan.left_out.items()]
        self.problems += [f"the budget ended: {why}" for why in self.refused.values()]
        if self.drift is not None:
            self.problems.append(
                f"over its window the finest run changes by {self.drift:+.0%} of its amplitude: what swings has no "
                "limit unless it is named, and a wide bar then; take a larger `time.end`"
            )
        if not found:
            what = (
                "fewer than two runs gave values"
                if self.names
                else "the outputs that are wanted are rounding, or not settled"
            )
            self.problems.append(f"nothing is known of errors: {what}")
            return Outcome(None, self.plan, runs, None, [], self.problems)
        recommended, front = self._recommend(found)
        verified = Verified(
            scene=self.scene.name,
            physics=physics(self.scene),
            sizes=self.plan.sizes,
            quantities=found,
            within=self.within,
            reached=self._reached(found),
            runs=len(rows),
            wall_s=sum(row[self.clock] for row in rows.values()),
        )
        if recommended:
            scene, expected, wall = recommended
            relative = {name: size / self.plan.sizes[name] for name, size in sizes(scene).items()}
            verified = replace(verified, recommended=relative, recommended_error=expected, recommended_wall_s=wall)
        verified.write(self.folder)
        return Outcome(verified, self.plan, runs, recommended[0] if recommended else None, front, self.problems)

    def _recommend(
        self, found: dict[str, Quantity]
    ) -> tuple[tuple[Scene, float, float] | None, list[tuple[float, float]]]:
        """Return the cheapest setting whose errors are within the tolerance, or else the best one that a run of the
        length of the budget can have, with its error and wall time, s; and the front of error over time."""
        others = {
            parameter.name: max(parameter.outward, parameter.other if parameter.other < 1 else 0.0)
            for parameter in self.plan.others
            if not is_part(parameter.name, self.plan.sizes) and _beyond(found, parameter.name, self.within)
        }
        first, front = self.plan.first.name, list[tuple[float, float, Scene]]()
        finest = self._sequence()[0].sizes[first]
        size = self._sequence()[-1].sizes[first]
        while size >= FINEST and not (front and size < finest / ROOT2 and front[-1][1] <= self.within):
            with suppress(SceneError):
                setting = self.plan.setting({first: size, **others})
                error = max(_expected(one, setting.sizes, finest, first) / one.scale for one in found.values())
                front.append((self.costs.of(setting.work), error, setting.scene))
            size /= FINER
        for i in reversed(range(len(front) - 1)):  # A coarser setting that is better is so by chance
            front[i] = (front[i][0], max(front[i][1], front[i + 1][1]), front[i][2])
        within = [one for one in front if one[1] <= self.within]
        allowed = [one for one in front if one[0] <= self.budget]
        best = within[0] if within else min(allowed, key=lambda one: one[1], default=None)
        return (best[2], best[1], best[0]) if best else None, [(wall, error) for wall, error, _ in front]


def _matters(wide: Sequence[Quantity], parameter: str, limit: float, again: bool = False) -> bool:
    """Return whether a parameter makes much of a bar that is too wide, more than `limit`, and half as much as any, or
    most of it; and whether a run could narrow it: one beside `again` another setting, or where it is not the difference
    of the finest run from the size 1."""
    for one in wide:
        made_by = bars(one.shares)
        most, own = max(made_by.values()), made_by.get(parameter, 0.0)
        is_much = own >= min(most, max(limit * one.scale, most / 2))
        if is_much and (again or one.shares[parameter].uncertainty >= SHARED * own):
            return True
    return False


def _beyond(found: dict[str, Quantity], parameter: str, within: float) -> bool:
    """Return whether the bar by a parameter is wider than its part of the tolerance."""
    shares = [(one, share) for one in found.values() if (share := one.shares.get(parameter))]
    return any(share.bar() > SHARED * within * one.scale for one, share in shares)


def _expected(quantity: Quantity, relative: Factors, finest: float, first: str) -> float:
    """Return the expected error of a run: of sizes below those of the runs, the bar shrinks with the error."""
    share = quantity.shares[first]
    order = min((exponent for _, exponent in share.terms if exponent), default=1.0)
    shrunk: float = min(1.0, (relative[first] / finest) ** order)
    return quantity.error(relative) - share.uncertainty * (1 - shrunk)


def chosen(summary: Summary, row: Row, wanted: Sequence[str]) -> list[str]:
    """Return the columns of the table of runs that are verified: those of the `wanted` outputs, or of all outputs that
    are settled and not small beside others of their unit. Of these one shows the frequency, that of the periods of the
    window: the others have it too or a multiple, and noise may change which."""
    found, window = [], summary.window
    pace = window.periods / (window.end - window.begin) if window else 0.0
    frequencies = {name: one.frequency_hz or 0.0 for name, one in summary.quantities.items()}
    main = next((name for name, one in frequencies.items() if abs(one - pace) < SAME * pace), None)
    largest: dict[str, float] = {}
    for name, quantity in summary.quantities.items():
        kind = "force" if is_force(name) else quantity.unit
        largest[kind] = max(largest.get(kind, 0.0), abs(quantity.mean) + quantity.amplitude)
    for name, quantity in summary.quantities.items():
        kind = "force" if is_force(name) else quantity.unit
        unsettled = unsettles(summary) and quantity.amplitude > MEAN * abs(quantity.mean)
        if (name not in wanted) if wanted else unsettled:
            continue
        if quantity.state == "rounding" or (
            not wanted and abs(quantity.mean) + quantity.amplitude < MINOR * largest[kind]
        ):
            continue
        swings = quantity.frequency_hz is not None and (wanted or quantity.amplitude >= MINOR * largest[kind])
        if not swings or abs(quantity.mean) >= MEAN * quantity.amplitude:
            found.append(f"{name}_mean")
        if swings:
            regular = wanted or (name == main and quantity.state in ("periodic", "drifting"))
            found += [f"{name}_amplitude", *([f"{name}_frequency_hz"] if regular else [])]
    numbers = [key for key, value in row.items() if isinstance(value, int | float) and key not in EFFORT]
    for name in wanted:
        if name in numbers and name not in found:
            found.append(name)
        elif name not in summary.quantities and name not in found and row.get(name, name) is not None:
            raise _unknown(name, [*summary.quantities, *numbers])  # What has no value here may have one in another run
    return found


def check_names(wanted: Sequence[str], facts: Facts, columns: Collection[str]) -> None:
    """Raise `InputError` where one of the `wanted` quantities is in no run of a scene that records these `columns`."""
    outputs = [name for name in quantities(facts) if name in columns]
    known = [*outputs, *(f"{name}_{what}" for name in outputs for what in STATISTICS)]
    known += [name for name in sweep.REPORTED if name not in EFFORT]
    known += coefficients.NAMES if coefficients.scale(facts) else []
    if "rigid_tip_ux" in columns:  # Without a fluid only what needs no default has a value
        of_drive = [own for own in fields(Flapping) if facts.scene.fluid or own.default is MISSING]
        known += [own.name for own in of_drive if own.type in (float, float | None)]
    for name in wanted:
        if name not in known:
            raise _unknown(name, known)


def _unknown(name: str, known: Iterable[str]) -> InputError:
    return InputError(f"the quantity `{name}` is not in the results: {hint(name, known)}")


def unsettles(summary: Summary) -> bool:
    """Return whether the amplitude changes so much that it is that of a time, not of a flow."""
    return abs(summary.amplitude_drift or 0.0) > UNSETTLED


def unit_of(name: str, summary: Summary) -> str:
    """Return the unit of a column of the table of runs."""
    column = next((f"_{what}" for what in STATISTICS if name.endswith(f"_{what}")), "")
    if column == "_frequency_hz":
        return "Hz"
    known = summary.quantities.get(name.removesuffix(column))
    return known.unit if known else ""
