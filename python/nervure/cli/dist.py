"""`dist`: the units of a scene, to be handed out."""

from pathlib import Path
from typing import Annotated

import typer

from nervure.cli import SceneFile


def dist(
    scene_file: SceneFile,
    folder: Annotated[Path, typer.Argument(help="Folder to write; one that exists is replaced as a whole.")],
) -> None:
    """Write FMUs, SSP, checksums and manifest of a scene into a folder; `make dist` builds the libraries for it."""
    from nervure.pack import delivery
    from nervure.scene import load

    delivery.write(load(scene_file), folder)
    typer.echo(folder)
