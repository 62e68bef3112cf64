"""Pictures of a run: tip, drag and lift over time, and the vorticity around the solids at its end."""

from collections.abc import Mapping, Sequence
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon

from nervure.evaluate import coefficients, flapping, statistics
from nervure.evaluate.rods import rod_columns
from nervure.evaluate.statistics import Series
from nervure.files import write_whole
from nervure.output import axis_label, displayed_unit
from nervure.output.fields import outline, station_positions
from nervure.scene import Scene
from nervure.scene.types import Body, Fluid, Reference, ShapeCircle, ShapeEllipse, ShapePolygon, ShapeRectangle
from nervure.simulation.loop import Observer
from nervure.simulation.results import Results
from nervure.simulation.session import Session
from nervure.simulation.summary import TIP

BLUE, ORANGE, GREEN = "#0072B2", "#D55E00", "#009E73"  # Colours that colour-blind readers tell apart (Okabe & Ito 2008)
VORTICITY_PERCENTILE = 99.0  # Percentage of the points whose vorticity lies within the colour scale
COLOUR_MAP = "RdBu_r"  # Diverging, white at 0, and the same to colour-blind readers
COLOURS = (BLUE, ORANGE, GREEN)
CYCLE = (BLUE, ORANGE, GREEN, "#CC79A7", "#56B4E9", "#E69F00", "0.3")  # For runs over each other
START_UP = 0.01  # Part of the record that a start-up peak may last
SOLID = "0.55"
POSE = ("x", "y", "angle")  # Outputs of the fluid for each rigid body
ROUND = 90  # Corners of a round outline
PNG = {"compress_level": 3}  # Files a sixth larger, and a tenth less time for the start of a run, than by default


def write(folder: Path, runs: Sequence[Results]) -> list[Path]:
    """Write tip.png, drag.png and lift.png, for the outputs that the runs have, with the published bands of the first
    run's scene; of a single run coefficients.png and flapping.png too. Several runs are labelled by the names of their
    folders, or by their paths where names are equal. Return the paths written."""
    first, *others = runs
    tips = [column for run in runs for own in run.facts.beams for column in (own.prefix + name for name in TIP)]
    named = {run.folder.resolve().name: run for run in runs}
    labelled = named if len(named) == len(runs) else {str(run.folder): run for run in runs}
    written = []
    for file, wanted in (("tip", list(dict.fromkeys(tips))), ("drag", ("drag",)), ("lift", ("lift",))):
        columns = [column for column in wanted if any(column in run.series for run in runs)]
        if columns:
            written.append(_save(over_time(labelled, columns, first.scene.reference), folder / f"{file}.png"))
    return written if others else [*written, *cylinder(folder, first), *driven_roots(folder, first)]


def unit(name: str, scene: Scene) -> str:
    """Return the label of a unit in pictures of `scene`."""
    return displayed_unit(name, scene.display)[0] if scene.display else name


def over_time(runs: Mapping[str, Results], columns: Sequence[str], reference: Reference | None = None) -> Figure:
    """Draw `columns` over time below each other, with the published bands of `reference`."""
    figure = Figure(figsize=(9, 1.5 + 2 * len(columns)), layout="constrained")
    axes = figure.subplots(len(columns), sharex=True, squeeze=False)
    keys: dict[str, Any] = {}
    display = next(iter(runs.values())).scene.display
    for number, column in enumerate(columns):
        axis, colour = axes[number, 0], COLOURS[number % len(COLOURS)]
        having = {label: run for label, run in runs.items() if column in run.series}
        named, scale = displayed_unit(next(iter(having.values())).units[column], display)
        ranges = []
        for label, run in having.items():
            values = run.series[column] * scale
            look = {"color": colour} if len(runs) == 1 else {"color": CYCLE[list(runs).index(label) % len(CYCLE)]}
            (line,) = axis.plot(run.series["time"], values, linewidth=0.8, **look)
            ranges.append(_settled_range(run, values))
            if len(runs) > 1:
                keys[label] = line
        band = reference.quantities.get(column) if reference else None
        if reference and band and band.mean is not None and band.amplitude is not None:
            low, high = (band.mean - band.amplitude) * scale, (band.mean + band.amplitude) * scale
            keys[f"{reference.source}: mean ± amplitude"] = axis.axhspan(low, high, color="0.85", zorder=0)
            ranges.append((low, high))
        low, high = min(low for low, _ in ranges), max(high for _, high in ranges)
        margin = 0.05 * (high - low) or 0.05 * abs(high) or 1.0
        axis.set(ylabel=axis_label(column.replace("_", " "), named), ylim=(low - margin, high + margin))
        axis.margins(x=0)
    if keys:
        figure.legend(keys.values(), keys.keys(), loc="outside lower center", ncols=3, fontsize="small")
    axes[-1, 0].set_xlabel(axis_label("time", displayed_unit("s", display)[0]))
    return figure


