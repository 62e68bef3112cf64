"""Vortices in space around the bodies, by pyvista without a window: surfaces of equal Q, coloured by the speed.

Q = −½ ∂u_i/∂x_j ∂u_j/∂x_i is above 0 where rotation outweighs strain (Hunt, Wray & Moin 1988).
"""

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import floor, log10
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb

from nervure import arguments
from nervure.errors import InputError
from nervure.extras import require
from nervure.output import displayed_unit, lengths_in, title
from nervure.output.space import cropped
from nervure.scene.solids import box_ends, cell_lengths, half_lengths, longest, placed, surface
from nervure.scene.types import (
    Body,
    Scene,
    ShapeCapsule,
    ShapeCircularCylinder,
    ShapeCuboid,
)

SIZE = (1000, 640)  # Points
LEVEL, PERCENTILE = 0.15, 99.9  # Q of the surfaces, by this percentile of Q
LAYER = 3.0  # Thickness of the layer at solids and walls that sets no scale, cells
MASKED = 1.5  # Thickness of the layer at solids in which the mask makes the flow, and no surface is drawn, cells
CAMERA = (0.45, 0.4, 1.0)  # Direction from the middle of the part that is shown to the eye; y is up
AGAINST_Z = (0.45, -1.0, 0.4)  # The same where a flyer falls along -z; z is up
PLACE, EDGE = (0.82, 0.84), 0.02  # Room for the part, of width and height, and free on the left
VEIL = 0.6  # Opacity of vortices, which wrap the bodies
ROOM, REACH = 0.2, 2.5  # Least and largest room around the solids in the picture, by the size of the largest
ENDS = (1.0, 1.2, 1.6, 2.0, 2.4, 3.2, 4.0, 6.0, 8.0, 10.0)  # Of the scale of speed, whose quarters have few digits
FAST = 98.0  # Part of the vortices inside the scale of speed, in percent
COLOURS = "viridis"
FONT = 14

Poses = Sequence[Sequence[float]]
Rods = Sequence[tuple[np.ndarray, float]]  # Centre lines, `[n, 3]`, and radii, m
Wing = tuple[np.ndarray, np.ndarray]  # Nodes, `[n, 3]`, m, and triangles, `[m, 3]`


@dataclass(frozen=True)
class Look:
    """What a picture of vortices shows; what is None is chosen by the flow."""

    q: float | None = None  # Q of the surfaces, 1/s²
    camera: Sequence[float] | None = None  # Direction from the middle to the eye
    background: str = "white"

    def checked(self) -> "Look":
        """Return the look with numbers of Python; raise `InputError` where a picture cannot be made."""
        q = arguments.if_given("q", self.q, least=arguments.ABOVE)
        camera = None if self.camera is None else arguments.numbers("camera", self.camera)
        if camera is not None and not (len(camera) == 3 and 0 < np.linalg.norm(camera) < np.inf):
            given = ", ".join(f"{part:g}" for part in camera)
            raise InputError(f"the camera is {given}, but must be a direction of three numbers")
        try:
            to_rgb(arguments.text("background", self.background))
        except ValueError as error:
            given = arguments.shown(self.background)
            raise InputError(f"the background is {given}, but must be a colour as white or #f4f4f4") from error
        return Look(q, camera, self.background)


@dataclass(frozen=True)
class Flow:
    """A fluid in space and all that is in it at `time`, s."""

    velocity: np.ndarray  # `[nx, ny, nz, 3]`, m/s
    poses: Poses
    rods: Rods
    wing: Wing | None
    time: float


def strength(velocity: np.ndarray, spacing: Sequence[float]) -> np.ndarray:
    """Return Q (1/s²) of a velocity `[nx, ny, nz, 3]` in a periodic box, by central differences."""
    slopes = np.empty((3, *velocity.shape), velocity.dtype)
    for axis, step in enumerate(spacing):
        slopes[axis] = (np.roll(velocity, -1, axis) - np.roll(velocity, 1, axis)) / (2 * step)
    found: np.ndarray = -0.5 * np.einsum("i...j,j...i->...", slopes, slopes)
    return found


