"""Random call sequences under FMI 3.0, with an oracle from the standard (FMI 3.0.2, sections 2.3 and 4.2)."""

import ctypes
import json
import math
import random
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy

from nervure.units import package
from nervure.units.describe import describe
from tests.slaves import FMU3Unpacked

from .calls import NEXT, STATES, WILD, Calls, play
from .unit import FMU2Unit

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
ABSENT = (
    "GetNumberOfVariableDependencies", "GetVariableDependencies", "GetDirectionalDerivative", "GetAdjointDerivative",
    "EnterConfigurationMode", "ExitConfigurationMode", "GetIntervalDecimal", "GetIntervalFraction", "GetShiftDecimal",
    "GetShiftFraction", "SetIntervalDecimal", "SetIntervalFraction", "EvaluateDiscreteStates", "UpdateDiscreteStates",
    "EnterContinuousTimeMode", "CompletedIntegratorStep", "SetTime", "SetContinuousStates", "GetContinuousStates",
    "GetContinuousStateDerivatives", "GetEventIndicators", "GetNominalsOfContinuousStates", "GetOutputDerivatives",
    "GetNumberOfEventIndicators", "GetNumberOfContinuousStates", "EnterStepMode", "EnterEventMode",
    "ActivateModelPartition",
)  # fmt: skip
"""Functions of features that the units lack: each call is an error, and changes nothing."""


class Calls3(Calls):
    prefix = "fmi3"
    allowed = ALLOWED
    absent = ABSENT
    often = (*list(NEXT)[:2], "DoStep", "DoStep", "SetFloat64", "GetFloat64")
    says_why = True

    def arguments(self, name: str, types: list) -> tuple[list, bool]:
        match name:
            case "SetDebugLogging":
                wrong = self.fault([b"logNothing"], [None], [b"\xff"]) or []
                names = [*wrong, b"logAll"]  # errors are to be said
                return [True, len(names), (types[2]._type_ * len(names))(*names)], not wrong
            case "EnterInitializationMode":
                return self.experiment()
            case "DoStep":
                t, h, right = self.step()
                answers = [ctypes.c_bool(True) for _ in range(3)]
                return [t, h, bool(self.chance.randrange(2)), *answers, ctypes.c_double()], right
            case _ if name[3:] in (*TYPES, *OTHERS) and name not in ABSENT:
                return self.values(name)
        empty = [kind._type_() if issubclass(kind, ctypes._Pointer) else kind() for kind in types]
        return empty, True

    def values(self, name: str) -> tuple[list, bool]:
        """Return arguments of a getter or setter, with whole arrays, and whether they are right."""
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
        super().follow(name, arguments)
        if name == "EnterInitializationMode":
            _, _, start, has_stop, stop = arguments
            self.progress = self.progress[0], start, stop if has_stop else None
        if name == "DoStep":
            t, h, _, event, end, early, reached = arguments
            assert not (event.value or end.value or early.value) and reached.value == t + h, arguments


def sequences(unit: FMU2Unit, count: int) -> str:
    """Check the status of random calls under FMI 3.0, also of functions that the units lack, against the standard."""
    with TemporaryDirectory() as folder:
        scene = json.loads((unit.folder / "resources" / "scene.json").read_text(encoding="utf-8"))
        path = package.pack(describe(unit.kind, scene, 3), Path(folder))
        own = FMU3Unpacked(fmpy.extract(str(path), str(Path(folder, "unit"))))

        def begin(chance: random.Random) -> Calls3:
            own.begin()
            return Calls3(own, chance)

        def end(calls: Calls) -> None:
            own.fmi3FreeInstance(own.component)
            own.messages.clear()

        result = play(count, begin, end)
        own.freeLibrary()
    return result
