"""Table and picture of a sweep."""

from collections.abc import Iterable, Sequence
from math import log
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table

from nervure.errors import InputError
from nervure.files import read_json
from nervure.output import axis_label, displayed_unit, lengths_in, title, unit_in
from nervure.scene import Scene, validate
from nervure.scene.solids import cell_lengths
from nervure.simulation.sweep import FINISHED, Row, short_keys, short_value

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHOWN = (
    ("thrust", "thrust", "N/m"),
    ("lift", "lift, cycle mean", "N/m"),
    ("efficiency", "efficiency", ""),
    ("thrust_by_power", "thrust by power", "s/m"),
    ("phase_lag_deg", "phase lag of the tip [°]", ""),
    ("cd_mean", "$c_D$, mean", ""),
    ("cl_peak_to_peak", "$c_L$, peak to peak", ""),
    ("st", "St", ""),
    ("tip_uy_amplitude", "tip, along y: amplitude", "m"),
    ("tip_uy_mean", "tip, along y: mean", "m"),
    ("tip_uy_frequency_hz", "tip, along y: frequency", "1/s"),
    *(
        (f"{force}_{what}", f"{force}, {what}", "N/m")
        for force in ("drag", "lift", "side")
        for what in ("mean", "amplitude")
    ),
)
"""Columns of a sweep in table and picture, with their names and units in the picture, in space in N."""

RIVALS = (("thrust", "lift"), *((f"{force}_mean", f"{force}_amplitude") for force in ("drag", "lift", "side")))
"""Pairs of columns of which one may be left out: of mean and amplitude the smaller one, a lift below `MINOR` of the
thrust."""

MINOR = 0.1

GRID = "fluid.box.cells"
PANELS = 4  # Largest number of quantities in table and picture
DECADE = 10  # Ratio of the largest to the smallest value from which the axis is logarithmic
NAMED = 8  # Largest number of names at an axis
LABEL = 0.15  # Room for a label, part of an axis
LINE: dict[str, Any] = {"linewidth": 0.9, "markersize": 4}
MARKERS = "os^Dv*"


def read(folder: Path) -> list[Row]:
    """Read the rows of the sweep in `folder`."""
    try:
        rows: list[Row] = read_json(folder / "sweep.json")
        needed = {"folder", "scene", "status"}
        if not isinstance(rows, list) or not all(isinstance(row, dict) and needed <= row.keys() for row in rows):
            raise ValueError("it is no list of runs")
    except (OSError, ValueError) as error:
        raise InputError(f"{folder} holds no sweep: sweep.json: {error}; `nervure sweep` makes it") from error
    return rows


def varied(rows: Sequence[Row]) -> list[str]:
    """Return the dotted keys that differ between `rows`: the columns between scene and status."""
    keys = list(dict.fromkeys(name for row in rows for name in list(row)[: list(row).index("status")]))
    return [key for key in keys if key not in ("folder", "scene")]


