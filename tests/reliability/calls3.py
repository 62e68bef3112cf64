"""Random call sequences under FMI 3.0, with an oracle from the standard (FMI 3.0.2, sections 2.3 and 4.2)."""

import ctypes
import json
import math
import random
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import fmpy
from fmpy.fmi3 import FMU3Slave

from nervure.units import package

from .calls import CALLS, COMPLETE, INITIALIZATION, INSTANTIATED, NOWHERE, STATES, TERMINATED, WILD
from .unit import ERROR, OK, STEP, FMU2Unit

TYPES = {"Float64": ctypes.c_double, "Int32": ctypes.c_int32, "Int64": ctypes.c_int64, "Boolean": ctypes.c_bool,
         "String": ctypes.c_char_p}  # fmt: skip
OTHERS = {"Float32": ctypes.c_float, "Int8": ctypes.c_int8, "UInt8": ctypes.c_uint8, "Int16": ctypes.c_int16,
          "UInt16": ctypes.c_uint16, "UInt32": ctypes.c_uint32, "UInt64": ctypes.c_uint64}  # fmt: skip
"""Types that no variable of the units has."""
ALLOWED = {
    **dict.fromkeys(("SetDebugLogging", "Reset", "SetFMUState", "FreeFMUState", "GetFMUState"), STATES),
    **dict.fromkeys(("SerializedFMUStateSize", "SerializeFMUState", "DeserializeFMUState"), STATES),
    "EnterInitializationMode": STATES[:1],
    "ExitInitializationMode": STATES[1:2],
    **dict.fromkeys(("DoStep", "Terminate"), STATES[2:3]),
    **dict.fromkeys((f"Get{kind}" for kind in (*TYPES, *OTHERS)), STATES[1:]),
    **dict.fromkeys((f"Set{kind}" for kind in (*TYPES, *OTHERS)), STATES[:3]),
}
"""In which states a function may be called, for an instance in which nothing has failed."""
ABSENT = (
    "GetNumberOfVariableDependencies", "GetVariableDependencies", "GetDirectionalDerivative", "GetAdjointDerivative",
    "EnterConfigurationMode", "ExitConfigurationMode", "GetIntervalDecimal", "GetIntervalFraction", "GetShiftDecimal",
    "GetShiftFraction", "SetIntervalDecimal", "SetIntervalFraction", "EvaluateDiscreteStates", "UpdateDiscreteStates",
    "EnterContinuousTimeMode", "CompletedIntegratorStep", "SetTime", "SetContinuousStates", "GetContinuousStates",
    "GetContinuousStateDerivatives", "GetEventIndicators", "GetNominalsOfContinuousStates", "GetOutputDerivatives",
    "GetNumberOfEventIndicators", "GetNumberOfContinuousStates", "EnterStepMode", "EnterEventMode",
    "ActivateModelPartition",
)  # fmt: skip
"""Functions of what the units have not: each call is an error, and changes nothing."""
NEXT = {"EnterInitializationMode": INITIALIZATION, "ExitInitializationMode": COMPLETE, "Terminate": TERMINATED}
OFTEN = (*list(NEXT)[:2], "DoStep", "DoStep", "SetFloat64", "GetFloat64")


class FMU3Unit(FMU3Slave):  # fmpy takes the version of FMI from the name of the class
    """A unit of FMI 3.0, with its variables and what it said."""

    def __init__(self, kind: str, folder: str):
        description = fmpy.read_model_description(folder, validate=False)
        place = {"unzipDirectory": folder, "modelIdentifier": f"fmu_{kind}", "instanceName": "unit"}
        super().__init__(guid=description.guid, **place)
        self.variables = description.modelVariables
        self.messages: list[str] = []

    def begin(self) -> None:
        self.instantiate(loggingOn=True, logMessage=lambda *said: self.messages.append(said[-1].decode()))


