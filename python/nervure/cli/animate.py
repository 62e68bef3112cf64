"""`animate` a run that was made with --fields-every."""

from pathlib import Path
from typing import Annotated

import typer


def animate(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Result folder of a run with --fields-every.")],
    begin: Annotated[
        float | None, typer.Option(help="First time, s; default: two whole periods before the last.")
    ] = None,
    end: Annotated[float | None, typer.Option(help="Last time, s.")] = None,
) -> None:
    """Write vorticity.gif and phases.png into a result folder."""
    from nervure.show import animation

    for path in animation.write(folder, begin, end):
        typer.echo(f"{path} ({path.stat().st_size / 1e6:.1f} MB)")
