"""`run` a scene and `resume` a run that was stopped."""

from pathlib import Path
from typing import Annotated

import typer

from nervure import simulation
from nervure.scene import customized

from nervure.cli import EndTime, Overrides, Quiet, SceneFile

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
    scene = customized(scene_file, overrides, end_time)
    foreign = {"rod": rod_fmu, "fluid": fluid_fmu}
    keeping = simulation.Keeping(checkpoint_every, fields_every)
    raise typer.Exit(simulation.run(scene, output, foreign, keeping, *simulation.consoles(quiet)))


def resume(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Result folder of a run with --checkpoint-every.")],
    quiet: Quiet = False,
) -> None:
    """Go on from the checkpoint in a result folder, with the scene, the units and the options of its run."""
    raise typer.Exit(simulation.resume(folder, *simulation.consoles(quiet)))
