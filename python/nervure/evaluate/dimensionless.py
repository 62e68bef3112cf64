"""The dimensionless numbers of a scene, and the resolution of its bodies by the grid.

    Re = U L / nu,   k = pi f L / U,   M = mu / (rho L),   K = EI / (rho U² L³)

`crates/scene` computes and defines them (`facts.rs`).
"""

from dataclasses import dataclass

from nervure.scene import Scene
from nervure.scene.facts import scene_facts


@dataclass(frozen=True, kw_only=True)
class Body:
    """Resolution of a body by the grid; cells are counted in the coarser direction."""

    length: float  # Diameter of a cylinder, length of a beam or a body, m
    thickness_cells: float  # Cells in the diameter of a cylinder, in the thickness of a beam or a body
    layer_cells: float | None  # Cells in the boundary layer at the front; None in still fluid and for a beam in a wake


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


def evaluate(scene: Scene) -> Dimensionless | None:
    """Return the numbers of `scene`; None without a fluid."""
    found = scene_facts(scene).dimensionless
    if found is None:
        return None
    return Dimensionless(**{**found, "bodies": {name: Body(**body) for name, body in found["bodies"]}})
