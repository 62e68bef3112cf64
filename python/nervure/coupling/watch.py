"""Guards of an explicit run: what is unstable may well stay finite, but shows in the powers that cross the interface."""

from nervure.errors import Refusal
from nervure.scene.types import Guards
from nervure.unit import Unit


class CouplingError(Refusal):
    """The units do not fit each other, or the iteration between them did not converge."""


def takes_momentum(rod: Unit) -> bool:
    """Whether `rod` takes the momentum load, which comes with an impedance."""
    impedance = rod.variables.get("impedance")
    return impedance is not None and impedance.causality == "input"


class Watch:
    """Stops a run whose two sides have come apart, or whose load is noise.

    Under the momentum load the powers that the rod takes and that the fluid gives are compared. Under the pressure jump they
    are not the same: it lacks the fluid inside the mask and the viscous traction. There it is the second difference of what the rod
    takes that counts.
    """

    def __init__(self, guards: Guards, rod: Unit, fluid: Unit):
        self.guards, self.rod, self.fluid = guards, rod, fluid
        self.momentum = takes_momentum(rod)
        self.took = _place(rod, "load.power")
        self.gave = _place(fluid, "beam.power") if self.momentum else 0
        self.balance = [0.0] * 5
        """Steps, fading sums of the magnitudes of what is watched and of what went across, W, and the rod's last two powers."""

    def check(self, t: float) -> None:
        """Take up the powers at `t` (s); raises `CouplingError` where a guard says so."""
        window = self.guards.window_steps
        took = self.rod.outputs.item(self.took)
        steps, watched, crossed, last, last_but_one = self.balance
        gave = self.fluid.outputs.item(self.gave) if self.momentum else took
        watched += (abs(took - gave) if self.momentum else abs(took - 2 * last + last_but_one)) - watched / window
        crossed += abs(gave) - crossed / window
        self.balance = [steps + 1, watched, crossed, took, last]
        if steps < window:
            return
        imbalance, noise = self.guards.largest_imbalance, self.guards.largest_noise
        if self.momentum and imbalance is not None and watched > imbalance * crossed:
            reason = f"the power that the rod took and that the fluid gave differ by {watched / crossed:.0%} of what went across"
        elif not self.momentum and noise is not None and watched > noise * crossed > noise * self.guards.quiet_power * window:
            reason = f"the power that the rod took is noise, {watched / crossed:.2g} of it from step to step; iterate, or take shorter steps"
        else:
            return
        raise CouplingError(
            f"the coupling is unstable at t = {t:g} s: over the last {window} steps {reason} (`coupling.guards` has the limits)"
        )


def _place(unit: Unit, name: str) -> int:
    """Where the outputs of `unit` have the power `name`."""
    place = unit.slices.get(name)
    if place is None:
        raise CouplingError(f"the guards of `coupling.guards` need the output `{name}`, which the {unit.name} does not have")
    return int(place.start)
