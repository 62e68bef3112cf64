"""The command `nervure`.

A subcommand imports its packages when it runs, so that help and errors come at once.
Exit codes: 0 done, 1 a unit or a run failed, 2 input cannot be used, 130 interrupted.
"""

import ast
import gc
import json
import math
import os
import re
import shutil
import sys
import textwrap
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated

import typer

import nervure
from nervure.errors import InputError, UnitFailure
from nervure.resources import SOURCE

FAILED, REFUSED, INTERRUPTED = 1, 2, 130

GARBAGE = 200_000
"""New objects between two collections of cycles. With the default of 700, Python would spend a tenth of the start of a
run on them."""


def _folder(text: str) -> Path:
    """Return an option as a path. An empty text, as from an unset variable, would mean the working folder."""
    if not text:
        raise typer.BadParameter("it is empty, but it must be the path of a folder; `.` is the working folder")
    return Path(text)


def _numbers(option: str, text: str | None) -> list[float] | None:
    """Return the numbers of an option."""
    try:
        return None if text is None else [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"{option} is {text}, but must be numbers, as 0,1.5,-2") from None


SECONDS = {"": 1.0, "s": 1.0, "min": 60.0, "h": 3600.0}  # Of the units of a time


def _duration(text: str) -> float:
    """Return a time as `20min` in s."""
    found = re.fullmatch(r"\s*([0-9.]+(?:e[-+]?\d+)?)\s*(s|min|h)?\s*", text)
    with suppress(ValueError):
        if found and 0 < (seconds := float(found[1]) * SECONDS[found[2] or ""]) < math.inf:
            return seconds
    raise typer.BadParameter(f"it is {text}, but must be a time above 0 as 90s, 20min or 1.5h")


def _part(text: str) -> float:
    """Return a part as `2%` or `0.02`."""
    number = text.strip()
    with suppress(ValueError):
        if 0 < (part := float(number.removesuffix("%")) / (100 if number.endswith("%") else 1)) < math.inf:
            return part
    raise typer.BadParameter(f"it is {text}, but must be a part above 0 as 2% or 0.02")


def _complete_scene(incomplete: str) -> list[tuple[str, str]]:
    """Return the shipped scenes and the scene files that begin with what was typed; without one, the shell offers its
    files."""
    from nervure.catalogue import shipped

    files = sorted(str(path) for path in Path().glob("*.json") if str(path).startswith(incomplete))
    return [(one.name, one.description) for one in shipped() if one.name.startswith(incomplete)] + [
        (path, "file") for path in files
    ]


def _complete_key(incomplete: str) -> list[str]:
    """Return the scene keys that begin with what was typed; values are not completed."""
    from nervure.catalogue import complete_key

    return [] if "=" in incomplete else complete_key(incomplete)


SCENE_HELP = "Scene file, or the name of a shipped scene; `nervure scenes` lists them."
SceneFile = Annotated[str, typer.Argument(metavar="SCENE", help=SCENE_HELP, autocompletion=_complete_scene)]
Folder = Annotated[Path, typer.Argument(metavar="FOLDER", help="Result folder of a run.")]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Override a scene key by its dotted path; repeatable.",
        autocompletion=_complete_key,
    ),
]
Output = Annotated[
    Path | None, typer.Option(metavar="FOLDER", parser=_folder, help="Result folder; default: results/NAME.")
]
EndTime = Annotated[float | None, typer.Option(help="End time of the run, s; default: from the scene.")]
Workers = Annotated[
    int | None, typer.Option(min=1, metavar="N", help="Runs at a time on this machine; default: one for each core.")
]
Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", help="Dask scheduler; default: one on this machine.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print errors only.")]
Live = Annotated[
    bool, typer.Option("--live", help="Show the run on a page of this machine, with buttons to stop it and to save it.")
]
Force = Annotated[bool, typer.Option("--force", help="Replace the results of another scene in the folder.")]
Fmi = Annotated[int, typer.Option("--fmi", min=2, max=3, help="FMI version of the units.")]
RodFmus = Annotated[
    list[str] | None,
    typer.Option(
        "--rod-fmu",
        metavar="[NAME=]FMU",
        help="Use this FMU in place of the rod, or of the rod or wing NAME; repeatable.",
    ),
]
DriveFile = Annotated[
    Path | None,
    typer.Option(
        "--drive", metavar="FILE.py", help="File whose `drive(time, values)` sets what the scene leaves open."
    ),
]
FmuPath = Annotated[Path | None, typer.Option(exists=True, dir_okay=False, help="Use this FMU in place of the fluid.")]

