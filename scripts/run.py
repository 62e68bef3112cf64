"""Run a scene: pack its units, couple them, write results/NAME with tables, a summary and pictures.

    python scripts/run.py scenes/fsi3-325x72.json --end-time 1 --set fluid.mask.log_linear.c_eta=1e-4
    python scripts/run.py scenes/fsi3-650x144.json --checkpoint-every 5 --fields-every 0.02
    python scripts/run.py scenes/fsi3-650x144.json --checkpoint-every 5 --fields-every 0.02 --resume

Exit codes: 0 the run reached its end, 1 a unit failed, 2 the scene or an FMU cannot be used, 130 it was interrupted.
"""

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from cosim import checkpoint, coupling, fields, master, package, plots, report
from cosim.progress import Display, interruptible
from cosim.recorder import Recorder
from cosim.scene import ROOT, SceneError, load, override
from cosim.unit import Unit, UnitError

FAILED, REFUSED, INTERRUPTED = 1, 2, 130

FmuPath = Annotated[Path | None, typer.Option(exists=True, dir_okay=False, help="Use this FMU in place of ours.")]


def main(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE.json", help="Scene file: fluid, rod or both.")],
    end_time: Annotated[float | None, typer.Option(help="End of the run, s, in place of the scene's.")] = None,
    output: Annotated[Path | None, typer.Option(help="Result folder; default: results/NAME.")] = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Override a scene key by its dotted path; repeatable."),
    ] = None,
    rod_fmu: FmuPath = None,
    fluid_fmu: FmuPath = None,
    checkpoint_every: Annotated[
        float | None,
        typer.Option(min=0, metavar="MINUTES", help="Write a checkpoint every so many minutes of wall time."),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on from the checkpoint in the result folder.")] = False,
    fields_every: Annotated[
        float | None, typer.Option(min=0, metavar="SECONDS", help="Write fields every so many simulated seconds.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Run a scene and write its results."""
    console, errors = Console(quiet=quiet, highlight=False), Console(stderr=True, highlight=False, soft_wrap=True)
    foreign = {"rod": rod_fmu, "fluid": fluid_fmu}
    try:
        scene = load(scene_file)
        for assignment in overrides or []:
            override(scene, assignment)
        if end_time is not None:
            override(scene, f"time.end={end_time}")
        for kind in package.kinds(scene):
            package.describe(kind, scene)
        folder = output or ROOT / "results" / scene["name"]
        fmus = {kind: foreign[kind] or package.pack(kind, scene, folder) for kind in package.kinds(scene)}
        keeping = Keeping(checkpoint_every, resume, fields_every)
        with ExitStack() as stack:
            completed = execute(scene, fmus, folder, keeping, console, errors, stack)
    except (SceneError, UnitError, coupling.CouplingError, checkpoint.CheckpointError) as error:
        errors.print(f"error: {error}", markup=False)
        raise typer.Exit(REFUSED) from error
    raise typer.Exit(completed)


@dataclass
class Keeping:
    """What a run keeps besides its tables."""

    checkpoint_every: float | None
    """Wall time between checkpoints, min."""
    resume: bool
    fields_every: float | None
    """Simulated time between fields, s."""


def execute(
    scene: dict,
    fmus: dict[str, Path],
    folder: Path,
    keeping: Keeping,
    console: Console,
    errors: Console,
    stack: ExitStack,
) -> int:
    """Run the packed units of `scene` and write the results into `folder`; returns the exit code."""

    def warn(message: str) -> None:
        errors.print(f"warning: {message}", markup=False)

    clock = master.Clock(scene["time"]["end"], scene["time"]["communication_step"])
    units = {}
    for kind, path in fmus.items():
        units[kind] = Unit(path, kind, clock.end)
        stack.callback(units[kind].close)
    scheme = coupling.couple(units, scene.get("coupling"))
    if scheme.choice:
        console.print("load {load}: {load_reason}\nscheme {scheme}: {scheme_reason}".format(**scheme.choice), soft_wrap=True)
    recorder = Recorder(units, clock.steps)

    done, wall, saved, watchers = 0, 0.0, None, []
    if keeping.resume or keeping.checkpoint_every is not None:
        saved = checkpoint.Checkpoint(folder, scene, units, scheme, recorder)
    if keeping.resume:
        scheme.start()
        done, wall = saved.load()
    if keeping.fields_every is not None:
        frames = fields.Fields(folder, scene, units, clock, keeping.fields_every, done)
        stack.callback(frames.close)
        watchers.append(frames.watch(warn))
    if keeping.checkpoint_every is not None:
        watchers.append(saved.every(keeping.checkpoint_every * 60, wall, warn))

    with interruptible() as stopping, Display(console, recorder, clock.end, quiet=console.quiet) as display:
        outcome = master.run(scheme, clock, recorder, [*watchers, display.show], stopping, done, wall)
    stopped = outcome.error is None and not outcome.completed
    if stopped and keeping.checkpoint_every is not None and outcome.steps > 0:
        saved.try_to_save(outcome.steps, outcome.simulated, outcome.wall, warn)

    report.clear(folder)
    if keeping.fields_every is None:
        fields.clear(folder)
    summary = report.summarize(scene, units, scheme, recorder, outcome)
    report.write(folder, scene, recorder, scheme, summary)
    plots.time_series(folder, recorder, scene["name"])
    plots.cylinder(folder, recorder, scene, summary)
    plots.driven_root(folder, recorder, summary)
    if outcome.error is None:
        plots.vorticity(folder, scene, units, outcome.simulated)
    report.print_table(console, summary)
    console.print(f"results in {folder}", soft_wrap=True)
    if outcome.error is not None:
        errors.print(f"error: {outcome.error}", markup=False)
        return FAILED
    if stopped:
        if saved is not None:
            console.print("stopped; the same command with --resume goes on")
        return INTERRUPTED
    checkpoint.clear(folder)
    return 0


if __name__ == "__main__":
    typer.run(main)
