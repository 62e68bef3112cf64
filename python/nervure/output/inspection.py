"""Tables about FMUs, scenes and result folders, for `nervure inspect`."""

import importlib
import zipfile
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from nervure.coupling import stand_still
from nervure.errors import InputError, UnitError
from nervure.output import forecast, prior
from nervure.output.tables import print_table
from nervure.scene import Scene
from nervure.scene.facts import Facts
from nervure.scene.solids import cell_lengths, counts_of
from nervure.scene.types import FineBox, Fluid, MiddleBox
from nervure.simulation import checkpoint, ranges, results, verified
from nervure.simulation.session import Session
from nervure.units.describe import unit_kinds
from nervure.units.fmu import read_description, variables_of, version_of

FLAGS = {
    2: (
        "canHandleVariableCommunicationStepSize", "canInterpolateInputs", "maxOutputDerivativeOrder",
        "canBeInstantiatedOnlyOncePerProcess", "canNotUseMemoryManagementFunctions", "canGetAndSetFMUstate",
        "canSerializeFMUstate", "providesDirectionalDerivative", "needsExecutionTool",
    ),
    3: (
        "canHandleVariableCommunicationStepSize", "maxOutputDerivativeOrder", "canBeInstantiatedOnlyOncePerProcess",
        "canGetAndSetFMUstate", "canSerializeFMUstate", "providesAdjointDerivatives", "hasEventMode",
        "needsExecutionTool",
    ),
}  # fmt: skip
"""Flags of a co-simulation unit that fmpy reads (FMI 2.0.4, section 4.3.1; FMI 3.0.2, section 4.4.1)."""

TIMED = 0.1  # Wall time of the first steps, s
PARTS = ("channel", "inflow", "sponge", "mean_flow", "cylinders", "bodies", "probes")  # Parts that a fluid may have


def _print(console: Console, title: str, rows: Iterable[tuple[str, str]]) -> None:
    """Print a table of two columns without lines."""
    table = Table(title=escape(title), show_header=False, box=None, title_justify="left", padding=(0, 1))
    for name, value in rows:
        table.add_row(escape(name), escape(value))
    console.print(table)


def show_unit(console: Console, path: Path) -> None:
    """Print model, flags and variables of an FMU; an array is one row."""
    description = read_description(path)
    with zipfile.ZipFile(path) as archive:
        platforms = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")}
    if description.coSimulation is None:
        raise UnitError(f"{path} is not a co-simulation unit")
    flags = FLAGS.get(version_of(description) or 2, ())
    rows = [
        ("description", description.description or ""),
        ("version", description.version or ""),
        ("made by", description.generationTool or ""),
        ("FMI", f"{description.fmiVersion}, {', '.join(sorted(platforms - {''})) or 'no library'}"),
        ("GUID", description.guid),
        ("flags", "\n".join(f"{flag} {getattr(description.coSimulation, flag, None)}" for flag in flags)),
    ]
    if experiment := description.defaultExperiment:
        rows.insert(4, ("experiment", f"to {experiment.stopTime} s in steps of {experiment.stepSize} s"))
    _print(console, description.modelName, rows)
    table = Table("variable", "causality", "type", "unit", "start", box=None, padding=(0, 1))
    for variable in variables_of(description).values():
        starts = list(dict.fromkeys(start for start in variable.start if start is not None))
        name = f"{variable.name}[1 … {variable.size}]" if variable.size > 1 else variable.name
        start = starts[0] if len(starts) == 1 else f"{starts[0]} … {starts[-1]}" if starts else ""
        cells = name, variable.causality or "", variable.kind, variable.unit or "", start
        table.add_row(*map(escape, cells))
    console.print(table)


