"""The dimensionless numbers of a scene, and how its grid resolves its bodies.

    Re = U L / nu,   k = pi f L / U,   M = mu / (rho L),   K = EI / (rho U² L³)

with U the velocity that drives the flow, L the diameter of the first cylinder, the length of the first body, or that of
the beam (in M and K that of the beam), f the frequency of the drive, mu the mass per area and EI the stiffness of the
beam per depth, both at its root. Of several beams it is the first.

The added mass is that of a thin plate across the flow, pi/4 rho L² (Theodorsen 1935). The layer at the front of a body
is that of the stagnation flow with the strain rate of potential flow: 4 U/D at a cylinder, 2 U/L amid a plate.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import dist, hypot, pi, sqrt
from typing import NamedTuple

import numpy as np

from nervure.scene import Own, Scene, beams
from nervure.scene.along import along, places, thickness
from nervure.scene.types import (
    Body as BodyOfScene,
    Cylinder,
    MaterialPlaneStrain,
    RootMotionLaws,
    Shape,
    ShapeCircle,
    ShapeEllipse,
    ShapePolygon,
    ShapeRectangle,
    TimeLaw,
    TimeLawConstant,
    TimeLawCosineRamp,
    TimeLawSine,
    TimeLawTable,
)

PEAK = {"uniform": 1.0, "parabolic": 1.5}  # Largest velocity of an inflow's profile by its mean


@dataclass(frozen=True, kw_only=True)
class Body:
    """How the grid resolves a body; a number of cells is that of the coarser direction."""

    length: float  # Diameter of a cylinder, length of a beam or a body, m
    thickness_cells: float  # Cells in the diameter of a cylinder, in the thickness of a beam or a body
    layer_cells: float | None  # Cells in the boundary layer at the front; None in still fluid and for a beam in a wake


@dataclass(frozen=True, kw_only=True)
class Dimensionless:
    """Those of a scene with a fluid. What a scene does not have is None."""

    velocity: float | None  # U, m/s; None where nothing drives the flow
    velocity_of: str | None
    length: float | None  # L, m; None without a body
    length_of: str | None
    reynolds: float | None
    reduced_frequency: float | None  # Of a sine that drives a body or the flow
    mass_ratio: float | None  # mu / (rho L)
    density_ratio: float | None  # Mass of the beam by that of the fluid it displaces, of several the least
    added_mass_ratio: float | None  # Added mass of a plate by the mass of the beam
    stiffness: float | None  # EI / (rho U² L³)
    cfl: float | None  # CFL number of the longest step, with twice the largest velocity, as at the side of a cylinder
    bodies: dict[str, Body]  # By the names of their forces: cylinder_1, …, body_1, …, beam, or beam_1, …


class Drive(NamedTuple):
    """A velocity that drives the flow."""

    speed: float  # m/s
    name: str
    frequency: float | None  # Hz


def evaluate(scene: Scene) -> Dimensionless | None:
    """The numbers of `scene`; None without a fluid."""
    fluid, own = scene.fluid, beams(scene)
    if fluid is None:
        return None
    sizes = {f"cylinder_{i}": (2 * cylinder.radius,) * 2 for i, cylinder in enumerate(fluid.cylinders, 1)}
    sizes |= {f"body_{i}": size(body.shape) for i, body in enumerate(fluid.bodies, 1)}
    sizes |= {each.force: (each.beam.length, float(thickness(each.beam).min())) for each in own}
    lengths = {name: length for name, (length, _) in sizes.items()}
    flexible = {each.force for each in own}
    plates = flexible | {
        f"body_{i}" for i, body in enumerate(fluid.bodies, 1) if not isinstance(body.shape, ShapeCircle)
    }
    length_of = next(iter(lengths), None)
    length = lengths[length_of] if length_of else None

    streams, motions = list(_streams(scene)), list(_motions(scene))
    drive = next((drive for drive in [*streams, *motions] if drive.speed > 0), None)
    velocity = drive.speed if drive else None
    frequency = next((found for _, _, found in [*motions, *streams] if found), None)
    fastest = hypot(*(max((speed for speed, _, _ in drives), default=0.0) for drives in (streams, motions)))
    if fluid.inflow:
        fastest *= PEAK[fluid.inflow.profile]

    (x0, x1), (y0, y1), (nx, ny) = fluid.box.x, fluid.box.y, fluid.box.cells
    dx, dy = (x1 - x0) / nx, (y1 - y0) / ny
    step = min(scene.time.communication_step, fluid.time_stepping.max_step)
    bodies = {}
    for name, (extent, thinnest) in sizes.items():
        strain = (2 if name in plates else 4) * fastest / extent if name == length_of or name not in flexible else 0.0
        bodies[name] = Body(
            length=extent,
            thickness_cells=thinnest / max(dx, dy),
            layer_cells=sqrt(fluid.kinematic_viscosity / strain) / max(dx, dy) if strain else None,
        )
    section, span = _section(own[0]) if own else None, own[0].beam.length if own else 0.0
    ratios = [
        float((found[0] / fluid.density / thickness(each.beam)).min()) for each in own if (found := _section(each))
    ]
    masses, stiffnesses = section or (np.zeros(1), np.zeros(1))
    mass = float(masses[0]) / fluid.density if section else None
    return Dimensionless(
        velocity=velocity,
        velocity_of=drive.name if drive else None,
        length=length,
        length_of=length_of,
        reynolds=velocity * length / fluid.kinematic_viscosity if velocity and length else None,
        reduced_frequency=pi * frequency * length / velocity if frequency and length and velocity else None,
        mass_ratio=mass / span if mass else None,
        density_ratio=min(ratios, default=None),
        added_mass_ratio=pi / 4 * span / mass if mass else None,
        stiffness=float(stiffnesses[0]) / (fluid.density * velocity**2 * span**3) if section and velocity else None,
        cfl=2 * fastest * step / min(dx, dy) if fastest else None,
        bodies=bodies,
    )


def _streams(scene: Scene) -> Iterator[Drive]:
    """Velocities of the flow that the scene asks for, the first that is not 0 being U."""
    fluid = scene.fluid
    if fluid is None:
        return
    if inflow := fluid.inflow:
        yield Drive(largest(inflow.mean_velocity), "inflow", _frequency(inflow.mean_velocity))
    if flow := fluid.mean_flow:
        yield Drive(hypot(largest(flow.x), largest(flow.y)), "mean flow", _frequency(flow.x) or _frequency(flow.y))
    if fluid.sponge:
        yield Drive(largest(fluid.sponge.mean_velocity), "sponge", _frequency(fluid.sponge.mean_velocity))
    yield Drive(hypot(*fluid.initial_velocity), "initial velocity", None)


def _motions(scene: Scene) -> Iterator[Drive]:
    """Largest speeds of the bodies that are driven: of a rigid one that of its pivot, or of its farthest point where it
    only turns; of a beam that of its tip if it were rigid."""
    cylinders: list[Cylinder] = scene.fluid.cylinders if scene.fluid else []
    for i, cylinder in enumerate(cylinders, 1):
        if motion := cylinder.motion:
            speed = hypot(largest_rate(motion.x), largest_rate(motion.y))
            yield Drive(speed, f"motion of cylinder {i}", _frequency(motion.x) or _frequency(motion.y))
    for i, body in enumerate(scene.fluid.bodies if scene.fluid else [], 1):
        if moved := body.motion:
            speed = hypot(largest_rate(moved.x), largest_rate(moved.y)) or largest_rate(moved.angle) * reach(body)
            found = _frequency(moved.x) or _frequency(moved.y) or _frequency(moved.angle)
            yield Drive(speed, f"motion of body {i}", found)
    for own in beams(scene):
        if not (own.rod and isinstance(own.rod.root_motion, RootMotionLaws)):
            continue
        laws = own.rod.root_motion.laws
        shifts, turns = [laws.x, laws.y, laws.z], [rotation.angle for rotation in laws.rotations]
        turning = own.beam.length * hypot(*map(largest_rate, turns))
        frequencies = [found for law in [*shifts, *turns] if (found := _frequency(law))]
        yield Drive(hypot(turning, *map(largest_rate, shifts)), "drive of the root", next(iter(frequencies), None))


def size(shape: Shape) -> tuple[float, float]:
    """Length and thickness of a body, m: of a polygon the largest distance of two corners, and its area by that."""
    match shape:
        case ShapeCircle():
            return 2 * shape.circle.radius, 2 * shape.circle.radius
        case ShapeEllipse():
            return shape.ellipse.length, shape.ellipse.thickness
        case ShapeRectangle():
            return shape.rectangle.length, shape.rectangle.thickness
        case ShapePolygon():
            corners = shape.polygon.corners
            length = max(dist(a, b) for a in corners for b in corners)
            area = sum(
                x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(corners, [*corners[1:], corners[0]], strict=True)
            )
            return length, abs(area) / 2 / length


def reach(body: BodyOfScene) -> float:
    """Distance from the pivot of a body to its farthest point, m: of an outline with an axis, to an end of that."""
    if isinstance(body.shape, ShapePolygon):
        return max(dist(corner, body.pivot) for corner in body.shape.polygon.corners)
    length, _ = size(body.shape)
    return max(dist((end, 0.0), body.pivot) for end in (-length / 2, length / 2))


def largest(law: TimeLaw) -> float:
    """Largest magnitude of a law; of a sine with a mean, both together."""
    match law:
        case TimeLawConstant():
            return abs(law.constant)
        case TimeLawCosineRamp():
            return abs(law.cosine_ramp.value)
        case TimeLawSine():
            return abs(law.sine.mean) + abs(law.sine.amplitude)
        case TimeLawTable():
            return max(map(abs, law.table.values))


def largest_rate(law: TimeLaw) -> float:
    """Largest magnitude of a law's rate, per second; of a sine without its ramp, of a table by its secants."""
    match law:
        case TimeLawConstant():
            return 0.0
        case TimeLawCosineRamp():
            return abs(law.cosine_ramp.value) * pi / 2 / law.cosine_ramp.duration
        case TimeLawSine():
            return abs(law.sine.amplitude) * 2 * pi * law.sine.frequency
        case TimeLawTable():
            times, values = law.table.times, law.table.values
            return max(abs((values[i + 1] - values[i]) / (times[i + 1] - times[i])) for i in range(len(times) - 1))


def _frequency(law: TimeLaw) -> float | None:
    return law.sine.frequency if isinstance(law, TimeLawSine) and law.sine.amplitude else None


def _section(own: Own) -> tuple[np.ndarray, np.ndarray] | None:
    """Mass and bending stiffness of a beam at its stations, per metre of depth; None without a rod."""
    if own.rod is None:
        return None
    material, h = own.rod.material, thickness(own.beam)
    if not isinstance(material, MaterialPlaneStrain):
        section, s = material.section, places(own.beam)
        return along(section.line_density, s), along(section.bending_stiffness, s)
    strain = material.plane_strain
    modulus = strain.youngs_modulus / (1 - strain.poisson_ratio**2)
    return strain.density * h, modulus * h**3 / 12
