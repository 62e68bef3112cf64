"""The drive of a run: a function that sets, step by step, the inputs that a scene leaves to the master.

A driven quantity y has the input of its value and, but for some, one of its rate v. A drive may set one of both:

    y alone:  v = d + (d - d') H / (H + H'),   d = (y - y') / H    the slope of the parabola through the last three y
    v alone:  y = y' + H (v' + v) / 2                              trapezoid

with the primes of the step before; before the start all is at rest. What a drive does not set stays where it is.
"""

import json
import math
import re
import runpy
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol, cast, runtime_checkable

import numpy as np

from nervure.arguments import shown
from nervure.coupling.guards import CouplingError
from nervure.errors import InputError
from nervure.scene import plain
from nervure.units.fmu import Unit

ROOT, BODY, HINGE = "root_motion", "fluid.bodies[k].motion", "flyer.hinges[k].motion"
BOX, GUST = "fluid.fine_box.follow", "fluid.gust"
"""Scene keys that leave something to the master: `root_motion` of a rod or a wing."""

DRIVEN: tuple[tuple[str, str, str | None], ...] = (
    (ROOT, r"root\.([xyz])", r"root.v\1"),
    (ROOT, r"root\.angle", r"root.omega"),
    (ROOT, r"root\.direction\.([xyz])", r"root.direction_rate.\1"),
    (BODY, r"(body\[\d+\]\.motion)\.([xyz])", r"\1.v\2"),
    (BODY, r"(body\[\d+\]\.motion)\.angle", r"\1.omega"),
    (HINGE, r"(\w+)\.(stroke|deviation|pitch)", r"\1.\2_rate"),
    (BODY, r"body\[\d+\]\.motion\.(angle|omega)_[xyz]", None),  # A rotation vector has another rate
    (BOX, r"fine_box\.motion\.[xyz]", None),
    (GUST, r"gust\.[xyz]", None),
)
"""Driven quantities: scene key, pattern of the input, and input of the rate; None where a drive sets all itself."""

MASTER = re.compile(r"root\.|gust\.|(body\[\d+\]|fine_box)\.motion\.")

NAME = "drive"  # Of the function in a file


class MissingDrive(InputError):
    """A scene leaves something to the master, and there is no drive: `left` says what."""

    def __init__(self, left: str):
        super().__init__(
            f"{left}, but nothing drives it: give laws of time, or a function as `drive` of `nervure.run`, or its file "
            "as `--drive` (docs/guide/drive.md)"
        )
        self.left = left


class Drive(Protocol):
    """A function of time that drives a run."""

    def __call__(self, time: float, values: Mapping[str, float], /) -> Mapping[str, float]:
        """Return values of driven inputs by name at `time` (s), the end of the coming step. `values` has the columns of
        the series at its beginning, `values["time"]`, and the inputs then."""


@runtime_checkable
class Memory(Protocol):
    """A drive that carries something from step to step, for checkpoints and for repeated episodes."""

    def state(self) -> Any:
        """Return what the next step depends on, as numbers, texts, lists and dictionaries."""

    def restore(self, state: Any, /) -> None:
        """Return to what `state` gave."""


def stand_still(_time: float, _values: Mapping[str, float], /) -> dict[str, float]:
    """Leave all where it is: a drive for any scene."""
    return {}


def driven_quantities(unit: Unit) -> dict[str, tuple[str, str | None]]:
    """Return the driven inputs of `unit` that are no rates, each with its scene key and the input of its rate."""
    found: dict[str, tuple[str, str | None]] = {}
    for variable in unit.variables.values():
        for key, pattern, rate in DRIVEN if variable.causality == "input" else ():
            if match := re.fullmatch(pattern, variable.name):
                found[variable.name] = key, rate and match.expand(rate)
    return found


def driven_inputs(unit: Unit) -> list[str]:
    """Return the driven inputs of `unit`, in its order."""
    found = driven_quantities(unit)
    rates = {rate for _, rate in found.values()}
    return [name for name in unit.variables if name in found or name in rates]


