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

from nervure.output import axis_label, displayed_unit, layout, lengths_in, space, title
from nervure.scene import Scene
from nervure.scene.outline import body_outline, circle
from nervure.scene.solids import pose_names
from nervure.scene.types import Fluid

PERCENTILE = 99.5  # Part of the visible points outside of `LAYER`, in percent, inside the colour scale
LAYER = 2.0  # Thickness of the layer at walls and solids that does not set the colour scale, cells
COLOUR_MAP = "RdBu_r"  # Diverging, white at 0, and the same to colour-blind readers
SOLID, EDGE = "0.8", "0.15"  # Greys of a solid and of its outline

Value = TypeVar("Value")
Solids = Sequence[np.ndarray]  # Outlines of the solids of a frame, m, each `[n, 2]`


def outlines(scene: Scene, beams: Solids, poses: Sequence[Sequence[float]]) -> list[np.ndarray]:
    """Return the outlines of the still cylinders, of the bodies at `poses` (m and rad, see `poses`) and of `beams`, in
    space those in the plane that pictures show."""
    fluid = _fluid(scene)
    if fluid.box.z:
        return [line for body, of in zip(fluid.bodies, poses, strict=False) for line in space.section(body, of, fluid)]
    still = [cylinder for cylinder in fluid.cylinders if cylinder.motion is None]
    found = [np.array(cylinder.center) + circle(cylinder.radius) for cylinder in still]
    return [*found, *(body_outline(body, *pose) for body, pose in zip(fluid.bodies, poses, strict=False)), *beams]


def poses(scene: Scene, read: Callable[[str], Value]) -> list[list[Value]]:
    """Return what `read` gives of the outputs for the place of each rigid body, by their names."""
    fluid = _fluid(scene)
    bodies = enumerate(fluid.bodies, 1)
    return [[read(f"body[{i}].{part}") for part in pose_names(fluid, body)] for i, body in bodies]


def panels(
    scene: Scene, width: float, rows: int = 1, columns: int = 1, top: float = layout.TOP
) -> tuple[Figure, np.ndarray]:
    """Return a figure of `width` (in) with axes `[rows, columns]` for pictures of `scene` below `top` (in)."""
    left, right, low, high = view(_fluid(scene))
    return layout.grid(width, [right - left] * columns, [high - low] * rows, top)


def colour_bar(
    figure: Figure, axes: np.ndarray, picture: AxesImage, scene: Scene, name: str = "vorticity", unit: str = "1/s"
) -> None:
    """Add the colour bar of a field, as high as all `axes` together."""
    place, triangle, ticks = layout.bar(figure, axes)
    label = axis_label(name, displayed_unit(unit, scene.display)[0])
    figure.colorbar(picture, cax=place, label=label, extend="both", extendfrac=triangle, ticks=ticks)


class Picture:
    """The vorticity in `axis`, with colours from -`limit` to `limit` (1/s)."""

    def __init__(self, axis: Axes, scene: Scene, limit: float):
        self.axis, self.fluid = axis, _fluid(scene)
        left, right, bottom, top = extent = view(self.fluid)
        unit, scale = lengths_in(scene, max(map(abs, extent)))
        self.unit, self.scale, self.patches = unit, scale, list[Polygon]()
        pixels = axis.get_window_extent()
        columns, rows = max(2, round(pixels.width)), max(2, round(pixels.height))
        self.x = left + (np.arange(columns) + 0.5) / columns * (right - left)
        self.y = bottom + (np.arange(rows) + 0.5) / rows * (top - bottom)
        look: dict[str, Any] = {"cmap": COLOUR_MAP, "vmin": -limit, "vmax": limit, "origin": "lower", "aspect": "auto"}
        look["extent"] = [scale * edge for edge in extent]
        self.image = axis.imshow(np.zeros((2, 2)), **look)
        axis.set(xlabel=axis_label("x", unit), ylabel=axis_label("y", unit))

    def show(self, field: np.ndarray, solids: Solids) -> None:
        """Show a vorticity `field` (1/s), `[nx, ny]`, and the solids over it."""
        fine = resample(resample(field, self.fluid.box.x, self.x).T, self.fluid.box.y, self.y)
        self.image.set_data(fine)
        for patch in self.patches:
            patch.remove()
        look: dict[str, Any] = {"facecolor": SOLID, "edgecolor": EDGE, "linewidth": 0.6}
        self.patches = [Polygon(self.scale * outline, **look) for outline in solids]
        for patch in self.patches:
            self.axis.add_patch(patch)

    def say(self, time: float, scene: Scene) -> None:
        """Write the title of the scene and the `time` (s) above the picture."""
        clock = f"t = {time:.3f} {displayed_unit('s', scene.display)[0]}"
        if self.fluid.box.z:
            clock = f"z = {self.scale * space.slice_z(self.fluid):.3g} {self.unit}, {clock}"
        inches = self.axis.get_window_extent().width / self.axis.figure.dpi
        self.axis.set_title(title(scene, inches - 0.1 * len(clock)), loc="left", fontsize="small")
        self.axis.set_title(clock, loc="right", fontsize="small")


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


def colour_limit(scene: Scene, frames: Iterable[tuple[np.ndarray, Solids]], percentile: float = PERCENTILE) -> float:
    """Return the end of the colour scale for frames of a field and solids; the layers at walls saturate."""
    shown = np.concatenate([np.abs(field[_free(scene, field.shape, solids)]) for field, solids in frames])
    return float(np.percentile(shown, percentile)) or 1.0 if shown.size else 1.0


def _free(scene: Scene, shape: tuple[int, ...], solids: Solids) -> np.ndarray:
    """Return which points of a grid of `shape` are seen outside of solids and of the layer at solids and walls."""
    fluid = _fluid(scene)
    left, right, bottom, top = view(fluid)
    x, y = (np.linspace(*ends, n, endpoint=False) for ends, n in zip((fluid.box.x, fluid.box.y), shape, strict=True))
    layer = LAYER * max(x[1] - x[0], y[1] - y[0])
    wall, side = (
        layer if walls else 0.0 for walls in (fluid.channel and fluid.channel.y, fluid.channel and fluid.channel.x)
    )
    along = (x >= left + side) & (x <= right - side)
    free: np.ndarray = np.logical_and.outer(along, (y >= bottom + wall) & (y <= top - wall))
    for outline in solids:
        near = np.ix_(*((at > low - layer) & (at < high + layer) for at, low, high in
                        zip((x, y), outline.min(axis=0), outline.max(axis=0), strict=True)))  # fmt: skip
        points = np.stack(np.broadcast_arrays(x[near[0]], y[near[1]]), axis=-1).reshape(-1, 2)
        solid = Path(outline).contains_points(points) | (_distance(points, outline) < layer)
        free[near] &= ~solid.reshape(free[near].shape)
    return free


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


def view(fluid: Fluid) -> tuple[float, float, float, float]:
    """Return left, right, lower and upper end of a picture, m: the channel behind the inflow zone, or the box."""
    (x0, x1), (bottom, top) = ((fluid.channel and getattr(fluid.channel, a)) or getattr(fluid.box, a) for a in "xy")
    left = fluid.inflow.x[1] if fluid.inflow else x0
    return left if x0 <= left < x1 - 0.1 * (x1 - x0) else x0, x1, bottom, top
