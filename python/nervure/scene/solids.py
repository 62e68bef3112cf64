"""Rigid bodies: the outputs for their places, and in space their lengths and surfaces."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from nervure.scene.outline import POSE, circle
from nervure.scene.types import (
    Body,
    BodyMotion,
    FineBox,
    Fluid,
    MiddleBox,
    ShapeCapsule,
    ShapeCircularCylinder,
    ShapeCuboid,
    ShapeDisk,
    ShapeEllipsoid,
    ShapePlate,
    ShapeSphere,
    ShapeTriangulation,
)

PLACE = ("x", "y", "z")
TURN = ("angle_x", "angle_y", "angle_z")  # Rotation vector of a body that has no axis
Z = (0.0, 0.0, 1.0)


def pose_names(fluid: Fluid, body: Body) -> tuple[str, ...]:
    """Return the outputs of the fluid for the place of a rigid body."""
    if not fluid.box.z:
        return POSE
    motion = body.motion
    has_axis = not motion or (isinstance(motion, BodyMotion) and not motion.rotations)
    return (*PLACE, *(("angle",) if has_axis and not body.mount else TURN))


def rotation(axis: Sequence[float], angle: float) -> np.ndarray:
    """Return the matrix that turns by an angle (rad) about an axis of any length (Rodrigues' formula)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turned: np.ndarray = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return turned


def placed(body: Body, pose: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrix from the axes of a body at `pose` (m and rad, see `pose_names`) to those of the box, and the
    place of their origin, m."""
    motion = body.motion if isinstance(body.motion, BodyMotion) else None
    if len(vector := pose[3:]) == len(TURN):
        turn = rotation(vector, float(np.linalg.norm(vector))) if any(vector) else np.eye(3)
    else:
        turn = rotation((motion and motion.axis) or Z, pose[3])
    if body.turn:
        turn = turn @ rotation(body.turn.axis, body.turn.angle)
    pivot = np.resize(body.pivot, 3) if any(body.pivot) else np.zeros(3)
    return turn, np.array(pose[:3]) - turn @ pivot


def half_lengths(body: Body, longest: float) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Return half the lengths of a body along its own axes, m, and a function of points over these lengths, `[..., 3]`,
    which is below 1 inside. A cylinder through the box has the length `longest` (m)."""

    def round_(points: np.ndarray) -> np.ndarray:
        distance: np.ndarray = np.linalg.norm(points, axis=-1)
        return distance

    match body.shape:
        case ShapeSphere(sphere=sphere):
            return np.full(3, sphere.radius), round_
        case ShapeEllipsoid(ellipsoid=ellipsoid):
            return np.array(ellipsoid.lengths) / 2, round_
        case ShapeCuboid(cuboid=cuboid):
            return np.array(cuboid.lengths) / 2, lambda points: np.abs(points).max(axis=-1)
        case ShapeCircularCylinder(circular_cylinder=cylinder):
            along = "xyz".index(cylinder.axis)
            half = np.full(3, cylinder.radius)
            half[along] = (cylinder.length or longest) / 2
            across = [axis for axis in range(3) if axis != along]
            return half, lambda points: np.maximum(np.abs(points[..., along]), round_(points[..., across]))
        case ShapeCapsule(capsule=capsule):
            along = "xyz".index(capsule.axis)
            half = np.full(3, capsule.radius)
            half[along] = capsule.length / 2
            core = capsule.length / 2 - capsule.radius

            def from_core(points: np.ndarray) -> np.ndarray:
                arm = points * half
                arm[..., along] -= np.clip(arm[..., along], -core, core)
                return round_(arm) / capsule.radius

            return half, from_core
    raise AssertionError("a body in space has one of these shapes")


def surface(body: Body) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the nodes of a surface of no thickness in its own axes, m, `[n, 3]`, and its triangles, `[m, 3]`; None for
    a solid."""
    match body.shape:
        case ShapePlate(plate=plate):
            x, z = plate.length / 2, (plate.width or 0.0) / 2
            return np.array([(-x, 0, -z), (x, 0, -z), (x, 0, z), (-x, 0, z)]), np.array([(0, 1, 2), (0, 2, 3)])
        case ShapeDisk(disk=disk):
            rim = np.insert(circle(disk.radius), 1, 0.0, axis=1)
            first = np.arange(1, len(rim) + 1)
            return np.vstack([np.zeros(3), rim]), np.stack([0 * first, first, first % len(rim) + 1], axis=-1)
        case ShapeTriangulation(triangulation=own):
            return np.array(own.nodes), np.array(own.triangles)
    return None


def longest(fluid: Fluid) -> float:
    """Return the diagonal of the box, m."""
    assert fluid.box.z, "the box has three dimensions"
    return float(np.linalg.norm(np.diff(box_ends(fluid))))


def box_ends(fluid: Fluid) -> list[tuple[float, float]]:
    """Return the ends of the box along each of its axes, m."""
    return [end for end in (fluid.box.x, fluid.box.y, fluid.box.z) if end]


def counts_of(fine: FineBox | MiddleBox, fluid: Fluid) -> list[int]:
    """Return the numbers of cells of a box in the large one; its ends are at the nearest points of the large grid."""
    ends = [end for end in (fine.x, fine.y, fine.z) if end]
    axes = zip(ends, box_ends(fluid), cell_lengths(fluid), strict=True)
    # Halves go up, as in the units: `round` takes them to even numbers.
    return [
        fine.ratio * (math.floor((own[1] - low) / cell + 0.5) - math.floor((own[0] - low) / cell + 0.5))
        for own, (low, _), cell in axes
    ]


def cell_lengths(fluid: Fluid) -> tuple[float, ...]:
    """Return the lengths of a cell along each axis, m."""
    return tuple((high - low) / n for (low, high), n in zip(box_ends(fluid), fluid.box.cells, strict=True))
