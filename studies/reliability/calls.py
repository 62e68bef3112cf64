"""Random call sequences, with an oracle that is written from the standard (FMI 2.0.4, section 4.2.4), not from the glue."""

import ctypes
import math
import random

from .unit import DISCARD, ERROR, INPUTS, INT, OK, POINTER, REAL, SIZE, STEP, TEXT, Library


STATES = ("instantiated", "initialization", "complete", "terminated")
INSTANTIATED, INITIALIZATION, COMPLETE, TERMINATED = STATES
ALLOWED = {
    **dict.fromkeys(("SetDebugLogging", "Reset", "SetFMUstate", "FreeFMUstate", "GetFMUstate"), STATES),
    **dict.fromkeys(("SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate"), STATES),
    **dict.fromkeys(("SetupExperiment", "EnterInitializationMode"), STATES[:1]),
    "ExitInitializationMode": STATES[1:2],
    **dict.fromkeys(("DoStep", "Terminate"), STATES[2:3]),
    "CancelStep": (),
    **dict.fromkeys(("GetReal", "GetInteger", "GetBoolean", "GetString", "GetDirectionalDerivative"), STATES[1:]),
    **dict.fromkeys(("SetReal", "SetInteger", "SetBoolean", "SetString", "SetRealInputDerivatives"), STATES[:3]),
    "GetRealOutputDerivatives": STATES[2:],
    **dict.fromkeys((f"Get{kind}Status" for kind in ("", "Real", "Integer", "Boolean", "String")), STATES[2:]),
}
"""The standard's table for an instance in which nothing has failed."""

OFTEN = ("SetupExperiment", "EnterInitializationMode", "ExitInitializationMode", "DoStep", "DoStep", "SetReal", "GetReal")
WILD = (math.nan, math.inf, -math.inf)
LAST_STATUS, PENDING_STATUS, LAST_TIME, TERMINATED_STATUS = range(4)


