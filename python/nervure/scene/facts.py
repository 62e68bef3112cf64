"""Facts of a scene, computed by the libraries of the units: their rules stand in `crates/scene` alone (`facts.rs`)."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from nervure import library
from nervure.errors import SceneError
from nervure.scene import Scene, beams, text, validate, wings
from nervure.scene.solids import rotation
from nervure.scene.types import ShapeDisk, ShapePlate, ShapePolyline, ShapeTriangulation, Wing


@dataclass(frozen=True, kw_only=True)
class Body:
    """Resolution of a body by the grid; cells are counted in the coarser direction."""

    length: float  # Diameter of a cylinder, length of a beam or a body, m
    thickness_cells: float  # Cells in the diameter of a cylinder, in the thickness of a beam or a body
    along: dict[str, float]  # Cells along what is a line to the fluid: length of a beam, mean chord and span of a wing
    layer_cells: float | None  # Cells in the boundary layer at the front; None in still fluid and for a beam in a wake


@dataclass(frozen=True, kw_only=True)
class Support:
    """A spring with its damper, by the mass of the body without a fluid."""

    natural_frequency: float  # f_n, Hz
    damping_ratio: float | None  # By the critical damping; None without a spring
    reduced_velocity: float | None  # U / (f_n L); None without a spring or a drive


@dataclass(frozen=True, kw_only=True)
class Mount:
    """A body on springs."""

    mass_ratio: float | None  # Mass by that of the displaced fluid; absent for a line
    supports: dict[str, Support]  # By the direction in which the body moves: x, y, angle, …


@dataclass(frozen=True, kw_only=True)
class Dimensionless:
    """Dimensionless numbers of a scene with a fluid; numbers that the scene lacks are None."""

    velocity: float | None  # U, m/s; None where nothing drives the flow
    velocity_of: str | None
    length: float | None  # L, m; None without a body
    length_of: str | None
    reynolds: float | None
    reduced_frequency: float | None  # Of a sine that drives a body or the flow
    mass_ratio: float | None  # mu / (rho L)
    density_ratio: float | None  # Least mass of a rod by the mass of the fluid it displaces
    added_mass_ratio: float | None  # Added mass of a plate by the mass of the beam
    stiffness: float | None  # EI / (rho U² L³)
    cfl: float | None  # CFL number of the longest step with twice the largest velocity, as beside a cylinder
    bodies: dict[str, Body]  # By the names of their forces: cylinder_1, …, body_1, …, beam, or beam_1, …
    mounts: dict[str, Mount]  # Of the bodies on springs, by the same names


@dataclass(frozen=True, kw_only=True)
class Scales:
    """Scales of the coefficients of a body, and unit vectors of its forces."""

    length: float  # L, m
    area: float | None  # A, m²; None in the plane, where forces are per metre of depth
    speed: float | None  # U of this body alone, m/s; None where it is that of the dimensionless numbers
    drag: tuple[float, float, float]
    lift: tuple[float, float, float]
    side: tuple[float, float, float]

    def directions(self, axes: int) -> np.ndarray:
        """Return the unit vectors of drag, lift and side, `[3, axes]`."""
        return np.array([self.drag, self.lift, self.side])[:, :axes]


@dataclass(frozen=True, kw_only=True)
class WingMesh:
    """The meshes of all wings together at rest; nodes are counted from 0."""

    nodes: np.ndarray  # m, `[n, 3]`
    triangles: np.ndarray  # Corners, `[triangles, 3]`
    veins: list[np.ndarray]  # Nodes of each vein from base to tip
    roots: list[np.ndarray]  # Held nodes of each wing
    tips: list[int]  # Node of each wing that is farthest from its pivot
    materials: np.ndarray  # Of each triangle, `[triangles]`: 0, or the number of a region from 1

    def edges(self) -> list[np.ndarray]:
        """Return the nodes around each wing, in order: sides that belong to one triangle."""
        sides = {(int(corners[i - 1]), int(corners[i])) for corners in self.triangles for i in range(3)}
        after = {first: second for first, second in sides if (second, first) not in sides}
        found = []
        while after:
            around = [min(after)]
            while (node := after.pop(around[-1], around[0])) != around[0]:  # Parts may share a node
                around.append(node)
            found.append(np.array(around))
        return found


def _alone(scene: Scene, wing: Wing) -> Scene:
    """Return a scene of one wing, whose mesh the library tells."""
    return validate({"name": scene.name, "time": scene.time.document(), "wing": wing.document()})


class Facts:
    """A scene and everything that follows from it. The library is asked once, when the first fact is needed; it raises
    `SceneError` with the faults of the scene."""

    def __init__(self, scene: Scene):
        self.scene, self.beams = scene, beams(scene)

    @cached_property
    def _found(self) -> dict[str, Any]:
        source = text(self.scene)
        if (found := library.facts(source)) is None:
            faults = library.check(source)
            raise SceneError("\n".join(fault.text for fault in faults), faults)
        return found

    @cached_property
    def numbers(self) -> Dimensionless | None:
        """The dimensionless numbers; None without a fluid."""
        if (found := self._found["dimensionless"]) is None:
            return None
        mounts = {
            name: Mount(
                mass_ratio=mount["mass_ratio"],
                supports={direction: Support(**support) for direction, support in mount["supports"]},
            )
            for name, mount in found["mounts"]
        }
        bodies = {name: Body(**{**body, "along": dict(body["along"])}) for name, body in found["bodies"]}
        return Dimensionless(**{**found, "bodies": bodies, "mounts": mounts})

    @cached_property
    def thickness(self) -> dict[str, np.ndarray]:
        """Thickness of each beam, by the name of its force, from root to tip, m: `[segments + 1]`."""
        each = zip(self.beams, self._found["beams"], strict=True)
        return {own.force: np.array(found["thickness"]) for own, found in each}

    @property
    def lines(self) -> set[str]:
        """The beams and bodies that the fluid meets as lines, by the names of their forces."""
        bodies = enumerate(self.scene.fluid.bodies if self.scene.fluid else (), 1)
        thin = ShapePlate | ShapePolyline | ShapeDisk | ShapeTriangulation
        rigid = {f"body_{i}" for i, body in bodies if isinstance(body.shape, thin)}
        flexible = zip(self.beams, self._found["beams"], strict=True)
        wings = {"wing"} if self.scene.wing else {f"wing_{i + 1}" for i in range(len(self.scene.wings))}
        return rigid | wings | {own.force for own, found in flexible if found["line"]}

    @cached_property
    def scales(self) -> dict[str, Scales]:
        """Scales of the coefficients of bodies, by the names of their forces."""
        axes = ("drag", "lift", "side")
        found: dict[str, dict[str, Any]] = self._found["scales"]
        return {name: Scales(**{**own, **{axis: tuple(own[axis]) for axis in axes}}) for name, own in found.items()}

    @cached_property
    def stream(self) -> np.ndarray | None:
        """Velocity of the stream, m/s, `[3]`; None in still fluid."""
        return None if self._found["stream"] is None else np.array(self._found["stream"])

    @property
    def followed(self) -> str | None:
        """Name of what the fine box follows, or `master`; None for a box that stays, and without one."""
        found: str | None = self._found["followed"]
        return found

    @cached_property
    def wing(self) -> WingMesh | None:
        """The meshes of the wings, as a flyer holds them at angles of 0; None without one."""
        if not (owns := wings(self.scene)):
            return None
        flyer = self.scene.flyer
        hinges = {hinge.carries: hinge for hinge in (flyer.hinges if flyer else ())}
        nodes, triangles, materials = list[np.ndarray](), list[np.ndarray](), list[np.ndarray]()
        veins, roots, tips, first = list[np.ndarray](), list[np.ndarray](), list[int](), 0
        for name, own in owns.items():
            found = (self if self.scene.wing else Facts(_alone(self.scene, own)))._found["wing"]
            places = np.array(found["nodes"])
            away = np.linalg.norm(places - own.pivot, axis=1)
            if flyer and (hinge := hinges.get(name)):
                turn = rotation(hinge.turn.axis, hinge.turn.angle) if hinge.turn else np.eye(3)
                places = np.add(flyer.position, hinge.position) + (places - own.pivot) @ turn.T
            nodes.append(places)
            triangles.append(first + np.array(found["triangles"], int).reshape(-1, 3))
            materials.append(np.array(found.get("materials") or [0] * len(triangles[-1]), int))
            veins += [first + np.array(vein, int) for vein in found["veins"]]
            roots.append(first + np.array(found["root"], int))
            tips.append(first + int(np.flatnonzero(away > (1 - 1e-12) * away.max())[-1]))  # As the unit takes it
            first += len(places)
        return WingMesh(
            nodes=np.concatenate(nodes),
            triangles=np.concatenate(triangles),
            veins=veins,
            roots=roots,
            tips=tips,
            materials=np.concatenate(materials),
        )

    @property
    def fluid_steps(self) -> int:
        """Number of steps that the fluid is expected to make in a communication step."""
        return int(self._found["fluid_steps"])

    @property
    def warnings(self) -> list[str]:
        """What may be a mistake in the scene, as sentences."""
        return [warning["text"] for warning in self._found["warnings"]]

    def final_value(self, key: str, by: float = np.inf) -> float | None:
        """Return the value that the law `key` of the flow keeps from the time `by` (s) on; None if it still changes."""
        law = self._found["laws"].get(key)
        time, value = (law and law["settles"]) or (np.inf, None)
        return value if time <= by else None