def _settled_range(run: Results, values: np.ndarray) -> tuple[float, float]:
    """Return the range of `values` in a picture. A peak of the start-up, which is shorter than `START_UP` of the record
    and exceeds the range of the rest by more than that range, is cut off."""
    part = run.summary.window.of(run.series["time"]) if run.summary.window else slice(None)
    usual = np.r_[np.quantile(values, (START_UP, 1 - START_UP)), values[part].min(), values[part].max()]
    low, high = float(usual.min()), float(usual.max())
    lowest, highest = float(values.min()), float(values.max())
    span = high - low
    return low if low - lowest > span else lowest, high if highest - high > span else highest


def cylinder(folder: Path, run: Results) -> list[Path]:
    """Write coefficients.png of a cylinder alone: cD and cL over time and, in a periodic flow, against each other, with
    published values. Return the paths written."""
    scale = coefficients.scale(run.facts)
    if scale is None or run.summary.window is None:
        return []
    time, curves = run.series["time"], coefficients.curves(scale, run.series)
    published = coefficients.published(run.scene.reference)
    window = run.summary.window.last(statistics.MIN_PERIODS)
    part = window.of(time)
    lines = ("max", "min") if window.periods else ("mean",)
    layout: list[Any] = [["cd", "orbit"], ["cl", "orbit"]] if window.periods else [["cd"], ["cl"]]
    figure = Figure(figsize=(12 if window.periods else 8, 5), layout="constrained")
    axes = figure.subplot_mosaic(layout, width_ratios=[1.6, 1] if window.periods else None)
    for name, label, colour in (("cd", "$c_D$", BLUE), ("cl", "$c_L$", ORANGE)):
        axes[name].plot(time, curves[name], color=colour, linewidth=0.8)
        levels = [published[f"{name}_{what}"] for what in lines if f"{name}_{what}" in published]
        for where, level in product([name, "orbit"] if window.periods and name == "cd" else [name], levels):
            axes[where].axhline(level, color="0.4", linestyle="--", linewidth=0.8)
        low, high = min([curves[name][part].min(), *levels]), max([curves[name][part].max(), *levels])
        margin = max(0.5 * (high - low), 0.02 * abs(high))
        axes[name].set(ylabel=label, ylim=(low - margin, high + margin), xlim=(0, time[-1]))
        axes[name].axvspan(window.begin, window.end, color="0.93", zorder=0)
    axes["cl"].set_xlabel(axis_label("time", unit("s", run.scene)))
    if window.periods:
        axes["orbit"].plot(curves["cl"][part], curves["cd"][part], color=GREEN, linewidth=0.8)
        axes["orbit"].set(xlabel="$c_L$", ylabel="$c_D$", title=f"{window.periods} periods")
    keys: list[Artist] = [Patch(color="0.93", label="window")]
    if published:
        source = run.scene.reference.source if run.scene.reference else ""
        keys.append(Line2D([], [], color="0.4", linestyle="--", linewidth=0.8, label=source))
    figure.legend(handles=keys, loc="outside lower center", ncols=2, fontsize="small")
    return [_save(figure, folder / "coefficients.png")]


def driven_roots(folder: Path, run: Results) -> list[Path]:
    """Write flapping.png, or of several rods flapping-NAME.png, of each driven root. Return the paths written."""
    of = {own.unit: (own, f"flapping-{own.unit}.png") for own in run.facts.beams}
    several = {name: rod.flapping for name, rod in (run.summary.rods or {}).items()}
    alone = {"rod": run.summary.flapping}
    pictures = []
    for name, found in (several or alone).items():
        if found is not None:
            own, file = of[name]
            picture = driven_root(run, found, rod_columns(run.series, own))
            pictures.append(_save(picture, folder / (file if several else "flapping.png")))
    return pictures


