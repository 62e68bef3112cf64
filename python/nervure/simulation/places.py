"""What a run tells of places: rods, and bodies on springs or moved by the master, that leave the box, reach into walls
or zones or meet something, and rods that change their length beyond reason. What laws move is looked at before the run
(`crates/scene/src/warnings.rs`)."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import combinations

import numpy as np

from nervure.scene.facts import Facts
from nervure.scene.outline import POSE, body_outline, circle
from nervure.scene.types import Body, Fluid, RootOnCylinder
from nervure.units.fmu import Unit

STRETCHED = 0.5
"""Change of the length of a rod, by the smaller of the length and that at rest, above which it is told of."""


Bounds = tuple[float, float]


@dataclass
class Part:
    """A rod, or a rigid body of the fluid."""

    name: str
    points: Callable[[], np.ndarray]
    """Its stations from root to tip, or the corners of its outline, m: `[n, dimension]`."""
    half: np.ndarray
    """Half the thickness of a rod at its stations, m; empty for a body."""
    is_free: bool
    """Whether only the run knows where it goes."""
    length: float = 0.0
    """Length of a rod at rest, m."""
    holder: int | None = None
    """Index of the cylinder that holds a rod."""


@dataclass(frozen=True)
class Sides:
    """The sides of a part in the plane at one time."""

    begin: np.ndarray
    end: np.ndarray
    half: np.ndarray
    is_closed: bool

    @classmethod
    def of(cls, part: Part, points: np.ndarray) -> "Sides":
        """Return the sides of a part at its `points`."""
        if part.half.size:
            return cls(points[:-1], points[1:], np.maximum(part.half[:-1], part.half[1:]), False)
        return cls(points, np.roll(points, -1, axis=0), np.zeros(len(points)), True)

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


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return twice the area of triangles, positive if their corners go round counter-clockwise."""
    turned: np.ndarray = (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (
        c[..., 0] - a[..., 0]
    )
    return turned


class Places:
    """Looks at the places of the parts of a run now and then, and tells each thing once."""

    def __init__(self, facts: Facts, units: Mapping[str, Unit]):
        self.fluid, self.parts = facts.scene.fluid, list(_parts(facts, units))
        self.wing = units.get("wing")
        self.known: dict[str, float] = {}
        """How far each thing had gone at the first look, or infinite where it was told: a root may be embedded."""

    def look(self, t: float) -> Iterator[str]:
        """Yield what is to be told at `t` (s)."""
        if self.wing and "crossings" in self.wing.variables:
            text = "the wing passes through itself, for nothing holds its parts apart,"
            yield from self._tell("crossings", float(self.wing.read("crossings")[0]), 0.0, text, t)
        places = [part.points() for part in self.parts]
        for part, points in zip(self.parts, places, strict=True):
            if part.is_free:
                for what, reached, least, text in self._alone(part, points):
                    yield from self._tell(f"{part.name} {what}", reached, least, f"{part.name} {text}", t)
        if not all(points.shape[1] == 2 for points in places):
            return
        sides = [Sides.of(part, points) for part, points in zip(self.parts, places, strict=True)]
        for i, j in combinations(range(len(self.parts)), 2):
            if self.parts[i].is_free or self.parts[j].is_free:
                yield from self._pair(i, j, sides[i], sides[j], t)
        for part, own in zip(self.parts, sides, strict=True):
            if part.half.size:
                yield from self._folded(part, own, t)

    def _alone(self, part: Part, points: np.ndarray) -> Iterator[tuple[str, float, float, str]]:
        """Yield what a part does without another: its name, how far it goes, how far it may, and a text."""
        if part.half.size:
            ratio = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) / part.length
            text = f"is {ratio:.2g} times as long as at rest: its axial stiffness is small for its loads"
            yield "length", max(ratio, 1 / max(ratio, 1e-9)) - 1, STRETCHED, text
        if self.fluid is None:
            return
        thickness = 2 * part.half.max() if part.half.size else 0.0
        for axis, bounds, cells in _box(self.fluid)[: points.shape[1]]:
            values = points[:, "xyz".index(axis)]
            over, cell = _beyond(values, bounds), (bounds[1] - bounds[0]) / cells
            text = f"reaches {over:.2g} m over the edge of the box along {axis} and comes in at the other side"
            yield f"edge {axis}", over, 0.0, text
            if axis == "y" and self.fluid.channel:
                reached = _beyond(values, self.fluid.channel.y)
                yield "wall", reached, thickness / 2 or cell, f"reaches {reached:.2g} m into a wall of the channel"
            for name, zone in (("inflow zone", self.fluid.inflow), ("sponge", self.fluid.sponge)):
                if axis == "x" and zone:
                    within = min(float(values.max()), zone.x[1]) - max(float(values.min()), zone.x[0])
                    text = f"reaches {within:.2g} m into the {name}, whose velocity is imposed inside bodies too,"
                    yield name, max(within, 0.0), cell, text

    def _pair(self, i: int, j: int, one: Sides, other: Sides, t: float) -> Iterator[str]:
        """Yield where two parts meet: they touch, or, if they did at the first look, cross more often."""
        first, second = self.parts[i], self.parts[j]
        what, held = f"{second.name} meets {first.name}", second.holder == i
        if held:  # The first side begins at the surface
            other = Sides(other.begin[1:], other.end[1:], other.half[1:], False)
        touched, crossed, at = float(held), 0, np.zeros(2)
        a, b = (one.near(other), other.near(one)) if len(other.begin) else (other, other)
        if len(a.begin) and len(b.begin):
            crossings, gaps, back = a.crossings(b), a.gaps(b), b.gaps(a)
            bodies = ((body, ends.begin) for body, ends in ((one, b), (other, a)) if body.is_closed)
            inside = [points[body.contains(points)] for body, points in bodies]
            within = np.concatenate([np.zeros((0, 2)), *inside])
            crossed = int(crossings.sum())
            nearest = a.begin[gaps.min(1).argmin()] if gaps.min() < back.min() else b.begin[back.min(1).argmin()]
            touched = float(held or crossed > 0 or len(within) > 0 or min(gaps.min(), back.min()) <= 0.0)
            at = a.begin[crossings.any(1)][0] if crossed else within[0] if len(within) else nearest
        place = f"near ({at[0]:.3g}, {at[1]:.3g}) m, and nothing keeps them apart,"
        if self.known.setdefault(what, touched) != 1.0:
            yield from self._tell(what, touched, 0.0, f"{what} {place}", t)
        else:  # A root in a body crosses its outline once
            most = max(float(crossed), float(one.is_closed and not held))
            yield from self._tell(f"{what} again", most, 0.0, f"{what} {place}", t)

    def _folded(self, part: Part, own: Sides, t: float) -> Iterator[str]:
        """Yield where a rod crosses itself."""
        along = own.end - own.begin
        angles = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
        crossed, at = 0, np.zeros(2)
        if np.ptp(angles) > np.pi:  # else it goes on in one direction
            crossings = own.crossings(own)
            crossed = int(crossings.sum())
            at = own.begin[crossings.any(1)][0] if crossed else at
        text = f"{part.name} crosses itself near ({at[0]:.3g}, {at[1]:.3g}) m"
        yield from self._tell(f"{part.name} itself", crossed, 0.0, text, t)

    def _tell(self, what: str, reached: float, least: float, text: str, t: float) -> Iterator[str]:
        if reached > self.known.setdefault(what, reached) + least:
            self.known[what] = np.inf
            yield f"{text} by t = {t:.4g} s"


