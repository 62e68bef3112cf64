"""A run from its scene to its results, and its resumption."""

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

from rich.console import Console

from nervure import checkpoint, master, results
from nervure.errors import Refusal
from nervure.evaluate.summary import summarize
from nervure.pack import package
from nervure.scene import Scene, kinds, typed
from nervure.show import fields, forecast
from nervure.show.progress import display, interruptible
from nervure.show.table import print_table


def run(
    scene: Scene,
    folder: Path | None,
    foreign: Mapping[str, Path | None],
    checkpoint_every: float | None = None,
    fields_every: float | None = None,
    quiet: bool = False,
) -> results.Results:
    """Run `scene` from its start into `folder` or results/NAME, with the FMUs `foreign` in the place of ours, minutes
    of wall time between checkpoints and simulated seconds between fields."""
    for kind in kinds(scene):
        package.describe(kind, scene)
    folder = folder or Path("results") / scene.name
    if (folder / checkpoint.FILE).exists():
        raise Refusal(
            f"{folder} holds the checkpoint of a run that was stopped: `nervure resume {folder}` goes on; to begin "
            f"anew, delete {checkpoint.FILE} or give another --output"
        )
    try:
        fmus = {kind: foreign.get(kind) or package.pack(kind, scene, folder) for kind in kinds(scene)}
    except OSError as error:
        raise Refusal(f"cannot write into the result folder {folder}: {error.strerror}") from error
    options = {"checkpoint_every": checkpoint_every, "fields_every": fields_every}
    return _execute(scene, fmus, any(foreign.values()), options, folder, quiet)


def resume(folder: Path, quiet: bool) -> results.Results:
    """Go on from the checkpoint in `folder` with the FMUs that the run had."""
    kept = checkpoint.read(folder)
    setup = kept.about["setup"]
    fmus = {kind: folder / path for kind, path in setup["fmus"].items()}
    for kind, path in fmus.items():
        if not path.is_file():
            raise Refusal(f"the {kind} of the run in {folder} is not there any more: {path}")
    return _execute(typed(kept.about["scene"]), fmus, setup["foreign"], setup["options"], folder, quiet, kept)


def _execute(
    scene: Scene,
    fmus: dict[str, Path],
    foreign: bool,
    options: dict[str, float | None],
    folder: Path,
    quiet: bool,
    kept: checkpoint.Kept | None = None,
) -> results.Results:
    """Run the packed units of `scene`, from what was `kept` if there is such, and write the results into `folder`;
    `foreign` says that a unit is not ours."""
    checkpoint_every, fields_every = options["checkpoint_every"], options["fields_every"]
    console, errors = Console(quiet=quiet, highlight=False), Console(stderr=True, highlight=False, soft_wrap=True)

    def warn(message: str) -> None:
        errors.print(f"warning: {message}", markup=False)

    with ExitStack() as stack:
        units, scheme, clock, recorder = master.assemble(scene, fmus, stack, foreign=foreign)
        if not quiet:
            for name, value in [*forecast.rows(scene), *(forecast.chosen(scheme.choice) if scheme.choice else ())]:
                console.print(f"{name}: {value}", markup=False, soft_wrap=True)
            for text in forecast.warnings(scene):
                warn(text)

        done, wall, saved = 0, 0.0, None
        watchers: list[master.Watcher] = [] if quiet else [forecast.announce(console, scene, units)]
        if checkpoint_every is not None:
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

        from nervure.show import plots

        summary = summarize(scene, units, scheme, recorder, status)
        made = results.Results(scene, folder, summary, recorder.series, recorder.units)
        try:
            results.write(made, scheme)
            if fields_every is None:
                fields.clear(folder)
            plots.write(folder, [made])
            if status.error is None:
                plots.vorticity(folder, scene, units, status.simulated)
        except OSError as error:
            raise Refusal(f"the results cannot be written into {folder}: {error.strerror}") from error
    print_table(console, summary)
    console.print(f"results in {folder}", soft_wrap=True)
    if status.stopped and saved:
        console.print(f"stopped; `nervure resume {folder}` goes on", soft_wrap=True)
    if status.completed:
        checkpoint.clear(folder)
    return made
