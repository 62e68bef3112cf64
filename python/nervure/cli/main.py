"""All that the project does with scenes, from one command line.

    nervure run fsi3-325x72 --end-time 1 --set fluid.mask.log_linear.c_eta=1e-4
    nervure resume results/fsi3-325x72
    nervure --help

Each command is a module of `cli`, which has its options and what it prints; what it does is elsewhere in the package.
Exit codes: 0 done, 1 a unit or a run failed, 2 something that was given cannot be used, 130 interrupted.
"""

import sys

import typer

from nervure.cli import REFUSED, animate, build, dist, inspect, merge, plot, run, sweep
from nervure.errors import Refusal

app = typer.Typer(
    help="Build, run and look at rod and fluid as FMI units.",
    no_args_is_help=True,
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
        from rich.console import Console

        Console(stderr=True, highlight=False, soft_wrap=True).print(f"error: {error}", markup=False)
        sys.exit(REFUSED)


if __name__ == "__main__":
    main()
