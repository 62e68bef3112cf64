"""Warnings of a run about the places of bodies, rods and wings; the rules stand in `crates/scene` (`monitor.rs`)."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from nervure import library
from nervure.scene import text, wings
from nervure.scene.facts import Facts
from nervure.scene.solids import pose_names
from nervure.units.fmu import Unit

NUMBER = re.compile(r"-?\d[\d.]*(e[-+]?\d+)?")
MOST_ALIKE = 3  # Warnings of one kind that are all shown
Reader = Callable[[], np.ndarray]


class Places:
    """Checks the places of the parts of a run now and then, and warns of each thing once."""

    def __init__(self, facts: Facts, units: Mapping[str, Unit]):
        self.monitor, fluid = library.monitor(text(facts.scene)), units.get("fluid")
        self.bodies: list[Reader | None] = []
        if part := facts.scene.fluid:
            for k, body in enumerate(part.bodies, 1):
                names = [f"body[{k}].{name}" for name in pose_names(part, body)]
                self.bodies.append(_reader(fluid, names) if body.mount or body.motion == "master" else None)
        rods = [units.get(own.unit) for own in facts.beams]
        self.beams = [_reader(rod, ["x", "y", "z"]) or _reader(rod, ["x", "y"]) for rod in rods]
        self.wings = [_reader(units.get(name), ["x", "y", "z"]) for name in wings(facts.scene)]
        self.memory: dict[str, Any] | None = None
        """What the library has to know of earlier times: where parts were at the first time, and what it warned of."""

    def check(self, t: float) -> Iterator[str]:
        """Yield the new warnings at `t` (s)."""
        places = {
            "time": t,
            "bodies": [pose and pose()[0].tolist() for pose in self.bodies],
            "beams": [stations and stations().tolist() for stations in self.beams],
            "wings": [nodes and nodes().tolist() for nodes in self.wings],
            "memory": self.memory,
        }
        answer = self.monitor(places)
        self.memory = answer["memory"]
        yield from counted(answer["warnings"])


def counted(warnings: Iterable[str]) -> Iterator[str]:
    """Yield warnings; of more than `MOST_ALIKE` that differ in numbers alone the first, with the number of the rest."""
    kinds: dict[str, list[str]] = {}
    for sentence in warnings:
        kinds.setdefault(NUMBER.sub("", sentence), []).append(sentence)
    for alike in kinds.values():
        if len(alike) > MOST_ALIKE:
            yield f"{alike[0]} (and {len(alike) - 1} more like it)"
        else:
            yield from alike


def _reader(unit: Unit | None, names: list[str]) -> Reader | None:
    """Return the function that reads variables of a unit; None where it has none of these names."""
    return unit.reader(names) if unit and unit.variables.keys() >= {*names} else None
