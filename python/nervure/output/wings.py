"""Pictures of wings in space, with rods beside them: their meshes with roots and veins, and their shapes over time."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from mpl_toolkits.mplot3d.art3d import Line3D, Poly3DCollection  # type: ignore[import-untyped]

from nervure.output import axis_label, displayed_unit, layout, lengths_in, plots, title
from nervure.output.fields import station_positions, wing_nodes
from nervure.scene import Scene, beams
from nervure.scene.facts import WingMesh
from nervure.simulation.session import Session

FLAT = 0.15  # Least extent of the axes, relative to the largest
LIGHT = np.array([0.3, -0.4, 0.87])  # Direction of the light
DARK, BRIGHT = 0.3, 0.95  # Greys of triangles along and across the light
ABOVE, ASIDE = 28.0, -60.0  # Place of the eye, degrees
VEIN, ROOT, ROD, MESH = 1.2, 2.4, 1.8, 0.15  # Widths of lines
LABEL = 8.0  # Distance of the label of an axis, points
TALL = 0.83  # Height of a tall box in its axes, by that of a box of matplotlib's own size
SIN, COS = np.sin(np.radians([ABOVE, ASIDE])), np.cos(np.radians([ABOVE, ASIDE]))
UP = np.array([SIN[0] * COS[1], -SIN[0] * SIN[1], COS[0]])  # Parts of x, y and z in the height of a box
SLIM = 0.6  # Least slimness at which labels of z have wider distances
PADS = ((3.5, 8.0), (LABEL, 21.0))  # Distances of ticks and label, and what matplotlib adds to them, points
CORNER, MEETING = 0.06, ((0, 1), (1, 1), (1, 0))  # Room without ticks where axes meet, and at which ends of x, y, z
NOWHERE = np.empty((0, 3))
TINTS = ("#F4A582", "#92C5DE", "#A6D96A", "#E6C35C", "#C2A5CF")  # Of regions, in turn


class WingPicture:
    """Axes in true proportions for wings, large enough for the shapes `points`, `[frames, n, 3]`, and for the paths of
    their tips and the rods, `others`, `[m, 3]`, m. What is drawn may be wider than their square."""

    def __init__(self, scene: Scene, mesh: WingMesh, points: np.ndarray, others: np.ndarray, width: float):
        everything = np.concatenate([points.reshape(-1, 3), others])
        low, high = everything.min(axis=0), everything.max(axis=0)
        half = np.maximum(high - low, FLAT * (high - low).max()) / 2
        named, self.scale = lengths_in(scene, float(np.abs(everything).max()))
        self.mesh = mesh
        is_tall = bool(half[2] > half.max() / 2)
        self.figure = Figure(figsize=(width, (0.95 if is_tall else 0.62) * width))
        bottom = 0.05 if is_tall else 0.0
        place: Any = self.figure.add_axes((0.02, bottom, 0.96, 0.92 - bottom), projection="3d", computed_zorder=False)
        self.axes = place
        for i, axis in enumerate("xyz"):
            ends = self.scale * ((low + high) / 2 + np.array([[-1], [1]]) * half)[:, i]
            getattr(self.axes, f"set_{axis}lim")(*ends)
            getattr(self.axes, f"set_{axis}label")(axis_label(axis, named), fontsize="small", labelpad=LABEL)
            low_end, high_end = ends
            located = layout.ticks(3 if half[i] < half.max() / 2 else 5).tick_values(low_end, high_end)
            room = CORNER * half.max() / half[i] * (high_end - low_end) * np.array(MEETING[i])
            kept = [tick for tick in located if low_end + room[0] <= tick <= high_end - room[1]]
            getattr(self.axes, f"set_{axis}ticks")(kept)
        self.axes.tick_params(labelsize="small")
        self.axes.set_proj_type("ortho")
        self.axes.set_box_aspect(half, zoom=TALL * np.linalg.norm(half) / (UP @ half) if is_tall else 1.25)
        slim = max(1.0, SLIM * half.max() / np.hypot(*half[:2]))  # Labels of z go outwards by parts of x and y
        pad, self.axes.zaxis.labelpad = (slim * (own + more) - more for own, more in PADS)
        self.axes.tick_params(axis="z", pad=pad)
        self.axes.view_init(elev=ABOVE, azim=ASIDE)
        self.skin = Poly3DCollection([], linewidths=MESH, edgecolors="0.35", zorder=1, clip_on=False)
        self.axes.add_collection3d(self.skin, autolim=False)
        self.veins = [self._line(VEIN, plots.BLUE) for _ in mesh.veins]
        self.roots = [self._line(ROOT, "0.15") for _ in mesh.roots]
        self.rods = [self._line(ROD, plots.ORANGE) for _ in beams(scene)]
        self.figure.suptitle(title(scene, width - 2.0), fontsize="small", x=0.02, ha="left")
        self.caption = self.figure.text(0.98, 0.98, "", fontsize="small", ha="right", va="top")
        self.clock = displayed_unit("s", scene.display)[0]

    def _line(self, width: float, colour: str) -> Line3D:
        line: Line3D = self.axes.plot([], [], [], color=colour, linewidth=width, zorder=2, clip_on=False)[0]
        return line

    def show(self, points: np.ndarray, rods: Sequence[np.ndarray] = ()) -> None:
        """Show a shape, `[n, 3]`, and the centre lines of the rods, each `[stations, 3]`, m."""
        placed = self.scale * points
        corners = placed[self.mesh.triangles]
        self.skin.set_verts(corners)
        self.skin.set_facecolor(tinted(shades(corners), self.mesh.materials))
        chains = zip([*self.veins, *self.roots], [*self.mesh.veins, *self.mesh.roots], strict=True)
        for line, nodes in chains:
            line.set_data_3d(*placed[nodes].T)
        for line, stations in zip(self.rods, rods, strict=False):
            line.set_data_3d(*(self.scale * stations).T)

    def add(self, points: np.ndarray, rods: Sequence[np.ndarray] = ()) -> None:
        """Add a shape and the rods in a light tone behind those that are shown."""
        corners = self.scale * points[self.mesh.triangles]
        look: dict[str, Any] = {"alpha": 0.25, "linewidths": 0.0, "zorder": 0, "clip_on": False}
        skin = Poly3DCollection(corners, facecolors=shades(corners), **look)
        self.axes.add_collection3d(skin, autolim=False)
        for stations in rods:
            self._draw(stations, plots.ORANGE, alpha=0.25)

    def draw_path(self, path: np.ndarray) -> None:
        """Draw the path of the tip, `[times, 3]`, m."""
        self._draw(path, "0.6")

    def _draw(self, line: np.ndarray, colour: str, alpha: float = 1.0) -> None:
        look: dict[str, Any] = {"color": colour, "alpha": alpha, "linewidth": 0.8, "zorder": 0, "clip_on": False}
        self.axes.plot(*(self.scale * line.T), scalex=False, scaley=False, **look)


def shades(corners: np.ndarray) -> np.ndarray:
    """Return the colours of triangles, `[n, 3, 3]`, in the light: greys, `[n, 4]`."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    turned = np.abs(normals @ LIGHT) / np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
    grey = DARK + (BRIGHT - DARK) * turned
    return np.column_stack([grey, grey, grey, np.ones_like(grey)])


