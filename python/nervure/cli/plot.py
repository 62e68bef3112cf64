"""`plot` what runs have recorded."""

from pathlib import Path
from typing import Annotated

import typer

from nervure.errors import Refusal


def plot(
    folders: Annotated[list[Path], typer.Argument(metavar="FOLDER...", help="Result folders of runs.")],
    output: Annotated[
        Path | None, typer.Option(help="Folder of the pictures; default: that of the run, if it is one.")
    ] = None,
) -> None:
    """Draw tip.png, drag.png and lift.png anew from series.csv, several runs over each other."""
    if len(folders) > 1 and output is None:
        raise Refusal("where several runs are drawn over each other, --output has to say where the pictures go")
    from nervure import results
    from nervure.show import plots

    runs = [results.read(folder) for folder in folders]
    target = output or folders[0]
    target.mkdir(parents=True, exist_ok=True)
    written = plots.time_series(target, results.labelled(runs), runs[0].scene)
    if len(runs) == 1:
        written += plots.cylinder(target, runs[0], runs[0].scene, runs[0].summary)
        written += plots.driven_root(target, runs[0], runs[0].summary)
    if not written:
        raise Refusal(f"{', '.join(map(str, folders))}: no tip, drag or lift was recorded")
    for path in written:
        typer.echo(path)
