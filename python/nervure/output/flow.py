"""Pictures of the fluid: its vorticity around the solids, with one colour bar as high as the axes.

A picture has more points than the grid. Between grid points the solver's Fourier series is evaluated with Lanczos'
sigma factors, as its mean over two cells (Lanczos, Applied Analysis, 1956): where the vorticity jumps, at a wall or at
the seam of the periodic box, the bare series rings with a wavelength of two to three cells. Field files hold the bare
values.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Polygon
from matplotlib.path import Path

from nervure.errors import InputError
from nervure.output import axis_label, displayed_unit, layout, lengths_in, space, title
from nervure.output.fields import outline
from nervure.scene import Scene
from nervure.scene.outline import body_outline, circle
from nervure.scene.solids import pose_names
from nervure.scene.types import Fluid

PERCENTILE = 99.5  # Part of the visible points outside of `LAYER`, in percent, inside the colour scale
LAYER = 2.0  # Thickness of the layer at walls and solids that does not set the colour scale, cells
COLOUR_MAP = "RdBu_r"  # Diverging, white at 0, and the same to colour-blind readers
SOLID, EDGE = "0.8", "0.15"  # Greys of a solid and of its outline
THICK, THIN = 0.6, 1.5  # Widths of the outline of a solid and of a line
MARK = "0.6"  # Grey of a sponge and of the outline of a fine box

Value = TypeVar("Value")
Crop = Sequence[float]  # Ends of a part along x, y and in space z, m: x_0, x_1, y_0, …
Solids = Sequence[np.ndarray]  # Outlines of the solids of a frame, m, each `[n, 2]`


class View:
    """The part of a fluid that pictures show: the plane, or in space the slice across the axis `across` (x, y or z) at
    `at` (m), by default where it shows the bodies (see `space.choose`); `crop` has the ends along each axis, m."""

    def __init__(self, scene: Scene, across: str | None = None, at: float | None = None, crop: Crop | None = None):
        self.scene, self.fluid = scene, _fluid(scene)
        box = self.fluid.box
        self.plane: space.Plane | None = None
        if box.z:
            self.plane, self.number = space.choose(scene, across, at)
        elif across is not None or at is not None:
            raise InputError("a slice is chosen in space only, but the fluid has two dimensions")
        self.axes = self.plane.axes if self.plane else (0, 1)
        self.names = tuple("xyz"[axis] for axis in self.axes)
        self.ends = [getattr(box, name) for name in self.names]
        parts = dict(zip("xyz", space.cropped(self.fluid, crop), strict=False)) if crop else {}
        shown = []
        for name, (low, high) in zip(self.names, self.ends, strict=True):
            walls = getattr(self.fluid.channel, name, None)
            begin, end = walls or (low, high)
            if name == "x" and (inflow := self.fluid.inflow) and low <= inflow.x[1] < end - 0.1 * (end - begin):
                begin = inflow.x[1]
            shown.append(parts.get(name, (begin, end)))
        (left, right), (bottom, top) = shown
        self.extent = left, right, bottom, top  # m
        self.unit, self.scale = lengths_in(scene, max(map(abs, self.extent)))

    @property
    def place(self) -> str:
        """Where a slice lies, as `z = 0 mm`; empty in the plane."""
        if not self.plane:
            return ""
        return f"{'xyz'[self.plane.normal]} = {self.scale * self.plane.place:.3g} {self.unit}"

    @property
    def component(self) -> str:
        """The component of the vorticity across the picture, as the fluid names it."""
        return "vorticity" if not self.plane or self.plane.normal == 2 else f"vorticity_{'xyz'[self.plane.normal]}"

    def named(self, field: str) -> str:
        """Return the words for a field."""
        return f"vorticity about {'xyz'[self.plane.normal]}" if self.plane and field == "vorticity" else field

    def cut(self, field: np.ndarray) -> np.ndarray:
        """Return the values of a field, `[nx, ny]` or `[nx, ny, nz]`, in the picture, `[n, m]`."""
        return np.take(field, self.number, axis=self.plane.normal) if self.plane else field

    def beam(self, line: np.ndarray, thickness: np.ndarray) -> list[np.ndarray]:
        """Return the outlines of a beam, m, each `[n, 2]`, by its stations, `[n, 2]` or `[n, 3]`, and its thickness."""
        return self.plane.rod(line, float(thickness.max()) / 2) if self.plane else [outline(line, thickness)]

    def outlines(
        self,
        beams: Solids,
        places: Sequence[Sequence[float]],
        wing: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> list[np.ndarray]:
        """Return the outlines in the picture of the cylinders and bodies at `places` (m and rad, see `poses`), of
        `beams`, and of a wing by its nodes, `[n, 3]` (m), and triangles."""
        fluid, plane, poses = self.fluid, self.plane, iter(places)
        bodies = list(zip(fluid.bodies, poses, strict=False))
        if plane:
            cut = [line for body, of in bodies for line in plane.body(body, of, fluid)]
            return list(map(self._image, [*cut, *beams, *(plane.cut(*wing) if wing else ())]))
        centres = (next(poses) if cylinder.motion else cylinder.center for cylinder in fluid.cylinders)
        found = [np.array(centre) + circle(own.radius) for centre, own in zip(centres, fluid.cylinders, strict=True)]
        return list(map(self._image, [*found, *(body_outline(body, *of) for body, of in bodies), *beams]))

    def _image(self, line: np.ndarray) -> np.ndarray:
        """Return an outline where it is in the box: what a fine box follows may have gone through its sides."""
        if not self.fluid.fine_box:
            return line
        low, high = np.transpose(self.ends)
        periods: np.ndarray = np.floor(((line.min(axis=0) + line.max(axis=0)) / 2 - low) / (high - low))
        return np.array(line - periods * (high - low))

    def fine_ends(self, lows: Sequence[float] | None = None) -> list[tuple[float, float]]:
        """Return the ends of the fine box along each axis, m, moved by whole periods so that it begins in the box; none
        without one. `lows` has its lower ends, m, if it moves."""
        box, fine, ends = self.fluid.box, self.fluid.fine_box, []
        for i, name in enumerate("xyz"[: len(box.cells)] if fine else ""):
            (low, high), own = getattr(box, name), getattr(fine, name)
            cell = (high - low) / box.cells[i]
            begin, end = (low + cell * np.round((np.array(own) - low) / cell)).tolist()
            if lows is not None:
                begin, end = lows[i], lows[i] + end - begin
            periods = (high - low) * float(np.floor((begin - low) / (high - low)))
            ends.append((begin - periods, end - periods))
        return ends

    def fine_box(self, lows: Sequence[float] | None = None) -> list[np.ndarray]:
        """Return the outlines of the fine box in the picture, m, each `[4, 2]`, see `fine_ends`: two where it reaches
        over a side of the periodic box."""
        ends = self.fine_ends(lows)
        if not ends or (self.plane and self.fine_number(ends) is None):
            return []
        across = []
        for axis, (low, high) in zip(self.axes, self.ends, strict=True):
            begin, end = ends[axis]
            across.append([(begin, end), (begin - high + low, end - high + low)][: 1 + (end > high)])
        return [np.array([(a, c), (b, c), (b, d), (a, d)]) for a, b in across[0] for c, d in across[1]]

    def fine_number(self, ends: list[tuple[float, float]]) -> int | None:
        """Return the number of the fine points in a slice; None where it misses the fine box."""
        assert self.plane and self.fluid.fine_box, "a slice has a plane"
        axis = self.plane.normal
        (low, high), (begin, end) = getattr(self.fluid.box, "xyz"[axis]), ends[axis]
        cell = (high - low) / self.fluid.box.cells[axis] / self.fluid.fine_box.ratio
        number = round((self.plane.place - begin) % (high - low) / cell)
        return number if number < round((end - begin) / cell) else None

    @property
    def sponge(self) -> tuple[float, float] | None:
        """The ends of the sponge along the picture, m; None where it is not in it."""
        return self.fluid.sponge.x if self.fluid.sponge and self.axes[0] == 0 else None

    def panels(
        self, width: float, rows: int = 1, columns: int = 1, top: float = layout.TOP
    ) -> tuple[Figure, np.ndarray]:
        """Return a figure of `width` (in) with axes `[rows, columns]` for pictures below `top` (in)."""
        left, right, low, high = self.extent
        return layout.grid(width, [right - left] * columns, [high - low] * rows, top)

    def colour_limit(self, frames: Iterable[tuple[np.ndarray, Solids]], percentile: float = PERCENTILE) -> float:
        """Return the end of the colour scale for frames of a field and solids; the layers at walls saturate."""
        shown = np.concatenate([np.abs(field[self._free(field.shape, solids)]) for field, solids in frames])
        return float(np.percentile(shown, percentile)) or 1.0 if shown.size else 1.0

    def _free(self, shape: tuple[int, ...], solids: Solids) -> np.ndarray:
        """Return which points of a grid of `shape` are seen outside of solids and of the layer at solids and walls."""
        x, y = (np.linspace(low, high, n, endpoint=False) for (low, high), n in zip(self.ends, shape, strict=True))
        layer = LAYER * max(x[1] - x[0], y[1] - y[0])
        inside = []
        for places, name, low, high in zip((x, y), self.names, self.extent[::2], self.extent[1::2], strict=True):
            wall = layer if getattr(self.fluid.channel, name, None) else 0.0
            inside.append((places >= low + wall) & (places <= high - wall))
        free: np.ndarray = np.logical_and.outer(*inside)
        for solid in solids:
            near = np.ix_(*((at > low - layer) & (at < high + layer) for at, low, high in
                            zip((x, y), solid.min(axis=0), solid.max(axis=0), strict=True)))  # fmt: skip
            points = np.stack(np.broadcast_arrays(x[near[0]], y[near[1]]), axis=-1).reshape(-1, 2)
            covered = Path(solid).contains_points(points) | (_distance(points, solid) < layer)
            free[near] &= ~covered.reshape(free[near].shape)
        return free


def poses(scene: Scene, read: Callable[[str], Value]) -> list[list[Value]]:
    """Return what `read` gives of the outputs for the place of each body, then of each cylinder that moves."""
    fluid = _fluid(scene)
    bodies = [[read(f"body[{i}].{part}") for part in pose_names(fluid, own)] for i, own in enumerate(fluid.bodies, 1)]
    moving = (i for i, cylinder in enumerate(fluid.cylinders, 1) if cylinder.motion)
    return [*bodies, *([read(f"cylinder[{i}].{axis}") for axis in "xy"] for i in moving)]


def colour_bar(
    figure: Figure, axes: np.ndarray, picture: AxesImage, view: View, name: str = "vorticity", unit: str = "1/s"
) -> None:
    """Add the colour bar of a field, as high as all `axes` together."""
    place, triangle, ticks = layout.bar(figure, axes)
    label = axis_label(view.named(name), displayed_unit(unit, view.scene.display)[0])
    figure.colorbar(picture, cax=place, label=label, extend="both", extendfrac=triangle, ticks=ticks)


class Picture:
    """The vorticity in `axis`, with colours from -`limit` to `limit` (1/s)."""

    def __init__(self, axis: Axes, view: View, limit: float):
        self.axis, self.view, self.patches = axis, view, list[Polygon]()
        left, right, bottom, top = view.extent
        pixels = axis.get_window_extent()
        columns, rows = max(2, round(pixels.width)), max(2, round(pixels.height))
        self.x = left + (np.arange(columns) + 0.5) / columns * (right - left)
        self.y = bottom + (np.arange(rows) + 0.5) / rows * (top - bottom)
        look: dict[str, Any] = {"cmap": COLOUR_MAP, "vmin": -limit, "vmax": limit, "origin": "lower", "aspect": "auto"}
        look["extent"] = [view.scale * edge for edge in view.extent]
        self.image = axis.imshow(np.zeros((2, 2)), **look)
        axis.set(xlabel=axis_label(view.names[0], view.unit), ylabel=axis_label(view.names[1], view.unit))
        if view.sponge and view.sponge[0] < right and view.sponge[1] > left:
            self._mark(*np.clip(view.sponge, left, right))

    def _mark(self, begin: float, end: float) -> None:
        """Mark a sponge from `begin` to `end`, m: the flow in it is not that of the scene."""
        begin, end = self.view.scale * begin, self.view.scale * end
        self.axis.axvspan(begin, end, facecolor="none", edgecolor=MARK, hatch="//", linewidth=0, alpha=0.6)
        self.axis.axvline(begin, color=MARK, linewidth=0.6)
        look: dict[str, Any] = {"rotation": 90, "ha": "right", "va": "bottom", "fontsize": "x-small", "color": "0.35"}
        self.axis.annotate("sponge", (begin, 0), (-1, 3), ("data", "axes fraction"), "offset points", **look)

    def show(self, field: np.ndarray, solids: Solids, boxes: Solids = (), fine: np.ndarray | None = None) -> None:
        """Show a vorticity `field` (1/s) in the view, `[n, m]`, in the fine box that of its own cells, `fine`, and over
        it the outlines of the box and the solids."""
        along, up = self.view.ends
        values = resample(resample(field, along, self.x).T, up, self.y)
        if fine is not None:
            for (left, bottom), _, (right, top), _ in boxes:
                inside = (self.y >= bottom) & (self.y < top), (self.x >= left) & (self.x < right)
                up_to, along_to = (
                    (self.y[inside[0]] - bottom) / (top - bottom),
                    (self.x[inside[1]] - left) / (right - left),
                )
                values[np.ix_(*inside)] = between(between(fine, along_to).T, up_to)
        self.image.set_data(values)
        for patch in self.patches:
            patch.remove()
        look: dict[str, Any] = {"facecolor": SOLID, "edgecolor": EDGE}
        self.patches = [
            Polygon(self.view.scale * solid, linewidth=THIN if is_line(solid) else THICK, **look) for solid in solids
        ]
        edges: dict[str, Any] = {"fill": False, "edgecolor": MARK, "linestyle": (0, (4, 3)), "linewidth": THICK}
        self.patches += [Polygon(self.view.scale * box, **edges) for box in boxes]
        for patch in self.patches:
            self.axis.add_patch(patch)

    def say(self, time: float) -> None:
        """Write the title of the scene and the `time` (s) above the picture, and where a slice lies."""
        view = self.view
        clock = f"t = {time:.3f} {displayed_unit('s', view.scene.display)[0]}"
        clock = ", ".join(filter(None, (view.place, clock)))
        inches = self.axis.get_window_extent().width / self.axis.figure.dpi
        self.axis.set_title(title(view.scene, inches - 0.1 * len(clock)), loc="left", fontsize="small")
        self.axis.set_title(clock, loc="right", fontsize="small")


def is_line(outline: np.ndarray) -> bool:
    """Return whether an outline is that of a line, which has no thickness."""
    return bool((outline == outline[::-1]).all())


def sigma(n: int) -> np.ndarray:
    """Return Lanczos' factors of the waves of `n` points: those of a mean over two cells."""
    return np.sinc(2 * np.arange(n // 2 + 1) / n)


def mean(values: np.ndarray) -> np.ndarray:
    """Return a field that is periodic along both axes at its own points, averaged over two cells along each."""
    for n in values.shape:  # each pass turns the field
        values = np.fft.irfft(sigma(n)[:, None] * np.fft.rfft(values, axis=0), n, axis=0).T
    return values


def resample(values: np.ndarray, ends: Sequence[float], places: np.ndarray) -> np.ndarray:
    """Return the Fourier series of `values`, which are periodic along the first axis between `ends`, at `places` along
    that axis, averaged over two cells."""
    n, (begin, end) = len(values), ends
    order = np.arange(n // 2 + 1)
    weight = np.where(order == 0, 1.0, 2.0) * sigma(n) / n
    waves = weight * np.exp(2j * np.pi * np.outer((places - begin) / (end - begin), order))
    found: np.ndarray = (waves @ np.fft.rfft(values, axis=0)).real
    return found


def between(values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return `values` along the first axis at `places`, 0 at the first and 1 a step behind the last, linear between."""
    at = places * len(values)
    below = np.clip(at.astype(int), 0, len(values) - 2)
    share = (at - below)[:, None]
    found: np.ndarray = (1 - share) * values[below] + share * values[below + 1]
    return found


def _distance(points: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """Return the distance of `points` from a closed `outline`, m."""
    least = np.full(len(points), np.inf)
    for begin, side in zip(outline, np.roll(outline, -1, axis=0) - outline, strict=True):
        along = np.clip((points - begin) @ side / max(side @ side, np.finfo(float).tiny), 0, 1)
        least = np.minimum(least, np.hypot(*(points - begin - along[:, None] * side).T))
    return least


def _fluid(scene: Scene) -> Fluid:
    assert scene.fluid is not None, "only a fluid has a vorticity"
    return scene.fluid
