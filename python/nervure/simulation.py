"""A run from its scene to its results, and its resumption."""

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

from rich.console import Console

from nervure import checkpoint, master, results
from nervure.errors import InputError
from nervure.evaluate.summary import summarize
from nervure.output import fields, forecast
from nervure.output.progress import display, interruptible
from nervure.output.tables import print_table
from nervure.scene import Scene, kinds, unit_label, validate
from nervure.units import package
from nervure.units.fmu import Unit, read_description


def run(
    scene: Scene,
    folder: Path | None,
    foreign: Mapping[str, Path | None],
    checkpoint_every: float | None = None,
    fields_every: float | None = None,
    quiet: bool = False,
    force: bool = False,
    series_every: float | None = None,
    fmi: int = 2,
) -> results.Results:
    """Run `scene` from its start into `folder` or results/NAME, with the FMUs `foreign` in the place of ours, minutes
    of wall time between checkpoints, and simulated seconds between fields and between rows of the series; `fmi` is the
    version of our units, 2 or 3.

    What the folder holds of another scene, or of a run that was stopped, is refused, or with `force` replaced.
    """
    for kind in kinds(scene):
        package.describe(kind, scene)
    folder = folder or Path("results") / scene.name
    strays = _make_room(scene, folder, foreign, force)
    try:
        fmus = {kind: foreign.get(kind) or package.pack(kind, scene, folder, version=fmi) for kind in kinds(scene)}
    except OSError as error:
        raise InputError(f"cannot write into the result folder {folder}: {error.strerror}") from error
    strays -= {path.parent.resolve() / path.name for path in fmus.values()}
    options = {"checkpoint_every": checkpoint_every, "fields_every": fields_every, "series_every": series_every}
    return _execute(scene, fmus, any(foreign.values()), options, folder, quiet, strays=strays)


def replaced(scene: Scene, rods: Mapping[str, Path], fluid: Path | None) -> dict[str, Path | None]:
    """The FMUs in the place of ours, by the unit that each is: `rods` by the name of a rod, that of the only one being
    `rod`. Raises `InputError` for a name that the scene does not have."""
    names = [kind for kind in kinds(scene) if kind != "fluid"] if scene.rods else ["rod"]
    for name in rods:
        if name not in names:
            known = f"the rods {', '.join(names)}" if scene.rods else "one rod, which needs no name"
            raise InputError(f"an FMU is given for the rod `{name}`, but the scene has {known}")
    return {**rods, "fluid": fluid}


def _make_room(scene: Scene, folder: Path, foreign: Mapping[str, Path | None], force: bool) -> set[Path]:
    """The units of an earlier scene in `folder` and its row of a sweep, which the results of this one will replace;
    raises `InputError` where that would lose something, unless `force` allows it."""
    if (folder / checkpoint.FILE).exists():
        if not force:
            raise InputError(
                f"{folder} holds the checkpoint of a run that was stopped: `nervure resume {folder}` goes on; to begin "
                "anew, give another --output, or --force to replace it"
            )
        checkpoint.clear(folder)
    models = {
        kind: read_description(path).modelName if (path := foreign.get(kind)) else f"{scene.name}.{kind}"
        for kind in kinds(scene)
    }
    if held := results.other(folder, scene, models):
        if not force:
            raise InputError(f"{folder} holds {held}; give another --output, or --force to replace what is there")
        units = {f"{results.scene_name(folder)}-{kind}.fmu" for kind in results.unit_names(folder)}
        return {folder.resolve() / name for name in (*units, "row.json")}
    return set()


def sample(scene: Scene, folder: Path, watchers: Sequence[master.Watcher]) -> results.Results:
    """Run `scene` into `folder` as one of many: without FMUs and pictures, which take longer than a short run."""
    with tempfile.TemporaryDirectory() as temporary:
        fmus = {kind: package.unpacked(kind, scene, Path(temporary)) for kind in kinds(scene)}
        return _execute(scene, fmus, False, {}, folder, quiet=True, many=True, watchers=watchers)


