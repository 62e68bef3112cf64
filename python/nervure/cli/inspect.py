"""`inspect` an FMU, a scene or a result folder."""

from pathlib import Path
from typing import Annotated

import typer


def inspect(
    path: Annotated[Path, typer.Argument(metavar="UNIT.fmu|SCENE.json|FOLDER", help="What to look at.")],
) -> None:
    """Show what an FMU offers, what a scene will do and take, or what a run has given."""
    from rich.console import Console

    from nervure.show import inspection

    console = Console(highlight=False)
    if path.is_dir():
        inspection.show_results(console, path)
    elif path.suffix == ".fmu":
        inspection.show_unit(console, path)
    else:
        inspection.show_scene(console, path)