def tinted(colours: np.ndarray, materials: np.ndarray) -> np.ndarray:
    """Return colours of triangles, `[n, 4]`, with those of each region in a tint of its own; `materials` is `[n]`."""
    tinted = colours.copy()
    for region in np.unique(materials[materials > 0]):
        tinted[materials == region, :3] *= to_rgb(TINTS[(region - 1) % len(TINTS)])
    return tinted


def save_mesh(scene: Scene, mesh: WingMesh, folder: Path) -> Path:
    """Write mesh.png, the mesh of wings at rest with roots, veins and regions, into `folder`; return its path."""
    picture = WingPicture(scene, mesh, mesh.nodes[None], NOWHERE, plots.WIDTH)
    picture.show(mesh.nodes)
    parts = [f"{len(mesh.nodes)} nodes", f"{len(mesh.triangles)} triangles", f"{len(mesh.veins)} veins"]
    if scene.wing and (regions := scene.wing.regions):
        parts.append(f"{len(regions)} region{'s' if len(regions) > 1 else ''}")
        squares = [Patch(color=TINTS[i % len(TINTS)], label=region.name) for i, region in enumerate(regions)]
        picture.figure.legend(handles=squares, loc="lower left", fontsize="small", frameon=False)
    picture.caption.set_text(", ".join(parts))
    folder.mkdir(parents=True, exist_ok=True)
    return plots.save(picture.figure, folder / "mesh.png")


def draw(session: Session, mesh: WingMesh) -> Figure:
    """Draw the wings and rods of a session as they are now."""
    points, rods = wing_nodes(session), [station_positions(session.units, own) for own in beams(session.scene)]
    picture = WingPicture(session.scene, mesh, points[None], np.concatenate([NOWHERE, *rods]), plots.WIDTH)
    picture.show(points, rods)
    picture.caption.set_text(f"t = {session.time:.3f} {picture.clock}")
    return picture.figure
