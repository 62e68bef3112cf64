"""Guards of a run: an unstable coupling may stay finite, but the powers across the interface show it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from nervure.errors import InputError
from nervure.scene.types import Guards
from nervure.units.fmu import Unit

SEGMENT = 0.25
"""Least length of a segment, in thicknesses: closer stations feel each other's load a step late."""

WARN_RATIO = 0.1
"""Difference of the powers on the rod and from the fluid, by the exchanged power, above which the run warns. FSI3 has
0.05."""

GROWN = 1.5
"""Growth of that difference from which on the run warns again."""

PENALIZED = 2.0
"""Longest step by C_eta under the pressure jump without iteration, for rods lighter than the added mass: of one with
0.3 of the density of the fluid, 2 holds and 5 does not."""

SOON, RECENT = 40, 0.25
"""Least steps of a window that is judged before its end, and the part of the first one that its own sums look back."""

LONGEST = "longest_step"
"""Output of a fluid: the longest step for which the loads that it announces hold, s."""

ROUNDING = 1e-9
"""Relative tolerance of a step."""

BLOCK = 64
"""Steps whose velocities are evaluated together."""

REST = 1e-12
"""Way of a station in a step, by the largest coordinate, below which a body rests: what it exchanges is rounding."""

MARGIN = 1.25
"""Part by which an advised step is shorter than the longest one by the speed of the stations so far."""


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

    cells: tuple[int, ...]
    cell: tuple[float, ...]  # Lengths of a cell, m
    max_cfl: float
    c_eta: float  # s
    max_step: float  # s
    thickness: float  # m
    line: bool
    fluid_steps: int  # Steps of the fluid in a communication step, by `max_step` and the stream
    cfl: float = 0.0  # CFL number of a step by the stream


class Balance(NamedTuple):
    """Powers that a guard has seen. A fading sum loses a part of one over the window in each step."""

    steps: float = 0.0
    difference: float = 0.0  # Fading sum of the magnitudes of the difference, W
    exchanged: float = 0.0  # Fading sum of the magnitudes of the exchanged power, W
    on_rod: float = 0.0  # Power of the last step, W
    on_rod_before: float = 0.0  # Power of the step before, W
    rate: float = 0.0  # Most cells that a station has passed in a second, 1/s
    own_difference: float = 0.0  # Sums since the last multiple of the window, W, which in the first one fade
    own_exchanged: float = 0.0


class Speeds:
    """Velocities of stations, evaluated after many steps: NumPy takes as long for a step as for a block of them."""

    def __init__(self, outputs: np.ndarray, places: list[slice], cell: Sequence[float]):
        begin, self.cell = min(place.start for place in places), cell
        self.given = outputs[begin : max(place.stop for place in places)]
        self.places = [slice(place.start - begin, place.stop - begin) for place in places]
        self.kept, self.count = np.empty((BLOCK, self.given.size)), 0

    def keep(self) -> bool:
        """Keep the velocities of a step; return whether the block is full."""
        self.kept[self.count] = self.given
        self.count += 1
        return self.count == BLOCK

    def largest(self) -> float:
        """Return how many cells a station has passed in a second at most since the last call, 1/s."""
        kept, self.count = self.kept[: self.count], 0
        passed = (np.abs(kept[:, place]) / length for place, length in zip(self.places, self.cell, strict=True))
        return float(sum(passed).max(initial=0.0))  # type: ignore[union-attr]


