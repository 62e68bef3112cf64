"""Random call sequences, with an oracle from the standard (FMI 2.0.4, section 4.2.4), not from the glue."""

import ctypes
import math
import random
from collections.abc import Sequence
from typing import Any

from .unit import DISCARD, ERROR, INPUTS, OK, STEP, FMU2Unit

CALLS = 50  # Calls of one sequence
STATES = ("instantiated", "initialization", "complete", "terminated")
INSTANTIATED, INITIALIZATION, COMPLETE, TERMINATED = STATES
KINDS = ("Real", "Integer", "Boolean", "String")
ALLOWED = {
    **dict.fromkeys(("SetDebugLogging", "Reset", "SetFMUstate", "FreeFMUstate", "GetFMUstate"), STATES),
    **dict.fromkeys(("SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate"), STATES),
    **dict.fromkeys(("SetupExperiment", "EnterInitializationMode"), STATES[:1]),
    "ExitInitializationMode": STATES[1:2],
    **dict.fromkeys(("DoStep", "Terminate"), STATES[2:3]),
    "CancelStep": (),
    **dict.fromkeys((*(f"Get{kind}" for kind in KINDS), "GetDirectionalDerivative"), STATES[1:]),
    **dict.fromkeys((*(f"Set{kind}" for kind in KINDS), "SetRealInputDerivatives"), STATES[:3]),
    **dict.fromkeys((*(f"Get{kind}Status" for kind in ("", *KINDS)), "GetRealOutputDerivatives"), STATES[2:]),
}
"""The standard's table for an instance in which nothing has failed."""
NEXT = {"EnterInitializationMode": INITIALIZATION, "ExitInitializationMode": COMPLETE, "Terminate": TERMINATED}
ANSWERED = {"GetRealStatus": 2, "GetBooleanStatus": 3}
"""Kinds of status that the units know: the last successful time and whether they terminated."""
OFTEN = ("SetupExperiment", *list(NEXT)[:2], "DoStep", "DoStep", "SetReal", "GetReal")
WILD = (math.nan, math.inf, -math.inf)
NOWHERE = 0xDEAD_BEEF_0000


