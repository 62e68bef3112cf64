"""Guards of an explicit run: what is unstable may stay finite, but shows in the powers across the interface."""

from nervure.errors import InputError
from nervure.scene.types import Guards
from nervure.units.fmu import Unit


class CouplingError(InputError):
    """The units do not fit each other, or the iteration between them did not converge."""


def takes_momentum(rod: Unit) -> bool:
    """Whether `rod` takes the momentum load, which comes with an impedance."""
    impedance = rod.variables.get("impedance")
    return impedance is not None and impedance.causality == "input"


def watched(rod: Unit, beam: str) -> tuple[list[str], list[str]]:
    """The outputs of `rod` and of the fluid that a watch needs in every step; there the names begin with `beam`."""
    return ["load.power"], [f"{beam}power"] if takes_momentum(rod) else []


class Watch:
    """Stops a run whose two sides have come apart, or whose load is noise.

    Under the momentum load the powers that the rod takes and that the fluid gives are compared. Under the pressure jump
    they are not the same: it lacks the fluid inside the mask and the viscous traction. There it is the second
    difference of what the rod takes that counts.
    """

    def __init__(self, guards: Guards, rod: Unit, fluid: Unit, beam: str = "beam", parallel: bool = False):
        self.guards, self.rod, self.fluid, self.parallel = guards, rod, fluid, parallel
        self.momentum = takes_momentum(rod)
        self.took = _place(rod, "load.power")
        self.gave = _place(fluid, f"{beam}.power") if self.momentum else 0
        self.balance = [0.0] * 5
        """Steps, fading sums of the magnitudes of what is watched and of what went across, W, and the rod's last two
        powers."""

    def check(self, t: float, h: float) -> None:
        """Take up the powers at `t`, after a step of `h` (s); raises `CouplingError` where a guard says so."""
        window = self.guards.window_steps
        took = self.rod.outputs.item(self.took)
        steps, watched, crossed, last, last_but_one = self.balance
        gave = self.fluid.outputs.item(self.gave) if self.momentum else took
        watched += (abs(took - gave) if self.momentum else abs(took - 2 * last + last_but_one)) - watched / window
        crossed += abs(gave) - crossed / window
        self.balance = [steps + 1, watched, crossed, took, last]
        if steps >= window and (reason := self.reason(watched, crossed, crossed / window)):
            raise CouplingError(
                f"the coupling is unstable at t = {t:g} s: over the last {window} steps {reason}; {self.remedy(h)} "
                "(the limits are in `coupling.guards`)"
            )

    def remedy(self, h: float) -> str:
        """What helps in this scene, whose step is `h` (s)."""
        if self.momentum and self.parallel:
            return "take the scheme explicit: in parallel the fluid sees the rod a step late"
        if self.momentum:
            segments = self.rod.variables["x"].size - 1
            return f"take fewer `beam.segments` than {segments}: close stations feel each other's load a step late"
        return f"leave `coupling.scheme` out, which iterates, or take a `time.communication_step` shorter than {h:g} s"

    def reason(self, watched: float, crossed: float, power: float) -> str | None:
        """What is wrong with the sums of what is watched and of what went across, whose mean is `power` (W); None if
        nothing is."""
        imbalance, noise = self.guards.largest_imbalance, self.guards.largest_noise
        if self.momentum and imbalance is not None and watched > imbalance * crossed:
            share = f"{watched / crossed:.0%}" if crossed else "all"
            return (
                f"the power that the {self.rod.name} took and that the fluid gave differ by {share} of what went across"
            )
        if not self.momentum and noise is not None and watched > noise * crossed and power > self.guards.min_power:
            noisy = f"{watched / crossed:.2g} of it from step to step"
            return f"the power that the {self.rod.name} took is noise, {noisy}"
        return None


def _place(unit: Unit, name: str) -> int:
    """Where the outputs of `unit` have the power `name`."""
    place = unit.slices.get(name)
    if place is None:
        raise CouplingError(
            f"the guards of `coupling.guards` need the output `{name}`, which the {unit.name} does not have"
        )
    return int(place.start)
