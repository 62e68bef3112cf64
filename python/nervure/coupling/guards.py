"""Guards of an explicit run: an unstable coupling may stay finite, but the powers across the interface show it."""

from nervure.errors import InputError
from nervure.scene.types import Guards
from nervure.units.fmu import Unit


class CouplingError(InputError):
    """Units do not fit each other, or the coupling between them is unstable or does not converge."""


def takes_momentum(rod: Unit) -> bool:
    """Return whether `rod` takes the momentum load, which comes with an impedance."""
    impedance = rod.variables.get("impedance")
    return impedance is not None and impedance.causality == "input"


def guarded_outputs(rod: Unit, beam: str) -> tuple[list[str], list[str]]:
    """Return the outputs of `rod` and of the fluid that an `EnergyGuard` needs in every step; the fluid's names begin
    with `beam`."""
    return ["load.power"], [f"{beam}power"] if takes_momentum(rod) else []


class EnergyGuard:
    """Stops a run whose coupling is unstable: the powers across the interface disagree, or they are noise.

    Under the momentum load the power on the rod is compared with the power from the fluid. Under the pressure jump the
    two differ by the fluid inside the mask and the viscous traction, so the second difference of the power on the rod
    is compared instead.
    """

    def __init__(self, guards: Guards, rod: Unit, fluid: Unit, beam: str = "beam", parallel: bool = False):
        self.guards, self.rod, self.fluid, self.parallel = guards, rod, fluid, parallel
        self.momentum = takes_momentum(rod)
        self.power_on_rod = _index(rod, "load.power")
        self.power_from_fluid = _index(fluid, f"{beam}.power") if self.momentum else 0
        self.balance = [0.0] * 5
        """Steps, fading sums of the magnitudes of the difference and of the exchanged power, W, and the last two powers
        on the rod."""

    def check(self, t: float, h: float) -> None:
        """Add the powers at `t`, after a step of `h` (s); raise `CouplingError` where a limit is exceeded."""
        window = self.guards.window_steps
        on_rod = self.rod.outputs.item(self.power_on_rod)
        steps, difference, exchanged, last, last_but_one = self.balance
        from_fluid = self.fluid.outputs.item(self.power_from_fluid) if self.momentum else on_rod
        deviation = abs(on_rod - from_fluid) if self.momentum else abs(on_rod - 2 * last + last_but_one)
        difference += deviation - difference / window
        exchanged += abs(from_fluid) - exchanged / window
        self.balance = [steps + 1, difference, exchanged, on_rod, last]
        if steps >= window and (reason := self.reason(difference, exchanged, exchanged / window)):
            raise CouplingError(
                f"the coupling is unstable at t = {t:g} s: over the last {window} steps {reason}; {self.advice(h)} "
                "(the limits are in `coupling.guards`)"
            )

    def advice(self, h: float) -> str:
        """Return advice for this scene, whose step is `h` (s)."""
        if self.momentum and self.parallel:
            return "take the scheme explicit: in parallel the fluid sees the rod a step late"
        if self.momentum:
            segments = self.rod.variables["x"].size - 1
            return f"take fewer `beam.segments` than {segments}: close stations feel each other's load a step late"
        return f"leave `coupling.scheme` out, which iterates, or take a `time.communication_step` shorter than {h:g} s"

    def reason(self, difference: float, exchanged: float, power: float) -> str | None:
        """Return what exceeds a limit in the sums of the difference and of the exchanged power, whose mean is `power`
        (W); None where nothing does."""
        imbalance, noise = self.guards.largest_imbalance, self.guards.largest_noise
        if self.momentum and imbalance is not None and difference > imbalance * exchanged:
            share = f"{difference / exchanged:.0%}" if exchanged else "all"
            both = f"the power on the {self.rod.name} and the power from the fluid"
            return f"{both} differ by {share} of the exchanged power"
        if not self.momentum and noise is not None and difference > noise * exchanged and power > self.guards.min_power:
            return f"the power on the {self.rod.name} is noise, {difference / exchanged:.2g} of it from step to step"
        return None


def _index(unit: Unit, name: str) -> int:
    """Return the index of the power `name` in the outputs of `unit`."""
    place = unit.slices.get(name)
    if place is None:
        raise CouplingError(
            f"the guards of `coupling.guards` need the output `{name}`, which the {unit.name} does not have"
        )
    return int(place.start)
