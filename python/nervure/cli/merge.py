"""`merge`: FMUs of one unit that were packed on several systems into one that runs on all of them."""

from pathlib import Path
from typing import Annotated

import typer


def merge(
    sources: Annotated[list[Path], typer.Argument(metavar="FMU...", help="FMUs that differ in their binaries only.")],
    output: Annotated[Path, typer.Option(metavar="MERGED.fmu", help="FMU to write.")],
) -> None:
    """Put the binaries of several systems into one FMU."""
    from nervure.pack import package

    typer.echo(package.merge(sources, output))
