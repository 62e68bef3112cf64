"""Put FMUs of one unit that were packed on several systems into one that runs on all of them.

python scripts/merge.py linux/flag-rod.fmu windows/flag-rod.fmu flag-rod.fmu      the last is written
"""

from pathlib import Path
from typing import Annotated

import typer

from cosim import package
from cosim.scene import SceneError


def main(files: Annotated[list[Path], typer.Argument(metavar="FMU... MERGED.fmu")]) -> None:
    """Merge the binaries of FMUs that are otherwise the same."""
    *sources, target = files
    try:
        typer.echo(package.merge(sources, target))
    except SceneError as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(2) from error


if __name__ == "__main__":
    typer.run(main)
