"""Where the parts of a run touch: rods, wings and outlines as sides between points, rigid bodies in space as solids or
as triangles."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nervure.scene.solids import half_lengths, longest, placed, surface
from nervure.scene.types import Body, Fluid

ONWARD = 0.65
"""Least cosine between the sides of a rod and its way from root to tip with which it cannot touch itself: 2/π, for only
over an arc of π/2 thicknesses its ends may come one thickness close."""

ROUNDING = 1e-9
"""Distance of sides that cross, by their length."""

MOST_POINTS = 9
"""Most points of a side at which it is looked for inside a solid."""


@dataclass(frozen=True)
class Sides:
    """The sides of a part at one time."""

    begin: np.ndarray
    end: np.ndarray
    half: np.ndarray
    is_closed: bool

    @cached_property
    def lengths(self) -> np.ndarray:
        """Lengths of the sides, m."""
        found: np.ndarray = np.sqrt(((self.end - self.begin) ** 2).sum(1))
        return found

    @cached_property
    def frame(self) -> np.ndarray:
        """Least and largest place of the surface along each axis, m, `[2, dimension]`."""
        corners, half = np.concatenate([self.begin, self.end]), self.half.max(initial=0.0)
        return np.stack([corners.min(0, initial=np.inf) - half, corners.max(0, initial=-np.inf) + half])

    def is_apart(self, other: "Sides") -> bool:
        """Return whether the frames around two parts are apart."""
        return bool((self.frame[0] > other.frame[1]).any() or (other.frame[0] > self.frame[1]).any())

    @property
    def is_onward(self) -> bool:
        """Whether a rod is too straight to touch itself."""
        way = self.end[-1] - self.begin[0]
        along = (self.end - self.begin) @ way
        return bool((along >= ONWARD * np.sqrt(way @ way) * self.lengths).all())

    def near(self, other: "Sides") -> "Sides":
        """Return the sides that the other part may touch: those that reach into the frame around it."""
        corners, reach = np.concatenate([other.begin, other.end]), self.half[:, None] + other.half.max()
        low, high = np.minimum(self.begin, self.end) - reach, np.maximum(self.begin, self.end) + reach
        close = ((low <= corners.max(0)) & (high >= corners.min(0))).all(1)
        return Sides(self.begin[close], self.end[close], self.half[close], self.is_closed)

    def crossings(self, other: "Sides") -> np.ndarray:
        """Return whether each side crosses each of the other part, `[n, m]`."""
        a, b, c, d = self.begin[:, None], self.end[:, None], other.begin[None], other.end[None]
        apart = _turn(a, b, c) * _turn(a, b, d) < 0.0
        crossed: np.ndarray = apart & (_turn(c, d, a) * _turn(c, d, b) < 0.0)
        return crossed

    def gaps(self, other: "Sides") -> np.ndarray:
        """Return the distance of the surface at the begin of each side from that at each of the other's, `[n, m]`."""
        along, way = other.end - other.begin, self.begin[:, None] - other.begin
        squared = np.maximum((along**2).sum(-1), np.finfo(float).tiny)
        share = np.clip((way * along).sum(-1) / squared, 0.0, 1.0)
        apart = np.linalg.norm(way - share[..., None] * along, axis=-1)
        found: np.ndarray = apart - self.half[:, None] - other.half
        return found

    def contains(self, points: np.ndarray) -> np.ndarray:
        """Return whether each point lies inside the outline of a body."""
        a, b, p = self.begin[None], self.end[None], points[:, None]
        passed = (a[..., 1] > p[..., 1]) != (b[..., 1] > p[..., 1])
        inside: np.ndarray = (passed & ((_turn(a, b, p) > 0.0) == (b[..., 1] > a[..., 1]))).sum(1) % 2 == 1
        return inside

    def touched(self, other: "Sides") -> np.ndarray:
        """Return whether each side of another part touches this one in space."""
        reach = other.half[:, None] + self.half.max()
        low, high = np.minimum(other.begin, other.end) - reach, np.maximum(other.begin, other.end) + reach
        corners = np.concatenate([self.begin, self.end])
        close: np.ndarray = ((low <= corners.max(0)) & (high >= corners.min(0))).all(1)
        a, b = other.begin[close, None], other.end[close, None]
        apart = distances(a, b, self.begin, self.end) - other.half[close, None] - self.half
        close[close] = apart.min(1, initial=np.inf) < 0.0
        return close

    def folded(self) -> np.ndarray:
        """Return whether each side of a rod touches a later one that is no neighbour."""
        length, found = self.lengths, np.zeros(len(self.begin), bool)
        middle, arc = (self.begin + self.end) / 2, np.cumsum(length) - length / 2
        apart = np.linalg.norm(middle[:, None] - middle, axis=-1)
        thick, long = self.half[:, None] + self.half, length[:, None] + length
        way = arc - arc[:, None]
        i, j = np.nonzero((apart < thick + long / 2) & (way > 0.75 * long))  # Neighbours are half of it apart
        gaps = distances(self.begin[i], self.end[i], self.begin[j], self.end[j])
        bent = way[i, j] > np.pi / 2 * thick[i, j] + long[i, j]  # else a narrow bend, whose sides may only cross
        found[i[gaps < np.where(bent, thick[i, j], ROUNDING * long[i, j])]] = True
        return found


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return twice the area of triangles, positive if their corners go round counter-clockwise."""
    turned: np.ndarray = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (
        c[..., 0] - a[..., 0]
    )
    return turned


class Solid:
    """A rigid body in space at one time."""

    def __init__(self, body: Body, pose: Sequence[float], fluid: Fluid):
        self.turn, self.origin = placed(body, pose)
        sheet = surface(body)
        self.corners = None if sheet is None else (sheet[0] @ self.turn.T + self.origin)[sheet[1]]
        self.form = half_lengths(body, longest(fluid)) if sheet is None else None

    def touched(self, sides: Sides) -> np.ndarray:
        """Return whether each side touches the body."""
        if self.corners is not None:
            return _pierced(sides, self.corners)
        assert self.form, "a body without triangles is a solid"
        half, level = self.form
        length = float(np.linalg.norm(sides.end - sides.begin, axis=1).max())
        shares = np.linspace(0.0, 1.0, int(np.clip(np.ceil(length / half.min()) + 1, 2, MOST_POINTS)))[:, None, None]
        points = sides.begin + shares * (sides.end - sides.begin) - self.origin
        inside = level(points @ self.turn / (half + sides.half[:, None])) < 1.0
        found: np.ndarray = np.any(inside, axis=0)
        return found


def distances(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return the distances of the sides from `a` to `b` from those from `c` to `d`, m; the arrays `[..., dimension]`
    are broadcast (Ericson, Real-Time Collision Detection, section 5.1.9)."""
    one, other, between = b - a, d - c, a - c
    tiny = np.finfo(float).tiny
    square, other_square = ((along**2).sum(-1) + tiny for along in (one, other))
    mixed, at_one, at_other = ((x * y).sum(-1) for x, y in ((one, other), (one, between), (other, between)))
    parallel = square * other_square - mixed**2
    share = np.clip((mixed * at_other - at_one * other_square) / np.maximum(parallel, tiny), 0.0, 1.0)
    other_share = np.clip((mixed * share + at_other) / other_square, 0.0, 1.0)
    share = np.clip((mixed * other_share - at_one) / square, 0.0, 1.0)
    apart: np.ndarray = np.linalg.norm(between + share[..., None] * one - other_share[..., None] * other, axis=-1)
    return apart