def _quantities(rows: Sequence[Row]) -> list[tuple[str, str, str]]:
    """Return the first columns of `SHOWN` that a finished run has, of rivals those that matter."""
    finished = [row for row in rows if row["status"] == FINISHED]

    def size(name: str) -> float:
        values = sorted(abs(row[name]) for row in finished if isinstance(row.get(name), float))
        return values[len(values) // 2] if values else -1.0

    minor = set()
    for one, other in RIVALS:
        first, second = size(one), size(other)
        if one.endswith("_mean"):
            minor.add(other if first >= second else one)
        elif second < MINOR * first:
            minor.add(other)
    space = any("side_mean" in row for row in rows)
    known = [shown for shown in SHOWN if shown[0] not in minor and size(shown[0]) >= 0.0][:PANELS]
    return [(name, words, unit.removesuffix("/m") if space else unit) for name, words, unit in known]


def print_table(console: Console, rows: Sequence[Row]) -> None:
    """Print a line for each run: values, status, first quantities, wall time."""
    keys, found = varied(rows), _quantities(rows)
    several = len({row["scene"] for row in rows}) > 1 or not keys
    headings = ["scene"] * several + [short_keys(keys)[key] for key in keys] + ["status"]
    numbers = (Column(escape(name.replace("_", " ")), justify="right") for name in [*(n for n, *_ in found), "wall s"])
    table = Table(*map(escape, headings), *numbers, box=None, padding=(0, 1))
    for row in rows:
        cells = [str(row["scene"])] * several + [short_value(row.get(key)) for key in keys] + [row["status"]]
        table.add_row(*map(escape, cells), *(_digits(row.get(name)) for name, *_ in found), _digits(row.get("wall_s")))
    console.print(table)


def _digits(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"


def plot(folder: Path, rows: Sequence[Row], form: str = "png", target: Path | None = None) -> Path | None:
    """Write sweep.png of the sweep in `folder`, there or into `target`, or the same in the format `form`: the first
    quantities over the first varied key, or over the cell size of grids, a curve for each combination of the other keys
    that do not change together with it. Return its path; None where fewer than two runs are finished."""
    planned = rows
    rows = [row for row in rows if row["status"] == FINISHED]
    found = _quantities(rows)
    if len(rows) < 2 or not found:
        return None
    from matplotlib.figure import Figure

    from nervure.output import plots

    keys = varied(rows)
    short = short_keys(keys)
    first, others = (keys[0], keys[1:]) if keys else ("scene", [])
    grid = next((key for key in keys if key == GRID or key.startswith(f"{GRID}.")), None)
    if grid and _together(planned, first, grid):
        first, others = grid, [key for key in keys if key != grid]
    if len({row["scene"] for row in rows}) > 1 and keys:
        others = ["scene", *others]
    others = [key for key in others if not _together(planned, first, key)]
    scenes = [_scene(folder, row) for row in rows]
    scene = scenes[0] if len({row["scene"] for row in rows}) == 1 else None
    values = [row[first] for row in rows]
    label = short.get(first, first).replace("_", " ")
    if first == grid and None not in scenes:
        sizes = [_cell(known) for known in scenes if known]
        unit, scale = lengths_in(scenes[0], max(sizes)) if scenes[0] else ("m", 1.0)
        values, label = [scale * size for size in sizes], axis_label("cell size", unit)
    numeric = all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
    places = list(dict.fromkeys(map(short_value, values)))
    columns = min(2, len(found))
    lines = -(-len(found) // columns)
    figure = Figure(figsize=(5 * columns, 3.2 * lines + 0.5), layout="constrained")
    axes = figure.subplots(lines, columns, squeeze=False)
    curves: dict[str, list[tuple[Any, Row]]] = {}
    for value, row in zip(values, rows, strict=True):
        of = ", ".join(f"{short.get(key, key)} = {short_value(row[key])}" for key in others)
        curves.setdefault(of, []).append((value if numeric else places.index(short_value(value)), row))
    for axis in axes.flat[len(found) :]:
        axis.set_visible(False)
    if scene:
        figure.suptitle(title(scene, 5 * columns), fontsize="medium")
    for axis, (name, words, unit) in zip(axes.flat, found, strict=False):
        if scene and scene.fluid and scene.fluid.box.z:
            unit = unit.removesuffix("/m") if unit.startswith("N") else unit
        largest = max(abs(row[name]) for row in rows if row.get(name) is not None)
        named, scale = unit_in(scene, unit, largest) if scene else displayed_unit(unit)
        for number, (curve, members) in enumerate(curves.items()):
            points = sorted((x, scale * row[name]) for x, row in members if row.get(name) is not None)
            colour, marker = plots.COLOURS[number % len(plots.COLOURS)], MARKERS[number % len(MARKERS)]
            axis.plot(*zip(*points, strict=True), color=colour, marker=marker, label=curve, **LINE) if points else None
        if numeric and _spans_decade(values):
            _set_logarithmic(axis, sorted(set(values)))
        elif numeric:
            axis.locator_params(axis="x", nbins=6)
        else:
            every = -(-len(places) // NAMED)
            axis.set_xticks(range(0, len(places), every), places[::every], rotation=20, ha="right")
        axis.ticklabel_format(axis="y", scilimits=(-3, 4), useOffset=False)
        axis.set(xlabel=label, ylabel=axis_label(words, named))
    if others:
        handles = axes.flat[0].get_legend_handles_labels()
        figure.legend(*handles, loc="outside lower center", ncols=3, fontsize="small")
    return plots.save(figure, (target or folder) / f"sweep.{form}")


def _set_logarithmic(axis: "Axes", values: Sequence[float]) -> None:
    """Make the x axis logarithmic, with the lines of a decade behind the `values`, which are labelled."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter

    axis.set_xscale("log")
    axis.xaxis.set_major_locator(FixedLocator(_apart(values)))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: short_value(float(value))))
    axis.xaxis.set_minor_locator(LogLocator(subs=range(1, 10), numticks=100))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.grid(axis="x", which="minor", color="0.88", linewidth=0.5)


def _cell(scene: Scene) -> float:
    """Return the longest side of a cell, m."""
    assert scene.fluid, "cells are those of a fluid"
    return max(cell_lengths(scene.fluid))


def _scene(folder: Path, row: Row) -> Scene | None:
    """Return the scene of a run; None where the file cannot be read."""
    try:
        return validate(read_json(folder / str(row["folder"]) / "scene.json"))
    except (OSError, ValueError, InputError):
        return None


def _together(rows: Sequence[Row], first: str, key: str) -> bool:
    """Return whether each value of `first` has one value of `key`."""
    pairs = {(short_value(row.get(first)), short_value(row.get(key))) for row in rows}
    return len(pairs) == len({of_first for of_first, _ in pairs})


def _apart(values: Sequence[float]) -> list[float]:
    """Return as many of the sorted `values` as have labels that do not overlap on a logarithmic axis."""
    least, kept = LABEL * log(values[-1] / values[0]), [values[0]]
    for value in values[1:]:
        if log(value / kept[-1]) >= least:
            kept.append(value)
    return kept


def _spans_decade(values: Iterable[float]) -> bool:
    """Return whether `values` are positive and span a decade."""
    known = list(values)
    return min(known) > 0 and max(known) >= DECADE * min(known)
