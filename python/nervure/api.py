"""The Python interface: the functions of `nervure`, and the class of a run."""

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nervure import arguments
from nervure.catalogue import hint
from nervure.coupling import Drive
from nervure.errors import InputError
from nervure.extras import require
from nervure.files import claimed, undone_on_error
from nervure.scene import Scene, document, load, plain, read as read_scene, with_files
from nervure.scene.facts import Facts
from nervure.simulation import checkpoint, results, sweep as sweeps
from nervure.simulation.loop import Observer, TimeLoop, interruptible
from nervure.simulation.session import Session

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame
    from PIL.Image import Image
    from xarray import Dataset

    from nervure.terminal import Console
    from nervure.verification.process import Outcome

__all__ = ["Run", "RunError", "compare", "inspect", "load", "read", "resume", "run", "sweep", "verify"]

OnStep = Callable[[float, dict[str, float]], object]
SHOWN = 7  # Quantities in the text of a run


class Run(results.Results):
    """A run: `scene`, `folder`, `summary`, and its `series` by name, in `units`."""

    def __repr__(self) -> str:
        """Return about ten lines: how far the run came, its first quantities, its columns."""
        summary, columns = self.summary, list(self.series)
        how = "" if summary.completed else f", {summary.error or 'interrupted'}"
        lines = [f"Run of {self.scene.name}, {summary.steps} steps to t = {summary.simulated_s:g} s{how}"]
        for name, found in list(summary.quantities.items())[:SHOWN]:
            frequency = f", {found.frequency_hz:.4g} Hz" if found.frequency_hz else ""
            lines.append(f"  {name}: {found.mean:.4g} ± {found.amplitude:.4g} {found.unit}{frequency}")
        if len(summary.quantities) > SHOWN:
            lines.append(f"  and {len(summary.quantities) - SHOWN} more in run.summary.quantities")
        shown = ", ".join(columns[:4]) + (" …" if len(columns) > 4 else "")
        lines.append(f"  series: {len(self.series['time'])} rows of {len(columns)} columns, {shown}")
        return "\n".join([*lines, f"  folder: {self.folder}"])

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the quantities as a table, and the last picture."""
        from nervure.output import notebook

        return notebook.html(self)

    def to_pandas(self) -> "DataFrame":
        """Return the series as a DataFrame over time (s); `attrs["units"]` has the unit of each column."""
        table = require("pandas", "a table of pandas").DataFrame(dict(self.series)).set_index("time")
        table.attrs["units"] = dict(self.units)
        return table  # type: ignore[no-any-return, unused-ignore]

    def to_xarray(self) -> "Dataset":
        """Return the series as a Dataset over time; each variable has its unit as the attribute `units`."""
        columns = {
            name: ("time", values, {"units": self.units.get(name) or "1"}) for name, values in self.series.items()
        }
        return require("xarray", "a dataset of xarray").Dataset(columns)  # type: ignore[no-any-return, unused-ignore]

    def fields(self, begin: float | None = None, end: float | None = None) -> "Dataset":
        """Return velocity (`u`, `v`), vorticity and pressure from `begin` to `end` (s) as a Dataset over time, y and x.
        The run needs `fields_every`."""
        from nervure.output import fields

        begin, end = arguments.if_given("begin", begin), arguments.if_given("end", end)
        return fields.dataset(self.folder, begin, end)  # type: ignore[no-any-return, unused-ignore]

    def plot_field(
        self,
        name: str = "vorticity",
        time: float | None = None,
        *,
        across: str | None = None,
        at: float | None = None,
        crop: Sequence[float] | None = None,
    ) -> "Figure":
        """Draw `vorticity`, `pressure`, `speed`, `u`, `v` or `w` at the frame nearest to `time` (s), by default the
        last. In space it is a slice `across` an axis, "x", "y" or "z", `at` a place (m), by default through the bodies.
        `crop` shows a part: its ends along each axis, m. The run needs `fields_every`."""
        _prepare_notebook()
        from nervure.output import animation

        name, time = arguments.text("name", name), arguments.if_given("time", time)
        return animation.plot_field(self.folder, name, time, animation.Part(across, at, crop).checked())

    def plot_vortices(
        self,
        time: float | None = None,
        *,
        q: float | None = None,
        camera: Sequence[float] | None = None,
        crop: Sequence[float] | None = None,
        background: str = "white",
    ) -> "Image":
        """Draw surfaces of equal `q` (1/s²) around the bodies in space at the frame nearest to `time` (s), by default
        the last; `image.save(path)` writes them. `camera` is the direction to the eye, `crop` the ends of the part
        that is shown along each axis, m. The run needs `fields_every`."""
        from nervure.output import animation, vortices

        look, time = vortices.Look(q, camera, background), arguments.if_given("time", time)
        return animation.plot_vortices(self.folder, time, look, animation.Part(crop=crop).checked())

    def plot(self, *names: str) -> "Figure":
        """Draw the columns `names` over time, below each other; `figure.savefig(path)` writes them."""
        shown = arguments.texts("names", names)
        self._require(shown)
        _prepare_notebook()
        from nervure.evaluate import benchmark
        from nervure.output import plots

        return plots.over_time({self.scene.name: self}, shown, benchmark.reference(self.scene))

    def _require(self, names: Iterable[str]) -> None:
        """Raise `InputError` where there are no `names`, or one was not recorded."""
        if not names:
            raise InputError(f"there is no column to draw: {hint('', self.series)}")
        for name in names:
            if name not in self.series:
                raise InputError(f"{name} was not recorded: {hint(name, self.series)}")

    def animate(
        self,
        begin: float | None = None,
        end: float | None = None,
        *,
        across: str | None = None,
        at: float | None = None,
        crop: Sequence[float] | None = None,
        q: float | None = None,
        camera: Sequence[float] | None = None,
        background: str = "white",
    ) -> list[Path]:
        """Write vorticity.gif, vorticity.mp4 and phases.png of the times from `begin` to `end` (s), or of the last two
        whole periods, into the folder, of a fluid in space also vortices.gif; return their paths. The other arguments
        are those of `plot_field` and `plot_vortices`. The run needs `fields_every`."""
        from nervure.output import animation, vortices

        part, look = animation.Part(across, at, crop).checked(), vortices.Look(q, camera, background)
        begin, end = arguments.if_given("begin", begin), arguments.if_given("end", end)
        return animation.write(self.folder, begin, end, part, look)


def _prepare_notebook() -> None:
    """Let a notebook draw a figure that a cell gives, unless it does already."""
    if "ipykernel" not in sys.modules:
        return
    from IPython import get_ipython
    from IPython.core.pylabtools import select_figure_formats
    from matplotlib.figure import Figure

    shell = get_ipython()
    if shell is not None and not shell.display_formatter.format(Figure())[0].keys() & {"image/png", "image/svg+xml"}:
        select_figure_formats(shell, {"png"})


def compare(*runs: Run, names: str | Sequence[str] = ("tip_ux", "tip_uy")) -> "Figure":
    """Draw the columns `names` of several runs over each other, labelled by their folders; a column in several units
    has axes for each."""
    if not runs:
        raise InputError("there is no run to draw")
    names = arguments.texts("names", names)
    for run in runs:
        if not isinstance(run, Run):
            raise InputError(
                f"a run is {arguments.shown(run)}, but must be what `nervure.run` or `nervure.read` returns"
            )
        run._require(names)
    _prepare_notebook()
    from nervure.evaluate import benchmark
    from nervure.output import plots

    return plots.over_time(plots.labelled(runs), names, benchmark.reference(runs[0].scene))


class RunError(Exception):
    """A unit or the coupling failed in a run; `run` has the results before the failure."""

    def __init__(self, run: Run):
        super().__init__(run.summary.error)
        self.run = run


def inspect(scene: Scene | str | Path) -> None:
    """Print what `nervure inspect` prints of a scene, an object or a name; it makes some steps. Raise
    `InputError` where the scene cannot be used."""
    from nervure.output import console, inspection

    given = with_files(scene) if isinstance(scene, Scene) else load(scene)
    inspection.show_scene(console.text_console(), given)


def run(
    scene: Scene | str | Path,
    output: str | Path | None = None,
    *,
    overrides: Iterable[str] = (),
    rod_fmu: Path | Mapping[str, Path] | None = None,
    fluid_fmu: Path | None = None,
    checkpoint_every: float | None = None,
    fields_every: float | None = None,
    series_every: float | None = None,
    on_step: OnStep | None = None,
    drive: Drive | None = None,
    force: bool = False,
    quiet: bool = False,
    live: bool = False,
    fmi: int = 2,
) -> Run:
    """Run a scene, an object or a name, into the folder `output` or results/NAME.

    The arguments are the options of `nervure run`: `overrides` (key=value), FMUs in the place of ours (`rod_fmu` by
    name where the scene has several rods), minutes between checkpoints, seconds between fields and between rows of the
    series, `force`, which replaces results of another scene, `live`, which shows the run on a page of this machine or,
    in a notebook, in a figure below the cell, and `fmi`, the version of our units.

    `on_step(time, values)` is called with each recorded row of the series, a dictionary by column; where it returns
    a true value, the run ends there, and its checkpoint stays in the folder. `drive(time, values)` sets what the scene
    leaves to the master (`nervure.coupling.Drive`).

    >>> run = nervure.run("csm3", folder / "csm3", overrides=["time.end=0.1"], quiet=True)
    >>> run.summary.completed, len(run.series["tip_uy"])
    (True, 101)

    Raise `InputError` where an argument cannot be used, `RunError` where the run failed, `KeyboardInterrupt` where it
    was interrupted, and what `on_step` raises; in the last three cases the results so far are written.
    """
    from nervure.output.console import announce, warn

    scene = _scene(scene, overrides)
    if not (isinstance(fmi, int) and fmi in (2, 3)):
        raise InputError(f"fmi is {arguments.shown(fmi)}, but must be 2 or 3")
    if on_step is not None:
        arguments.function("on_step", on_step, "time and row")
    force, quiet, live = (arguments.flag(*own) for own in (("force", force), ("quiet", quiet), ("live", live)))
    if fields_every is not None:
        require("h5py", "writing fields")  # before units are packed
    folder = None if output is None else arguments.path("output", output)
    foreign = _foreign(scene, rod_fmu, fluid_fmu)
    given = {"checkpoint_every": checkpoint_every, "fields_every": fields_every, "series_every": series_every}
    options = {name: arguments.if_given(name, value, least=0.0) for name, value in given.items()}
    place = folder or Path("results") / scene.name
    with claimed(place), undone_on_error(place) as keep:
        if not quiet:
            announce(Facts(scene))
        session = Session.packed(
            scene, folder, foreign, fmi=fmi, force=force, series_every=options["series_every"], drive=drive
        )
        for name in ("fields_every", "series_every"):
            if text := session.grid.rounded(name, options[name]):
                session.warnings.append(text)
                if not quiet:
                    warn(text)
        return _run(session, options, quiet, live, keep, on_step)


def resume(
    folder: str | Path,
    *,
    end_time: float | None = None,
    drive: Drive | None = None,
    quiet: bool = False,
    live: bool = False,
) -> Run:
    """Continue the run in `folder` from its checkpoint, to another end time (s) if it is given: so a run that is
    finished goes on, if it was made with `checkpoint_every`. A driven run needs its `drive` again. Raise what `run`
    raises."""
    from nervure.output.console import announce

    folder, end_time = arguments.path("folder", folder), arguments.if_given("end_time", end_time, least=0.0)
    quiet, live = arguments.flag("quiet", quiet), arguments.flag("live", live)
    with claimed(folder) if folder.is_dir() else nullcontext():
        session, options = checkpoint.resume(folder, end_time, drive)
        if not quiet:
            announce(session.facts)
        return _run(session, options, quiet, live, started=lambda: None)


def _scene(scene: Scene | str | Path, overrides: Iterable[str]) -> Scene:
    """Return a scene, an object or a name, with what its files hold; only one that is read takes `overrides`."""
    overrides = arguments.texts("overrides", overrides)
    if not isinstance(scene, Scene):
        return load(scene, overrides)
    if overrides:
        raise InputError(f"{', '.join(overrides)}: a scene that is an object is changed by its attributes")
    return with_files(scene)


def _foreign(scene: Scene, rod_fmu: Path | Mapping[str, Path] | None, fluid_fmu: Path | None) -> dict[str, Path]:
    """Return the FMUs in the place of ours by unit; raise `InputError` for a rod or wing that the scene lacks."""
    if rod_fmu is not None and not isinstance(rod_fmu, Mapping):
        if scene.rods:
            given = arguments.shown(rod_fmu)
            raise InputError(f"rod_fmu is {given}, but the scene has several rods: it must be a dict by their names")
        rod_fmu = {"rod": arguments.path("rod_fmu", rod_fmu)}
    foreign = {name: arguments.path(f"the FMU of {name}", path) for name, path in (rod_fmu or {}).items()}
    names = [own.name for own in scene.rods] or (["rod"] if scene.rod else [])
    wings = [own.name for own in scene.wings] or (["wing"] if scene.wing else [])
    for name in foreign:
        if name not in [*names, *wings]:
            one = "one rod, which needs no name" if names else "no rod"
            known = f"the rods {', '.join(names)}" if scene.rods else one
            known += f" and the wings {', '.join(wings)}" if wings else ""
            raise InputError(f"an FMU is given for the rod `{name}`, but the scene has {known}")
    if fluid_fmu is None:
        return foreign
    fluid_fmu = arguments.path("fluid_fmu", fluid_fmu)
    if not scene.fluid:
        raise InputError(f"the FMU {fluid_fmu} is given for the fluid, but the scene has no fluid")
    return foreign | {"fluid": fluid_fmu}


class Caller(Observer):
    """Calls a function with every recorded row; `stopped` is what it answered, or true after the `error` it raised."""

    def __init__(self, call: OnStep):
        self.call, self.stopped = call, False
        self.error: Exception | None = None

    def step(self, loop: TimeLoop) -> None:
        recorder = loop.recorder
        if loop.steps % recorder.stride == 0:
            values = dict(zip(recorder.columns, recorder.table[recorder.rows - 1].tolist(), strict=True))
            try:
                self.stopped = bool(self.call(loop.time, values))
            except Exception as error:
                self.stopped, self.error = True, error


def _run(
    session: Session,
    options: checkpoint.Options,
    quiet: bool,
    live: bool,
    started: Callable[[], None],
    on_step: OnStep | None = None,
) -> Run:
    """Run a session to its end or an interruption, with everything that watches it; call `started` before its start."""
    from nervure.output import console, fields
    from nervure.output.pictures import Pictures

    caller, keeper, page = Caller(on_step or (lambda _time, _values: None)), None, None
    with session, ExitStack() as stack:
        if options["fields_every"] is not None:
            session.observers.append(fields.Fields(session, options["fields_every"], console.warn))
        if options["checkpoint_every"] is not None or all(unit.can_serialize for unit in session.units.values()):
            keeper = checkpoint.Checkpoint(session, options, console.warn)
            session.observers.append(keeper)
        if not quiet:
            session.observers.append(console.Terminal(session))
        if on_step:
            session.observers.append(caller)
        if live and console.in_notebook():
            from nervure.output.notebook import Figures

            session.observers.append(Figures(session))
        elif live:
            from nervure.output.live import Live

            page = stack.enter_context(Live(session, keeper))
            session.observers.append(page)
            console.text_console().print(f"live: {page.url}", markup=False, soft_wrap=True)
            page.open()
        session.observers.append(Pictures(session))  # Last: the table is printed before
        started()
        with interruptible() as stopping:
            session.run(lambda: caller.stopped or (page is not None and page.stopped) or stopping())
        done = Run(**vars(session.finish()))
    if caller.error is not None:
        raise caller.error
    if done.summary.error is not None:
        raise RunError(done)
    if not (done.summary.completed or caller.stopped):
        raise KeyboardInterrupt
    return done


def sweep(
    scenes: Scene | str | Path | Sequence[Scene | str | Path],
    vary: Mapping[str | tuple[str, ...], Sequence[Any]],
    output: str | Path | None = None,
    *,
    overrides: Iterable[str] = (),
    workers: int | None = None,
    scheduler: str | None = None,
    retry_failed: bool = False,
    force: bool = False,
    quiet: bool = False,
) -> list[sweeps.Row]:
    """Run all combinations of the values of scene keys into the folder `output` or results/sweep-NAME; return a row
    for each run. `pandas.DataFrame(rows)` makes a table of them.

    The values of a tuple of keys are tuples: these keys change together. The arguments are the options of
    `nervure sweep`; runs that are finished are not repeated.

    >>> scene = nervure.load("csm3").copy(time__end=0.1)
    >>> rows = nervure.sweep(scene, {"beam.segments": [8, 16]}, folder / "sweep", workers=1, quiet=True)
    >>> [(row["beam.segments"], row["status"]) for row in rows]
    [(8, 'finished'), (16, 'finished')]

    Raise `InputError` where an argument cannot be used and `KeyboardInterrupt` where the sweep was interrupted.
    """
    workers = _workers(workers, scheduler)
    force, quiet = arguments.flag("force", force), arguments.flag("quiet", quiet)
    several = [*scenes] if isinstance(scenes, Iterable) and not isinstance(scenes, _ONE_SCENE) else [scenes]
    if not several:
        raise InputError("there is no scene to sweep")
    overrides = arguments.texts("overrides", overrides)
    bases = [_scene(one, overrides) if isinstance(one, Scene) else read_scene(one, overrides) for one in several]
    if not isinstance(vary, Mapping):
        raise InputError(f"vary is {arguments.shown(vary)}, but must be a dictionary of the values by scene key")
    cases = sweeps.grid(bases, [_variation(keys, values) for keys, values in vary.items()])
    default = Path("results") / f"sweep-{sweeps.path_name(document(bases[0]))}"
    folder = default if output is None else arguments.path("output", output)
    todo = sweeps.missing_cases(cases, folder, arguments.flag("retry_failed", retry_failed))
    from nervure.output.console import text_console

    console = text_console(quiet)
    console.print(f"{len(cases)} runs, {len(todo)} to do, into {folder}", markup=False, soft_wrap=True)
    return run_cases(console, cases, todo, folder, scheduler=scheduler, workers=workers, force=force)


def run_cases(
    console: "Console",
    cases: list[sweeps.Case],
    todo: list[sweeps.Case],
    folder: Path,
    *,
    scheduler: str | None,
    workers: int | None,
    force: bool,
) -> list[sweeps.Row]:
    """Run the cases `todo` of a sweep into `folder`, draw and print the table, and return its rows."""
    from nervure.output import console as shown, sweeps as tables

    say = partial(console.print, markup=False, soft_wrap=True)
    with shown.sweep_progress(console, len(todo), sum(case.steps for case in todo)) as count:
        rows = sweeps.run(cases, folder, scheduler, todo, force, say, count, workers)
    tables.print_table(console, rows)
    picture = tables.plot(folder, rows)
    say(f"table in {folder / 'sweep.csv'}" + (f", picture in {picture}" if picture else ""))
    return rows


def verify(
    scene: Scene | str | Path,
    output: str | Path | None = None,
    *,
    within: float = 0.02,
    budget: float = 1200.0,
    quantities: Sequence[str] = (),
    parameters: Sequence[str] = (),
    overrides: Iterable[str] = (),
    workers: int | None = None,
    scheduler: str | None = None,
    force: bool = False,
    quiet: bool = False,
) -> "Outcome":
    """Find the errors of a scene by runs on other settings into the folder `output` or results/verify-NAME, until all
    bars are `within` a part of the values, or for a `budget` of wall time, s.

    `quantities` are outputs, such as `lift`, or columns of the table of runs, such as `lift_mean`; `parameters` are
    those to vary, by default all that the scene has. The other arguments are those of `sweep`. Runs that are finished
    are not repeated. The returned `verified` has the quantities with their bars, `recommended` is the scene with the
    cheapest setting within the tolerance.

    >>> scene = nervure.load("csm1").copy({"beam.segments": 8})
    >>> found = nervure.verify(scene, folder / "verify", quantities=["tip_uy"], budget=30, workers=1, quiet=True)
    >>> found.reached
    True

    Raise `InputError` where an argument cannot be used and `KeyboardInterrupt` where it was interrupted.
    """
    from nervure.output import console as shown, prior
    from nervure.verification import process, report

    within, budget = (arguments.number(*own, least=arguments.ABOVE) for own in (("within", within), ("budget", budget)))
    wanted, varied = arguments.texts("quantities", quantities), arguments.texts("parameters", parameters)
    workers = _workers(workers, scheduler)
    force, quiet = arguments.flag("force", force), arguments.flag("quiet", quiet)
    given = _scene(scene, overrides)
    folder = Path("results") / f"verify-{given.name}" if output is None else arguments.path("output", output)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"cannot write into the result folder {folder}: it is a file")
    console = shown.text_console(quiet)
    if likely := prior.expected(Facts(given)):
        console.print(likely, markup=False, soft_wrap=True)
    options = wanted, varied, workers, scheduler, force, console
    outcome = process.Verification(given, folder, within, budget, *options).run()
    report.print_outcome(console, outcome, folder, report.write(outcome, folder))
    return outcome


_ONE_SCENE = Scene, str, Path, bytes, Mapping


def _workers(workers: int | None, scheduler: str | None) -> int | None:
    """Return the number of workers of this machine; raise `InputError` for one beside a scheduler."""
    if workers is not None and scheduler is not None:
        raise InputError("workers are for runs on this machine; those of a scheduler are its own")
    return None if workers is None else arguments.count("workers", workers)


def _variation(keys: str | tuple[str, ...], values: Sequence[Any]) -> sweeps.Variation:
    """Return the values of each key; raise `InputError` where a tuple of keys has values of another length."""
    if not (isinstance(keys, str) or (isinstance(keys, tuple) and all(isinstance(key, str) for key in keys))):
        raise InputError(f"vary has the key {arguments.shown(keys)}, but it must be a scene key or a tuple of them")
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        raise InputError(f"the values of {keys} are {arguments.shown(values)}, but must be a list")
    rows = plain(list(values))
    if not rows:
        raise InputError(f"there are no values of {keys}")
    if isinstance(keys, str):
        return {keys: rows}
    for one in rows:
        if not isinstance(one, list) or len(one) != len(keys):
            raise InputError(f"the values of {', '.join(keys)} must be tuples of {len(keys)}, but one is {one!r}")
    return {key: list(column) for key, column in zip(keys, zip(*rows, strict=True), strict=True)}


def read(folder: str | Path) -> Run:
    """Read the run in `folder`.

    >>> run = nervure.run("csm3", folder / "short", overrides=["time.end=0.02"], quiet=True)
    >>> nervure.read(folder / "short").summary.steps
    20
    """
    return Run(**vars(results.read(arguments.path("folder", folder))))