def resume(folder: Path, quiet: bool) -> results.Results:
    """Go on from the checkpoint in `folder` with the FMUs that the run had."""
    kept = checkpoint.read(folder)
    setup = kept.about["setup"]
    fmus = {kind: folder / path for kind, path in setup["fmus"].items()}
    for kind, path in fmus.items():
        if not path.is_file():
            raise InputError(f"the {unit_label(kind)} of the run in {folder} is not there any more: {path}")
    return _execute(validate(kept.about["scene"]), fmus, setup["foreign"], setup["options"], folder, quiet, kept)


def _execute(
    scene: Scene,
    fmus: dict[str, Path],
    foreign: bool,
    options: Mapping[str, float | None],
    folder: Path,
    quiet: bool,
    kept: checkpoint.Kept | None = None,
    strays: Iterable[Path] = (),
    many: bool = False,
    watchers: Sequence[master.Watcher] = (),
) -> results.Results:
    """Run the packed units of `scene`, from what was `kept` if there is such, and write the results into `folder` in
    place of `strays`; `foreign` says that a unit is not ours, `many` that the run is one of many, which has neither
    pictures nor a checkpoint."""
    checkpoint_every, fields_every = options.get("checkpoint_every"), options.get("fields_every")
    console, errors = Console(quiet=quiet, highlight=False), Console(stderr=True, highlight=False, soft_wrap=True)

    def warn(message: str) -> None:
        errors.print(f"warning: {message}", markup=False)

    with ExitStack() as stack:
        every = options.get("series_every")
        units, scheme, clock, recorder = master.assemble(scene, fmus, stack, foreign=foreign, series_every=every)
        done, wall, saved = 0, 0.0, None
        watchers = list(watchers)
        if not quiet:
            for name, value in [*forecast.rows(scene), *(forecast.chosen(scheme.choice) if scheme.choice else ())]:
                console.print(f"{name}: {value}", markup=False, soft_wrap=True)
            for text in forecast.warnings(scene):
                warn(text)
            watchers.append(forecast.announce(console, scene, units))
        if checkpoint_every is not None or (not many and all(unit.can_serialize for unit in units.values())):
            home, places = folder.resolve(), {kind: path.resolve() for kind, path in fmus.items()}
            # The folder may be moved: what is in it is known from there.
            inside = {kind: str(p.relative_to(home) if p.is_relative_to(home) else p) for kind, p in places.items()}
            setup = {"fmus": inside, "foreign": foreign, "options": options}
            saved = checkpoint.Checkpoint(folder, scene, setup, units, scheme, recorder)
            if kept is not None:
                scheme.start()
                done, wall = saved.restore(kept)
        if fields_every is not None:
            frames = fields.Fields(folder, scene, units, clock, fields_every, done)
            stack.callback(frames.close)
            watchers.append(frames.watch(warn))
        if saved and checkpoint_every is not None:
            watchers.append(saved.every(checkpoint_every * 60, wall, warn))

        with interruptible() as stopping, display(console, recorder, clock.end) as show:
            status = master.run(scheme, clock, recorder, [*watchers, show], stopping, done, wall)
        if saved and status.stopped and status.steps > 0:
            saved.try_to_save(status.steps, status.simulated, status.wall, warn)

        summary = summarize(scene, units, scheme, recorder, status)
        made = results.Results(scene, folder, summary, recorder.series, recorder.units)
        try:
            results.write(made, scheme, strays)
            if fields_every is None:
                fields.clear(folder)
            if not many:
                _draw(made, units, status)
        except OSError as error:
            raise InputError(f"the results cannot be written into {folder}: {error.strerror}") from error
    print_table(console, summary, scene.display)
    console.print(f"results in {folder}", soft_wrap=True)
    if status.stopped:
        how = f"`nervure resume {folder}` goes on" if (folder / checkpoint.FILE).exists() else "there is no checkpoint"
        console.print(f"stopped at t = {status.simulated:g} of {clock.end:g} s; {how}", soft_wrap=True)
    if status.completed:
        checkpoint.clear(folder)
    return made


def _draw(made: results.Results, units: dict[str, Unit], status: master.RunStatus) -> None:
    """Write the pictures of a run."""
    from nervure.output import plots

    plots.write(made.folder, [made])
    if status.error is None:
        plots.vorticity(made.folder, made.scene, units, status.simulated)
