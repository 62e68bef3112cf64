"""What is known of the errors of a scene: the file of a verification, and the bars of runs of the same physics.

The error of a quantity at the sizes h of a scene, relative to those h_0 of the verified one, is the sum over parameters

    phi(h) − phi = Σ_i Σ_k c_ik (h_i / h_0i)^p_ik

with the cell, the square root of c_eta, the reciprocals of the numbers of segments and of the lengths of the box as
sizes. The step follows the cells.
"""

import hashlib
import json
import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from nervure.evaluate import benchmark
from nervure.scene import Scene, beams, wings
from nervure.scene.solids import box_ends, cell_lengths
from nervure.scene.types import ShapeCircularCylinder

FILE = "verify.json"
FOLDERS = "verify-*"  # Names of the folders of verifications, beside those of runs
GEOMETRY = ("fluid.box.", "fluid.fine_box.", "fluid.middle_box.", "fluid.precision")
"""Keys of the physics that are numerical here."""
DIGITS = 9


@dataclass(frozen=True)
class Share:
    """The error of a quantity by one parameter."""

    terms: list[tuple[float, float]]  # Coefficient, in the unit of the quantity, and exponent of the relative size
    uncertainty: float  # Of the limit, 95 %, in the unit of the quantity
    order: float | None  # Observed; None where the values do not converge
    kind: str  # How the values behave: converging, oscillating, scattered, two runs, noise
    sizes: list[float]  # Relative sizes of the runs
    values: list[float]
    noise: list[float]  # Statistical error of each, 95 %

    def error(self, size: float) -> float:
        """Return the error at a relative size: between those of the runs as they had it, of smaller ones as the terms
        say, of larger ones at least that of the coarsest run."""
        finest = self.sizes[0]
        if size <= finest:
            return math.fsum(coefficient * size**exponent for coefficient, exponent in self.terms)
        seen = np.array(self.values) - self.values[0] + self.error(finest)
        return float(np.interp(math.log(size), np.log(self.sizes), seen))

    def bar(self, size: float = 1.0) -> float:
        """Return the 95 % bound of the error at a relative size, where nothing is corrected: that of the finest run and
        the difference from it; of sizes beyond those of the runs at the least or the largest order."""
        finest, coarsest = self.sizes[0], self.sizes[-1]
        if size < finest:
            return self.uncertainty * size / finest
        apart = np.zeros(len(self.values)) if self.kind == "noise" else np.abs(np.array(self.values) - self.values[0])
        known = min(size, coarsest)
        bound = self.uncertainty + float(np.interp(math.log(known), np.log(self.sizes), apart))
        return bound * (size / known) ** 2


def is_part(name: str, parameters: Container[str]) -> bool:
    """Return whether the errors of a parameter are part of those of another one: steps follow the cells."""
    return name == "step" and "cells" in parameters


@dataclass(frozen=True)
class Quantity:
    """A quantity of a verified scene, in its unit."""

    value: float  # On the finest run
    limit: float  # Extrapolated
    uncertainty: float  # Of the limit, 95 %
    scale: float  # To which errors are relative: the value, of a mean at least the amplitude
    unit: str
    shares: dict[str, Share]  # By parameter, the first of which has the steps too

    def error(self, sizes: Mapping[str, float]) -> float:
        """Return the largest error at relative `sizes`: that by the first parameter, and the bars."""
        (first, main), *others = self.shares.items()
        beside, bars = 0.0, [main.uncertainty]
        for name, share in others:
            size = sizes.get(name, 1.0)
            if is_part(name, self.shares):
                beside = abs(share.error(size / sizes.get(first, 1.0)) - share.error(1.0))
            else:
                bars.append(share.bar(size))
        return abs(main.error(sizes.get(first, 1.0))) + beside + math.hypot(*bars)


@dataclass(frozen=True)
class Bar:
    """What a verification says of a quantity of a run, in its unit."""

    error: float  # Largest, 95 %, on the setting of the run
    limit: float  # Extrapolated
    uncertainty: float  # Of the limit, 95 %
    unit: str


