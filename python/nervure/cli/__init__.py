"""The commands, one module each, and the options that several of them have.

No module here loads what its command needs before it is run: help and errors of the command line come at once.
"""

from typing import Annotated

import typer

FAILED, REFUSED, INTERRUPTED = 1, 2, 130
"""Exit codes."""

SceneFile = Annotated[str, typer.Argument(metavar="SCENE", help="Scene file, or the name of a shipped scene.")]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Override a scene key by its dotted path; repeatable."),
]
EndTime = Annotated[float | None, typer.Option(help="End of the run, s, in place of the scene's.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]
