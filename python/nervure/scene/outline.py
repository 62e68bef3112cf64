"""Outlines of rigid bodies in the plane."""

import numpy as np

from nervure.scene.types import (
    Body,
    ShapeCircle,
    ShapeEllipse,
    ShapePlate,
    ShapePolygon,
    ShapePolyline,
    ShapeRectangle,
)

POSE = ("x", "y", "angle")  # Outputs of the fluid for a rigid body
ROUND = 64  # Corners of a round outline, as in crates/geometry


def circle(radius: float) -> np.ndarray:
    """Return corners of a circle about the origin, `[n, 2]`."""
    turn = np.linspace(0, 2 * np.pi, ROUND, endpoint=False)
    return radius * np.column_stack([np.cos(turn), np.sin(turn)])


def body_outline(body: Body, x: float, y: float, angle: float) -> np.ndarray:
    """Return the outline of a rigid body, m, `[n, 2]`, with its pivot at (x, y), turned by an angle (rad)."""
    match body.shape:
        case ShapePolygon(polygon=polygon):
            own = np.array(polygon.corners)
        case ShapePlate(plate=plate):
            own = np.array([[-plate.length / 2, 0.0], [plate.length / 2, 0.0]])
        case ShapePolyline(polyline=polyline):  # there and back
            own = np.array([*polyline.points, *polyline.points[-2:0:-1]])
        case ShapeCircle(circle=round):
            own = circle(round.radius)
        case ShapeEllipse(ellipse=ellipse):
            own = circle(1.0) * [ellipse.length / 2, ellipse.thickness / 2]
        case ShapeRectangle(rectangle=rectangle) if rectangle.ends == "square":
            own = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * [rectangle.length / 2, rectangle.thickness / 2]
        case ShapeRectangle(rectangle=rectangle):
            corners = circle(1.0)
            straight = (rectangle.length - rectangle.thickness) / 2 * np.sign(corners[:, :1])
            own = corners * rectangle.thickness / 2 + np.pad(straight, ((0, 0), (0, 1)))
    sin, cos = np.sin(angle), np.cos(angle)
    placed: np.ndarray = (own - body.pivot[:2]) @ np.array([[cos, sin], [-sin, cos]]) + [x, y]
    return placed
