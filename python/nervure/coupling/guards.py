"""Guards of a run: an unstable coupling may stay finite, but the powers across the interface show it; and a rod may go
where no fluid is."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nervure.errors import InputError
from nervure.scene.types import Fluid, Guards
from nervure.units.fmu import Unit

SEGMENT = 0.25
"""Least length of a segment, in thicknesses: closer stations feel each other's load a step late."""

PENALIZED = 2.0
"""Longest step under the pressure jump without iteration, by C_eta + dt (`docs/theory/coupling.md`)."""

STRETCHED = 1.5
"""Length of a rod by that at rest, or at rest by that, above which it is told of."""


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


@dataclass(frozen=True)
class Limits:
    """What decides on the stability of an explicit exchange: the numbers of the fluid and of one beam."""

    cell: tuple[float, float]  # Lengths of a cell, m
    max_cfl: float
    c_eta: float  # s
    max_step: float  # s
    thickness: float  # m


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
        self.limits: Limits | None = None
        """Numbers of the scene from which advice is computed; None where they are not known."""
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
            return self._divided(h) or self._too_close() or f"take a `time.communication_step` of {_below(h / 2)} s"
        shorter = f"shorter than {h:g} s"
        if self.limits and h > (longest := PENALIZED * (self.limits.c_eta + min(self.limits.max_step, h))):
            shorter = f"of {_below(longest)} s, {PENALIZED:g} (C_eta + dt)"
        return f"leave `coupling.scheme` out, which iterates, or take a `time.communication_step` {shorter}"

    def _divided(self, h: float) -> str | None:
        """Return advice where the beam is so fast that the fluid must divide a step of `h` (s)."""
        if not (self.limits and {"vx", "vy"} <= self.rod.slices.keys()):
            return None
        rates = (
            np.abs(self.rod.outputs[self.rod.slices[name]]) / cell
            for name, cell in zip(("vx", "vy"), self.limits.cell, strict=True)
        )
        cells = h * float(sum(rates).max())
        if cells <= self.limits.max_cfl:
            return None
        return (
            f"take a `time.communication_step` of {_below(h * self.limits.max_cfl / cells)} s: the beam passes "
            f"{cells:.2g} cells in a step, so that the fluid divides it, and the momentum load holds for one step of "
            f"the fluid, up to {self.limits.max_cfl:g} cells"
        )

    def _too_close(self) -> str | None:
        """Return advice where the stations are close."""
        x, y = (self.rod.variables[name].size for name in ("x", "y"))
        segments = min(x, y) - 1
        if self.limits is None:
            return f"take fewer `beam.segments` than {segments}: close stations feel each other's load a step late"
        places = [self.rod.outputs[self.rod.slices[name]] for name in ("x", "y")]
        length = float(np.hypot(*np.diff(places)).sum())
        most = int(length / (SEGMENT * self.limits.thickness))
        if segments <= most:
            return None
        return (
            f"take at most {most} `beam.segments` in place of {segments}: stations closer than {SEGMENT:g} thicknesses "
            "feel each other's load a step late"
        )

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


def _below(value: float) -> str:
    """Return a number of one digit that is not above `value`."""
    unit = 10.0 ** np.floor(np.log10(value))
    return f"{np.floor(value / unit * (1 + 1e-9)) * unit:.1g}"


class RodWatch:
    """Looks at the stations of a rod now and then: a rod that leaves the box, meets a wall or changes its length beyond
    reason is told of once."""

    def __init__(self, unit: Unit, name: str, length: float, thickness: float, fluid: Fluid | None):
        self.unit, self.name, self.length, self.thickness = unit, name, length, thickness
        self.axes = [axis for axis in "xyz" if axis in unit.variables]
        self.bounds = {"x": fluid.box.x, "y": fluid.box.y} if fluid else {}
        self.channel = fluid.channel.y if fluid and fluid.channel else None
        self.told: set[str] = set()
        self.in_wall: float | None = None
        """How far the rod reached into a wall at the start, m: a root may be embedded."""

    def look(self, t: float) -> Iterator[str]:
        """Yield what is to be told of the stations at `t` (s)."""
        places = {axis: self.unit.read(axis) for axis in self.axes}
        for axis, bounds in self.bounds.items():
            if (over := _beyond(places[axis], bounds)) > 0.0:
                text = f"reaches {over:.2g} m over the edge of the box along {axis} and comes in at the other side"
                yield from self._tell("edge", text, t)
        if self.channel:
            reached = _beyond(places["y"], self.channel)
            self.in_wall = reached if self.in_wall is None else self.in_wall
            if reached > self.in_wall + self.thickness / 2:
                yield from self._tell("wall", f"reaches {reached:.2g} m into a wall of the channel", t)
        ratio = float(np.sqrt(sum(np.diff(values) ** 2 for values in places.values())).sum()) / self.length
        if not 1 / STRETCHED < ratio < STRETCHED:
            text = f"is {ratio:.2g} times as long as at rest: its axial stiffness is small for its loads"
            yield from self._tell("length", text, t)

    def _tell(self, what: str, text: str, t: float) -> Iterator[str]:
        if what not in self.told:
            self.told.add(what)
            yield f"the {self.name} {text} by t = {t:.4g} s"


def _beyond(values: np.ndarray, bounds: tuple[float, float]) -> float:
    """Return how far values lie outside of bounds."""
    return max(0.0, bounds[0] - float(values.min()), float(values.max()) - bounds[1])