def show_scene(console: Console, scene: Scene) -> None:
    """Print sizes, choices and forecast of a scene."""
    facts, units = Facts(scene), unit_kinds(scene)
    rows = [("description", scene.description)] if scene.description else []
    *front, last = units
    rows.append(("units", f"{', '.join(front)} and {last}" if front else last))
    if fluid := scene.fluid:
        spacing = (f"{length:.3g}" for length in cell_lengths(fluid))
        rows.append(("fluid", f"{' x '.join(map(str, fluid.box.cells))} cells of {' x '.join(spacing)} m"))
        if middle := fluid.middle_box:
            rows.append(("middle box", _cells_of(middle, fluid)))
        if fine := fluid.fine_box:
            follows = f", follows {facts.followed}" if facts.followed else ""
            rows.append(("fine box", f"{_cells_of(fine, fluid)}{follows}"))
        rows.append(("in it", ", ".join(name.replace("_", " ") for name in PARTS if getattr(fluid, name)) or "nothing"))
    for own in facts.beams:
        beam, ends = own.beam, dict.fromkeys(f"{h:g}" for h in facts.thickness[own.force][[0, -1]])
        size = f"{beam.length:g} x {' to '.join(ends)} m, {beam.segments} segments, {beam.segments + 1} stations"
        rows.append((f"beam of {own.unit}" if own.prefix else "beam", size))
    if mesh := facts.wing:
        lengths = np.ptp(mesh.nodes, axis=0)
        lengths[lengths < 1e-9 * lengths.max()] = 0.0  # Rounding of a turned root
        extent = " x ".join(f"{length:.3g}" for length in lengths)
        size = f"{extent} m, {len(mesh.nodes)} nodes, {len(mesh.triangles)} triangles, {len(mesh.veins)} veins"
        if scene.wing and scene.wing.regions:
            names = [region.name for region in scene.wing.regions]
            size += f", regions {', '.join(f'{n} ({(mesh.materials == i).sum()})' for i, n in enumerate(names, 1))}"
        wings = importlib.import_module("nervure.output.wings")  # Drawing in space is slow to import
        rows += [
            ("wing" if scene.wing else "wings", size),
            ("picture", str(wings.save_mesh(scene, mesh, Path("results") / scene.name))),
        ]
    rows += forecast.scene_rows(facts)
    if not (bars := verified.bars(scene, Path("results"))) and (likely := prior.expected(facts)):
        rows.append(("errors", likely))
    for name, bar in (bars or {}).items():
        rows.append(
            (f"verified {name.replace('_', ' ')}", f"{bar.limit:.4g} {bar.unit}, here off by up to {bar.error:.2g}")
        )
    rows += _measured(scene)
    rows += (("warning", text) for text in ranges.warnings(facts))
    _print(console, scene.name, rows)


def _cells_of(fine: FineBox | MiddleBox, fluid: Fluid) -> str:
    """Return number and lengths of the cells of a box in the large one."""
    counts = map(str, counts_of(fine, fluid))
    lengths = (f"{cell / fine.ratio:.3g}" for cell in cell_lengths(fluid))
    return f"{' x '.join(counts)} cells of {' x '.join(lengths)} m"


def _measured(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield scheme, table, memory and wall time of a scene, by name, from its first steps."""
    before = forecast.resident_memory()
    with Session(scene, drive=stand_still) as session:
        wall = forecast.measured(session, TIMED)
        resident = forecast.resident_memory()
    recorder = session.recorder
    yield from forecast.scheme_rows(session)
    yield "series.csv", f"{len(recorder.table)} rows of {len(recorder.columns)} columns"
    if resident:
        total, pythons = (f"{size / 1e6:.0f} MB" for size in (resident + recorder.table.nbytes, before))
        yield "memory", f"about {total}, of which Python and its packages take {pythons}"
    yield "wall time", f"about {forecast.duration(wall)} on this machine"


def show_results(console: Console, folder: Path) -> None:
    """Print the summary of a run, and the progress of a run that was stopped or killed."""
    stopped = (folder / results.CHECKPOINT).is_file()
    try:
        found = results.read(folder)
        summary = found.summary
    except InputError:
        if not stopped:
            raise
    else:
        known = summary.verified or verified.bars(found.scene, folder.resolve().parent)
        print_table(console, replace(summary, verified=known), found.scene)
        if not summary.completed:
            console.print(f"not completed: {summary.error or 'interrupted'}", markup=False, soft_wrap=True)
        git = summary.git
        revision = git.revision + (" with changes" if git.dirty else "") if git else "unknown"
        console.print(f"revision {revision}, {summary.machine.cpu}", markup=False, soft_wrap=True)
    if stopped:
        about = checkpoint.read(folder).about
        text = f"checkpoint after {about['done']} steps, {about['wall']:.0f} s of wall time"
        console.print(f"{text}: `nervure resume {folder}` continues the run", markup=False, soft_wrap=True)