class Space:
    """Box and bodies of a scene in space, for pictures of its vortices; a few flows choose level and scale, and without
    a `crop` (m) the part that is shown."""

    def __init__(self, scene: Scene, look: Look, crop: Sequence[float] | None, flows: Iterable[Flow]):
        assert scene.fluid and scene.fluid.box.z, "the scene has a fluid in space"
        self.pyvista = require("pyvista", "a picture of vortices")
        self.pyvista.vtk_verbosity("off")  # without a display VTK says so, and draws in memory
        self.scene, self.fluid, self.look = scene, scene.fluid, look
        self.ends, self.spacing, cells = box_ends(self.fluid), cell_lengths(self.fluid), scene.fluid.box.cells
        self.axes = [
            low + step * np.arange(n) for (low, _), step, n in zip(self.ends, self.spacing, cells, strict=True)
        ]
        flows = list(flows)
        strengths = [strength(flow.velocity, self.spacing) for flow in flows]
        free = [self.free(flow.poses, LAYER * max(self.spacing)) for flow in flows]
        levels = [LEVEL * np.percentile(q[away], PERCENTILE) for q, away in zip(strengths, free, strict=True)]
        self.strength = float(np.max(levels)) if look.q is None else look.q
        seen = [(q > self.strength) & away for q, away in zip(strengths, free, strict=True)]
        speeds = [np.linalg.norm(flow.velocity[part], axis=-1) for flow, part in zip(flows, seen, strict=True)]
        known = np.concatenate(speeds)
        self.speed = round_up(float(np.percentile(known, FAST)) if known.size else 0.0)
        part = cropped(self.fluid, crop) if crop else self._around(flows, seen)
        walls = [getattr(self.fluid.channel, axis, None) or (-np.inf, np.inf) for axis in "xyz"]
        self.part = [(max(a, low), min(b, high)) for (a, b), (low, high) in zip(part, walls, strict=True)]

    def _around(self, flows: Sequence[Flow], seen: Sequence[np.ndarray]) -> list[tuple[float, float]]:
        """Return the ends of the part of the box that holds the solids of `flows`, and the vortices near them."""
        solids = [points for flow in flows for points in self._points(flow)]
        if not solids:
            return self.ends
        points = np.concatenate(solids)
        low, high = points.min(axis=0), points.max(axis=0)
        size = max(float(np.ptp(one, axis=0).max()) for one in solids)
        part = []
        for axis, places in enumerate(self.axes):
            across = tuple(other for other in range(3) if other != axis)
            of = places[np.any([one.any(axis=across) for one in seen], axis=0)]
            begin = np.clip(of.min(initial=np.inf), low[axis] - REACH * size, low[axis]) - ROOM * size
            end = np.clip(of.max(initial=-np.inf), high[axis], high[axis] + REACH * size) + ROOM * size
            part.append((max(float(begin), self.ends[axis][0]), min(float(end), self.ends[axis][1])))
        return part

    def _points(self, flow: Flow) -> list[np.ndarray]:
        """Return points of the solids, each `[n, 3]`, m."""
        bodies = [self._solid(body, pose).points for body, pose in zip(self.fluid.bodies, flow.poses, strict=True)]
        return [*bodies, *(line for line, _ in flow.rods), *([flow.wing[0]] if flow.wing else [])]

    def free(self, poses: Poses, layer: float) -> np.ndarray:
        """Return which grid points are farther than `layer` (m) from walls and bodies."""
        walls = [getattr(self.fluid.channel, axis, None) or (-np.inf, np.inf) for axis in "xyz"]
        inside = [
            (places >= low + layer) & (places <= high - layer)
            for places, (low, high) in zip(self.axes, walls, strict=True)
        ]
        free: np.ndarray = inside[0][:, None, None] & inside[1][:, None] & inside[2]
        for body, pose in zip(self.fluid.bodies, poses, strict=True):
            shape = self._solid(body, pose)
            low, high = shape.points.min(axis=0) - layer, shape.points.max(axis=0) + layer
            near = np.ix_(*((at > a) & (at < b) for at, a, b in zip(self.axes, low, high, strict=True)))
            points = np.stack(np.broadcast_arrays(*(self.axes[axis][near[axis]] for axis in range(3))), axis=-1)
            if not points.size:
                continue
            if surface(body) is None:
                turn, origin = placed(body, pose)
                half, level = half_lengths(body, longest(self.fluid))
                away = level((points - origin) @ turn / (half + layer)) > 1
            else:
                away = self._distance(points.reshape(-1, 3), shape).reshape(points.shape[:-1]) > layer
            free[near] &= away
        return free

    def _distance(self, points: np.ndarray, sheet: Any) -> np.ndarray:
        """Return the distance of points, `[n, 3]`, from a surface, m: below 0 inside a closed one."""
        sheet = sheet.clean()
        is_open = bool(sheet.n_open_edges)
        out = sheet if is_open else sheet.compute_normals(auto_orient_normals=True)
        found = np.array(self.pyvista.PolyData(points).compute_implicit_distance(out)["implicit_distance"])
        return np.abs(found) if is_open else found

    def picture(self, flow: Flow) -> np.ndarray:
        """Return a picture, `[height, width, 3]` of bytes."""
        pyvista, look = self.pyvista, self.look
        bounds = [end for ends in self.part for end in ends]
        unit, scale = lengths_in(self.scene, max(map(abs, bounds)))
        grid = pyvista.ImageData(
            dimensions=flow.velocity.shape[:3], spacing=self.spacing, origin=[low for low, _ in self.ends]
        )
        grid["Q"] = strength(flow.velocity, self.spacing).ravel(order="F")
        grid["speed"] = np.linalg.norm(flow.velocity, axis=-1).ravel(order="F")
        ink = "black" if np.dot(to_rgb(look.background), (0.3, 0.6, 0.1)) > 0.5 else "white"
        plotter = pyvista.Plotter(off_screen=True, window_size=SIZE)
        plotter.set_background(look.background)
        solids = [self._solid(body, pose) for body, pose in zip(self.fluid.bodies, flow.poses, strict=True)]
        wing = pyvista.PolyData.from_regular_faces(*flow.wing) if flow.wing else None
        surfaces = self._clip(grid.contour([self.strength], scalars="Q"))
        surfaces = self._outside(surfaces, [*solids, wing] if wing else solids)
        per_time, speed_scale = displayed_unit("m/s", self.scene.display)
        bar: dict[str, Any] = {
            "title": f"speed [{per_time}]\n", "vertical": True, "position_x": 0.86, "position_y": 0.2, "height": 0.6,
            "width": 0.05, "title_font_size": FONT, "label_font_size": FONT, "color": ink, "fmt": "%.3g", "n_labels": 5,
        }  # fmt: skip
        if surfaces.n_points:
            surfaces["speed"] *= speed_scale
            plotter.add_mesh(
                surfaces, scalars="speed", cmap=COLOURS, clim=(0.0, speed_scale * self.speed), scalar_bar_args=bar,
                smooth_shading=True, specular=0.2, opacity=VEIL,
            )  # fmt: skip
        for body, solid in zip(self.fluid.bodies, solids, strict=True):
            self._add(plotter, solid, color="lightgray", smooth_shading=not _has_edges(body))
        for line, radius in flow.rods:
            self._add(plotter, pyvista.lines_from_points(line).tube(radius=radius), color="dimgray")
        if wing:
            self._add(plotter, wing, color="dimgray", ambient=0.3)
        plotter.add_mesh(pyvista.Box(bounds).extract_all_edges(), color="gray")
        self._mark_sponge(plotter, ink)
        clock = displayed_unit("s", self.scene.display)[0]
        style: dict[str, Any] = {"viewport": True, "font_size": 8, "color": ink}
        plotter.add_text(title(self.scene, 7.0), position=(0.02, 0.95), **style)
        ends = zip("xyz", self.part, strict=True)
        size = ", ".join(f"{axis} {scale * low:.3g} to {scale * high:.3g}" for axis, (low, high) in ends)
        level = f"Q = {self.strength:.2g} {displayed_unit('1/s', self.scene.display)[0]}²"
        plotter.add_text(f"t = {flow.time:.3f} {clock}, {level}, {size} {unit}", position=(0.02, 0.02), **style)
        plotter.add_axes(color=ink, line_width=2)
        plotter.enable_parallel_projection()
        falls = bool(self.scene.flyer and self.scene.flyer.gravity[2] < 0)
        direction = np.array((AGAINST_Z if falls else CAMERA) if look.camera is None else look.camera, float)
        up, behind = ((0, 0, 1), (0, 1, 0)) if falls else ((0, 1, 0), (0, 0, -1))
        if abs(direction @ up) >= 0.95 * np.linalg.norm(direction):
            up = behind
        plotter.view_vector(direction, viewup=up)
        self._fit(plotter.camera)
        plotter.reset_camera_clipping_range()
        shown: np.ndarray = plotter.screenshot(return_img=True)
        plotter.close()
        return shown

    def _fit(self, camera: Any) -> None:
        """Let the part fill the picture between the texts and the bar."""
        toward, up = np.array(camera.direction), np.array(camera.up)
        right = np.cross(toward, up)
        corners = np.stack(np.meshgrid(*self.part), axis=-1).reshape(-1, 3)
        wide, high = (np.ptp(corners @ (side / np.linalg.norm(side))) for side in (right, np.cross(right, toward)))
        camera.parallel_scale = max(high / PLACE[1], wide / PLACE[0] * SIZE[1] / SIZE[0]) / 2
        camera.SetWindowCenter(1 - PLACE[0] - EDGE, 0.0)

    def _clip(self, mesh: Any) -> Any:
        """Return what of a mesh lies in the part that is shown."""
        bounds = [end for ends in self.part for end in ends]
        return as_surface(mesh.clip_box(bounds, invert=False)) if mesh.n_points else mesh

    def _outside(self, surfaces: Any, solids: Sequence[Any]) -> Any:
        """Return what of surfaces lies farther than `MASKED` from solids."""
        for solid in solids:
            if surfaces.n_points:
                surfaces["away"] = self._distance(surfaces.points, solid)
                surfaces = surfaces.clip_scalar(scalars="away", invert=False, value=MASKED * max(self.spacing))
        return surfaces

    def _add(self, plotter: Any, mesh: Any, **look: Any) -> None:
        if (part := self._clip(mesh)).n_points:
            plotter.add_mesh(part, **look)

    def _mark_sponge(self, plotter: Any, ink: str) -> None:
        """Mark where the sponge begins, behind which the flow is not that of the scene."""
        (begin, end), y, z = self.part
        if self.fluid.sponge and begin < (place := self.fluid.sponge.x[0]) < end:
            corners = [(place, y[0], z[0]), (place, y[1], z[0]), (place, y[1], z[1]), (place, y[0], z[1])]
            plotter.add_mesh(self.pyvista.PolyData(corners, faces=[4, 0, 1, 2, 3]), color="gray", opacity=0.15)
            plotter.add_point_labels(
                [(place, y[0], z[1])], ["sponge"], text_color=ink, font_size=FONT, bold=False, shape=None,
                show_points=False,
            )  # fmt: skip

    def _solid(self, body: Body, pose: Sequence[float]) -> Any:
        """Return the surface of a body."""
        pyvista = self.pyvista
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
            case ShapeCapsule(capsule=capsule):
                direction = [float(axis == capsule.axis) for axis in "xyz"]
                unit = pyvista.Capsule(
                    direction=direction, radius=capsule.radius, cylinder_length=capsule.length - 2 * capsule.radius
                )
                unit.points = unit.points / half
            case _:
                unit = pyvista.Sphere(radius=1, theta_resolution=90, phi_resolution=60)
        unit.points = (unit.points * half) @ turn.T + origin
        # A cylinder may be longer than the box
        return as_surface(unit.clip_box([end for ends in self.ends for end in ends], invert=False))


def as_surface(mesh: Any) -> Any:
    """Return the surface of a mesh; pyvista warns of each call from 0.47 on, but has another form only since then."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return mesh.extract_surface()


def round_up(value: float) -> float:
    """Return the least number of `ENDS`, times a power of ten, that is at least `value`; 1 for 0."""
    ten = 10.0 ** floor(log10(value)) if value > 0 else 1.0
    return ten * next(end for end in ENDS if end * ten >= value * (1 - 1e-12))


def _has_edges(body: Body) -> bool:
    return isinstance(body.shape, ShapeCuboid | ShapeCircularCylinder) or surface(body) is not None
