"""`build` the libraries and pack the units of a scene."""

import subprocess
from pathlib import Path
from typing import Annotated

import typer

from nervure.cli import SceneFile
from nervure.errors import Refusal
from nervure.resources import SOURCE


def build(
    scene_file: SceneFile,
    output: Annotated[Path | None, typer.Option(help="Folder of the FMUs; default: results/NAME.")] = None,
    descriptions: Annotated[
        Path | None,
        typer.Option(exists=True, file_okay=False, help="Write fmu_KIND.xml into this folder in place of FMUs."),
    ] = None,
) -> None:
    """Pack the units of a scene without running it; in the source tree, build both libraries before."""
    from nervure.pack import package
    from nervure.scene import kinds, read, typed
    from nervure.simulation import default_folder

    document = read(scene_file)
    if SOURCE is not None:
        _compile(SOURCE)
    scene = typed(document)
    for kind in kinds(scene):
        if descriptions:
            path = descriptions / f"fmu_{kind}.xml"
            path.write_text(package.describe(kind, scene), encoding="utf-8")
        else:
            path = package.pack(kind, scene, output or default_folder(scene))
        typer.echo(path)


def _compile(source: Path) -> None:
    try:
        built = subprocess.run(["cargo", "build", "--release", "--locked"], cwd=source)
    except FileNotFoundError:
        raise Refusal("there is no `cargo` on the PATH: install Rust, https://rustup.rs") from None
    if built.returncode != 0:
        raise Refusal("the libraries cannot be built: cargo says above why")
