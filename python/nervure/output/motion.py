"""Pictures of rods without a fluid, in the plane or in space from above, from the front and from the side."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D

from nervure.output import axis_label, displayed_unit, layout, lengths_in, title
from nervure.scene import Scene

MARGIN = 0.05  # Room around the rod, relative to the largest extent of its motion
FLAT = 0.1  # Least extent of a view, relative to the largest
ABOVE, FRONT, SIDE = (0, 1), (0, 2), (1, 2)  # Views, by the axes of space that they show
NAMES = {ABOVE: "from above", FRONT: "from the front", SIDE: "from the side"}
SCALE = "viridis"  # Colours of times
PAPER = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}  # Behind a name that a path may cross


class RodPicture:
    """Axes for rods, all views to one scale and large enough for the `shapes` of each, `[frames, n, 3]`, and the paths
    of their tips, `[times, 3]`, both in m and of the whole run. In space shapes are centre lines, else outlines."""

    def __init__(
        self, scene: Scene, shapes: Sequence[np.ndarray], paths: Sequence[np.ndarray], width: float, *, in_space: bool
    ):
        everything = np.concatenate([points.reshape(-1, 3) for points in (*shapes, *paths)])
        low, high = everything.min(axis=0), everything.max(axis=0)
        self.in_space = in_space
        largest = (high - low).max()
        half = np.maximum(high - low, FLAT * largest) / 2 + MARGIN * largest
        low, high = (low + high) / 2 - half, (low + high) / 2 + half
        named, self.scale = lengths_in(scene, float(np.abs([low, high]).max()))
        x, y, z = 2 * half
        columns, rows = ([x, y], [y, z]) if self.in_space else ([x], [y])
        self.figure, self.grid = layout.grid(width, columns, rows)
        places = {ABOVE: (0, 0), FRONT: (1, 0), SIDE: (1, 1)} if self.in_space else {ABOVE: (0, 0)}
        self.views: dict[tuple[int, int], Axes] = {view: self.grid[place] for view, place in places.items()}
        for (across, up), axis in self.views.items():
            axis.set(xlim=self.scale * np.array([low[across], high[across]]))
            axis.set(ylim=self.scale * np.array([low[up], high[up]]))
            axis.set(xlabel=axis_label("xyz"[across], named), ylabel=axis_label("xyz"[up], named))
            if self.in_space:
                look: dict[str, Any] = {"va": "top", "fontsize": "small", "zorder": 5, "bbox": PAPER}
                axis.text(0.03, 0.97, NAMES[across, up], transform=axis.transAxes, **look)
        layout.label_outer(self.grid)
        if self.in_space:
            self.grid[0, 1].set_axis_off()
        inches = width - layout.LEFT - layout.RIGHT
        self.views[ABOVE].set_title(title(scene, inches - 1.2), loc="left", fontsize="small")
        self.caption = self.grid[0, -1].set_title("", loc="right", fontsize="small")
        self.clock = displayed_unit("s", scene.display)[0]

    def draw_paths(self, paths: Sequence[np.ndarray], times: np.ndarray | None = None) -> None:
        """Draw the paths of tips, in grey, or with their `times` (s) in colours and their bar."""
        for view, axis in self.views.items():
            for line in (self.scale * path[:, view] for path in paths):
                if times is None:
                    axis.plot(*line.T, color="0.75", linewidth=0.8, scalex=False, scaley=False)
                    continue
                scale = Normalize(times[0], times[-1])
                pieces = LineCollection(
                    list(np.stack([line[:-1], line[1:]], axis=1)), cmap=SCALE, norm=scale, linewidth=0.8
                )
                pieces.set_array(times[:-1])
                axis.add_collection(pieces, autolim=False)
        if times is not None:
            place, _, ticks = layout.bar(self.figure, self.grid)
            label = axis_label("time at the tip", self.clock)
            self.figure.colorbar(ScalarMappable(scale, SCALE), cax=place, label=label, ticks=ticks)

    def add(self, shape: np.ndarray, **look: Any) -> list[Line2D]:
        """Draw a shape of the rod, `[n, 3]`; return its lines, one in each view."""
        return [
            axis.plot(*self.line(shape, view), scalex=False, scaley=False, **look)[0]
            for view, axis in self.views.items()
        ]

    def line(self, shape: np.ndarray, view: tuple[int, int]) -> np.ndarray:
        """Return the points of a shape in a view, `[2, n]`; the outline of a rod in the plane is closed."""
        closed = shape if self.in_space else np.concatenate([shape, shape[:1]])
        placed: np.ndarray = self.scale * closed[:, view].T
        return placed
