"""A run from its scene to its results, and its resumption."""

from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.console import Console

from nervure import checkpoint, coupling, master, report
from nervure.pack import package
from nervure.show import fields
from nervure.errors import Refusal
from nervure.show.progress import Display, interruptible
from nervure.recorder import Recorder
from nervure.unit import Unit

REACHED, FAILED, INTERRUPTED = 0, 1, 130
"""How a run ended, as exit codes."""


@dataclass(frozen=True)
class Keeping:
    """What a run keeps besides its tables."""

    checkpoint_every: float | None = None
    """Wall time between checkpoints, min."""
    fields_every: float | None = None
    """Simulated time between fields, s."""


def assemble(
    scene: dict, fmus: dict[str, Path], stack: ExitStack
) -> tuple[dict[str, Unit], coupling.Single, master.Clock, Recorder]:
    """The packed units of `scene`, coupled and ready to step, with clock and recorder; `stack` closes them."""
    clock = master.Clock(scene["time"]["end"], scene["time"]["communication_step"])
    units = {}
    for kind, path in fmus.items():
        units[kind] = Unit(path, kind, clock.end)
        stack.callback(units[kind].close)
    return units, coupling.couple(units, scene.get("coupling")), clock, Recorder(units, clock.steps)


def consoles(quiet: bool) -> tuple[Console, Console]:
    """Where a run prints what it does, and what went wrong."""
    return Console(quiet=quiet, highlight=False), Console(stderr=True, highlight=False, soft_wrap=True)


def default_folder(scene: dict) -> Path:
    """results/NAME, for a scene that a unit has accepted."""
    return Path("results") / scene["name"]


def run(
    scene: dict, folder: Path | None, foreign: dict[str, Path | None], keeping: Keeping, console: Console, errors: Console
) -> int:
    """Run `scene` from its start, with the FMUs `foreign` by kind in the place of ours, into `folder` or results/NAME;
    returns how it ended."""
    for kind in package.kinds(scene):
        package.describe(kind, scene)
    folder = folder or default_folder(scene)
    if (folder / checkpoint.FILE).exists():
        raise Refusal(
            f"{folder} holds the checkpoint of a run that was stopped: `nervure resume {folder}` goes on; to begin "
            f"anew, delete {checkpoint.FILE} or give another --output"
        )
    try:
        fmus = {kind: foreign.get(kind) or package.pack(kind, scene, folder) for kind in package.kinds(scene)}
    except OSError as error:
        raise Refusal(f"cannot write into the result folder {folder}: {error.strerror}") from error
    return _execute(scene, fmus, folder, keeping, None, console, errors)


def resume(folder: Path, console: Console, errors: Console) -> int:
    """Go on from the checkpoint in `folder` with the FMUs that the run had; returns how it ended."""
    kept = checkpoint.read(folder)
    setup = kept.about["setup"]
    fmus = {kind: folder / path for kind, path in setup["fmus"].items()}
    for kind, path in fmus.items():
        if not path.is_file():
            raise Refusal(f"the {kind} of the run in {folder} is not there any more: {path}")
    return _execute(kept.about["scene"], fmus, folder, Keeping(**setup["keeping"]), kept, console, errors)


def _execute(
    scene: dict,
    fmus: dict[str, Path],
    folder: Path,
    keeping: Keeping,
    kept: checkpoint.Kept | None,
    console: Console,
    errors: Console,
) -> int:
    """Run the packed units of `scene`, from what was `kept` if there is such, and write the results into `folder`."""

    def warn(message: str) -> None:
        errors.print(f"warning: {message}", markup=False)

    with ExitStack() as stack:
        units, scheme, clock, recorder = assemble(scene, fmus, stack)
        if scheme.choice:
            text = "load {load}: {load_reason}\nscheme {scheme}: {scheme_reason}".format(**scheme.choice)
            console.print(text, soft_wrap=True)

        done, wall, saved, watchers = 0, 0.0, None, []
        if keeping.checkpoint_every is not None:
            inside = {kind: _inside(path, folder) for kind, path in fmus.items()}
            setup = {"fmus": inside, "keeping": asdict(keeping)}
            saved = checkpoint.Checkpoint(folder, scene, setup, units, scheme, recorder)
        if kept is not None:
            scheme.start()
            done, wall = saved.restore(kept)
        if keeping.fields_every is not None:
            frames = fields.Fields(folder, scene, units, clock, keeping.fields_every, done)
            stack.callback(frames.close)
            watchers.append(frames.watch(warn))
        if saved:
            watchers.append(saved.every(keeping.checkpoint_every * 60, wall, warn))

        with interruptible() as stopping, Display(console, recorder, clock.end, quiet=console.quiet) as display:
            outcome = master.run(scheme, clock, recorder, [*watchers, display.show], stopping, done, wall)
        stopped = outcome.error is None and not outcome.completed
        if stopped and saved and outcome.steps > 0:
            saved.try_to_save(outcome.steps, outcome.simulated, outcome.wall, warn)

        from nervure.show import plots

        summary = report.summarize(scene, units, scheme, recorder, outcome)
        try:
            report.write(folder, scene, recorder, scheme, summary)
            if keeping.fields_every is None:
                fields.clear(folder)
            plots.time_series(folder, {scene["name"]: recorder}, scene["name"])
            plots.cylinder(folder, recorder, scene, summary)
            plots.driven_root(folder, recorder, summary)
            if outcome.error is None:
                plots.vorticity(folder, scene, units, outcome.simulated)
        except OSError as error:
            raise Refusal(f"the results cannot be written into {folder}: {error.strerror}") from error
    report.print_table(console, summary)
    console.print(f"results in {folder}", soft_wrap=True)
    if outcome.error is not None:
        errors.print(f"error: {outcome.error}", markup=False)
        return FAILED
    if stopped:
        if saved:
            console.print(f"stopped; `nervure resume {folder}` goes on", soft_wrap=True)
        return INTERRUPTED
    checkpoint.clear(folder)
    return REACHED


def _inside(path: Path, folder: Path) -> str:
    """`path` from `folder`, which may be moved, or as a whole where it is not in it."""
    path, folder = path.resolve(), folder.resolve()
    return str(path.relative_to(folder) if path.is_relative_to(folder) else path)