def _parts(facts: Facts, units: Mapping[str, Unit]) -> Iterator[Part]:
    """Yield the parts whose places are known during a run: still cylinders, bodies and rods."""
    fluid, unit, none = facts.scene.fluid, units.get("fluid"), np.zeros(0)
    holders: dict[int, int] = {}
    count = 0
    if fluid and unit and fluid.box.z is None:
        for k, cylinder in enumerate(fluid.cylinders):
            if cylinder.motion is None:
                holders[k], count = count, count + 1
                corners = partial(np.add, cylinder.center, circle(cylinder.radius))
                yield Part(f"cylinder {k + 1}", corners, none, False)
        for k, body in enumerate(fluid.bodies):
            names = [f"body[{k + 1}].{name}" for name in POSE]
            if all(name in unit.variables for name in names):
                is_free = body.mount is not None or body.motion == "master"
                yield Part(f"body {k + 1}", _corners(body, unit, names), none, is_free)
    for own in facts.beams:
        rod = units.get(own.unit)
        if rod and {"x", "y"} <= rod.variables.keys():
            axes = [axis for axis in "xyz" if axis in rod.variables]
            half = facts.thickness[own.force] / 2
            root = own.beam.root
            holder = holders.get(root.on_cylinder.cylinder) if isinstance(root, RootOnCylinder) else None
            yield Part(f"the {rod.name}", _stations(rod, axes), half, True, own.beam.length, holder)


def _corners(body: Body, unit: Unit, names: list[str]) -> Callable[[], np.ndarray]:
    return lambda: body_outline(body, *(float(unit.read(name)[0]) for name in names))


def _stations(rod: Unit, axes: list[str]) -> Callable[[], np.ndarray]:
    return lambda: np.column_stack([rod.read(axis) for axis in axes])


def _box(fluid: Fluid) -> list[tuple[str, Bounds, int]]:
    """Return name, bounds (m) and cells of each axis of the box."""
    sides = [("x", fluid.box.x), ("y", fluid.box.y), *([("z", fluid.box.z)] if fluid.box.z else [])]
    return [(axis, bounds, cells) for (axis, bounds), cells in zip(sides, fluid.box.cells, strict=True)]


def _beyond(values: np.ndarray, bounds: Bounds) -> float:
    """Return how far values lie outside of bounds."""
    return max(0.0, bounds[0] - float(values.min()), float(values.max()) - bounds[1])
