"""`sweep`: a grid of runs."""

from pathlib import Path
from typing import Annotated

import typer

from nervure.cli import FAILED, EndTime, Overrides, Quiet


def sweep(
    scene_files: Annotated[
        list[str], typer.Argument(metavar="SCENE...", help="Scene files or shipped scenes to start from.")
    ],
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=V1,V2,…",
            help="Values for a scene key, or KEY=[V1, V2, …] in JSON; repeatable: all combinations are run.",
        ),
    ] = None,
    overrides: Overrides = None,
    end_time: EndTime = None,
    output: Annotated[Path | None, typer.Option(help="Folder of the sweep; default: results/sweep-NAME.")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Dask scheduler to run on, in place of this machine's cores.")
    ] = None,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="Run again what failed or was killed.")] = False,
    quiet: Quiet = False,
) -> None:
    """Run a grid of scenes, each in a process of its own, and write sweep.csv and sweep.json.

    The same command goes on where it was: what is finished is not run again.
    """
    from nervure import simulation, sweep as sweeps
    from nervure.scene import read

    scenes = [read(name, overrides or (), end_time) for name in scene_files]
    cases = sweeps.grid(scenes, [sweeps.values(text) for text in vary or []])
    folder = output or Path("results") / f"sweep-{sweeps.plain_name(scenes[0])}"
    console, _ = simulation.consoles(quiet)
    rows = sweeps.run(
        cases, folder, scheduler, retry_failed, lambda text: console.print(text, markup=False, soft_wrap=True)
    )
    console.print(f"table in {folder / 'sweep.csv'}", soft_wrap=True)
    if any(row["status"] != sweeps.FINISHED for row in rows):
        raise typer.Exit(FAILED)