def driven_root(run: Results, found: flapping.Flapping, series: Series) -> Figure:
    """Draw the path of the tip of a driven rod beside the path of a rigid rod, and forces and power over the periods of
    the window; `series` has the columns of this rod."""
    time, main, window = series["time"], found.axis, statistics.Window(*found.window_s, found.periods)
    part = window.of(time)
    phase = (time[part] - window.begin) * window.periods / (window.end - window.begin)
    other = max((axis for axis in flapping.AXES if axis != main and f"tip_u{axis}" in series),
                key=lambda axis: np.ptp(series[f"tip_u{axis}"][part]))  # fmt: skip
    figure = Figure(figsize=(11, 7.5), layout="constrained")
    axes = figure.subplot_mosaic([["path", "tip"], ["force", "power"]])
    for name, colour, label in (("rigid_tip", "0.6", "rigid"), ("tip", BLUE, "flexible")):
        along, across = (series[f"{name}_u{axis}"][part] for axis in (main, other))
        axes["path"].plot(across, along, color=colour, linewidth=0.8, label=label)
        axes["tip"].plot(phase, along, color=colour, linewidth=0.8, label=label)
    length = unit("m", run.scene)
    names = {"xlabel": axis_label(f"tip u{other}", length), "ylabel": axis_label(f"tip u{main}", length)}
    axes["path"].set(**names, aspect="equal")
    axes["path"].set_adjustable("datalim")
    axes["path"].locator_params(nbins=6)
    axes["tip"].set(xlabel="t/T", ylabel=names["ylabel"])

    if "beam_drag" in series:
        forces, told = [("beam_drag", -1, "thrust"), ("beam_lift", 1, "lift")], "force of the fluid"
    else:
        forces, told = [(f"root_force_{axis}", 1, f"along {axis}") for axis in flapping.AXES], "force at the root"
    powers = [
        ("root_power", 1, "in at the root"),
        ("load_power", 1, "by the loads"),
        ("damping_power", -1, "by damping"),
    ]
    starts = np.searchsorted(phase, np.arange(window.periods + 1))
    depth = "" if "tip_uz" in series else "/m"
    for place, curves, title, name in (("force", forces, told, "N"), ("power", powers, "power", "W")):
        shown = [curve for curve in curves if curve[0] in series and series[curve[0]].any()]
        for (column, sign, label), colour in zip(shown, COLOURS, strict=False):
            values = sign * series[column][part]
            for begin, end in pairwise(starts):
                look = {"label": label} if end == starts[-1] else {"alpha": 0.3}
                axes[place].plot(phase[begin:end] % 1, values[begin:end], color=colour, linewidth=0.8, **look)
        axes[place].set(xlabel="t/T", ylabel=axis_label(title, "" if run.scene.display else name + depth), xlim=(0, 1))
    for axis in axes.values():  # above the curves, not on them
        axis.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, fontsize="small", frameon=False, borderaxespad=0)
    first = f"t = {window.begin:.3g} {unit('s', run.scene)}"
    figure.suptitle(f"{window.periods} periods from {first}, the last one dark", fontsize="small")
    return figure


class Pictures(Observer):
    """Draws the pictures of a session when its results are written."""

    def __init__(self, session: Session):
        self.session = session

    def finish(self, results: Results) -> None:
        write(results.folder, [results])
        if results.summary.error is None:
            vorticity(self.session)


def vorticity(session: Session) -> None:
    """Write vorticity.png of the fluid as it is now, with still cylinders, and with bodies and beams in their places;
    nothing if the fluid shows no field."""
    scene, units = session.scene, session.units
    field = units["fluid"].shown_field("vorticity") if "fluid" in units else None
    if field is None or scene.fluid is None:
        return
    corners = [
        outline(station_positions(units, own), session.facts.thickness[own.force]) for own in session.facts.beams
    ]
    figure = Figure(figsize=size(scene, 12.0), layout="constrained")
    axis = figure.subplots()
    poses = [
        [float(units["fluid"].read(f"body[{i}].{part}")[0]) for part in POSE]
        for i, _ in enumerate(scene.fluid.bodies, 1)
    ]
    picture = draw_vorticity(axis, scene, field, corners, vorticity_limit(scene, [field]), poses)
    axis.set_title(f"t = {session.time:.3f} {unit('s', scene)}")
    figure.colorbar(picture, label=vorticity_label(scene), extend="both", pad=0.01)
    _save(figure, session.folder / "vorticity.png")


def vorticity_label(scene: Scene) -> str:
    """Return the label of the colour scale of the vorticity."""
    return axis_label("vorticity", unit("1/s", scene))


