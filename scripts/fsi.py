"""All that the project does with scenes, from one command line.

    python scripts/fsi.py run scenes/fsi3-325x72.json --end-time 1 --set fluid.mask.log_linear.c_eta=1e-4
    python scripts/fsi.py resume results/fsi3-325x72
    python scripts/fsi.py --help

Each command is a module of `commands`, which has its options and what it prints; what it does is in `cosim`.
Exit codes: 0 done, 1 a unit or a run failed, 2 something that was given cannot be used, 130 interrupted.
"""

import sys

import typer
from rich.console import Console

from commands import REFUSED, animate, build, dist, inspect, merge, plot, run, sweep
from cosim.errors import Refusal

app = typer.Typer(
    help="Build, run and look at rod and fluid as FMI units.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for command in (
    build.build,
    run.run,
    run.resume,
    inspect.inspect,
    plot.plot,
    animate.animate,
    sweep.sweep,
    dist.dist,
    merge.merge,
):
    app.command()(command)


def main() -> None:
    try:
        app()
    except Refusal as error:
        Console(stderr=True, highlight=False, soft_wrap=True).print(f"error: {error}", markup=False)
        sys.exit(REFUSED)


if __name__ == "__main__":
    main()
