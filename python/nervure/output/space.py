"""Planes across an axis of space, and the outlines of solids in them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from contourpy import contour_generator

from nervure.errors import InputError
from nervure.output.fields import outline
from nervure.scene import Scene
from nervure.scene.facts import Facts
from nervure.scene.outline import circle
from nervure.scene.solids import box_ends, half_lengths, longest, placed, surface
from nervure.scene.types import Body, Fluid, TimeLawConstant

FINE = 400  # Points of the grid on which an outline is found, along each axis
AXES = ((1, 2), (0, 2), (0, 1))  # Axes along and up a picture across x, y and z
STILL = TimeLawConstant(constant=0.0)


@dataclass(frozen=True)
class Plane:
    """A plane across the axis `normal` (0, 1, 2 for x, y, z) at `place`, m."""

    normal: int
    place: float

    @property
    def axes(self) -> tuple[int, int]:
        """The axes along and up the picture."""
        return AXES[self.normal]

    def height(self, points: np.ndarray) -> np.ndarray:
        """Return how far `points`, `[n, 3]`, lie above the plane, m."""
        above: np.ndarray = points[:, self.normal] - self.place
        return above

    def cut(self, points: np.ndarray, triangles: np.ndarray) -> list[np.ndarray]:
        """Return the outlines, m, each `[n, 2]`, in which the plane cuts triangles between points `[n, 3]`; an open
        line goes there and back."""
        points, same = np.unique(points, axis=0, return_inverse=True)
        triangles = same.reshape(-1)[triangles]
        height = self.height(points)
        above = height > 0
        beside: dict[tuple[int, int], list[tuple[int, int]]] = {}  # Neighbours of each side that is cut
        for a, b, c in triangles[above[triangles].any(axis=1) & ~above[triangles].all(axis=1)].tolist():
            one, other = [
                (min(side), max(side)) for side in ((a, b), (b, c), (c, a)) if above[side[0]] != above[side[1]]
            ]
            beside.setdefault(one, []).append(other)
            beside.setdefault(other, []).append(one)
        lines = []
        while beside:
            sides = [next((side for side, near in beside.items() if len(near) == 1), next(iter(beside)))]
            while near := beside[sides[-1]]:
                sides.append(near.pop())
                beside[sides[-1]].remove(sides[-2])
            beside = {side: near for side, near in beside.items() if near}
            a, b = np.transpose(sides)
            share = (height[a] / (height[a] - height[b]))[:, None]
            line = (points[a] + share * (points[b] - points[a]))[:, self.axes]
            lines.append(line if sides[0] == sides[-1] else there_and_back(line))
        return lines

    def body(self, body: Body, pose: Sequence[float], fluid: Fluid) -> list[np.ndarray]:
        """Return the outlines of a body, m, each `[n, 2]`; none where the plane misses it."""
        turn, origin = placed(body, pose)
        if (sheet := surface(body)) is not None:
            return self.cut(sheet[0] @ turn.T + origin, sheet[1])
        half, level = half_lengths(body, longest(fluid))
        reach = 1.02 * np.abs(turn) @ half
        x, y = (np.linspace(origin[axis] - reach[axis], origin[axis] + reach[axis], FINE) for axis in self.axes)
        points = np.full((FINE, FINE, 3), self.place)
        points[..., self.axes[0]], points[..., self.axes[1]] = x, y[:, None]
        lines = contour_generator(x, y, level((points - origin) @ turn / half)).lines(1.0)
        return [line for line in lines if len(line) > 3]  # type: ignore[misc]

    def rod(self, line: np.ndarray, radius: float) -> list[np.ndarray]:
        """Return the outlines of a rod by its centre line, `[n, 3]`, and radius, m: a circle where it crosses the
        plane, a stripe where it lies in it."""
        height, flat = self.height(line), line[:, self.axes]
        inside = np.abs(height) < radius
        stripes = [run for run in np.split(np.arange(len(line)), np.flatnonzero(np.diff(inside)) + 1) if inside[run[0]]]
        found = [outline(flat[run], 2 * np.sqrt(radius**2 - height[run] ** 2)) for run in stripes if len(run) > 1]
        for a in np.flatnonzero((height[:-1] > 0) != (height[1:] > 0)):
            if not any(len(run) > 1 and a in run for run in stripes):
                share = height[a] / (height[a] - height[a + 1])
                found.append(flat[a] + share * (flat[a + 1] - flat[a]) + circle(radius))
        return found


def there_and_back(line: np.ndarray) -> np.ndarray:
    """Return an open line as an outline."""
    return np.concatenate([line, line[::-1]])


def choose(scene: Scene, across: str | None, at: float | None) -> tuple[Plane, int]:
    """Return the plane of grid points nearest to `at` (m) across the axis `across`, and its number. By default it lies
    in the stream or the fall, across the axis along which a body or the wing is longest, in the middle of the first of
    them."""
    fluid = scene.fluid
    assert fluid and fluid.box.z, "the box has three dimensions"
    if across not in (None, "x", "y", "z"):
        raise InputError(f"across is {across}, but must be x, y or z")
    ends = np.array(box_ends(fluid))
    solids = [np.clip(points, *ends.T) for points in _at_rest(scene, fluid)]
    longest_of = np.max([np.ptp(points, axis=0) for points in solids], axis=0) if solids else np.zeros(3)
    stream = _stream(fluid)
    sizes = [(axis != stream, round(float(longest_of[axis] / (longest_of.max() or 1.0)), 2), axis) for axis in range(3)]
    normal = max(sizes)[-1] if across is None else "xyz".index(across)
    middle = (ends if not solids or not longest_of.any() else np.array([solids[0].min(0), solids[0].max(0)]).T)[normal]
    (low, high), n = ends[normal], fluid.box.cells[normal]
    if at is not None and not low <= at <= high:
        raise InputError(f"at is {at:g} m, but the box is from {low:g} to {high:g} m along {'xyz'[normal]}")
    number = round(((middle.mean() if at is None else at) - low) / (high - low) * n) % n
    return Plane(normal, float(low + (high - low) / n * number)), number


def cropped(fluid: Fluid, crop: Sequence[float]) -> list[tuple[float, float]]:
    """Return the ends of a part of the box, `x_0, x_1, y_0, …` (m), along each axis."""
    ends = box_ends(fluid)
    parts = list(zip(crop[::2], crop[1::2], strict=False))
    inside = [low <= begin < end <= high for (begin, end), (low, high) in zip(parts, ends, strict=False)]
    if len(crop) != 2 * len(ends) or not all(inside):
        box = ", ".join(f"{low:g}, {high:g}" for low, high in ends)
        raise InputError(
            f"the crop is {', '.join(f'{end:g}' for end in crop)}, but must be ends inside the box {box} m"
        )
    return parts


def _at_rest(scene: Scene, fluid: Fluid) -> Iterator[np.ndarray]:
    """Return points around each body and of the wings at rest, m, `[n, 3]`."""
    for body in fluid.bodies:
        turn, origin = placed(body, [*body.position, 0.0])
        if (sheet := surface(body)) is not None:
            yield sheet[0] @ turn.T + origin
        else:
            reach = np.abs(turn) @ half_lengths(body, longest(fluid))[0]
            yield np.array([origin - reach, origin + reach])
    if mesh := Facts(scene).wing:
        yield mesh.nodes


def _stream(fluid: Fluid) -> int | None:
    """Return the axis along which a stream flows, in still fluid the one along which a body falls."""
    laws = [getattr(fluid.mean_flow, axis, None) or STILL for axis in "xyz"]
    if driven := [axis for axis, law in enumerate(laws) if law != STILL]:
        return driven[0]
    speeds = np.abs(fluid.initial_velocity)
    if fluid.inflow or fluid.sponge:
        return 0
    falling = [np.abs(body.mount.gravity) for body in fluid.bodies if body.mount and any(body.mount.gravity)]
    along = speeds if speeds.any() else falling[0] if falling else None
    return None if along is None else int(np.argmax(along))
