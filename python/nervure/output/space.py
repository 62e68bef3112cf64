"""Outlines of rigid bodies in space in a plane across z."""

from collections.abc import Sequence

import numpy as np
from contourpy import contour_generator

from nervure.scene.solids import half_lengths, longest, placed, surface
from nervure.scene.types import Body, Fluid

FINE = 400  # Points of the grid on which an outline is found, along each axis


def cut(points: np.ndarray, triangles: np.ndarray, z: float) -> list[np.ndarray]:
    """Return the lines in which a plane across z cuts triangles between points `[n, 3]`, m, each `[2, 2]`."""
    height = points[:, 2] - z
    above = height[triangles] > 0
    lines = []
    for corners in triangles[above.any(axis=1) & ~above.all(axis=1)]:
        sides = [
            (a, b) for a, b in zip(corners, np.roll(corners, -1), strict=True) if (height[a] > 0) != (height[b] > 0)
        ]
        shares = [height[a] / (height[a] - height[b]) for a, b in sides]
        ends = [points[a] + share * (points[b] - points[a]) for (a, b), share in zip(sides, shares, strict=True)]
        lines.append(np.array(ends)[:, :2])
    return lines


def section(body: Body, pose: Sequence[float], fluid: Fluid) -> list[np.ndarray]:
    """Return the outline of a body in the plane of `slice_z`, m, `[n, 2]`; none where the plane misses it."""
    turn, origin = placed(body, pose)
    if (sheet := surface(body)) is not None:
        return cut(sheet[0] @ turn.T + origin, sheet[1], slice_z(fluid))
    half, level = half_lengths(body, longest(fluid))
    reach = np.abs(turn) @ half
    x, y = (np.linspace(origin[a] - 1.02 * reach[a], origin[a] + 1.02 * reach[a], FINE) for a in (0, 1))
    points = np.stack(np.broadcast_arrays(x, y[:, None], slice_z(fluid)), axis=-1) - origin
    contours = contour_generator(x, y, level(points @ turn / half))
    lines: list[np.ndarray] = contours.lines(1.0)  # type: ignore[assignment]
    return [line for line in lines if len(line) > 3]


def slice_z(fluid: Fluid) -> float:
    """Return the place of the plane of grid points in the middle of the box along z, m."""
    assert fluid.box.z, "the box has three dimensions"
    (low, high), n = fluid.box.z, fluid.box.cells[-1]
    return low + (high - low) / n * (n // 2)
