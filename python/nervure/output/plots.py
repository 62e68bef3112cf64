"""Pictures of a run: tip, drag and lift over time, and the vorticity around the solids at its end."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nervure.errors import InputError
from nervure.evaluate import benchmark, coefficients, flapping, statistics
from nervure.evaluate.rods import columns_of_units
from nervure.evaluate.statistics import Series
from nervure.files import write_whole
from nervure.output import axis_label, displayed_unit, flow, in_words, lengths_in, title, unit_in
from nervure.output.fields import fine_box, station_positions, wing_nodes
from nervure.scene import Scene
from nervure.scene.facts import Scales
from nervure.scene.types import Reference
from nervure.simulation.results import Results
from nervure.simulation.session import Session
from nervure.simulation.summary import TIP, prefixes_of_tips

BLUE, ORANGE, GREEN = "#0072B2", "#D55E00", "#009E73"  # Colours that colour-blind readers tell apart (Okabe & Ito 2008)
COLOURS = (BLUE, ORANGE, GREEN)
CYCLE = (BLUE, ORANGE, GREEN, "#CC79A7", "#56B4E9", "#E69F00", "0.3")  # For runs over each other
START_UP = 0.01  # Part of the record that a start-up peak may last
MARGIN = 0.08  # Part of an axis' range that stays free above and below
CLOSER = 3  # Whole periods that a second column of axes shows
FILTER_PERIODS = 1 / 25
"""Width of the box filter over forces in pictures, periods: it takes 1 % from an oscillation at twice the frequency."""
RAW, LIGHT = 0.6, 0.35  # Width and opacity of an unfiltered force
WIDTH, DPI = 9.0, 150  # Width of a picture, in, and points an inch
Ranges = Sequence[tuple[float, float]]  # Smallest and largest values of curves
FORMATS = ("png", "svg", "pdf")
PNG = {"compress_level": 3}  # Files a sixth larger, and a tenth less time for the start of a run, than by default


def write(folder: Path, runs: Sequence[Results], form: str = "png") -> list[Path]:
    """Write tip.png, drag.png and lift.png, or the same in another of `FORMATS`, for the outputs that the runs have,
    with the published bands of the first run's scene; of a single run coefficients.png and flapping.png too. Return
    what is written."""
    first, *others = runs
    tips = [prefix + name for run in runs for prefix in prefixes_of_tips(run.scene) for name in TIP]
    written = []
    for file, wanted in (("tip", list(dict.fromkeys(tips))), ("drag", ("drag",)), ("lift", ("lift",))):
        columns = [column for column in wanted if any(column in run.series for run in runs)]
        if columns:
            written.append(
                save(over_time(labelled(runs), columns, benchmark.reference(first.scene)), folder / f"{file}.{form}")
            )
    return written if others else [*written, *cylinder(folder, first, form), *driven_roots(folder, first, form)]


def labelled(runs: Sequence[Results]) -> dict[str, Results]:
    """Return runs by the names of their folders, or by their paths where names are equal."""
    named = {run.folder.resolve().name: run for run in runs}
    return named if len(named) == len(runs) else {str(run.folder): run for run in runs}


def unit(name: str, scene: Scene) -> str:
    """Return the name of a unit in pictures of `scene`."""
    return displayed_unit(name, scene.display)[0]


def over_time(runs: Mapping[str, Results], columns: Sequence[str], reference: Reference | None = None) -> Figure:
    """Draw `columns` over time below each other, each unit on axes of its own, and over the window of the first run the
    band that `reference` has. A force in a fluid is drawn as a running mean over the computed one in a light tone.
    Raise `InputError` for runs whose scenes have other units of length and time."""
    first = next(iter(runs.values()))
    for label, run in runs.items():
        if run.scene.display != first.scene.display:
            raise InputError(f"{label} has other units of length and time in `display` than {next(iter(runs))}")
    panels = list(dict.fromkeys((column, run.units[column]) for column in columns for run in runs.values()
                                if column in run.series))  # fmt: skip
    figure = Figure(figsize=(WIDTH, 1.7 + 2 * len(panels)), layout="constrained")
    figure.suptitle(title(first.scene, WIDTH), fontsize="medium")
    window = first.summary.window
    closer = window.last(CLOSER) if window and window.periods > CLOSER else None
    ratios = (2, 1) if closer else (1,)
    how: dict[str, Any] = {"squeeze": False, "sharex": "col", "sharey": "row", "width_ratios": ratios}
    axes = figure.subplots(len(panels), len(ratios), **how)
    keys: dict[str, Any] = {}
    for number, (column, of) in enumerate(panels):
        having = {label: run for label, run in runs.items() if column in run.series and run.units[column] == of}
        known = next(iter(having.values()))
        named, scale = unit_in(known.scene, known.units[column], float(np.abs(known.series[column]).max()))
        ranges, extremes = [], []
        for label, run in having.items():
            values = run.series[column] * scale
            colour = COLOURS[number % len(COLOURS)] if len(runs) == 1 else CYCLE[list(runs).index(label) % len(CYCLE)]
            shown = _filtered(run, column) * scale
            force = bool((shown != values).any())
            for axis in axes[number]:
                raw = axis.plot(run.series["time"], values, color=colour, linewidth=RAW, alpha=LIGHT) if force else []
                (line,) = axis.plot(run.series["time"], shown, color=colour, linewidth=1.0)
            ranges.append(_settled_range(run, shown))
            extremes.append((float(values.min()), float(values.max())))
            if len(runs) > 1:
                keys[label] = line
            elif force:
                keys |= {"as computed": raw[0], _name_filter(run): line}
        band = reference.quantities.get(column) if reference else None
        if reference and band and band.unit == of and band.mean is not None and band.amplitude is not None:
            low, high = (band.mean - band.amplitude) * scale, (band.mean + band.amplitude) * scale
            over = (window.begin, window.end) if window else (first.series["time"][0], first.series["time"][-1])
            for axis in axes[number]:
                drawn = axis.fill_between(over, low, high, color="0.85", linewidth=0, zorder=0)
            keys[f"{reference.source}: mean ± amplitude"] = drawn
            ranges.append((low, high))
        axes[number, 0].set_ylabel(axis_label(in_words(column, known.scene), named))
        axes[number, 0].margins(x=0)
        _set_range(axes[number, 0], ranges, extremes, named)
    if keys:
        figure.legend(keys.values(), keys.keys(), loc="outside lower center", ncols=2, fontsize="small")
    for axis in axes[-1]:
        axis.set_xlabel(axis_label("time", displayed_unit("s", first.scene.display)[0]))
    if closer:
        axes[0, 1].set_xlim(closer.begin, closer.end)
        axes[0, 1].locator_params(axis="x", nbins=4)
    return figure


def _filtered(run: Results, column: str) -> np.ndarray:
    """Return a column; a force in a fluid under the filter of pictures, where the run has a window."""
    values, window = run.series[column], run.summary.window
    if window is None or run.scene.fluid is None or not (run.units[column] or "").startswith("N"):
        return values
    return statistics.box_filter(run.series["time"], values, filter_width(window))


def filter_width(window: statistics.Window) -> float:
    """Return the width of the box filter over forces in pictures, s; a surface that crosses grid points makes noise."""
    if window.periods == 0:
        return statistics.FORCE_FILTER
    return FILTER_PERIODS * (window.end - window.begin) / window.periods


def _name_filter(run: Results) -> str:
    window = run.summary.window
    width = f"{filter_width(window):.2g} {unit('s', run.scene)}" if window else ""
    return f"mean over {width}"


def _settled_range(run: Results, values: np.ndarray) -> tuple[float, float]:
    """Return the smallest and the largest of `values` for an axis: from the window on where the run is periodic,
    otherwise of the whole record. A peak shorter than `START_UP` of the record that exceeds the range of the rest by
    more than that range is cut off."""
    time, window = run.series["time"], run.summary.window
    if window and window.periods:
        settled = values[time >= window.begin]
        return float(settled.min()), float(settled.max())
    part = window.of(time) if window else slice(None)
    usual = np.r_[np.quantile(values, (START_UP, 1 - START_UP)), values[part].min(), values[part].max()]
    low, high = float(usual.min()), float(usual.max())
    lowest, highest = float(values.min()), float(values.max())
    span = high - low
    return low if low - lowest > span else lowest, high if highest - high > span else highest


def _set_range(axis: Axes, ranges: Ranges, extremes: Ranges, named: str, margin: float = MARGIN) -> None:
    """Set the y axis to `ranges` with a margin, and write above it how far curves with `extremes` leave the axis."""
    (low, high), (lowest, highest) = (
        (min(a for a, _ in found), max(b for _, b in found)) for found in (ranges, extremes)
    )
    room = margin * (high - low) or margin * abs(high) or 1.0
    axis.set_ylim(low - room, high + room)
    if lowest < low - room or highest > high + room:
        beyond = f"clipped: {lowest:.3g} to {highest:.3g} {named}".rstrip()
        axis.set_title(beyond, loc="right", fontsize="small", color="0.4", pad=3)


def cylinder(folder: Path, run: Results, form: str) -> list[Path]:
    """Write coefficients.png of a cylinder alone: cD and cL over time and, in a periodic flow, against each other, with
    published values. Return the paths written."""
    scale = coefficients.scale(run.facts)
    if scale is None or run.summary.window is None:
        return []
    time, raw = run.series["time"], coefficients.curves(scale, run.series)
    curves = coefficients.curves(scale, run.series, filter_width(run.summary.window))
    reference = benchmark.reference(run.scene)
    published = coefficients.published(reference)
    window = run.summary.window.last(statistics.MIN_PERIODS)
    part = window.of(time)
    lines = ("max", "min") if window.periods else ("mean",)
    layout: list[Any] = [["cd", "orbit"], ["cl", "orbit"]] if window.periods else [["cd"], ["cl"]]
    figure = Figure(figsize=(12 if window.periods else WIDTH, 5.4), layout="constrained")
    figure.suptitle(title(run.scene, WIDTH), fontsize="medium")
    axes = figure.subplot_mosaic(layout, width_ratios=[1.6, 1] if window.periods else None)
    for name, label, colour in (("cd", "$c_D$", BLUE), ("cl", "$c_L$", ORANGE)):
        axes[name].plot(time, raw[name], color=colour, linewidth=RAW, alpha=LIGHT)
        axes[name].plot(time, curves[name], color=colour, linewidth=1.0)
        levels = [published[f"{name}_{what}"] for what in lines if f"{name}_{what}" in published]
        axes[name].hlines(levels, window.begin, window.end, color="0.4", linestyle="--", linewidth=0.8)
        if window.periods and name == "cd":
            for level in levels:
                axes["orbit"].axhline(level, color="0.4", linestyle="--", linewidth=0.8)
        low, high = min([curves[name][part].min(), *levels]), max([curves[name][part].max(), *levels])
        room = max(0.5 * (high - low), 0.02 * abs(high)) / (high - low or abs(high) or 1.0)
        axes[name].set(ylabel=label, xlim=(0, time[-1]))
        _set_range(axes[name], [(low, high)], [(raw[name].min(), raw[name].max())], "", room)
        axes[name].axvspan(window.begin, window.end, color="0.93", zorder=0)
    axes["cl"].set_xlabel(axis_label("time", unit("s", run.scene)))
    if window.periods:
        axes["orbit"].plot(curves["cl"][part], curves["cd"][part], color=GREEN, linewidth=1.0)
        axes["orbit"].set(xlabel="$c_L$", ylabel="$c_D$")
        axes["orbit"].set_title(f"{window.periods} periods", fontsize="medium")
        axes["orbit"].locator_params(nbins=5)
    keys: list[Artist] = [Patch(color="0.93", label="window")]
    keys.append(Line2D([], [], color="0.4", linewidth=RAW, alpha=LIGHT, label="as computed"))
    if published:
        source = reference.source if reference else ""
        keys.append(Line2D([], [], color="0.4", linestyle="--", linewidth=0.8, label=source))
    figure.legend(handles=keys, loc="outside lower center", ncols=3, fontsize="small")
    return [save(figure, folder / f"coefficients.{form}")]


def driven_roots(folder: Path, run: Results, form: str) -> list[Path]:
    """Write flapping.png, or of several rods and wings flapping-NAME.png, of each driven root; return the paths."""
    of = columns_of_units(run.series, run.scene)
    several = {name: own.flapping for name, own in {**(run.summary.rods or {}), **(run.summary.wings or {})}.items()}
    alone = dict.fromkeys(of, run.summary.flapping)
    pictures = []
    for name, found in (several or alone).items():
        if found is not None:
            force, series = of[name]
            file = f"flapping-{name}.{form}" if several else f"flapping.{form}"
            pictures.append(save(driven_root(run, found, series, run.facts.scales.get(force)), folder / file))
    return pictures


def driven_root(run: Results, found: flapping.Flapping, series: Series, scales: Scales | None) -> Figure:
    """Draw the path of the tip of a driven rod beside the path of a rigid rod, and forces and power over the periods of
    the window; `series` has the columns of this rod, and `scales` the directions of its forces."""
    time, main, window = series["time"], found.axis, statistics.Window(*found.window_s, found.periods)
    part = window.of(time)
    phase = (time[part] - window.begin) * window.periods / (window.end - window.begin)
    other = max((axis for axis in flapping.AXES if axis != main and f"tip_u{axis}" in series),
                key=lambda axis: np.ptp(series[f"tip_u{axis}"][part]))  # fmt: skip
    figure = Figure(figsize=(11, 7.7), layout="constrained")
    axes = figure.subplot_mosaic([["path", "tip"], ["force", "power"]])
    reach = np.concatenate([series[f"{name}_u{axis}"][part] for name in ("tip", "rigid_tip") for axis in (main, other)])
    length, scale = lengths_in(run.scene, float(np.abs(reach).max()))
    for name, colour, label in (("rigid_tip", "0.6", "rigid"), ("tip", BLUE, "flexible")):
        along, across = (scale * series[f"{name}_u{axis}"][part] for axis in (main, other))
        axes["path"].plot(across, along, color=colour, linewidth=0.8, label=label)
        axes["tip"].plot(phase, along, color=colour, linewidth=0.8, label=label)
    names = [axis_label(in_words(f"tip_u{axis}", run.scene), length) for axis in (other, main)]
    axes["path"].set(xlabel=names[0], ylabel=names[1], aspect="equal")
    axes["path"].set_adjustable("datalim")
    axes["path"].locator_params(nbins=5)
    axes["tip"].set(xlabel="t/T", ylabel=names[1])

    if scales and (on_beam := flapping.forces(series, "beam")) is not None:
        series = {**series, **dict(zip(flapping.FORCES, scales.directions(len(on_beam)) @ on_beam, strict=True))}
        forces, of_force = [("drag", -1, "thrust"), ("lift", 1, "lift")], "force of the fluid"
        if len(on_beam) > 2:
            forces.append(("side", 1, "side"))
    else:
        forces, of_force = [(f"root_force_{axis}", 1, f"along {axis}") for axis in flapping.AXES], "force at the root"
    powers = [
        ("root_power", 1, "in at the root"),
        ("load_power", 1, "by the loads"),
        ("damping_power", -1, "by damping"),
    ]
    starts = np.searchsorted(phase, np.arange(window.periods + 1))
    width = filter_width(window) if run.scene.fluid else 0.0
    depth = "" if "tip_uz" in series else "/m"
    for place, curves, named, of in (("force", forces, of_force, "N"), ("power", powers, "power", "W")):
        shown = [curve for curve in curves if curve[0] in series and series[curve[0]].any()]
        for (column, sign, label), colour in zip(shown, COLOURS, strict=False):
            raw = sign * series[column][part]
            values = sign * statistics.box_filter(time, series[column], width)[part]
            for begin, end in pairwise(starts):
                last = end == starts[-1]
                look = {"label": label} if last else {"alpha": 0.3}
                axes[place].plot(phase[begin:end] % 1, values[begin:end], color=colour, linewidth=0.9, **look)
                if last:
                    light: dict[str, Any] = {"color": colour, "linewidth": RAW, "alpha": LIGHT}
                    axes[place].plot(phase[begin:end] % 1, raw[begin:end], **light)
        axes[place].set(xlabel="t/T", ylabel=axis_label(named, "" if run.scene.display else of + depth), xlim=(0, 1))
    for axis in axes.values():  # above the curves, not on them
        axis.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, fontsize="small", frameon=False, borderaxespad=0)
    first = f"t = {window.begin:.3g} {unit('s', run.scene)}"
    caption = f"{window.periods} periods from {first}, the last one dark"
    if width:
        caption += (
            f"; forces and powers as a mean over T/{1 / FILTER_PERIODS:.0f}, of the last as computed in a light tone"
        )
    figure.suptitle(f"{title(run.scene, 11)}\n{caption}", fontsize="medium")
    return figure


def vorticity(session: Session) -> Figure | None:
    """Draw the fluid as it is now, with cylinders, bodies and beams in their places; None if the fluid shows no
    field. In space it is the vorticity in a slice, about the axis across it."""
    scene, units = session.scene, session.units
    if scene.fluid is None or "fluid" not in units:
        return None
    view = flow.View(scene)
    field = units["fluid"].shown_field(view.component)
    if field is None:
        return None
    beams = [
        outline
        for own in session.facts.beams
        for outline in view.beam(station_positions(units, own), session.facts.thickness[own.force])
    ]
    poses = flow.poses(scene, lambda name: float(units["fluid"].read(name)[0]))
    mesh = session.facts.wing
    shown = view.cut(field), view.outlines(beams, poses, (wing_nodes(session), mesh.triangles) if mesh else None)
    figure, axes = view.panels(WIDTH)
    figure.set_dpi(DPI)
    picture = flow.Picture(axes[0, 0], view, view.colour_limit([shown]))
    picture.show(*shown, view.fine_box(fine_box(units["fluid"]) or None))
    picture.say(session.time)
    flow.colour_bar(figure, axes, picture.image, view)
    return figure


def save(figure: Figure, path: Path) -> Path:
    """Write a picture in the format that the suffix of `path` names, `FORMATS`; return `path`."""
    figure.set_dpi(DPI)
    if path.suffix != ".png":
        write_whole(path, lambda unfinished: figure.savefig(unfinished, format=path.suffix[1:]))
        return path
    canvas = FigureCanvasAgg(figure)  # `savefig` would draw it twice
    write_whole(path, lambda unfinished: canvas.print_png(unfinished, pil_kwargs=PNG))
    return path
