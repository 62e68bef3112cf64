"""Pack the units of a scene without running it.

python scripts/pack.py scenes/fsi3-325x72.json             NAME-rod.fmu and NAME-fluid.fmu in results/NAME
python scripts/pack.py --descriptions DIR SCENE.json       only fmu_rod.xml and fmu_fluid.xml, their descriptions
"""

from pathlib import Path
from typing import Annotated

import typer

from cosim import package
from cosim.scene import ROOT, SceneError, load


def main(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE.json", help="Scene file: fluid, rod or both.")],
    output: Annotated[Path | None, typer.Option(help="Folder of the FMUs; default: results/NAME.")] = None,
    descriptions: Annotated[Path | None, typer.Option(help="Write model descriptions into this folder.")] = None,
) -> None:
    """Pack the units of a scene."""
    try:
        scene = load(scene_file)
        for kind in package.kinds(scene):
            description = package.describe(kind, scene)
            if descriptions:
                path = descriptions / f"fmu_{kind}.xml"
                path.write_text(description, encoding="utf-8")
            else:
                path = package.pack(kind, scene, output or ROOT / "results" / scene["name"])
            typer.echo(path)
    except SceneError as error:
        typer.echo(f"error: {error}", err=True)
        raise typer.Exit(2) from error


if __name__ == "__main__":
    typer.run(main)
