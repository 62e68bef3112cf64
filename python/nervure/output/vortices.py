"""Vortices in space around the bodies, by pyvista without a window: surfaces of equal Q, coloured by the speed.

Q = −½ ∂u_i/∂x_j ∂u_j/∂x_i is above 0 where rotation outweighs strain (Hunt, Wray & Moin 1988).
"""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from nervure.extras import require
from nervure.output import displayed_unit, lengths_in, title
from nervure.scene.solids import half_lengths, longest, placed, surface
from nervure.scene.types import (
    Body,
    Scene,
    ShapeCircularCylinder,
    ShapeCuboid,
)

SIZE = (1000, 640)  # Points
LEVEL, PERCENTILE = 0.15, 99.9  # Q of the surfaces, by this percentile of Q
LAYER = 3.0  # Thickness of the layer at solids and walls that sets no scale, cells
VIEW = (0.45, 0.4, 1.0)  # Direction from the middle of the box to the eye; y is up
CLOSER = 1.1
VEIL = 0.35  # Opacity of vortices, which wrap a wing
COLOURS = "viridis"
FONT = 16


def strength(velocity: np.ndarray, spacing: Sequence[float]) -> np.ndarray:
    """Return Q (1/s²) of a velocity `[nx, ny, nz, 3]` in a periodic box, by central differences."""
    slopes = np.empty((3, *velocity.shape), velocity.dtype)
    for axis, step in enumerate(spacing):
        slopes[axis] = (np.roll(velocity, -1, axis) - np.roll(velocity, 1, axis)) / (2 * step)
    found: np.ndarray = -0.5 * np.einsum("i...j,j...i->...", slopes, slopes)
    return found


