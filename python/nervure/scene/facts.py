"""Facts of a scene from the units' libraries: the rules that give them stand in `crates/scene` alone."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from nervure import library
from nervure.errors import SceneError
from nervure.scene import Scene, beams, text


@dataclass(frozen=True)
class SceneFacts:
    """Facts of a scene; arrays along a beam are `[segments + 1]`, from root to tip."""

    thickness: dict[str, np.ndarray]  # Of each beam by the name of its force, m
    settles: dict[str, tuple[float, float]]  # By key: time from which a law of the flow is constant, s, and its value
    dimensionless: dict[str, Any] | None  # Fields of `evaluate.dimensionless.Dimensionless`; None without a fluid
    fluid_steps: int  # Steps that the fluid is expected to make in a communication step

    def final_value(self, key: str, by: float = np.inf) -> float | None:
        """Return the value that the law `key` keeps from the time `by` (s) on; None if it still changes then."""
        time, value = self.settles.get(key, (np.inf, 0.0))
        return value if key in self.settles and time <= by else None


def scene_facts(scene: Scene) -> SceneFacts:
    """Return the facts of `scene`; raises `SceneError` with its faults where it has some."""
    forces = tuple(own.force for own in beams(scene))
    return _facts(text(scene), forces)


@lru_cache(maxsize=8)
def _facts(scene: str, forces: tuple[str, ...]) -> SceneFacts:
    found = library.facts(scene)
    if found is None:
        faults = library.check(scene)
        raise SceneError("\n".join(fault.text for fault in faults), faults)
    each = zip(forces, found["beams"], strict=True)
    return SceneFacts(
        thickness={force: np.array(beam["thickness"]) for force, beam in each},
        settles={key: tuple(law["settles"]) for key, law in found["laws"].items() if law["settles"]},
        dimensionless=found["dimensionless"],
        fluid_steps=found["fluid_steps"],
    )