class WithinStep:
    """The driven inputs of `units` within a communication step: rates linear in time, values with a rate cubic. They
    are few: numbers of Python are faster than arrays."""

    def __init__(self, units: Sequence[Unit], left: Callable[[Unit], list[str]]):
        self.places: list[tuple[np.ndarray, int, int]] = []
        """Of each driven input the array and the place in it, and the number here of its rate, or its own."""
        self.moving: list[tuple[np.ndarray, int, bool, float, float, float, float]] = []
        """Inputs that move in this step: place, whether a rate, value and rate at the beginning, and at the end."""
        for unit in units:
            names, rates = left(unit), {name: rate for name, (_, rate) in driven_quantities(unit).items()}
            number = {name: len(self.places) + i for i, name in enumerate(names)}
            for name in names:
                place, rate = unit.input_slices[name].start, rates.get(name) or name
                self.places.append((unit.inputs, place, number[rate]))
        self.keep()

    def keep(self) -> None:
        """Take the present values for those at the beginning of the next step."""
        self.first = [inputs.item(place) for inputs, place, _ in self.places]

    def aim(self) -> None:
        """Take the present values for those at the end of the step; what stands still needs no more."""
        first, last = self.first, [inputs.item(place) for inputs, place, _ in self.places]
        self.moving = [
            (inputs, place, rate == i, first[i], first[rate], last[i], last[rate])
            for i, (inputs, place, rate) in enumerate(self.places)
            if first[i] != last[i] or first[rate] != last[rate] or (rate != i and first[rate])
        ]

    def move(self, share: float, h: float) -> None:
        """Set the inputs to what they are after a share of a step of `h` (s)."""
        for inputs, own, is_rate, x, v, x_end, v_end in self.moving:
            if share == 1.0:
                inputs[own] = x_end
                continue
            way, there = x_end - x, x + share * (x_end - x)
            if not is_rate:
                there += share * (1 - share) * ((1 - share) * (h * v - way) - share * (h * v_end - way))
            inputs[own] = there


def master_inputs(unit: Unit) -> list[str]:
    """Return the inputs of `unit` that a scene leaves to the master, by a drive or by a body that carries its root."""
    return [
        variable.name
        for variable in unit.variables.values()
        if variable.causality == "input" and MASTER.match(variable.name)
    ]


def read_drive(path: Path) -> Drive:
    """Return the function or object `drive` of a Python file; raise `InputError` where there is none."""
    if not path.is_file():
        raise InputError(f"the drive {path} does not exist, but must be a Python file")
    try:
        content = runpy.run_path(str(path))
    except (Exception, SystemExit) as error:  # whatever the file raises
        raise InputError(f"the drive {path} cannot be used: {_told(error, str(path))}") from error
    if not callable(found := content.get(NAME)):
        functions = [name for name, own in content.items() if callable(own) and not name.startswith("_")]
        has = f", but {', '.join(functions)}" if functions else ""
        raise InputError(f"the drive {path} has no function `{NAME}(time, values)`{has}")
    return cast(Drive, found)


def _told(error: BaseException, file: str | None = None) -> str:
    """Return an exception in one line, with the last line of `file`, by default of the called function's, that met
    it."""
    frames = [(frame.filename, frame.lineno) for frame in traceback.extract_tb(error.__traceback__)[1:]]
    lines = [line for name, line in frames if name == (file or frames[0][0])]
    place = f" ({Path(file or frames[0][0]).name}, line {lines[-1]})" if lines else ""
    return f"{type(error).__name__}: {error}{place}"


