"""Random calls of an instance beside the prescription of the standard: the common part of FMI 2.0 and 3.0."""

import ctypes
import math
import random
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .unit import ERROR, OK, STEP

CALLS = 50  # Calls of one sequence
STATES = ("instantiated", "initialization", "complete", "terminated")
INSTANTIATED, INITIALIZATION, COMPLETE, TERMINATED = STATES
NEXT = {"EnterInitializationMode": INITIALIZATION, "ExitInitializationMode": COMPLETE, "Terminate": TERMINATED}
WILD = (math.nan, math.inf, -math.inf)
NOWHERE = 0xDEAD_BEEF_0000


class Calls:
    """One instance under random calls, and the progress that the standard prescribes."""

    prefix: str
    allowed: Mapping[str, Sequence[str]]
    """States in which a function may be called, for an instance in which nothing has failed."""
    absent: Sequence[str] = ()
    often: Sequence[str]
    says_why = False
    """Whether errors are always logged."""

    def __init__(self, unit: Any, chance: random.Random):
        self.unit, self.chance = unit, chance
        self.progress: tuple[str, float, float | None] = (INSTANTIATED, 0.0, None)
        """State, time and stop time."""
        self.handles: dict[int | None, tuple] = {}
        self.stored: list[tuple[bytes, Any]] = []
        self.chosen: Any = None
        """The handle that is freed, or the progress at the stored state that is read."""
        self.freed, self.stepped = 1, False

    def random_call(self) -> None:
        """Call some function, sometimes with wrong arguments, with NULL in place of one, or without an instance."""
        chance, before = self.chance, self.progress
        name = chance.choice(self.often) if chance.random() < 0.5 else chance.choice([*self.allowed, *self.absent])
        if name == "Reset" and chance.random() < 0.7:  # it loads the model again, the slowest of all calls
            return
        function = self.unit._functions[self.prefix + name]
        types = function.argtypes[1:]
        arguments, right = self.state_arguments(name, types) or self.arguments(name, types)
        passed = list(arguments)
        pointers = [k for k, kind in enumerate(types) if issubclass(kind, ctypes._Pointer)]
        if pointers and chance.random() < 0.08:
            k = chance.choice(pointers)
            passed[k] = None
            right = name.startswith("FreeFMU") or (right and getattr(arguments[k], "_length_", 1) == 0)
        component = None if chance.random() < 0.02 else self.unit.component
        may = component and before[0] in self.allowed.get(name, ()) and right
        expected = self.answer(name, arguments) if may else ERROR
        said = len(self.unit.messages)
        status = function(component, *passed)
        about = (
            f"{self.prefix}{name}{passed} of {component} after {before} with {'right' if right else 'wrong'} arguments"
        )
        assert status == expected, f"{about} returned {status}, not {expected}: {self.unit.messages[-1:]}"
        if self.says_why and status == ERROR and component:
            assert self.unit.messages[said:] and f"{self.prefix}{name}: " in self.unit.messages[-1], (
                f"{about} said nothing"
            )
        if status == OK and passed == arguments:
            self.follow(name, arguments)

    def answer(self, name: str, arguments: list) -> int:
        """Return the status of a call that is right."""
        return OK

    def arguments(self, name: str, types: list) -> tuple[list, bool]:
        """Return arguments after the instance, and whether they are right."""
        raise NotImplementedError

    def fault(self, *values: Any) -> Any:
        """Return None in three of four cases, or else one of some wrong values."""
        return self.chance.choice(values) if self.chance.random() < 0.25 else None

    def experiment(self) -> tuple[list, bool]:
        """Return tolerance, start and stop time as arguments, and whether they are right."""
        choice, fault = self.chance.choice, self.fault("start", "stop")
        start = choice(WILD if fault == "start" else (0.0, 0.0, 1.5, -2.0))
        wrong, right = (*WILD, start, start - 1.0), (None, start + 5 * STEP, start + 1.0)
        stop = choice(wrong if fault == "stop" else right)
        return [True, 1e-6, start, stop is not None, stop or 0.0], not fault

    def step(self) -> tuple[float, float, bool]:
        """Return time and length of a step, and whether they are right."""
        choice, (_, time, stop), fault = self.chance.choice, self.progress, self.fault("time", "step")
        h = choice((*WILD, 0.0, -STEP)) if fault == "step" else STEP * choice([0.5, 1.0, 2.0])
        t = choice((*WILD, time + 0.5 * h, time - h, 1e300)) if fault == "time" else time
        too_far = stop is not None and t + h > stop + 1e-9 * max(abs(t), h)
        return t, h, not (fault or too_far)

    def state_arguments(self, name: str, types: list) -> tuple[list, bool] | None:
        """Return arguments of a function that handles stored states, and whether they are right."""
        unit, choice, size = self.unit, self.chance.choice, ctypes.c_size_t()
        handle = choice([None, 1, NOWHERE, self.freed])
        if self.handles and not self.fault(True):
            handle = choice(list(self.handles))
        known = handle in self.handles
        match name.lower():
            case "getfmustate":  # into no place, into the place of another state, or into one that does not exist
                place = ctypes.c_void_p(choice([None, None, handle]))
                return [place], place.value is None or known
            case "setfmustate":
                return [handle], known
            case "freefmustate":
                self.chosen = handle
                return [ctypes.c_void_p(handle)], known or handle is None
            case "serializedfmustatesize":
                return [handle, size], known
            case "serializefmustate":
                if known:
                    measure = name.replace("Serialize", "Serialized") + "Size"
                    unit._functions[self.prefix + measure](unit.component, handle, size)
                buffer, cut = (types[1]._type_ * size.value)(), size.value and self.fault(True)
                return [handle, buffer, self.chance.randrange(size.value) if cut else size.value], known and not cut
            case "deserializefmustate":
                data, self.chosen = choice(self.stored or [(b"", None)])
                buffer, cut = (types[0]._type_ * len(data)).from_buffer_copy(data), data and self.fault(True)
                size.value = self.chance.randrange(len(data)) if cut else len(data)
                return [buffer, size, ctypes.c_void_p()], bool(data) and not cut
        return None

    def follow(self, name: str, arguments: list) -> None:
        """Follow the standard over a call with status OK."""
        state, time, stop = self.progress
        match name.lower(), arguments:
            case "reset", _:
                self.progress, self.stepped = (INSTANTIATED, 0.0, None), False
            case _ if name in NEXT:
                self.progress = NEXT[name], time, stop
            case "dostep", [t, h, *_]:
                self.progress, self.stepped = (state, t + h, stop), True
            case (("getreal" | "getfloat64"), [references, _, values, *_]):
                assert all(map(math.isfinite, values)), f"{list(values)} from {list(references)} with status OK"
            case "getfmustate", [place]:
                self.handles[place.value] = self.progress
            case "setfmustate", [handle]:
                self.progress, self.stepped = self.handles[handle], False
            case "freefmustate", [place] if self.chosen is not None:
                assert place.value is None, "a freed state's pointer must be NULL"
                del self.handles[self.chosen]
                self.freed = self.chosen
            case "serializefmustate", [handle, buffer, _]:
                self.stored.append((bytes(buffer), self.handles[handle]))
            case "deserializefmustate", [_, _, place]:
                self.handles[place.value] = self.chosen


def play(count: int, begin: Callable[[random.Random], Calls], end: Callable[[Calls], None]) -> str:
    """Play sequences of random calls, each with an instance of its own."""
    for seed in range(count):
        calls = begin(random.Random(seed))
        try:
            for _ in range(CALLS):
                calls.random_call()
        except AssertionError as error:
            raise AssertionError(f"sequence {seed}: {error}") from None
        end(calls)
    return f"{count * CALLS} calls, every status the one expected"