app = typer.Typer(
    no_args_is_help=True, pretty_exceptions_enable=False, context_settings={"help_option_names": ["-h", "--help"]}
)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(f"nervure {nervure.__version__}")
        raise typer.Exit


@app.callback()
def command(
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Build, run and inspect co-simulation units of an elastic rod and a fluid."""


@app.command()
def scenes(
    as_json: Annotated[bool, typer.Option("--json", help="Print names, descriptions and paths as JSON.")] = False,
) -> None:
    """List the shipped scenes."""
    from nervure.catalogue import shipped

    found = shipped()
    if as_json:
        typer.echo(json.dumps([{**vars(one), "path": str(one.path)} for one in found], indent=2, ensure_ascii=False))
        return
    width = 2 + max(len(one.name) for one in found)
    room = shutil.get_terminal_size().columns - width if sys.stdout.isatty() else sys.maxsize
    for one in found:
        typer.echo(f"{one.name:<{width}}{textwrap.shorten(one.description, max(room, 20), placeholder=' …')}")


@app.command()
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new scene, or path of its file.")],
    base: Annotated[
        str,
        typer.Option(
            "--from", metavar="SCENE", help=f"Scene to begin with. {SCENE_HELP}", autocompletion=_complete_scene
        ),
    ],
) -> None:
    """Write NAME.json, a copy of a scene to edit; an existing file stays."""
    from nervure.scene import write_copy

    path = write_copy(name, base)
    typer.echo(f"{path}: edit it, then `nervure run {path}`")


@app.command()
def examples(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="New folder for the files.", parser=_folder)],
) -> None:
    """Copy the shipped scenes, scripts and solvers in Python into a folder, as the documents name them."""
    from nervure.resources import EXAMPLES, ROOT

    try:
        folder.mkdir(parents=True)
        left_out = shutil.ignore_patterns("__pycache__", "*.xml", "*.md", "scene_types.py")
        for name in EXAMPLES:
            shutil.copytree(ROOT / name, folder / name, ignore=left_out)
    except OSError as error:
        raise InputError(f"cannot write {folder}: {error.strerror or error}; it must be a new folder") from error
    for path in sorted(folder.rglob("*.py")):
        first = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        typer.echo(f"{path}: {first.splitlines()[0]}")
    typer.echo(f"{folder / 'scenes'}: the scenes")


@app.command()
def build(
    scene_file: SceneFile,
    output: Output = None,
    descriptions: Annotated[
        Path | None,
        typer.Option(exists=True, file_okay=False, help="Write only fmu_UNIT.xml into this folder."),
    ] = None,
    fmi: Fmi = 2,
) -> None:
    """Pack the units of a scene without a run; in the source tree, build the libraries first, but for those of
    NERVURE_LIBRARIES."""
    from nervure import library
    from nervure.scene import load
    from nervure.units import package
    from nervure.units.describe import describe_all

    scene = load(scene_file)  # before the libraries are built, which takes a while
    if SOURCE is not None and not os.environ.get("NERVURE_LIBRARIES"):
        library.build()
    for unit in describe_all(scene, fmi).values():
        if descriptions:
            path = descriptions / f"fmu_{unit.unit}.xml"
            path.write_text(unit.xml, encoding="utf-8")
        else:
            path = package.pack(unit, output or Path("results") / scene.name)
        typer.echo(path)


@app.command()
def run(
    scene_file: SceneFile,
    end_time: EndTime = None,
    output: Output = None,
    overrides: Overrides = None,
    rod_fmu: RodFmus = None,
    fluid_fmu: FmuPath = None,
    drive: DriveFile = None,
    checkpoint_every: Annotated[
        float | None,
        typer.Option(min=0, metavar="MINUTES", help="Wall time between checkpoints, min."),
    ] = None,
    fields_every: Annotated[
        float | None, typer.Option(min=0, metavar="SECONDS", help="Simulated time between fields, s.")
    ] = None,
    series_every: Annotated[
        float | None, typer.Option(min=0, metavar="SECONDS", help="Simulated time between rows of the series, s.")
    ] = None,
    force: Force = False,
    quiet: Quiet = False,
    live: Live = False,
    fmi: Fmi = 2,
) -> None:
    """Run a scene; write tables, a summary and pictures into results/NAME."""
    from nervure import api
    from nervure.coupling import read_drive
    from nervure.scene import load

    scene = load(scene_file, overrides or (), end_time)
    rod_fmus = _rod_fmus(rod_fmu or [], bool(scene.rods), {"wing", *(own.name for own in scene.wings)})
    with _exit_code():
        api.run(
            scene,
            output,
            rod_fmu=rod_fmus,
            fluid_fmu=fluid_fmu,
            drive=read_drive(drive) if drive else None,
            checkpoint_every=checkpoint_every,
            fields_every=fields_every,
            series_every=series_every,
            force=force,
            quiet=quiet,
            live=live,
            fmi=fmi,
        )


def _rod_fmus(given: list[str], several: bool, wings: Collection[str]) -> dict[str, Path]:
    """Return the FMUs of `--rod-fmu` by the name of the rod or wing; a single rod is `rod`."""
    fmus: dict[str, Path] = {}
    for text in given:
        named = several or text.partition("=")[0] in wings
        name, equals, path = text.partition("=") if named else ("rod", "=", text)
        if not (name and equals and path):
            raise InputError(f"--rod-fmu is {text}, but the scene has several rods: it must be of the form NAME=FMU")
        if name in fmus:
            raise InputError(
                f"--rod-fmu gives two FMUs for the rod{f' {name}' if several else ''}: {fmus[name]}, {path}"
            )
        fmus[name] = Path(path)
        if not fmus[name].is_file():
            alone = "" if named or "=" not in text else ", and the one rod of the scene needs no NAME="
            raise InputError(f"--rod-fmu: the file {path} does not exist{alone}")
    return fmus


@app.command()
def resume(
    folder: Folder,
    end_time: Annotated[
        float | None,
        typer.Option(help="Another end time, s; a finished run goes on if it was made with --checkpoint-every."),
    ] = None,
    drive: DriveFile = None,
    quiet: Quiet = False,
    live: Live = False,
) -> None:
    """Continue the run in a result folder from its checkpoint, with the scene, the units and the options of the run."""
    from nervure import api
    from nervure.coupling import read_drive

    with _exit_code():
        api.resume(folder, end_time=end_time, drive=read_drive(drive) if drive else None, quiet=quiet, live=live)


@contextmanager
def _exit_code() -> Iterator[None]:
    """End the command with the exit code of a run that failed or was interrupted."""
    from nervure.api import RunError

    try:
        yield
    except RunError as error:
        _say_error(error)
        raise typer.Exit(FAILED) from error
    except KeyboardInterrupt:
        raise typer.Exit(INTERRUPTED) from None


@app.command()
def inspect(
    path: Annotated[Path, typer.Argument(metavar="UNIT.fmu|SCENE|FOLDER", help="FMU, scene, or result folder.")],
    end_time: EndTime = None,
    overrides: Overrides = None,
) -> None:
    """Show the variables of an FMU, the size and forecast of a scene, or the results of a run or a sweep."""
    from nervure.output import inspection, sweeps
    from nervure.scene import load
    from nervure.terminal import Console

    console = Console()
    if (overrides or end_time is not None) and (path.is_dir() or path.suffix == ".fmu"):
        raise InputError(f"--set and --end-time change a scene, but {path} is none")
    if (path / "verify.json").is_file():
        from nervure.verification import report

        report.print_table(console, report.read(path))
    elif (path / "sweep.json").is_file():
        sweeps.print_table(console, sweeps.read(path))
    elif path.is_dir():
        inspection.show_results(console, path)
    elif path.suffix == ".fmu":
        inspection.show_unit(console, path)
    else:
        inspection.show_scene(console, load(path, overrides or (), end_time))


@app.command()
def plot(
    folders: Annotated[list[Path], typer.Argument(metavar="FOLDER...", help="Result folders of runs.")],
    output: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER", parser=_folder, help="Folder of the pictures; default: the folder of a single run."
        ),
    ] = None,
    form: Annotated[str, typer.Option("--format", metavar="png|svg|pdf", help="Format of the pictures.")] = "png",
) -> None:
    """Draw tip.png, drag.png and lift.png of one or several runs, or sweep.png of a sweep."""
    if len(folders) > 1 and output is None:
        raise InputError("several runs in one picture need --output, the folder of the pictures")
    from nervure.output import plots, sweeps
    from nervure.simulation import results

    if form not in plots.FORMATS:
        raise InputError(f"--format is {form}, but must be one of {', '.join(plots.FORMATS)}")
    if len(folders) == 1 and (folders[0] / "sweep.json").is_file():
        if (picture := sweeps.plot(folders[0], sweeps.read(folders[0]), form, output)) is None:
            raise InputError(f"{folders[0]}: fewer than two runs of the sweep are finished")
        typer.echo(picture)
        return
    runs = [results.read(folder) for folder in folders]
    target = output or folders[0]
    target.mkdir(parents=True, exist_ok=True)
    if not (written := plots.write(target, runs, form)):
        raise InputError(f"{', '.join(map(str, folders))}: no tip, drag or lift was recorded")
    for path in written:
        typer.echo(path)


@app.command()
def animate(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Result folder of a run with --fields-every.")],
    begin: Annotated[
        float | None, typer.Option(help="First time, s; default: two whole periods before the last.")
    ] = None,
    end: Annotated[float | None, typer.Option(help="Last time, s.")] = None,
    across: Annotated[
        str | None,
        typer.Option(metavar="x|y|z", help="Axis across the slice of a fluid in space."),
    ] = None,
    at: Annotated[float | None, typer.Option(metavar="PLACE", help="Place of the slice along this axis, m.")] = None,
    crop: Annotated[
        str | None, typer.Option(metavar="X0,X1,Y0,…", help="Ends of the part that is shown, along each axis, m.")
    ] = None,
    q: Annotated[float | None, typer.Option(metavar="Q", help="Q of the surfaces in vortices.gif, 1/s².")] = None,
    camera: Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Direction to the eye in vortices.gif.")] = None,
    background: Annotated[str, typer.Option(metavar="COLOUR", help="Background of vortices.gif.")] = "white",
) -> None:
    """Write vorticity.gif and phases.png into a result folder, of a fluid in space also vortices.gif."""
    from nervure.output import animation, vortices

    part = animation.Part(across, at, _numbers("--crop", crop))
    look = vortices.Look(q, _numbers("--camera", camera), background)
    for path in animation.write(folder, begin, end, part, look):
        typer.echo(f"{path} ({path.stat().st_size / 1e6:.1f} MB)")


@app.command()
def sweep(
    scene_files: Annotated[
        list[str],
        typer.Argument(
            metavar="SCENE...",
            help="Base scenes: files, or names of shipped scenes.",
            autocompletion=_complete_scene,
        ),
    ],
    vary: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=V1,V2,…",
            help="Values of a scene key, or KEY=[V1, V2, …] in JSON; repeatable: all combinations run. "
            "Keys of one option, 'KEY=V1,V2; KEY=W1,W2', change together.",
            autocompletion=_complete_key,
        ),
    ] = None,
    overrides: Overrides = None,
    end_time: EndTime = None,
    output: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", parser=_folder, help="Folder of the sweep; default: results/sweep-NAME."),
    ] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Repeat runs that failed or were killed.")
    ] = False,
    list_runs: Annotated[bool, typer.Option("--list", help="List the runs with their state, and run none.")] = False,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Run a grid of scenes in parallel and write sweep.csv, sweep.json and sweep.png.

    The same command continues a sweep: finished runs are not repeated.
    """
    from nervure import api
    from nervure.scene import read
    from nervure.simulation import sweep as sweeps
    from nervure.terminal import Console

    if workers is not None and scheduler is not None:
        raise InputError("--workers is for runs on this machine; those of --scheduler have their own workers")
    scenes = [read(name, overrides or (), end_time) for name in scene_files]
    cases = sweeps.grid(scenes, [sweeps.variation(text) for text in vary or []])
    folder = output or Path("results") / f"sweep-{sweeps.path_name(scenes[0])}"
    console = Console(quiet=quiet)
    todo = sweeps.missing_cases(cases, folder, retry_failed)
    console.print(f"{len(cases)} runs, {len(todo)} to do, into {folder}", markup=False, soft_wrap=True)
    if list_runs:
        for case in cases:
            row = sweeps.earlier_row(case, folder)
            state = f"{row['status']} {row['reason'] or ''}" if row else f"{case.steps} steps to do"
            console.print(f"{case.folder}: {state}", markup=False, soft_wrap=True)
        return
    try:
        rows = api.run_cases(console, cases, todo, folder, scheduler=scheduler, workers=workers, force=force)
    except KeyboardInterrupt:
        console.print("stopped; the same command continues with the missing runs")
        raise typer.Exit(INTERRUPTED) from None
    if any(row["status"] != sweeps.FINISHED for row in rows):
        raise typer.Exit(FAILED)


@app.command()
def verify(
    scene_file: SceneFile,
    within: Annotated[
        float, typer.Option(metavar="PART", parser=_part, help="Tolerance relative to the values, as 2% or 0.02.")
    ] = "2%",  # type: ignore[assignment]
    budget: Annotated[
        float, typer.Option(metavar="TIME", parser=_duration, help="Largest wall time, as 90s, 20min or 2h.")
    ] = "20min",  # type: ignore[assignment]
    quantities: Annotated[
        str | None,
        typer.Option(metavar="NAME,…", help="Outputs, as lift, or their statistics, as lift_mean; default: the large."),
    ] = None,
    parameters: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,…",
            help="What varies of cells, segments, mesh, step, c_eta, box, ratio, fine_box; default: all that it has.",
        ),
    ] = None,
    overrides: Overrides = None,
    end_time: EndTime = None,
    output: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", parser=_folder, help="Folder of the runs; default: results/verify-NAME."),
    ] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Find the errors of a scene by runs on other settings; write a table, a picture and a recommended scene.

    The same command continues: finished runs are not repeated. The exit status is 1 unless all errors are known within
    the tolerance.
    """
    from nervure import api
    from nervure.scene import load

    names = [[name.strip() for name in (given or "").split(",") if name.strip()] for given in (quantities, parameters)]
    scene = load(scene_file, overrides or (), end_time)
    try:
        found = api.verify(
            scene,
            output,
            within=within,
            budget=budget,
            quantities=names[0],
            parameters=names[1],
            workers=workers,
            scheduler=scheduler,
            force=force,
            quiet=quiet,
        )
    except KeyboardInterrupt:
        typer.echo("stopped; the same command continues with the missing runs")
        raise typer.Exit(INTERRUPTED) from None
    if not found.reached:
        raise typer.Exit(FAILED)


@app.command()
def dist(
    scene_file: SceneFile,
    folder: Annotated[Path, typer.Argument(help="Folder to write; one that `dist` wrote is replaced.")],
    fmi: Fmi = 2,
) -> None:
    """Write FMUs, SSP (FMI 2.0 only), checksums and manifest of a scene into a folder.

    `make dist` builds the libraries first.
    """
    from nervure.scene import load
    from nervure.units import delivery

    delivery.write(load(scene_file), folder, fmi)
    typer.echo(folder)


@app.command()
def merge(
    sources: Annotated[list[Path], typer.Argument(metavar="FMU...", help="FMUs that differ in their binaries only.")],
    output: Annotated[Path, typer.Option(metavar="MERGED.fmu", help="FMU to write.")],
) -> None:
    """Merge the binaries of several systems into one FMU."""
    from nervure.units import package

    typer.echo(package.merge(sources, output))


def main() -> None:
    """Run the command `nervure`."""
    from nervure.terminal import accept_all_signs

    accept_all_signs()
    gc.set_threshold(GARBAGE)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # NumPy solves small systems only, and its threads spin
    os.environ["PYDANTIC_DISABLE_PLUGINS"] = "1"  # Their search reads what is known of all packages
    os.environ["MPLBACKEND"] = "agg"  # A notebook hands its own on, which may not be installed here
    try:
        app()
    except UnitFailure as error:
        _say_error(error)
        sys.exit(FAILED)
    except InputError as error:
        _say_error(error)
        sys.exit(REFUSED)
    except OSError as error:  # a path that is too long, or a disk that takes nothing
        _say_error(f"{error.filename or 'a file'}: {error.strerror or error}")
        sys.exit(REFUSED)


def _say_error(error: object) -> None:
    from nervure.terminal import Console

    Console(stderr=True, soft_wrap=True).print(f"error: {error}", markup=False)