class EnergyGuard:
    """Stops a run whose coupling is unstable: the powers across the interface disagree, or they are noise.

    Under the momentum load the power on the rod is compared with the power from the fluid. Under the pressure jump the
    two differ by the fluid inside the mask and the viscous traction, so the second difference of the power on the rod
    is compared instead.
    """

    def __init__(self, guards: Guards, rod: Unit, fluid: Unit, beam: str = "beam", parallel: bool = False):
        self.guards, self.rod, self.fluid, self.parallel = guards, rod, fluid, parallel
        self.is_beam = not beam.startswith("wing")
        number = beam.removeprefix("beam[").removesuffix("]")  # Of several rods, from 1
        self.segments = f"rods[{int(number) - 1}].beam.segments" if number.isdecimal() else "beam.segments"
        self.momentum = takes_momentum(rod)
        self.power_on_rod = _index(rod, "load.power")
        self.power_from_fluid = _index(fluid, f"{beam}.power") if self.momentum else 0
        self.limits: Limits | None = None
        """Numbers of the scene from which advice is computed; None where they are not known."""
        self.warned = 0.0  # Largest difference of which the run has warned, by the exchanged power
        self._sums = [*Balance()]  # A step changes a list faster than it makes a tuple

    @property
    def balance(self) -> Balance:
        """What the guard has seen so far."""
        self._evaluate_speeds()
        return Balance(*self._sums)

    @balance.setter
    def balance(self, balance: Balance) -> None:
        self._sums = [*balance]

    def check(self, t: float, h: float) -> None:
        """Add the powers at `t`, after a step of `h` (s); raise `CouplingError` where a limit is exceeded."""
        window = self.guards.window_steps
        on_rod = self.rod.outputs.item(self.power_on_rod)
        steps, difference, exchanged, last, last_but_one, rate, own_difference, own_exchanged = self._sums
        if steps % window == 0:
            own_difference = own_exchanged = 0.0
        elif steps < window:  # A violent start is forgotten
            recent = max(RECENT * steps, 1.0)
            own_difference -= own_difference / recent
            own_exchanged -= own_exchanged / recent
        from_fluid = self.fluid.outputs.item(self.power_from_fluid) if self.momentum else on_rod
        deviation = abs(on_rod - from_fluid) if self.momentum else abs(on_rod - 2 * last + last_but_one)
        difference += deviation - difference / window
        exchanged += abs(from_fluid) - exchanged / window
        own_difference += deviation
        own_exchanged += abs(from_fluid)
        self._sums = [steps + 1, difference, exchanged, on_rod, last, rate, own_difference, own_exchanged]
        if self._speeds and self._speeds.keep():
            self._evaluate_speeds()
        if steps < window or not (reason := self.reason(difference, exchanged, exchanged / window)):
            return
        if not self._rests(h):
            raise CouplingError(
                f"the coupling is unstable at t = {t:g} s: over the last {window} steps {reason}{self._then(h)} "
                "(the limits are in `coupling.guards`)"
            )

    def warn(self, t: float, h: float, at_end: bool = False) -> Iterator[str]:
        """Yield, at `t` (s) with a step of `h` (s), that the powers of the momentum load differ in a run that goes on,
        or at its end, and again when the difference has grown by half."""
        window, steps = self.guards.window_steps, int(self.balance.steps)
        if self.guards.largest_imbalance is None or not self.momentum or self._rests(h):
            return
        last = (steps - 1) % window + 1 if steps else 0  # Steps since the end of a window, or in the whole one
        fading = (window, self.balance.difference, self.balance.exchanged)
        own = (last if steps > window else round(RECENT * steps), *self.balance[-2:])
        judged = [fading] if steps >= window else []
        # The last quarter of a short run is too few steps to judge by alone.
        if last == window or (at_end and last >= SOON and (steps > window or self._exceeds(*fading[1:]))):
            judged.append(own)
        for count, difference, exchanged in judged:
            if self._exceeds(difference, exchanged):
                self.warned = difference / exchanged
                yield (
                    f"over the last {count} steps to t = {t:.4g} s {self._differ(difference, exchanged)}{self._then(h)}"
                )
                return

    def _exceeds(self, difference: float, exchanged: float) -> bool:
        """Return whether the run warns of these sums."""
        return difference > max(WARN_RATIO, GROWN * self.warned) * exchanged > 0.0

    def _rests(self, h: float) -> bool:
        """Return whether no station moved in the last step of `h` (s) by more than the rounding of its place."""

        def largest(names: Sequence[str]) -> float:
            slices = [self.rod.slices[name] for name in names if name in self.rod.slices]
            return max((float(np.abs(self.rod.outputs[place]).max()) for place in slices), default=0.0)

        return h * largest(["vx", "vy", "vz"]) < REST * largest(["x", "y", "z"])

    def _then(self, h: float) -> str:
        advice = self.advice(h)
        return f"; {advice}" if advice else ""

    def advice(self, h: float) -> str:
        """Return advice for this scene, whose step is `h` (s); empty where none was tried."""
        if self.momentum and self.parallel:
            return "take the scheme explicit: in parallel the fluid sees the rod a step late"
        if self.momentum:
            divided = self._divided(h)
            if not self.is_beam:
                return divided or ""
            if self.limits and self.limits.line:
                finer = self._finer(h, self.limits)
                return f"{divided}; if that is not enough, {finer}" if divided else finer
            return divided or self._too_close() or ""
        shorter = f"of {below(h / 2)} s"
        if self.limits and h > self.limits.max_step * (1 + ROUNDING):
            shorter = f"of {below(self.limits.max_step)} s, a step of the fluid"
        elif self.limits and h > (longest := PENALIZED * self.limits.c_eta) * (1 + ROUNDING):
            shorter = f"of {below(longest)} s, {PENALIZED:g} C_eta"
        return f"leave `coupling.scheme` out, which iterates, or take a `time.communication_step` {shorter}"

    def _finer(self, h: float, limits: Limits) -> str:
        """Return advice for a line: cells of half the length, and segments as long, resolve its short waves."""
        parts = [f"`fluid.box.cells` of {[2 * count for count in limits.cells]}"]
        stations = self._stations()
        needed = round(2 * np.linalg.norm(np.diff(stations), axis=0).sum() / min(limits.cell))
        if stations.shape[1] - 1 < needed:
            parts.append(f"`{self.segments}` of {needed}")
        if (ratio := 2 * limits.cfl / limits.max_cfl) > 1.0:
            parts.append(f"a `time.communication_step` of {below(h / ratio)} s")
        *front, last = parts
        return f"take {', '.join(front)} and {last}" if front else f"take {last}"

    def _stations(self) -> np.ndarray:
        """Return the positions of the stations of a beam, m: `[dimension, stations]`."""
        names = ["x", "y", "z"][: len(self.limits.cell) if self.limits else 2]
        return np.array([self.rod.outputs[self.rod.slices[name]] for name in names])

    def _evaluate_speeds(self) -> None:
        """Take the speeds that are kept into the balance."""
        if self._speeds and self._speeds.count:
            rate = Balance._fields.index("rate")
            self._sums[rate] = max(self._speeds.largest(), self._sums[rate])

    @cached_property
    def _speeds(self) -> Speeds | None:
        """The velocities of the stations so far; None where no advice needs them."""
        names = ["vx", "vy", "vz"][: len(self.limits.cell)] if self.limits else []
        if LONGEST in self.fluid.variables:
            return None
        if not (self.momentum and self.limits and {*names} <= self.rod.slices.keys()):
            return None
        return Speeds(self.rod.outputs, [self.rod.slices[name] for name in names], self.limits.cell)

    def _divided(self, h: float) -> str | None:
        """Return advice where the fluid must divide a step of `h` (s), and does not tell the coupling so."""
        if self.limits is None or LONGEST in self.fluid.variables:
            return None
        cells = h * self.balance.rate
        by_beam, by_fluid = cells / self.limits.max_cfl, self.limits.fluid_steps
        if max(by_beam, by_fluid) <= 1.0:
            return None
        by_beam *= MARGIN
        body = "beam" if self.is_beam else "wing"
        cause = (
            f"the {body} passes up to {cells:.2g} cells in a step, and a step of the fluid has {self.limits.max_cfl:g}"
            if by_beam > by_fluid
            else f"the fluid makes some {by_fluid} steps in one"
        )
        return (
            f"take a `time.communication_step` of {below(h / max(by_beam, by_fluid))} s: {cause}, but the momentum "
            "load holds for one step of the fluid"
        )

    def _too_close(self) -> str | None:
        """Return advice where the stations are close."""
        x, y = (self.rod.variables[name].size for name in ("x", "y"))
        segments = min(x, y) - 1
        if self.limits is None:
            return f"take fewer `{self.segments}` than {segments}: close stations feel each other's load a step late"
        length = float(np.linalg.norm(np.diff(self._stations()), axis=0).sum())
        most = int(length / (SEGMENT * self.limits.thickness))
        if segments <= max(most, 1):
            return None
        return (
            f"take at most {most} `{self.segments}` in place of {segments}: stations closer than {SEGMENT:g} "
            "thicknesses feel each other's load a step late"
        )

    def reason(self, difference: float, exchanged: float, power: float) -> str | None:
        """Return what exceeds a limit in the sums of the difference and of the exchanged power, whose mean is `power`
        (W); None where nothing does."""
        imbalance, noise = self.guards.largest_imbalance, self.guards.largest_noise
        if self.momentum and imbalance is not None and difference > imbalance * exchanged:
            return self._differ(difference, exchanged)
        if not self.momentum and noise is not None and difference > noise * exchanged and power > self.guards.min_power:
            return f"the power on the {self.rod.name} is noise, {difference / exchanged:.2g} of it from step to step"
        return None

    def _differ(self, difference: float, exchanged: float) -> str:
        share = f"{difference / exchanged:.0%}" if exchanged else "all"
        both = f"the power on the {self.rod.name} and the power from the {self.fluid.name}"
        return f"{both} differ by {share} of the exchanged power"


def _index(unit: Unit, name: str) -> int:
    """Return the index of the power `name` in the outputs of `unit`."""
    place = unit.slices.get(name)
    if place is None:
        raise CouplingError(
            f"the guards of `coupling.guards` need the output `{name}`, which the {unit.name} does not have"
        )
    return int(place.start)


def below(value: float) -> str:
    """Return a number of one digit that is not above `value`."""
    unit = 10.0 ** np.floor(np.log10(value))
    return f"{np.floor(value / unit * (1 + 1e-9)) * unit:.1g}"
