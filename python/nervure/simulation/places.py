"""What a run tells of places: rods, wings, and bodies on springs or moved by the master, that leave the box, reach into
walls or zones or meet something, and rods that change their length beyond reason. What laws move is looked at before
the run (`crates/scene/src/warnings.rs`)."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import combinations

import numpy as np

from nervure.scene import solids
from nervure.scene.facts import Facts
from nervure.scene.outline import POSE, body_outline, circle
from nervure.scene.types import Body, Fluid, RootOnCylinder
from nervure.simulation.contacts import Sides, Solid
from nervure.units.fmu import Unit

STRETCHED = 0.5
"""Change of the length of a rod, by the smaller of the length and that at rest, above which it is told of."""


Bounds = tuple[float, float]


@dataclass
class Part:
    """A rod, the wing, or a rigid body of the fluid."""

    name: str
    points: Callable[[], np.ndarray]
    """Its stations from root to tip, its nodes, or the corners of its outline, m: `[n, dimension]`."""
    half: np.ndarray
    """Half the thickness of a rod at its stations, m; empty for others."""
    is_free: bool
    """Whether only the run knows where it goes."""
    edges: np.ndarray | None = None
    """Pairs of nodes of the wing, `[n, 2]`."""
    solid: Callable[[], Solid] | None = None
    """A body in space, which has no outline."""
    length: float = 0.0
    """Length of a rod at rest, m."""
    holder: int | None = None
    """Index of the cylinder that holds a rod."""

    @cached_property
    def side_half(self) -> np.ndarray:
        """Half the thickness of a rod at its sides, m."""
        found: np.ndarray = np.maximum(self.half[:-1], self.half[1:])
        return found

    def sides(self, points: np.ndarray) -> Sides:
        """Return the sides between the points."""
        if self.edges is not None:
            return Sides(points[self.edges[:, 0]], points[self.edges[:, 1]], np.zeros(len(self.edges)), False)
        if self.half.size:
            return Sides(points[:-1], points[1:], self.side_half, False)
        return Sides(points, np.roll(points, -1, axis=0), np.zeros(len(points)), True)


class Places:
    """Looks at the places of the parts of a run now and then, and tells each thing once."""

    def __init__(self, facts: Facts, units: Mapping[str, Unit]):
        self.fluid, self.parts = facts.scene.fluid, list(_parts(facts, units))
        self.wing = units.get("wing")
        self.known: dict[str, float] = {}
        """How far each thing had gone at the first look, or infinite where it was told: a root may be embedded."""
        self.first: list[np.ndarray] = []
        """Middles of the sides of each part at the first look, m."""
        self.embedded: dict[str, np.ndarray] = {}
        """Middles of the sides that touched another part at the first look, m."""

    def look(self, t: float) -> Iterator[str]:
        """Yield what is to be told at `t` (s)."""
        if self.wing and "crossings" in self.wing.variables:
            text = "the wing passes through itself, for nothing holds its parts apart,"
            yield from self._tell("crossings", float(self.wing.read("crossings")[0]), 0.0, text, t)
        places = [part.points() for part in self.parts]
        sides = [part.sides(points) for part, points in zip(self.parts, places, strict=True)]
        for part, points, own in zip(self.parts, places, sides, strict=True):
            if part.is_free:
                for what, reached, least, text in self._alone(part, points, own):
                    yield from self._tell(f"{part.name} {what}", reached, least, f"{part.name} {text}", t)
        if not self.first:
            self.first = [(own.begin + own.end) / 2 for own in sides]
        for i, j in combinations(range(len(self.parts)), 2):
            if self.parts[i].is_free or self.parts[j].is_free:
                pair = self._pair if places[i].shape[1] == 2 else self._pair_in_space
                yield from pair(i, j, sides[i], sides[j], t)
        for part, own in zip(self.parts, sides, strict=True):
            if part.half.size:
                yield from self._folded(part, own, t)

    def _alone(self, part: Part, points: np.ndarray, sides: Sides) -> Iterator[tuple[str, float, float, str]]:
        """Yield what a part does without another: its name, how far it goes, how far it may, and a text."""
        if part.half.size:
            ratio = float(sides.lengths.sum()) / part.length
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
            if self.fluid.channel and (walls := getattr(self.fluid.channel, axis)):
                reached = _beyond(values, walls)
                text = f"reaches {reached:.2g} m into a wall of the channel"
                yield f"wall {axis}", reached, thickness / 2 or cell, text
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
        is_apart = one.is_apart(other)
        a, b = (one, other) if is_apart else (one.near(other), other.near(one))
        if len(a.begin) and len(b.begin) and not is_apart:
            crossings = a.crossings(b)
            crossed = int(crossings.sum())
            if crossed:
                touched, at = 1.0, a.begin[crossings.any(1)][0]
            elif not held and self.known.get(what, 0.0) == 0.0:
                gaps, back = a.gaps(b), b.gaps(a)
                bodies = ((body, ends.begin) for body, ends in ((one, b), (other, a)) if body.is_closed)
                inside = [points[body.contains(points)] for body, points in bodies]
                within = np.concatenate([np.zeros((0, 2)), *inside])
                nearest = a.begin[gaps.min(1).argmin()] if gaps.min() < back.min() else b.begin[back.min(1).argmin()]
                touched = float(len(within) > 0 or min(gaps.min(), back.min()) <= 0.0)
                at = within[0] if len(within) else nearest
        place = f"near {_place(at)} m, and nothing keeps them apart,"
        if self.known.setdefault(what, touched) != 1.0:
            yield from self._tell(what, touched, 0.0, f"{what} {place}", t)
        else:  # A root in a body crosses its outline once
            most = max(float(crossed), float(one.is_closed and not held))
            yield from self._tell(f"{what} again", most, 0.0, f"{what} {place}", t)

    def _pair_in_space(self, i: int, j: int, one: Sides, other: Sides, t: float) -> Iterator[str]:
        """Yield where two parts in space meet beyond what touched at the first look."""
        first, second = self.parts[i], self.parts[j]
        what, solid = f"{second.name} meets {first.name}", first.solid
        touched = (solid() if solid else one).touched(other)
        known = self.embedded.setdefault(what, self.first[j][touched])
        if not touched.any():
            return
        lengths = np.linalg.norm(other.end - other.begin, axis=1)
        margin = 2 * (lengths + other.half + one.half.max(initial=0.0)).max()
        apart = np.linalg.norm(self.first[j][touched, None] - known, axis=-1).min(1, initial=np.inf)
        if (apart > margin).any():
            at = ((other.begin + other.end) / 2)[touched][apart.argmax()]
            yield from self._tell(what, 1.0, -1.0, f"{what} near {_place(at)} m, and nothing keeps them apart,", t)

    def _folded(self, part: Part, own: Sides, t: float) -> Iterator[str]:
        """Yield where a rod meets itself."""
        touched = np.zeros(1, bool) if own.is_onward else own.folded()
        at = own.begin[touched.argmax()]
        text = f"{part.name} meets itself near {_place(at)} m, and nothing keeps its parts apart,"
        yield from self._tell(f"{part.name} itself", float(touched.any()), 0.0, text, t)

    def _tell(self, what: str, reached: float, least: float, text: str, t: float) -> Iterator[str]:
        if reached > self.known.setdefault(what, reached) + least:
            self.known[what] = np.inf
            yield f"{text} by t = {t:.4g} s"


def _parts(facts: Facts, units: Mapping[str, Unit]) -> Iterator[Part]:
    """Yield the parts whose places are known during a run: still cylinders, bodies and rods."""
    fluid, unit, none, wing = facts.scene.fluid, units.get("fluid"), np.zeros(0), units.get("wing")
    holders: dict[int, int] = {}
    count = 0
    if fluid and unit and fluid.box.z is None:
        for k, cylinder in enumerate(fluid.cylinders):
            if cylinder.motion is None:
                holders[k], count = count, count + 1
                corners = np.add(cylinder.center, circle(cylinder.radius))
                yield Part(f"cylinder {k + 1}", partial(np.asarray, corners), none, False)
        for k, body in enumerate(fluid.bodies):
            names = [f"body[{k + 1}].{name}" for name in POSE]
            if all(name in unit.variables for name in names):
                is_free = body.mount is not None or body.motion == "master"
                yield Part(f"body {k + 1}", _corners(body, unit, names), none, is_free)
    elif fluid and unit:
        for k, body in enumerate(fluid.bodies):
            names = [f"body[{k + 1}].{name}" for name in solids.POSE]
            if all(name in unit.variables for name in names):
                solid = _solid(body, unit, names, fluid)
                yield Part(f"body {k + 1}", partial(np.zeros, (1, 3)), none, False, solid=solid)
    if wing and facts.wing and {"x", "y", "z"} <= wing.variables.keys():
        triangles = facts.wing.triangles
        edges = np.sort(np.vstack([triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]))
        yield Part("the wing", wing.reader(["x", "y", "z"]), none, True, np.unique(edges, axis=0))
    for own in facts.beams:
        rod = units.get(own.unit)
        if rod and {"x", "y"} <= rod.variables.keys():
            axes = [axis for axis in "xyz" if axis in rod.variables]
            half = facts.thickness[own.force] / 2
            root = own.beam.root
            holder = holders.get(root.on_cylinder.cylinder) if isinstance(root, RootOnCylinder) else None
            length = own.beam.length
            yield Part(f"the {rod.name}", rod.reader(axes), half, True, length=length, holder=holder)


def _corners(body: Body, unit: Unit, names: list[str]) -> Callable[[], np.ndarray]:
    pose = unit.reader(names)
    return lambda: body_outline(body, *pose()[0])


def _solid(body: Body, unit: Unit, names: list[str], fluid: Fluid) -> Callable[[], Solid]:
    pose = unit.reader(names)
    return lambda: Solid(body, pose()[0].tolist(), fluid)


def _box(fluid: Fluid) -> list[tuple[str, Bounds, int]]:
    """Return name, bounds (m) and cells of each axis of the box."""
    sides = [("x", fluid.box.x), ("y", fluid.box.y), *([("z", fluid.box.z)] if fluid.box.z else [])]
    return [(axis, bounds, cells) for (axis, bounds), cells in zip(sides, fluid.box.cells, strict=True)]


def _place(point: np.ndarray) -> str:
    return f"({', '.join(f'{at:.3g}' for at in point)})"


def _beyond(values: np.ndarray, bounds: Bounds) -> float:
    """Return how far values lie outside of bounds."""
    return max(0.0, bounds[0] - float(values.min()), float(values.max()) - bounds[1])