@dataclass(frozen=True)
class Verified:
    """A verified scene."""

    scene: str
    physics: str  # Digest of the scene without its numerical keys
    sizes: dict[str, float]  # Sizes of the parameters in the scene
    quantities: dict[str, Quantity]  # By the name of a column of the table of runs
    within: float  # Wanted tolerance, relative
    reached: bool
    runs: int
    wall_s: float  # Of all runs
    recommended: dict[str, float] | None = None  # Sizes, relative to the scene
    recommended_wall_s: float | None = None
    recommended_error: float | None = None  # Largest of all quantities, relative

    def write(self, folder: Path) -> None:
        """Write the file of the verification."""
        content = json.dumps(TypeAdapter(Verified).dump_python(self), indent=2, ensure_ascii=False)
        (folder / FILE).write_text(content + "\n", encoding="utf-8")

    def bars(self, scene: Scene) -> dict[str, "Bar"]:
        """Return the bar of each quantity in a run of `scene`, which has the same physics."""
        relative = {name: size / self.sizes[name] for name, size in sizes(scene).items() if self.sizes.get(name)}
        return {
            name: Bar(quantity.error(relative), quantity.limit, quantity.uncertainty, quantity.unit)
            for name, quantity in self.quantities.items()
        }


def physics(scene: Scene) -> str:
    """Return a digest of the scene without its numerical keys."""
    known = sorted((key, value) for key, value in benchmark.physics(scene) if not key.startswith(GEOMETRY))
    rounded = [(key, f"{value:.{DIGITS}g}" if isinstance(value, int | float) else value) for key, value in known]
    return hashlib.sha256(json.dumps(rounded).encode()).hexdigest()[:16]


def find(scene: Scene, folder: Path) -> Verified | None:
    """Return the latest verification of the physics of `scene` in `folder`, that of the results; None without one."""
    found = sorted(folder.glob(f"{FOLDERS}/{FILE}"), key=lambda path: path.stat().st_mtime, reverse=True)
    own = physics(scene) if found else ""
    for path in found:
        try:
            known = TypeAdapter(Verified).validate_json(path.read_bytes())
        except (OSError, ValueError):
            continue  # Of another version, or being written
        if known.physics == own:
            return known
    return None


def bars(scene: Scene, folder: Path) -> dict[str, Bar] | None:
    """Return the bars of a run of `scene` by a verification of its physics in `folder`; None without one."""
    found = find(scene, folder)
    return found.bars(scene) if found else None


def sizes(scene: Scene) -> dict[str, float]:
    """Return the size of each numerical parameter that a scene has: the smaller, the smaller is the error."""
    found: dict[str, float] = {}
    if fluid := scene.fluid:
        fine = fluid.fine_box
        found["cells"] = _mean(cell_lengths(fluid)) / (fine.ratio if fine else 1)
    if count := [own.beam.segments for own in beams(scene) if not own.beam.rest_angles and own.rod]:
        found["segments"] = 1 / _mean(count)
    if along := triangles_along(scene):
        found["mesh"] = 1 / along
    found["step"] = min(scene.time.communication_step, fluid.time_stepping.max_step if fluid else math.inf)
    if fluid and _is_solid(scene):
        (mask,) = fluid.mask.document().values()
        found["c_eta"] = math.sqrt(mask["c_eta"])
        if axes := free_axes(scene):
            ends = box_ends(fluid)
            found["box"] = 1 / _mean([ends[axis][1] - ends[axis][0] for axis in axes])
        if fine:
            found["ratio"] = fine.ratio
            found["fine_box"] = 1 / _mean([end[1] - end[0] for end in (fine.x, fine.y, fine.z) if end])
    return found


def triangles_along(scene: Scene) -> int | None:
    """Return the key `along` of a generated mesh of a wing."""
    mesh: Any = scene.wing.mesh.document() if scene.wing else {}
    return next((part["along"] for part in mesh.values() if isinstance(part, dict) and "along" in part), None)


def free_axes(scene: Scene) -> list[int]:
    """Return the axes along which the box may be longer: those without walls and without a body through the box."""
    fluid = scene.fluid
    if fluid is None or not _is_solid(scene):
        return []
    walls = [getattr(fluid.channel, axis) if fluid.channel else None for axis in "xyz"]
    shapes = [body.shape.circular_cylinder for body in fluid.bodies if isinstance(body.shape, ShapeCircularCylinder)]
    through = {cylinder.axis for cylinder in shapes if cylinder.length is None}
    return [axis for axis in range(len(fluid.box.cells)) if walls[axis] is None and "xyz"[axis] not in through]


def _is_solid(scene: Scene) -> bool:
    """Return whether anything stands in the fluid."""
    fluid = scene.fluid
    return bool(fluid and (fluid.cylinders or fluid.bodies or beams(scene) or wings(scene)))


def _mean(values: Sequence[float]) -> float:
    """Return the geometric mean."""
    return math.exp(sum(map(math.log, values)) / len(values))
