"""Random call sequences with an oracle from the standard (FMI 2.0.4, section 4.2.4), not from the glue."""

import ctypes
import math
from collections.abc import Sequence

from .calls import NEXT, STATES, WILD, Calls, play
from .unit import DISCARD, INPUTS, OK, FMU2Unit

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
ANSWERED = {"GetRealStatus": 2, "GetBooleanStatus": 3}
"""Kinds of status that the units know: the last successful time and whether they terminated."""


class Calls2(Calls):
    prefix = "fmi2"
    allowed = ALLOWED
    often = ("SetupExperiment", *list(NEXT)[:2], "DoStep", "DoStep", "SetReal", "GetReal")

    def answer(self, name: str, arguments: list) -> int:
        return DISCARD if name.endswith("Status") and arguments[0] != ANSWERED.get(name) else OK

    def references(self, pool: Sequence[int], foreign: Sequence[int]) -> tuple[ctypes.Array, int, bool]:
        """Return references of `pool`, their number, and whether they are right: none is foreign or does not exist."""
        chosen = self.chance.choices(pool, k=self.chance.randrange(5)) if pool else []
        wrong = self.fault(*foreign, 10_000, 0xFFFF_FFFF)
        chosen += [] if wrong is None else [wrong]
        return (ctypes.c_uint * len(chosen))(*chosen), len(chosen), wrong is None

    def arguments(self, name: str, types: list) -> tuple[list, bool]:
        unit, chance, choice = self.unit, self.chance, self.chance.choice
        state, flags = self.progress[0], unit.description.coSimulation
        parameters, stations = unit.references("parameter"), unit.references("output", INPUTS["fluid"])
        match name:
            case "SetDebugLogging":
                wrong = self.fault([b"logNothing"], [None], [b"\xff"]) or []
                names = wrong + chance.choices([b"logEvents", b"logAll", b"logStatusError"], k=chance.randrange(3))
                return [chance.randrange(2), len(names), (types[2]._type_ * len(names))(*names)], not wrong
            case "SetupExperiment":
                return self.experiment()
            case "DoStep":
                t, h, right = self.step()
                return [t, h, chance.randrange(2)], right
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
        if name == "SetupExperiment":
            _, _, start, has_stop, stop = arguments
            self.progress = self.progress[0], start, stop if has_stop else None
        super().follow(name, arguments)


def sequences(unit: FMU2Unit, count: int) -> str:
    """Check the status of random calls with NULL, wrong-size and out-of-range arguments against the standard."""

    def end(calls: Calls) -> None:
        calls.unit.close()
        unit.messages.clear()

    return play(count, lambda chance: Calls2(unit.new(start=False), chance), end)
