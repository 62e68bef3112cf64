"""Starts the checks; with --continue, it is the other process of `states.processes`."""

import sys
from pathlib import Path

import typer

sys.path[:1] = [str(Path(__file__).parents[level]) for level in (1, 2)]

from reliability.checks import main
from reliability.states import continued

if __name__ == "__main__":
    if sys.argv[1:2] == ["--continue"]:
        continued(*sys.argv[2:])
    else:
        typer.run(main)
