"""`run` a scene and `resume` a run that was stopped."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from nervure.cli import FAILED, INTERRUPTED, EndTime, Overrides, Quiet, SceneFile

if TYPE_CHECKING:
    from rich.console import Console

    from nervure.evaluate.summary import Summary

FmuPath = Annotated[Path | None, typer.Option(exists=True, dir_okay=False, help="Use this FMU in place of ours.")]


def run(
    scene_file: SceneFile,
    end_time: EndTime = None,
    output: Annotated[Path | None, typer.Option(help="Result folder; default: results/NAME.")] = None,
    overrides: Overrides = None,
    rod_fmu: FmuPath = None,
    fluid_fmu: FmuPath = None,
    checkpoint_every: Annotated[
        float | None,
        typer.Option(min=0, metavar="MINUTES", help="Write a checkpoint every so many minutes of wall time."),
    ] = None,
    fields_every: Annotated[
        float | None, typer.Option(min=0, metavar="SECONDS", help="Write fields every so many simulated seconds.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Run a scene: pack its units, couple them, write results/NAME with tables, a summary and pictures."""
    from nervure import simulation
    from nervure.scene import load

    scene = load(scene_file, overrides or (), end_time)
    options = simulation.OutputOptions(checkpoint_every, fields_every)
    console, errors = simulation.consoles(quiet)
    fmus = {"rod": rod_fmu, "fluid": fluid_fmu}
    _exit(simulation.run(scene, output, fmus, options, console, errors).summary, errors)


def resume(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Result folder of a run with --checkpoint-every.")],
    quiet: Quiet = False,
) -> None:
    """Go on from the checkpoint in a result folder, with the scene, the units and the options of its run."""
    from nervure import simulation

    console, errors = simulation.consoles(quiet)
    _exit(simulation.resume(folder, console, errors).summary, errors)


def _exit(summary: "Summary", errors: "Console") -> None:
    """End the command with the exit code of a run."""
    if summary.error is not None:
        errors.print(f"error: {summary.error}", markup=False)
        raise typer.Exit(FAILED)
    if not summary.completed:
        raise typer.Exit(INTERRUPTED)
