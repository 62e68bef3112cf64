"""Errors to expect of a scene before any run: those of the recorded runs of shipped scenes that are nearest to it.

`prior.csv` has the runs with their errors against published values, by kind, Reynolds number, cells in the length of
the body, and mass ratio; `python -m studies coverage` writes it. The distance of two scenes is that of the logarithms.
"""

import csv
import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from nervure.scene import Scene, wings
from nervure.scene.facts import Facts
from nervure.scene.solids import cell_lengths
from nervure.scene.types import Body, BodyMotion, Cylinder, Motion, TimeLawConstant

FILE = Path(__file__).with_name("prior.csv")
NUMBERS = ("reynolds", "cells", "mass_ratio")
QUANTITIES = ("drag", "lift", "motion", "frequency")
NEAREST = 3  # Runs whose median counts
FARTHEST = math.log(8)  # Distance up to which a run says something
NONE = 1e-3  # In place of a number that a scene lacks, in distances


@dataclass(frozen=True)
class Likeness:
    """What makes two scenes alike."""

    kind: str  # still, moving or elastic, in the plane or in space
    numbers: tuple[float | None, ...]

    def distance(self, other: "Likeness") -> float:
        """Return the distance of two scenes of a kind."""
        if self.kind != other.kind:
            return math.inf
        pairs = zip(self.numbers, other.numbers, strict=True)
        return math.hypot(*(math.log((one or NONE) / (two or NONE)) for one, two in pairs))


def likeness(facts: Facts) -> Likeness | None:
    """Return what makes a scene like others; None without a fluid that something drives around a body."""
    scene, numbers = facts.scene, facts.numbers
    if scene.fluid is None or numbers is None or not (numbers.reynolds and numbers.length):
        return None
    ratio = scene.fluid.fine_box.ratio if scene.fluid.fine_box else 1
    cells = numbers.length * ratio / max(cell_lengths(scene.fluid))
    return Likeness(f"{kind(scene)} {len(scene.fluid.box.cells)}", (numbers.reynolds, cells, numbers.mass_ratio))


def kind(scene: Scene) -> str:
    """Return whether a scene bends, moves or is still."""
    if scene.rod or scene.rods or wings(scene):
        return "elastic"
    bodies: list[Cylinder | Body] = [*scene.fluid.cylinders, *scene.fluid.bodies] if scene.fluid else []
    return "moving" if any(map(_moves, bodies)) else "still"


def _moves(body: Cylinder | Body) -> bool:
    if isinstance(body, Body) and body.mount:
        return True
    laws = vars(body.motion) if isinstance(body.motion, Motion | BodyMotion) else {}
    return body.motion == "master" or any(
        name != "axis" and not isinstance(law, TimeLawConstant) for name, law in laws.items()
    )


@cache
def known() -> list[tuple[Likeness, str, dict[str, float]]]:
    """Return likeness, name and errors of the recorded runs."""
    with FILE.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return [
        (
            Likeness(row["kind"], tuple(float(row[name]) if row[name] else None for name in NUMBERS)),
            row["case"],
            {name: float(row[name]) for name in QUANTITIES if row[name]},
        )
        for row in rows
    ]


def expected(facts: Facts) -> str | None:
    """Return the errors to expect as a sentence, e.g. "expect some 12 % in lift, by …"; None where no run is like the
    scene."""
    if (own := likeness(facts)) is None:
        return None
    near = [(distance, name, errors) for like, name, errors in known() if (distance := own.distance(like)) <= FARTHEST]
    near.sort(key=lambda one: one[0])
    found, names = [], list[str]()
    for quantity in QUANTITIES:
        nearest = [(errors[quantity], name) for _, name, errors in near if quantity in errors][:NEAREST]
        if nearest:
            middle = sorted(error for error, _ in nearest)[len(nearest) // 2]
            found.append(f"{100 * middle:.2g} % in {quantity}")
            names.append(nearest[0][1])
    return f"expect some {', '.join(found)}, as in {', '.join(dict.fromkeys(names))}" if found else None
