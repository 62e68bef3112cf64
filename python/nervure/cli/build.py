"""`build` the libraries and pack the units of a scene."""

import subprocess
from pathlib import Path
from typing import Annotated

import typer

from nervure import simulation
from nervure.pack import package
from nervure.errors import Refusal
from nervure.resources import SOURCE
from nervure.scene import load

from nervure.cli import SceneFile


def build(
    scene_file: SceneFile,
    output: Annotated[Path | None, typer.Option(help="Folder of the FMUs; default: results/NAME.")] = None,
    descriptions: Annotated[
        Path | None,
        typer.Option(exists=True, file_okay=False, help="Write fmu_KIND.xml into this folder in place of FMUs."),
    ] = None,
) -> None:
    """Build both libraries (cargo build --release --locked) and pack the units of a scene, without running it."""
    scene = load(scene_file)
    if SOURCE is None:
        raise Refusal("the libraries came with the package; `nervure pack` packs the units of a scene")
    try:
        built = subprocess.run(["cargo", "build", "--release", "--locked"], cwd=SOURCE)
    except FileNotFoundError:
        raise Refusal("there is no `cargo` on the PATH: install Rust, https://rustup.rs") from None
    if built.returncode != 0:
        raise Refusal("the libraries cannot be built: cargo says above why")
    for kind in package.kinds(scene):
        description = package.describe(kind, scene)
        if descriptions:
            path = descriptions / f"fmu_{kind}.xml"
            path.write_text(description, encoding="utf-8")
        else:
            path = package.pack(kind, scene, output or simulation.default_folder(scene))
        typer.echo(path)