def _pierced(sides: Sides, corners: np.ndarray) -> np.ndarray:
    """Return whether each side comes closer than its half thickness to the inside of a triangle, `[m, corner, 3]`."""
    reach = sides.half[:, None]
    low, high = np.minimum(sides.begin, sides.end) - reach, np.maximum(sides.begin, sides.end) + reach
    found: np.ndarray = np.zeros(len(low), bool)
    close = ((corners.max(1) >= low.min(0)) & (corners.min(1) <= high.max(0))).all(1)
    near: np.ndarray = ((low <= corners.max((0, 1))) & (high >= corners.min((0, 1)))).all(1)
    if not (close.any() and near.any()):
        return found
    a, one, other = corners[close, 0], *(corners[close, k] - corners[close, 0] for k in (1, 2))
    normal = np.cross(one, other)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    begin, end = (points[near, None] - a for points in (sides.begin, sides.end))
    height, fall = (begin * normal).sum(-1), ((begin - end) * normal).sum(-1)
    share = np.clip(height / np.where(fall == 0.0, np.inf, fall), 0.0, 1.0)
    point = begin + share[..., None] * (end - begin)
    squares = [(one * one).sum(-1), (one * other).sum(-1), (other * other).sum(-1)]
    along, across = (point * one).sum(-1), (point * other).sum(-1)
    area = squares[0] * squares[2] - squares[1] ** 2
    first = (squares[2] * along - squares[1] * across) / area
    second = (squares[0] * across - squares[1] * along) / area
    inside = (first >= 0.0) & (second >= 0.0) & (first + second <= 1.0)
    found[near] = (inside & (np.abs(height - share * fall) <= sides.half[near, None])).any(1)
    return found
