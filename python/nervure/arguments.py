"""Arguments of the Python interface, checked where a function begins: a message names the argument and its value."""

import math
import os
import reprlib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from numbers import Integral, Real
from pathlib import Path
from typing import Any

from nervure.errors import InputError

LONGEST = 60  # Characters of a value in a message

_short = reprlib.Repr()
_short.maxstring = _short.maxother = _short.maxlong = LONGEST


def shown(value: Any) -> str:
    """Return a value as Python writes it, shortened in the middle."""
    return _short.repr(value)


def path(name: str, value: Any) -> Path:
    """Return a path; raise `InputError` where the argument `name` is none."""
    if isinstance(value, str | os.PathLike):
        with suppress(UnicodeError):
            place = os.fspath(value)
            if isinstance(place, str) and place and b"\0" not in os.fsencode(place):
                return Path(place)
    raise InputError(f"{name} is {shown(value)}, but must be a path")


def text(name: str, value: Any) -> str:
    """Return a text; raise `InputError` where the argument `name` is none."""
    if isinstance(value, str):
        return value
    raise InputError(f"{name} is {shown(value)}, but must be a text")


def texts(name: str, value: Any) -> list[str]:
    """Return a text or several as a list; raise `InputError` where the argument `name` has something else."""
    if isinstance(value, str):
        return [value]
    if isinstance(value, Iterable) and not isinstance(value, bytes | Mapping):
        found = list(value)
        if all(isinstance(one, str) for one in found):
            return [str(one) for one in found]  # Of NumPy, too
    raise InputError(f"{name} is {shown(value)}, but must be a text or a list of texts")


def number(name: str, value: Any, least: float = -math.inf) -> float:
    """Return a finite number of at least `least`, above 0 with the least positive number; raise `InputError` where the
    argument `name` is none."""
    with suppress(OverflowError):
        if isinstance(value, Real) and not isinstance(value, bool) and least <= float(value) < math.inf:
            return float(value)
    ends = {-math.inf: "", ABOVE: " above 0"}.get(least, f" of at least {least:g}")
    raise InputError(f"{name} is {shown(value)}, but must be a finite number{ends}")


ABOVE = math.ulp(0.0)
"""Least number above 0."""


def if_given(name: str, value: Any, least: float = -math.inf) -> float | None:
    """Return `number` of an argument that is not None."""
    return None if value is None else number(name, value, least)


def numbers(name: str, value: Any) -> list[float]:
    """Return a list of finite numbers; raise `InputError` where the argument `name` is none."""
    if isinstance(value, Iterable) and not isinstance(value, str | bytes | Mapping):
        with suppress(InputError):
            return [number(name, one) for one in value]
    raise InputError(f"{name} is {shown(value)}, but must be a list of finite numbers")


def flag(name: str, value: Any) -> bool:
    """Return a truth value; raise `InputError` where the argument `name` is none."""
    is_numpy = type(value).__module__ == "numpy" and type(value).__name__ in ("bool", "bool_")
    if is_numpy or (isinstance(value, int) and value in (0, 1)):
        return bool(value)
    raise InputError(f"{name} is {shown(value)}, but must be True or False")


def count(name: str, value: Any) -> int:
    """Return a whole number of at least 1; raise `InputError` where the argument `name` is none."""
    if isinstance(value, Integral) and not isinstance(value, bool) and int(value) >= 1:
        return int(value)
    raise InputError(f"{name} is {shown(value)}, but must be a whole number of at least 1")


def function(name: str, value: Any, of: str) -> None:
    """Raise `InputError` where the argument `name` is no function `of` something."""
    if not callable(value):
        raise InputError(f"{name} is {shown(value)}, but must be a function of {of}")