class Sequence:
    """One instance under random calls, with what the standard says of it beside it.

    Each method of the name of a function makes arguments, right ones or wrong ones, and calls it; it returns the
    status, the status that right arguments in an allowed state have, and whether the arguments were right.
    """

    def __init__(self, library: Library, chance: random.Random):
        self.library, self.chance, self.component = library, chance, library.new()
        self.flags = library.description.coSimulation
        self.state, self.time, self.stop = INSTANTIATED, 0.0, None
        self.handles: dict[int, tuple] = {}
        self.bytes: list[tuple[bytes, tuple]] = []
        self.freed, self.stepped = 0, False

    def close(self) -> None:
        self.library.free(self.component)

    def wrong(self) -> bool:
        return self.chance.random() < 0.25

    def progress(self) -> tuple:
        return self.state, self.time, self.stop

    def call(self) -> None:
        chance = self.chance
        name = chance.choice(OFTEN) if chance.random() < 0.5 else chance.choice(tuple(ALLOWED))
        before = self.progress()
        self.null = chance.random() < 0.02
        component, allowed = (None, False) if self.null else (self.component, before[0] in ALLOWED[name])
        made = getattr(self, name, None)
        if made is None:
            made = self.get if name[:3] == "Get" else self.set
            status, good, right = made(component, name, allowed)
        else:
            status, good, right = made(component, allowed)
        expected = good if allowed and right else ERROR
        assert status == expected, (
            f"fmi2{name} in the state {before} with {'right' if right else 'wrong'} arguments returned {status}, "
            f"not {expected}: {self.library.messages[-1:]}"
        )

    def plain(name: str, target: str | None):  # noqa: N805
        def method(self, component, allowed):
            status = getattr(self.library, name)(component)
            if allowed and target:
                self.state = target
            return status, OK, True

        return method

    EnterInitializationMode = plain("EnterInitializationMode", INITIALIZATION)
    ExitInitializationMode = plain("ExitInitializationMode", COMPLETE)
    Terminate = plain("Terminate", TERMINATED)
    CancelStep = plain("CancelStep", None)

    def Reset(self, component, allowed):  # noqa: N802
        if not self.null and self.chance.random() < 0.7:  # a reset loads the model anew, the dearest of all calls
            return OK, OK, True
        status = self.library.Reset(component)
        if allowed:
            self.state, self.time, self.stop, self.stepped = INSTANTIATED, 0.0, None, False
        return status, OK, True

    def SetDebugLogging(self, component, allowed):  # noqa: N802
        names = self.chance.choices([b"logEvents", b"logAll", b"logStatusError"], k=self.chance.randrange(3))
        right = True
        if self.wrong():
            names.append(self.chance.choice([b"logNothing", None, b"\xff"]))
            right = False
        categories, size = (TEXT * len(names))(*names), len(names)
        if self.wrong():
            categories, size = None, self.chance.randrange(3)
            right = size == 0
        return self.library.SetDebugLogging(component, self.chance.randrange(2), size, categories), OK, right

    def SetupExperiment(self, component, allowed):  # noqa: N802
        start = self.chance.choice([0.0, 0.0, 1.5, -2.0])
        stop = self.chance.choice([None, start + 5 * STEP, start + 1.0])
        right = True
        if self.wrong():
            right = False
            if self.chance.random() < 0.5:
                start = self.chance.choice(WILD)
            else:
                stop = self.chance.choice([*WILD, start, start - 1.0])
        status = self.library.SetupExperiment(component, 1, 1e-6, start, stop is not None, stop or 0.0)
        if allowed and right:
            self.time, self.stop = start, stop
        return status, OK, right

    def DoStep(self, component, allowed):  # noqa: N802
        t, h = self.time, STEP * self.chance.choice([0.5, 1.0, 2.0])
        right = True
        if self.wrong():
            right = False
            if self.chance.random() < 0.5:
                h = self.chance.choice([*WILD, 0.0, -STEP])
            else:
                t = self.chance.choice([*WILD, t + 0.5 * h, t - h, 1e300])
        passes_stop = self.stop is not None and t + h > self.stop + 1e-9 * max(abs(t), h)
        right = right and not passes_stop
        status = self.library.DoStep(component, t, h, self.chance.randrange(2))
        if allowed and right:
            self.time, self.stepped = t + h, True
        return status, OK, right

    def values(self, causality: str, kind: str = "Real") -> list[int]:
        return [v.valueReference for v in self.library.variables if v.causality == causality and v.type == kind]

    def references(self, pool: list[int], foreign: list[int]) -> tuple[ctypes.Array | None, int, bool]:
        """Some references of `pool`, and whether they are right: no NULL, none that does not exist or is foreign."""
        chosen, right = self.chance.choices(pool, k=self.chance.randrange(5)) if pool else [], True
        if self.wrong():
            chosen.append(self.chance.choice([*foreign, 10_000, 0xFFFF_FFFF]))
            right = False
        if chosen and self.chance.random() < 0.05:
            return None, len(chosen), False
        return (ctypes.c_uint * len(chosen))(*chosen), len(chosen), right

    def get(self, component, name, allowed):
        kind = name[3:]
        variables = self.library.variables
        pool = [v.valueReference for v in variables if v.type == kind]
        references, size, right = self.references(pool, [v.valueReference for v in variables if v.type != kind])
        buffer = (ctypes.c_double * max(size, 1))(*[math.nan] * size)  # room for every type
        if size and self.chance.random() < 0.05:
            buffer, right = None, False
        status = getattr(self.library, name)(component, references, size, buffer)
        if status == OK and kind == "Real" and size:
            assert all(map(math.isfinite, buffer)), f"{list(buffer)} from {list(references)} with status OK"
        return status, OK, right

    def set(self, component, name, allowed):
        kind, variables, chance = name[3:], self.library.variables, self.chance
        settable = ["input"] + ["parameter"] * (self.state in STATES[:2])
        names = {v.valueReference: v for v in variables if v.type == kind and v.causality in settable}
        references, size, right = self.references(
            list(names), [v.valueReference for v in variables if v.valueReference not in names]
        )
        values = []
        for k in range(size):
            variable = names.get(references[k]) if references else None
            start = float(variable.start) if variable and variable.type == "Real" else 0.0
            values.append(start * (1 + 1e-4 * chance.random()))
        if kind == "Real" and values and self.wrong():
            values[chance.randrange(size)] = chance.choice(WILD)
            right = False
        buffer = {
            "Real": lambda: (REAL * size)(*values),
            "Integer": lambda: (INT * size)(),
            "Boolean": lambda: (INT * size)(),
            "String": lambda: (TEXT * size)(*[b"text"] * size),
        }[kind]()
        if size and chance.random() < 0.05:
            buffer, right = None, False
        return getattr(self.library, name)(component, references, size, buffer), OK, right

    def GetFMUstate(self, component, allowed):  # noqa: N802
        status, right, handle = OK, True, POINTER()
        if self.chance.random() < 0.1:
            return self.library.GetFMUstate(component, None), OK, False
        if self.handles and self.chance.random() < 0.3:  # into the place of one that exists
            handle.value = self.chance.choice(list(self.handles))
        elif self.wrong():
            handle.value, right = self.chance.choice([self.freed or 1, 1, 0xDEAD_BEEF_0000]), False
            right = handle.value in self.handles
        status = self.library.GetFMUstate(component, ctypes.byref(handle))
        if status == OK:
            self.handles[handle.value] = self.progress()
        return status, OK, right

    def handle(self) -> tuple[int | None, bool]:
        if self.handles and not self.wrong():
            return self.chance.choice(list(self.handles)), True
        value = self.chance.choice([None, 1, 0xDEAD_BEEF_0000, self.freed or None])
        return value, value in self.handles

    def SetFMUstate(self, component, allowed):  # noqa: N802
        handle, right = self.handle()
        status = self.library.SetFMUstate(component, handle)
        if allowed and right:
            (self.state, self.time, self.stop), self.stepped = self.handles[handle], False
        return status, OK, right

    def FreeFMUstate(self, component, allowed):  # noqa: N802
        handle, right = self.handle()
        place = POINTER(handle)
        if self.chance.random() < 0.1:
            return self.library.FreeFMUstate(component, None), OK, True
        status = self.library.FreeFMUstate(component, ctypes.byref(place))
        if allowed and right:
            assert place.value is None, "a freed state's pointer must be NULL"
            del self.handles[handle]
            self.freed = handle
        return status, OK, right or handle is None

    def SerializedFMUstateSize(self, component, allowed):  # noqa: N802
        handle, right = self.handle()
        size = SIZE()
        if self.chance.random() < 0.1:
            return self.library.SerializedFMUstateSize(component, handle, None), OK, False
        return self.library.SerializedFMUstateSize(component, handle, ctypes.byref(size)), OK, right

    def SerializeFMUstate(self, component, allowed):  # noqa: N802
        handle, right = self.handle()
        size = SIZE()
        if right and not self.null:
            self.library.SerializedFMUstateSize(component, handle, ctypes.byref(size))
        buffer = ctypes.create_string_buffer(size.value)
        if right and self.wrong():
            size.value, right = self.chance.randrange(size.value) if size.value else 0, False
        if self.chance.random() < 0.1:
            return self.library.SerializeFMUstate(component, handle, None, size), OK, False
        status = self.library.SerializeFMUstate(component, handle, buffer, size)
        if status == OK:
            self.bytes.append((buffer.raw, self.handles[handle]))
        return status, OK, right

    def DeSerializeFMUstate(self, component, allowed):  # noqa: N802
        data, progress = self.chance.choice(self.bytes) if self.bytes else (b"", None)
        right, place, size = progress is not None, POINTER(), len(data)
        if right and self.wrong():
            size, right = self.chance.randrange(len(data)), False
        if self.chance.random() < 0.1:
            data, size, right = None, self.chance.choice([0, 10]), False
        if self.chance.random() < 0.1:
            return self.library.DeSerializeFMUstate(component, data, size, None), OK, False
        status = self.library.DeSerializeFMUstate(component, data, size, ctypes.byref(place))
        if status == OK:
            self.handles[place.value] = progress
        return status, OK, right

    def GetDirectionalDerivative(self, component, allowed):  # noqa: N802
        unknown, n_unknown, right = self.references(self.library.unknowns, self.values("parameter"))
        known, n_known, also = self.references(self.library.knowns, self.values("parameter"))
        seed, derivative = (REAL * n_known)(), (REAL * n_unknown)()
        if n_unknown and self.chance.random() < 0.05:
            derivative, right = None, False
        status = self.library.GetDirectionalDerivative(
            component, unknown, n_unknown, known, n_known, seed, derivative
        )
        # The rod has derivatives of the step that it made last; where there is none, it says so.
        return status, OK, right and also and self.flags.providesDirectionalDerivative and self.stepped

    def orders(self, size: int) -> tuple[ctypes.Array, bool]:
        if size and self.wrong():
            return (INT * size)(*[self.chance.choice([0, 2, -1])] * size), False
        return (INT * size)(*[1] * size), True

    def GetRealOutputDerivatives(self, component, allowed):  # noqa: N802
        references, size, right = self.references(self.library.unknowns, self.values("parameter"))
        orders, also = self.orders(size)
        status = self.library.GetRealOutputDerivatives(component, references, size, orders, (REAL * size)())
        return status, OK, right and also and self.flags.maxOutputDerivativeOrder == 1

    def SetRealInputDerivatives(self, component, allowed):  # noqa: N802
        references, size, right = self.references(self.library.knowns, self.values("output"))
        orders, also = self.orders(size)
        status = self.library.SetRealInputDerivatives(component, references, size, orders, (REAL * size)())
        return status, OK, right and also and self.flags.canInterpolateInputs

    def status_of(name: str, answered: int | None):  # noqa: N805
        def method(self, component, allowed):
            kind, value = self.chance.choice([*range(4), -1, 99]), REAL()
            if self.wrong():
                return getattr(self.library, name)(component, kind, None), OK, False
            status = getattr(self.library, name)(component, kind, ctypes.byref(value))
            return status, OK if kind == answered else DISCARD, True

        return method

    GetStatus = status_of("GetStatus", None)
    GetRealStatus = status_of("GetRealStatus", LAST_TIME)
    GetIntegerStatus = status_of("GetIntegerStatus", None)
    GetBooleanStatus = status_of("GetBooleanStatus", TERMINATED_STATUS)
    GetStringStatus = status_of("GetStringStatus", None)


CALLS = 50


def sequences(library: Library, count: int) -> str:
    """Random calls with NULL, wrong-size and out-of-range arguments: the status of each is the standard's."""
    library.variables = library.description.modelVariables
    library.unknowns = list(library.array("output", ("x", "y", "vx", "vy"))[0])
    library.knowns = list(library.array("input", INPUTS[library.kind])[0])
    for seed in range(count):
        chance = random.Random(seed)
        sequence = Sequence(library, chance)
        try:
            for _ in range(CALLS):
                sequence.call()
        except AssertionError as error:
            raise AssertionError(f"sequence {seed}: {error}") from None
        sequence.close()
        library.messages.clear()
    return f"{count * CALLS} calls, every status the one expected"
