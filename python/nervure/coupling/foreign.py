"""Checks of units from elsewhere, which may claim what they do not do."""

import numpy as np

from nervure.coupling.guards import CouplingError
from nervure.errors import UnitFailure
from nervure.units.fmu import Unit

REPEATS = 3  # Steps that each unit repeats before it is trusted
REPEAT_TOLERANCE, ROUNDING = 1e-6, 1e-12  # Difference of a repeated step, relative to the change and to the values
FARTHEST = 10.0  # Largest way of a station in a step, and largest distance of two neighbours, in lengths of the beam


class StationWatch:
    """Refuses places of a rod's stations that no beam can have."""

    def __init__(self, rod: Unit):
        self.rod = rod
        self.last = self._places()
        self.length = float(np.linalg.norm(np.diff(self.last, axis=1), axis=0).sum())

    def _places(self) -> np.ndarray:
        return np.array([self.rod.outputs[self.rod.slices[axis]] for axis in "xyz" if axis in self.rod.slices])

    def check(self, t: float) -> None:
        """Raise `UnitFailure` where a station at `t` (s) is too far from its last place or from its neighbour."""
        places = self._places()
        ways = np.linalg.norm(places - self.last, axis=0)
        gaps = np.linalg.norm(np.diff(places, axis=1, prepend=places[:, :1]), axis=0)
        worst = int(np.argmax(np.maximum(ways, gaps)))
        if max(ways[worst], gaps[worst]) > FARTHEST * self.length:
            here = ", ".join(f"{place:g}" for place in places[:, worst])
            raise UnitFailure(
                f"{self.rod.name}: its station {worst + 1} is at ({here}) m at t = {t:g} s, {ways[worst]:.3g} m from "
                f"its last place, though the beam is {self.length:.3g} m long"
            )
        self.last = places


class RepeatedSteps:
    """Tests whether units that claim to roll back do so: each repeats its first steps that change something."""

    def __init__(self, units: list[Unit]):
        self.left = dict.fromkeys(range(len(units)), REPEATS)
        self.units = units

    def test(self, t: float, h: float) -> None:
        """Make the step from `t` to `t + h` (s) twice from the saved states, and return to them; raise `CouplingError`
        where the second differs from the first."""
        for number in [number for number, left in self.left.items() if left]:
            unit = self.units[number]
            before, made = unit.outputs.copy(), []
            for _ in range(2):
                unit.step(t, h)
                made.append(unit.exchanged.copy())
                unit.restore()
            unit.outputs[:] = before
            first, second = made
            change, apart = (float(np.linalg.norm(d)) for d in (first - before[: first.size], second - first))
            if apart > REPEAT_TOLERANCE * change + ROUNDING * float(np.linalg.norm(first)):
                share = f"{apart / change:.2g} of their change" if change else f"{apart:.2g}"
                raise CouplingError(
                    f"the scheme repeats steps, but the {unit.name} does not come back to the state that it "
                    f"saved: the step from t = {t:g} s to {t + h:g} s, repeated, gives outputs that differ by {share}; "
                    "fmi2GetFMUstate must save everything that a step changes"
                )
            self.left[number] -= change > ROUNDING * float(np.linalg.norm(first))
