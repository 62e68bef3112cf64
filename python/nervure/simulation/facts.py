"""Everything that follows from a scene before it runs."""

import math
from dataclasses import dataclass

from nervure.evaluate import dimensionless
from nervure.evaluate.dimensionless import Dimensionless
from nervure.scene import Own, Scene, beams

STEP_ROUNDING = 1e-9
"""Part of a step by which the end time may exceed a whole number of steps without one more step."""


@dataclass(frozen=True)
class TimeGrid:
    """Communication points i · H for i = 0 … steps - 1, and the end time, s; the last step may be shorter."""

    end: float
    communication_step: float

    @property
    def steps(self) -> int:
        """Number of communication steps."""
        return max(1, math.ceil(self.end / self.communication_step - STEP_ROUNDING))

    def step(self, i: int) -> tuple[float, float]:
        """Return the time at the beginning of step `i` and the length of the step, s."""
        t = i * self.communication_step
        return t, self.end - t if i == self.steps - 1 else self.communication_step


@dataclass(frozen=True)
class Facts:
    """A scene and everything that follows from it, computed once and handed on."""

    scene: Scene
    beams: list[Own]
    numbers: Dimensionless | None  # None without a fluid
    grid: TimeGrid

    @classmethod
    def of(cls, scene: Scene) -> "Facts":
        """Return the facts of a scene."""
        grid = TimeGrid(scene.time.end, scene.time.communication_step)
        return cls(scene, beams(scene), dimensionless.evaluate(scene), grid)