class Driver:
    """Sets the driven inputs of connected `units` by a `drive`, those that `left` names for a unit. With several rods,
    their roots have the name of the rod in front, as `upper.root.y`.

    Raise `MissingDrive` where the scene leaves something to the master and there is no drive, and `InputError` in the
    reverse case.
    """

    def __init__(
        self, units: Mapping[str, Unit], drive: Drive | None, left: Callable[[Unit], list[str]] = driven_inputs
    ):
        if drive is not None and not callable(drive):
            raise InputError(f"the drive is {drive!r}, but must be a function of time and row")
        self.drive, self.rates = drive, dict[str, str | None]()
        self.places: dict[str, tuple[np.ndarray, int]] = {}
        self.units: dict[str, str | None] = {}  # Physical units
        several, keys = len(units) > 2, set[str]()
        self.has_wing = any("root.rotation" in unit.variables for unit in units.values() if left(unit))
        for own, unit in units.items():
            names, quantities = left(unit), driven_quantities(unit)
            shown = {name: f"{own}.{name}" if several and name.startswith("root.") else name for name in names}
            for name in names:
                self.places[shown[name]] = unit.inputs, unit.input_slices[name].start
                self.units[shown[name]] = unit.variables[name].unit
                if name in quantities:
                    key, rate = quantities[name]
                    self.rates[shown[name]] = rate and shown[rate]
                    keys.add(key)
        if self.places and drive is None:
            raise MissingDrive(f"the scene leaves {', '.join(self.rates)} to the master ({', '.join(sorted(keys))})")
        if drive not in (None, stand_still) and not self.places:
            allowed = " or ".join(dict.fromkeys(key for key, *_ in DRIVEN))
            raise InputError(
                f'a drive is given, but the scene leaves nothing to it: {allowed} must be "master" '
                "(docs/guide/drive.md)"
            )
        if hasattr(drive, "state") != hasattr(drive, "restore"):
            raise InputError("the drive has only one of `state` and `restore`, but a memory needs both")
        self.slopes = dict.fromkeys(self.rates, 0.0)
        self.last: float | None = None  # Length of the step before, s
        self.memory()  # Refuses a state before the run

    def move(self, t: float, h: float, values: Mapping[str, float]) -> None:
        """Set the inputs for the step from `t` to `t + h` (s) after the `values` at its beginning. Raise
        `CouplingError` where the drive fails."""
        if self.drive is None or not self.places:
            return
        given = self._ask(self.drive, t + h, values)
        last, self.last = self.last or h, h
        for name, rate in self.rates.items():
            (at, i), before = self.places[name], self[name]
            if rate is None:
                at[i] = given.get(name, before)
                continue
            at_rate, j = self.places[rate]
            if name in given:
                at[i] = given[name]
            elif rate in given:
                at[i] = before + h * (self[rate] + given[rate]) / 2
            slope, earlier = (float(at[i]) - before) / h, self.slopes[name]
            if rate in given:
                at_rate[j] = given[rate]
            else:
                at_rate[j] = slope + (slope - earlier) * h / (h + last) if name in given else 0.0
            self.slopes[name] = slope

    def __getitem__(self, name: str) -> float:
        """Return the present value of a driven input."""
        at, place = self.places[name]
        return float(at.item(place))

    def _ask(self, drive: Drive, time: float, values: Mapping[str, float]) -> dict[str, float]:
        """Return what the drive sets at `time` (s), checked."""
        try:
            given = drive(time, values)
        except (Exception, SystemExit) as error:  # whatever the user's function raises
            raise CouplingError(f"the drive failed for t = {time:g} s: {_told(error)}") from error
        if not isinstance(given, Mapping):
            raise CouplingError(
                f"the drive returned {shown(given)} for t = {time:g} s, but must return a dictionary by the names of "
                "inputs"
            )
        found: dict[str, float] = {}
        for name, value in given.items():
            if name not in self.places:
                left = ", ".join(self.places)
                more = "; at a hinge of a `flyer` it turns a wing, too" if self.has_wing and "root." in name else ""
                raise CouplingError(f"the drive sets {name!r} for t = {time:g} s, but the scene leaves it {left}{more}")
            try:
                found[name] = math.nan if isinstance(value, str | bool | np.bool_) else float(value)
            except (TypeError, ValueError, OverflowError):
                found[name] = math.nan
            if not math.isfinite(found[name]):
                unit, said = self.units[name], shown(value)
                raise CouplingError(
                    f"the drive sets {name} to {said} for t = {time:g} s, but must set a finite number, in {unit}"
                )
        return found

    def memory(self) -> dict[str, Any] | None:
        """Return what the next step depends on beside the inputs, as JSON holds it; None without a drive. Raise
        `InputError` where the drive has none, or one that is nothing for JSON."""
        if self.drive is None:
            return None
        try:
            own = plain(self.drive.state()) if isinstance(self.drive, Memory) else None
        except (Exception, SystemExit) as error:  # whatever the user's method raises
            raise InputError(f"the drive cannot give its state: {_told(error)}") from error
        try:
            json.dumps(own)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"the state of the drive must hold numbers, texts, lists and dictionaries only: {error}"
            ) from error
        return {"slopes": dict(self.slopes), "last": self.last, "state": own}

    def remember(self, memory: dict[str, Any]) -> None:
        """Return to what `memory` gave. Raise `InputError` where it is of another drive."""
        self.slopes, self.last = {name: float(memory["slopes"][name]) for name in self.rates}, memory["last"]
        if isinstance(self.drive, Memory):
            try:
                self.drive.restore(memory["state"])
            except (Exception, SystemExit) as error:
                why = f"{type(error).__name__}: {error}"
                raise InputError(f"the drive cannot restore its state {memory['state']!r}: {why}") from error
        elif memory["state"] is not None:
            raise InputError("the run had a drive with a state, but this one has no `restore`: give that of the run")