class Calls:
    """One instance under random calls, with what the standard says of it beside it."""

    def __init__(self, unit: FMU2Unit, chance: random.Random):
        self.unit, self.chance = unit, chance
        self.progress: tuple[str, float, float | None] = (INSTANTIATED, 0.0, None)
        """State, time and stop time."""
        self.handles: dict[int | None, tuple] = {}
        self.stored: list[tuple[bytes, tuple]] = []
        self.chosen: Any = None
        """The handle that is freed, or the progress at the stored state that is read."""
        self.freed, self.stepped = 1, False

    def random_call(self) -> None:
        """Call some function, sometimes with wrong arguments, with NULL in place of one, or without an instance."""
        chance, before = self.chance, self.progress
        name = chance.choice(OFTEN) if chance.random() < 0.5 else chance.choice(list(ALLOWED))
        if name == "Reset" and chance.random() < 0.7:  # it loads the model again, the slowest of all calls
            return
        types = self.unit._functions[f"fmi2{name}"].argtypes[1:]
        arguments, right = self.arguments(name, types)
        passed = list(arguments)
        pointers = [k for k, kind in enumerate(types) if issubclass(kind, ctypes._Pointer)]
        if pointers and chance.random() < 0.08:
            k = chance.choice(pointers)
            passed[k] = None
            right = name == "FreeFMUstate" or (right and getattr(arguments[k], "_length_", 1) == 0)
        good = DISCARD if name.endswith("Status") and arguments[0] != ANSWERED.get(name) else OK
        component = None if chance.random() < 0.02 else self.unit.component
        expected = good if component and before[0] in ALLOWED[name] and right else ERROR
        status = self.unit._functions[f"fmi2{name}"](component, *passed)
        assert status == expected, (
            f"fmi2{name}{passed} of {component} after {before} with {'right' if right else 'wrong'} arguments returned "
            f"{status}, not {expected}: {self.unit.messages[-1:]}"
        )
        if status == OK and passed == arguments:
            self.follow(name, arguments)

    def fault(self, *values: Any) -> Any:
        """Mostly None, else one of some wrong values."""
        return self.chance.choice(values) if self.chance.random() < 0.25 else None

    def references(self, pool: Sequence[int], foreign: Sequence[int]) -> tuple[ctypes.Array, int, bool]:
        """Some references of `pool`, how many, and whether they are right: none that does not exist or is foreign."""
        chosen = self.chance.choices(pool, k=self.chance.randrange(5)) if pool else []
        wrong = self.fault(*foreign, 10_000, 0xFFFF_FFFF)
        chosen += [] if wrong is None else [wrong]
        return (ctypes.c_uint * len(chosen))(*chosen), len(chosen), wrong is None

    def arguments(self, name: str, types: list) -> tuple[list, bool]:
        """Arguments after the instance, and whether they are right."""
        unit, chance, choice, size = self.unit, self.chance, self.chance.choice, ctypes.c_size_t()
        (state, time, stop), flags = self.progress, unit.description.coSimulation
        parameters, stations = unit.references("parameter"), unit.references("output", INPUTS["fluid"])
        handle = choice([None, 1, NOWHERE, self.freed])
        if self.handles and not self.fault(True):
            handle = choice(list(self.handles))
        known = handle in self.handles
        match name:
            case "SetDebugLogging":
                wrong = self.fault([b"logNothing"], [None], [b"\xff"]) or []
                names = wrong + chance.choices([b"logEvents", b"logAll", b"logStatusError"], k=chance.randrange(3))
                return [chance.randrange(2), len(names), (types[2]._type_ * len(names))(*names)], not wrong
            case "SetupExperiment":
                fault = self.fault("start", "stop")
                start = choice(WILD if fault == "start" else (0.0, 0.0, 1.5, -2.0))
                wrong, right = (*WILD, start, start - 1.0), (None, start + 5 * STEP, start + 1.0)
                stop = choice(wrong if fault == "stop" else right)
                return [1, 1e-6, start, int(stop is not None), stop or 0.0], not fault
            case "DoStep":
                fault = self.fault("time", "step")
                h = choice((*WILD, 0.0, -STEP)) if fault == "step" else STEP * choice([0.5, 1.0, 2.0])
                t = choice((*WILD, time + 0.5 * h, time - h, 1e300)) if fault == "time" else time
                too_far = stop is not None and t + h > stop + 1e-9 * max(abs(t), h)
                return [t, h, chance.randrange(2)], not (fault or too_far)
            case "GetFMUstate":  # into no place, into that of another state, or into one that does not exist
                place = ctypes.c_void_p(choice([None, None, handle]))
                return [place], place.value is None or known
            case "SetFMUstate":
                return [handle], known
            case "FreeFMUstate":
                self.chosen = handle
                return [ctypes.c_void_p(handle)], known or handle is None
            case "SerializedFMUstateSize":
                return [handle, size], known
            case "SerializeFMUstate":
                if known:
                    unit.call("SerializedFMUstateSize", handle, size)
                buffer, cut = ctypes.create_string_buffer(size.value), size.value and self.fault(True)
                return [handle, buffer, chance.randrange(size.value) if cut else size.value], known and not cut
            case "DeSerializeFMUstate":
                data, self.chosen = choice(self.stored or [(b"", None)])
                buffer, cut = (ctypes.c_char * len(data)).from_buffer_copy(data), data and self.fault(True)
                size.value = chance.randrange(len(data)) if cut else len(data)
                return [buffer, size, ctypes.c_void_p()], bool(data) and not cut
            case "GetDirectionalDerivative":
                unknown, n, right = self.references(stations, parameters)
                inputs, m, also = self.references(unit.inputs, parameters)
                # The rod has derivatives of the step that it made last; where there is none, it says so.
                right = right and also and flags.providesDirectionalDerivative and self.stepped
                return [unknown, n, inputs, m, (types[4]._type_ * m)(), (types[5]._type_ * n)()], right
            case "SetRealInputDerivatives" | "GetRealOutputDerivatives":
                pool, foreign, able = stations, parameters, flags.maxOutputDerivativeOrder == 1
                if name[0] == "S":
                    pool, foreign, able = unit.inputs, unit.outputs, flags.canInterpolateInputs
                references, n, right = self.references(pool, foreign)
                order = self.fault(0, 2, -1) if n else None
                orders = (types[2]._type_ * n)(*[1 if order is None else order] * n)
                return [references, n, orders, (types[3]._type_ * n)()], right and able and order is None
            case _ if name.endswith("Status"):
                return [choice([*range(4), -1, 99]), types[1]._type_()], True
            case _ if name[3:] in KINDS:
                usable = {"input", "parameter"} if state in STATES[:2] else {"input"}
                fit = [v for v in unit.variables if v.type == name[3:] and (name[0] == "G" or v.causality in usable)]
                starts = {v.valueReference: v.start for v in fit}
                foreign = [v.valueReference for v in unit.variables if v.valueReference not in starts]
                references, n, right = self.references(list(starts), foreign)
                values, wrong = (types[2]._type_ * n)(), None
                if name == "GetReal":
                    values[:] = [math.nan] * n
                elif name == "SetReal" and n:
                    changed = set(unit.references("input"))  # a parameter that is changed may be beyond its limits
                    factors = [1 + 1e-4 * chance.random() * (r in changed) for r in references]
                    values[:] = [float(starts.get(r) or 0.0) * factor for r, factor in zip(references, factors)]
                    wrong = self.fault(*WILD)
                    values[0] = values[0] if wrong is None else wrong
                elif name == "SetString":
                    values[:] = [b"text"] * n
                return [references, n, values], right and wrong is None
        return [], True

    def follow(self, name: str, arguments: list) -> None:
        """What the standard says of the instance after a call with status OK."""
        state, time, stop = self.progress
        match name, arguments:
            case "Reset", _:
                self.progress, self.stepped = (INSTANTIATED, 0.0, None), False
            case (("EnterInitializationMode" | "ExitInitializationMode" | "Terminate"), _):
                self.progress = NEXT[name], time, stop
            case "SetupExperiment", [_, _, start, has_stop, stop]:
                self.progress = state, start, stop if has_stop else None
            case "DoStep", [t, h, _]:
                self.progress, self.stepped = (state, t + h, stop), True
            case "GetReal", [references, _, values]:
                assert all(map(math.isfinite, values)), f"{list(values)} from {list(references)} with status OK"
            case "GetFMUstate", [place]:
                self.handles[place.value] = self.progress
            case "SetFMUstate", [handle]:
                self.progress, self.stepped = self.handles[handle], False
            case "FreeFMUstate", [place] if self.chosen is not None:
                assert place.value is None, "a freed state's pointer must be NULL"
                del self.handles[self.chosen]
                self.freed = self.chosen
            case "SerializeFMUstate", [handle, buffer, _]:
                self.stored.append((buffer.raw, self.handles[handle]))
            case "DeSerializeFMUstate", [_, _, place]:
                self.handles[place.value] = self.chosen


def sequences(unit: FMU2Unit, count: int) -> str:
    """Random calls with NULL, wrong-size and out-of-range arguments: the status of each is the standard's."""
    for seed in range(count):
        calls = Calls(unit.new(start=False), random.Random(seed))
        try:
            for _ in range(CALLS):
                calls.random_call()
        except AssertionError as error:
            raise AssertionError(f"sequence {seed}: {error}") from None
        calls.unit.close()
        unit.messages.clear()
    return f"{count * CALLS} calls, every status the one expected"