class Calls:
    """One instance under random calls, with what the standard says of it beside it."""

    def __init__(self, unit: FMU3Unit, chance: random.Random):
        self.unit, self.chance = unit, chance
        self.progress: tuple[str, float, float | None] = (INSTANTIATED, 0.0, None)
        """State, time and stop time."""
        self.handles: dict[int | None, tuple] = {}
        self.stored: list[tuple[bytes, tuple]] = []
        self.chosen: Any = None
        """The handle that is freed, or the progress at the stored state that is read."""
        self.freed = 1

    def random_call(self) -> None:
        """Call some function, sometimes with wrong arguments, with NULL in place of one, or without an instance."""
        chance, before = self.chance, self.progress
        name = chance.choice(OFTEN) if chance.random() < 0.5 else chance.choice([*ALLOWED, *ABSENT])
        if name == "Reset" and chance.random() < 0.7:  # it loads the model again, the slowest of all calls
            return
        function = self.unit._functions[f"fmi3{name}"]
        arguments, right = self.arguments(name, function.argtypes[1:])
        passed = list(arguments)
        pointers = [k for k, kind in enumerate(function.argtypes[1:]) if issubclass(kind, ctypes._Pointer)]
        if pointers and chance.random() < 0.08:
            k = chance.choice(pointers)
            passed[k] = None
            right = name == "FreeFMUState" or (right and getattr(arguments[k], "_length_", 1) == 0)
        component = None if chance.random() < 0.02 else self.unit.component
        expected = OK if component and before[0] in ALLOWED.get(name, ()) and right else ERROR
        said = len(self.unit.messages)
        status = function(component, *passed)
        about = f"fmi3{name}{passed} of {component} after {before} with {'right' if right else 'wrong'} arguments"
        assert status == expected, f"{about} returned {status}, not {expected}: {self.unit.messages[-1:]}"
        if status == ERROR and component:
            assert self.unit.messages[said:] and f"fmi3{name}: " in self.unit.messages[-1], f"{about} said nothing"
        if status == OK and passed == arguments:
            self.follow(name, arguments)

    def fault(self, *values: Any) -> Any:
        """Mostly None, else one of some wrong values."""
        return self.chance.choice(values) if self.chance.random() < 0.25 else None

    def arguments(self, name: str, types: Sequence[Any]) -> tuple[list, bool]:
        """Arguments after the instance, and whether they are right."""
        unit, chance, choice, size = self.unit, self.chance, self.chance.choice, ctypes.c_size_t()
        _, time, stop = self.progress
        handle = choice([None, 1, NOWHERE, self.freed])
        if self.handles and not self.fault(True):
            handle = choice(list(self.handles))
        known = handle in self.handles
        match name:
            case "SetDebugLogging":
                wrong = self.fault([b"logNothing"], [None], [b"\xff"]) or []
                names = [*wrong, b"logAll"]  # errors are to be said
                return [True, len(names), (types[2]._type_ * len(names))(*names)], not wrong
            case "EnterInitializationMode":
                fault = self.fault("start", "stop")
                start = choice(WILD if fault == "start" else (0.0, 0.0, 1.5, -2.0))
                wrong, right = (*WILD, start, start - 1.0), (None, start + 5 * STEP, start + 1.0)
                stop = choice(wrong if fault == "stop" else right)
                return [True, 1e-6, start, stop is not None, stop or 0.0], not fault
            case "DoStep":
                fault = self.fault("time", "step")
                h = choice((*WILD, 0.0, -STEP)) if fault == "step" else STEP * choice([0.5, 1.0, 2.0])
                t = choice((*WILD, time + 0.5 * h, time - h, 1e300)) if fault == "time" else time
                too_far = stop is not None and t + h > stop + 1e-9 * max(abs(t), h)
                answers = [ctypes.c_bool(True) for _ in range(3)]
                return [t, h, bool(chance.randrange(2)), *answers, ctypes.c_double()], not (fault or too_far)
            case "GetFMUState":  # into no place, into that of another state, or into one that does not exist
                place = ctypes.c_void_p(choice([None, None, handle]))
                return [place], place.value is None or known
            case "SetFMUState":
                return [handle], known
            case "FreeFMUState":
                self.chosen = handle
                return [ctypes.c_void_p(handle)], known or handle is None
            case "SerializedFMUStateSize":
                return [handle, size], known
            case "SerializeFMUState":
                if known:
                    unit._functions["fmi3SerializedFMUStateSize"](unit.component, handle, size)
                buffer, cut = (types[1]._type_ * size.value)(), size.value and self.fault(True)
                return [handle, buffer, chance.randrange(size.value) if cut else size.value], known and not cut
            case "DeserializeFMUState":
                data, self.chosen = choice(self.stored or [(b"", None)])
                buffer, cut = (types[0]._type_ * len(data)).from_buffer_copy(data), data and self.fault(True)
                size.value = chance.randrange(len(data)) if cut else len(data)
                return [buffer, size, ctypes.c_void_p()], bool(data) and not cut
            case _ if name[3:] in (*TYPES, *OTHERS) and name not in ABSENT:
                return self.values(name)
        empty = [kind._type_() if issubclass(kind, ctypes._Pointer) else kind() for kind in types]
        return empty, True

    def values(self, name: str) -> tuple[list, bool]:
        """Arguments of a getter or setter, arrays whole, and whether they are right."""
        kind, chance = name[3:], self.chance
        usable = {"input", "parameter"} if self.progress[0] in STATES[:2] else {"input"}
        fit = [v for v in self.unit.variables if v.type == kind and (name[0] == "G" or v.causality in usable)]
        chosen = chance.choices(fit, k=chance.randrange(4)) if fit else []
        references, n = [v.valueReference for v in chosen], sum(math.prod(v.shape) for v in chosen)
        others = [v.valueReference for v in self.unit.variables if v not in fit]
        within = [v.valueReference + 1 for v in self.unit.variables if v.shape]
        wrong = self.fault(*others, *within, 10_000, 0xFFFF_FFFF)
        references += [] if wrong is None else [wrong]
        count = self.fault(n + 1, max(n - 1, 0))
        values = ({**TYPES, **OTHERS}[kind] * max(n, 1))()
        if name == "SetFloat64":
            # A parameter that is changed may be beyond its limits.
            starts = [(start, v.causality == "input") for v in chosen for start in (v.start or "0").split()]
            values[:n] = [float(start) * (1 + 1e-4 * chance.random() * changed) for start, changed in starts]
        right = wrong is None and count in (None, n)
        if name == "SetFloat64" and n and (wild := self.fault(*WILD)) is not None:
            values[0], right = wild, False
        given = (ctypes.c_uint * len(references))(*references)
        if name == "SetString" and n:
            values[:n] = [b"text"] * n
        return [given, len(references), values if n else (values._type_ * 0)(), n if count is None else count], right

    def follow(self, name: str, arguments: list) -> None:
        """What the standard says of the instance after a call with status OK."""
        state, time, stop = self.progress
        match name, arguments:
            case "Reset", _:
                self.progress = INSTANTIATED, 0.0, None
            case "EnterInitializationMode", [_, _, start, has_stop, stop]:
                self.progress = NEXT[name], start, stop if has_stop else None
            case (("ExitInitializationMode" | "Terminate"), _):
                self.progress = NEXT[name], time, stop
            case "DoStep", [t, h, _, event, end, early, reached]:
                self.progress = state, t + h, stop
                assert not (event.value or end.value or early.value) and reached.value == t + h, arguments
            case "GetFloat64", [references, _, values, _]:
                assert all(map(math.isfinite, values)), f"{list(values)} from {list(references)} with status OK"
            case "GetFMUState", [place]:
                self.handles[place.value] = self.progress
            case "SetFMUState", [handle]:
                self.progress = self.handles[handle]
            case "FreeFMUState", [place] if self.chosen is not None:
                assert place.value is None, "a freed state's pointer must be NULL"
                del self.handles[self.chosen]
                self.freed = self.chosen
            case "SerializeFMUState", [handle, buffer, _]:
                self.stored.append((bytes(buffer), self.handles[handle]))
            case "DeserializeFMUState", [_, _, place]:
                self.handles[place.value] = self.chosen


def sequences(unit: FMU2Unit, count: int) -> str:
    """Random calls under FMI 3.0, also of functions of what the units have not: each status is the standard's."""
    with TemporaryDirectory() as folder:
        scene = json.loads((unit.folder / "resources" / "scene.json").read_text(encoding="utf-8"))
        path = package.pack(unit.kind, scene, Path(folder), version=3)
        own = FMU3Unit(unit.kind, fmpy.extract(str(path), str(Path(folder, "unit"))))
        for seed in range(count):
            own.begin()
            calls = Calls(own, random.Random(seed))
            try:
                for _ in range(CALLS):
                    calls.random_call()
            except AssertionError as error:
                raise AssertionError(f"sequence {seed}: {error}") from None
            own.fmi3FreeInstance(own.component)
            own.messages.clear()
        own.freeLibrary()
    return f"{count * CALLS} calls, every status the one expected"
