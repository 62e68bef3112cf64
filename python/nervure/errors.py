"""Errors that a user sees as sentences in place of a traceback."""

from collections.abc import Iterable
from dataclasses import dataclass


class InputError(Exception):
    """Input that nervure cannot use; the message says why and, if possible, what to do. Exit code 2."""


class UnitError(InputError):
    """A unit that cannot be used; the message is the unit's own where it logged one."""


class UnitFailure(UnitError):
    """A unit that failed in a call, or gave what no unit can use. Exit code 1."""


@dataclass(frozen=True)
class Fault:
    """A reason why a scene cannot be run, from the check in the units' libraries (`Fault` in `crates/scene`)."""

    kind: str  # syntax, duplicate, format, unknown, missing, type, range or conflict
    key: str  # Path, e.g. `fluid.cylinders[0].radius`; empty for the whole file
    line: int | None  # From 1; None where the key is not in the file
    column: int | None  # In characters from 1
    value: str | None  # As the file has it, or a summary
    allowed: str | None
    text: str  # The whole as a sentence without the place


class SceneError(InputError):
    """A scene, or a change of one, that cannot be used; `faults` has the reasons as far as the units found them."""

    def __init__(self, message: str, faults: Iterable[Fault] = ()):
        super().__init__(message)
        self.faults = tuple(faults)