class Space:
    """Box and bodies of a scene in space, for pictures of its vortices."""

    def __init__(self, scene: Scene, velocities: Iterable[tuple[np.ndarray, Sequence[Sequence[float]]]]):
        """Choose the surfaces by a few frames: velocities (m/s) with the poses of the bodies."""
        assert scene.fluid and scene.fluid.box.z, "the scene has a fluid in space"
        self.scene, self.fluid = scene, scene.fluid
        self.ends = [scene.fluid.box.x, scene.fluid.box.y, scene.fluid.box.z]
        self.bounds, cells = [end for ends in self.ends for end in ends], scene.fluid.box.cells
        self.spacing = [(high - low) / n for (low, high), n in zip(self.ends, cells, strict=True)]
        self.axes = [
            low + step * np.arange(n) for (low, _), step, n in zip(self.ends, self.spacing, cells, strict=True)
        ]
        strengths, speeds = [], []
        for velocity, poses in velocities:
            free = self.free(poses, LAYER * max(self.spacing))
            strengths.append(LEVEL * np.percentile(strength(velocity, self.spacing)[free], PERCENTILE))
            speeds.append(np.linalg.norm(velocity[free], axis=-1).max())
        self.strength, self.speed = float(np.max(strengths)), float(np.max(speeds))

    def free(self, poses: Sequence[Sequence[float]], layer: float) -> np.ndarray:
        """Return which grid points are farther than `layer` (m) from walls and bodies."""
        walls = [getattr(self.fluid.channel, axis, None) or (-np.inf, np.inf) for axis in "xyz"]
        inside = [
            (places >= low + layer) & (places <= high - layer)
            for places, (low, high) in zip(self.axes, walls, strict=True)
        ]
        free: np.ndarray = inside[0][:, None, None] & inside[1][:, None] & inside[2]
        points = np.stack(np.meshgrid(*self.axes, indexing="ij"), axis=-1)
        for body, pose in zip(self.fluid.bodies, poses, strict=True):
            if surface(body) is not None:
                continue
            turn, origin = placed(body, pose)
            half, level = half_lengths(body, longest(self.fluid))
            free &= level((points - origin) @ turn / (half + layer)) > 1
        return free

    def picture(
        self,
        velocity: np.ndarray,
        poses: Sequence[Sequence[float]],
        rods: Sequence[tuple[np.ndarray, float]],
        wing: tuple[np.ndarray, np.ndarray] | None,
        time: float,
    ) -> np.ndarray:
        """Return a picture, `[height, width, 3]` of bytes, of a velocity (m/s), bodies, rods by their centre line
        `[n, 3]` and radius (m), and a wing by its nodes `[n, 3]` (m) and triangles `[m, 3]`."""
        pyvista = require("pyvista", "a picture of vortices")
        pyvista.vtk_verbosity("off")  # without a display VTK says so, and draws in memory
        unit, scale = lengths_in(self.scene, max(map(abs, self.bounds)))
        grid = pyvista.ImageData(
            dimensions=velocity.shape[:3], spacing=self.spacing, origin=[low for low, _ in self.ends]
        )
        values = strength(velocity, self.spacing)
        values[~self.free(poses, 0.0)] = 0.0
        grid["Q"] = values.ravel(order="F")
        grid["speed"] = np.linalg.norm(velocity, axis=-1).ravel(order="F")
        plotter = pyvista.Plotter(off_screen=True, window_size=SIZE)
        plotter.set_background("white")
        surfaces = grid.contour([self.strength], scalars="Q")
        metres_a_second, speed_scale = displayed_unit("m/s", self.scene.display)
        bar: dict[str, Any] = {
            "title": f"speed [{metres_a_second}]\n", "vertical": True, "position_x": 0.89, "position_y": 0.2,
            "height": 0.6, "width": 0.05, "title_font_size": FONT, "label_font_size": FONT, "color": "black",
            "fmt": "%.2g",
        }  # fmt: skip
        if surfaces.n_points:
            surfaces["speed"] *= speed_scale
            plotter.add_mesh(
                surfaces, scalars="speed", cmap=COLOURS, clim=(0.0, speed_scale * self.speed), scalar_bar_args=bar,
                smooth_shading=True, specular=0.2, opacity=1.0 if wing is None else VEIL,
            )  # fmt: skip
        for body, pose in zip(self.fluid.bodies, poses, strict=True):
            plotter.add_mesh(self._solid(pyvista, body, pose), color="lightgray", smooth_shading=not _has_edges(body))
        for line, radius in rods:
            plotter.add_mesh(pyvista.lines_from_points(line).tube(radius=radius), color="dimgray")
        if wing is not None:
            plotter.add_mesh(pyvista.PolyData.from_regular_faces(*wing), color="dimgray", ambient=0.3)
        plotter.add_mesh(pyvista.Box(self.bounds).extract_all_edges(), color="gray")
        clock = displayed_unit("s", self.scene.display)[0]
        plotter.add_text(title(self.scene, 7.0), position=(0.02, 0.95), viewport=True, font_size=8, color="black")
        size = " x ".join(f"{scale * (high - low):g}" for low, high in self.ends)
        words = f"t = {time:.3f} {clock}, Q = {self.strength:.2g} {displayed_unit('1/s', self.scene.display)[0]}²"
        plotter.add_text(
            f"{words}, box {size} {unit}", position=(0.02, 0.02), viewport=True, font_size=8, color="black"
        )
        plotter.add_axes(color="black", line_width=2)
        plotter.enable_parallel_projection()
        plotter.view_vector(VIEW, viewup=(0, 1, 0))
        plotter.camera.zoom(CLOSER)
        shown: np.ndarray = plotter.screenshot(return_img=True)
        plotter.close()
        return shown

    def _solid(self, pyvista: Any, body: Body, pose: Sequence[float]) -> Any:
        """Return the surface of a body."""
        turn, origin = placed(body, pose)
        if (sheet := surface(body)) is not None:
            return pyvista.PolyData.from_regular_faces(sheet[0] @ turn.T + origin, sheet[1])
        half, _ = half_lengths(body, longest(self.fluid))
        match body.shape:
            case ShapeCuboid():
                unit = pyvista.Cube(x_length=2, y_length=2, z_length=2)
            case ShapeCircularCylinder(circular_cylinder=cylinder):
                direction = [float(axis == cylinder.axis) for axis in "xyz"]
                unit = pyvista.Cylinder(direction=direction, radius=1, height=2, resolution=90)
            case _:
                unit = pyvista.Sphere(radius=1, theta_resolution=90, phi_resolution=60)
        unit.points = (unit.points * half) @ turn.T + origin
        return unit.clip_box(self.bounds, invert=False)  # a cylinder may be longer than the box


def _has_edges(body: Body) -> bool:
    return isinstance(body.shape, ShapeCuboid | ShapeCircularCylinder) or surface(body) is not None