def draw_vorticity(
    axis: Axes,
    scene: Scene,
    field: np.ndarray,
    corners: Sequence[np.ndarray],
    limit: float,
    poses: Sequence[Sequence[float]] = (),
) -> AxesImage:
    """Draw a vorticity `field`, `[nx, ny]`, colours from -`limit` to `limit` (1/s), with the solids: `corners` are the
    outlines of the beams, `poses` position (m) and angle (rad) of the pivots of the bodies."""
    fluid = _fluid(scene)
    (x0, x1), (y0, y1) = fluid.box.x, fluid.box.y
    half_x, half_y = (x1 - x0) / field.shape[0] / 2, (y1 - y0) / field.shape[1] / 2
    extent = (x0 - half_x, x1 - half_x, y0 - half_y, y1 - half_y)
    look: dict[str, Any] = {"cmap": COLOUR_MAP, "vmin": -limit, "vmax": limit, "interpolation": "bilinear"}
    picture = axis.imshow(field.T, origin="lower", extent=extent, **look)
    for cylinder in fluid.cylinders:
        if cylinder.motion is None:
            axis.add_patch(Circle(cylinder.center, cylinder.radius, color=SOLID))
    for body, pose in zip(fluid.bodies, poses, strict=False):
        axis.add_patch(Polygon(body_outline(body, *pose), color=SOLID))
    for each in corners:
        axis.add_patch(Polygon(each, color=SOLID))
    left, right, bottom, top = _view(fluid)
    metre = unit("m", scene)
    axis.set(xlim=(left, right), ylim=(bottom, top), xlabel=axis_label("x", metre), ylabel=axis_label("y", metre))
    return picture


def body_outline(body: Body, x: float, y: float, angle: float) -> np.ndarray:
    """Return the outline of a rigid body, m, `[n, 2]`, with its pivot at (x, y), turned by an angle (rad)."""
    turn = np.linspace(0, 2 * np.pi, ROUND, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    match body.shape:
        case ShapePolygon(polygon=polygon):
            own = np.array(polygon.corners)
        case ShapeCircle(circle=round):
            own = circle * round.radius
        case ShapeEllipse(ellipse=ellipse):
            own = circle * [ellipse.length / 2, ellipse.thickness / 2]
        case ShapeRectangle(rectangle=rectangle) if rectangle.ends == "square":
            own = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * [rectangle.length / 2, rectangle.thickness / 2]
        case ShapeRectangle(rectangle=rectangle):
            straight = (rectangle.length - rectangle.thickness) / 2 * np.sign(circle[:, :1])
            own = circle * rectangle.thickness / 2 + np.pad(straight, ((0, 0), (0, 1)))
    sin, cos = np.sin(angle), np.cos(angle)
    placed: np.ndarray = (own - body.pivot) @ np.array([[cos, sin], [-sin, cos]]) + [x, y]
    return placed


def vorticity_limit(scene: Scene, vorticities: list[np.ndarray]) -> float:
    """Return the end of the colour scale for `vorticities` of a run, 1/s; the largest, at the walls, saturate."""
    fluid = _fluid(scene)
    left, _, bottom, top = _view(fluid)
    (x0, x1), (y0, y1) = fluid.box.x, fluid.box.y
    nx, ny = vorticities[0].shape
    columns, rows = np.linspace(x0, x1, nx, endpoint=False), np.linspace(y0, y1, ny, endpoint=False)
    seen = np.ix_(columns >= left, (rows >= bottom) & (rows <= top))
    return float(np.percentile(np.abs([field[seen] for field in vorticities]), VORTICITY_PERCENTILE)) or 1.0


def size(scene: Scene, width: float) -> tuple[float, float]:
    """Return the size of a figure of the fluid with a colour bar, in, for its width."""
    left, right, bottom, top = _view(_fluid(scene))
    return width, max(0.21 * width, 0.875 * width * (top - bottom) / (right - left) + 0.8)


def _fluid(scene: Scene) -> Fluid:
    assert scene.fluid is not None, "only a fluid has a vorticity"
    return scene.fluid


def _view(fluid: Fluid) -> tuple[float, float, float, float]:
    """Return the view of a picture of the fluid, m: the channel behind the inflow zone, else the whole box."""
    (x0, x1), (y0, y1) = fluid.box.x, fluid.box.y
    left = fluid.inflow.x[1] if fluid.inflow else x0
    bottom, top = fluid.channel.y if fluid.channel else (y0, y1)
    return left if x0 <= left < x1 - 0.1 * (x1 - x0) else x0, x1, bottom, top


def _save(figure: Figure, path: Path) -> Path:
    figure.set_dpi(150)
    canvas = FigureCanvasAgg(figure)  # `savefig` would draw it twice
    write_whole(path, lambda unfinished: canvas.print_png(unfinished, pil_kwargs=PNG))
    return path
