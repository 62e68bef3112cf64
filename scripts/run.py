"""Run a scene: pack its units, couple them, write results/NAME with tables, a summary and pictures.

    python scripts/run.py scenes/fsi3-325x72.json --end-time 1 --set fluid.mask.cosine.c_eta=1e-5

Exit codes: 0 the run reached its end, 1 a unit failed, 2 the scene or an FMU cannot be used, 130 it was interrupted.
"""

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from cosim import master, package, plots, report
from cosim.progress import Display, interruptible
from cosim.recorder import Recorder
from cosim.scene import ROOT, SceneError, load, override
from cosim.unit import Unit, UnitError

FAILED, REFUSED, INTERRUPTED = 1, 2, 130

FmuPath = Annotated[Path | None, typer.Option(exists=True, dir_okay=False, help="Use this FMU in place of ours.")]


def main(
    scene_file: Annotated[Path, typer.Argument(metavar="SCENE.json", help="Scene file: fluid, rod or both.")],
    end_time: Annotated[float | None, typer.Option(help="End of the run, s, in place of the scene's.")] = None,
    output: Annotated[Path | None, typer.Option(help="Result folder; default: results/NAME.")] = None,
    overrides: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Override a scene key by its dotted path; repeatable."),
    ] = None,
    rod_fmu: FmuPath = None,
    fluid_fmu: FmuPath = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Run a scene and write its results."""
    console, errors = Console(quiet=quiet, highlight=False), Console(stderr=True, highlight=False, soft_wrap=True)
    foreign = {"rod": rod_fmu, "fluid": fluid_fmu}
    try:
        scene = load(scene_file)
        for assignment in overrides or []:
            override(scene, assignment)
        if end_time is not None:
            override(scene, f"time.end={end_time}")
        for kind in package.kinds(scene):
            package.describe(kind, scene)
        folder = output or ROOT / "results" / scene["name"]
        fmus = {kind: foreign[kind] or package.pack(kind, scene, folder) for kind in package.kinds(scene)}
        with ExitStack() as stack:
            completed = execute(scene, fmus, folder, console, errors, stack)
    except (SceneError, UnitError, master.CouplingError) as error:
        errors.print(f"error: {error}", markup=False)
        raise typer.Exit(REFUSED) from error
    raise typer.Exit(completed)


def execute(
    scene: dict, fmus: dict[str, Path], folder: Path, console: Console, errors: Console, stack: ExitStack
) -> int:
    """Run the packed units of `scene` and write the results into `folder`; returns the exit code."""
    clock = master.Clock(scene["time"]["end"], scene["time"]["communication_step"])
    units = {}
    for kind, path in fmus.items():
        units[kind] = Unit(path, kind, clock.end)
        stack.callback(units[kind].close)
    scheme = master.couple(units, (scene.get("coupling") or {}).get("scheme", "explicit"))
    recorder = Recorder(units, clock.steps)

    with interruptible() as stopping, Display(console, recorder, clock.end, quiet=console.quiet) as display:
        outcome = master.run(scheme, clock, recorder, display.show, stopping)

    report.clear(folder)
    summary = report.summarize(scene, units, recorder, outcome)
    report.write(folder, scene, recorder, summary)
    plots.time_series(folder, recorder, scene["name"])
    if outcome.error is None:
        plots.vorticity(folder, scene, units, outcome.simulated)
    report.print_table(console, summary)
    console.print(f"results in {folder}", soft_wrap=True)
    if outcome.error is not None:
        errors.print(f"error: {outcome.error}", markup=False)
        return FAILED
    return 0 if outcome.completed else INTERRUPTED


if __name__ == "__main__":
    typer.run(main)
