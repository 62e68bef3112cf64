"""Mistreats both FMUs as files, through the C functions alone, and writes the table of docs/reliability.md.

python scripts/studies/reliability.py                  everything at full count, each check in a process of its own
python scripts/studies/reliability.py --only forks     one check (`--list` names them); `--share 0.01` for fewer cases

The oracle of the random call sequences is written from the standard (FMI 2.0.4, section 4.2.4), not from the glue.
"""

import csv
import ctypes
import hashlib
import io
import math
import multiprocessing
import os
import random
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import _ctypes
import fmpy
import typer

sys.path.insert(0, str(Path(__file__).parents[1]))

from cosim import package
from cosim.scene import ROOT

OK, WARNING, DISCARD, ERROR = range(4)
STEP = 2e-4
"""Communication step, s."""

SCENE = {
    "name": "reliability",
    "time": {"end": 1.0, "communication_step": STEP},
    "beam": {
        "root": {"at": {"position": [0.25, 0.2], "direction": [1.0, 0.0]}},
        "length": 0.35,
        "thickness": 0.06,
        "segments": 6,
    },
    "rod": {"material": {"plane_strain": {"density": 2000.0, "youngs_modulus": 1.4e6, "poisson_ratio": 0.4}}},
    "fluid": {
        "density": 1000.0,
        "kinematic_viscosity": 1e-3,
        "box": {"x": [0.0, 0.8], "y": [0.0, 0.4], "cells": [32, 16]},
        "initial_velocity": [1.0, 0.0],
        "inflow": {"x": [0.0, 0.1], "profile": "uniform", "mean_velocity": {"steady": 1.0}, "c_eta": 1e-2},
        "mask": {"cosine": {"c_eta": 1e-3, "half_width": 1.0}},
        "time_stepping": {"max_step": STEP, "max_cfl": 0.5},
    },
    "coupling": {"load": "momentum"},
}
"""A thick flag in a stream, small enough for a million cases."""

INPUTS = {"rod": ("force_x", "force_y"), "fluid": ("x", "y", "vx", "vy")}
"""Inputs that the checks change."""


class Callbacks(ctypes.Structure):
    """`fmi2CallbackFunctions`."""

    logger_type = ctypes.CFUNCTYPE(None, *[ctypes.c_char_p] * 2, ctypes.c_int, *[ctypes.c_char_p] * 2)
    _fields_ = [("logger", logger_type)] + [(name, ctypes.c_void_p) for name in ("allocate", "free", "done", "own")]


POINTER, SIZE, REAL, TEXT, INT = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_double, ctypes.c_char_p, ctypes.c_int
VALUES = [POINTER, POINTER, SIZE, POINTER]
SIGNATURES = {
    "SetDebugLogging": [POINTER, INT, SIZE, POINTER],
    "SetupExperiment": [POINTER, INT, REAL, REAL, INT, REAL],
    **dict.fromkeys(("EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset", "CancelStep"), [POINTER]),
    **{f"{way}{kind}": VALUES for way in ("Get", "Set") for kind in ("Real", "Integer", "Boolean", "String")},
    "GetFMUstate": [POINTER, POINTER],
    "SetFMUstate": [POINTER, POINTER],
    "FreeFMUstate": [POINTER, POINTER],
    "SerializedFMUstateSize": [POINTER, POINTER, POINTER],
    "SerializeFMUstate": [POINTER, POINTER, POINTER, SIZE],
    "DeSerializeFMUstate": [POINTER, POINTER, SIZE, POINTER],
    "GetDirectionalDerivative": [POINTER, POINTER, SIZE, POINTER, SIZE, POINTER, POINTER],
    "SetRealInputDerivatives": [POINTER, POINTER, SIZE, POINTER, POINTER],
    "GetRealOutputDerivatives": [POINTER, POINTER, SIZE, POINTER, POINTER],
    "DoStep": [POINTER, REAL, REAL, INT],
    **{f"Get{kind}Status": [POINTER, INT, POINTER] for kind in ("", "Real", "Integer", "Boolean", "String")},
}
"""Argument types of the functions that act on an instance and return a status."""


class Library:
    """An unpacked FMU with its library loaded."""

    def __init__(self, kind: str, folder: Path):
        self.kind = kind
        self.description = fmpy.read_model_description(str(folder), validate=False)
        self.guid = self.description.guid.encode()
        self.resources = (folder / "resources").as_uri().encode()
        self.path = folder / "binaries" / fmpy.platform / f"fmu_{kind}{fmpy.sharedLibraryExtension}"
        self.references = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        self.messages: list[str] = []
        self.logger = Callbacks.logger_type(lambda _, name, status, category, text: self.messages.append(text.decode()))
        self.callbacks = Callbacks(logger=self.logger)
        self.load()

    def load(self) -> None:
        self.dll = ctypes.CDLL(str(self.path))
        for name, arguments in SIGNATURES.items():
            function = self.dll[f"fmi2{name}"]
            function.argtypes, function.restype = arguments, ctypes.c_int
            setattr(self, name, function)
        self.instantiate = self.dll["fmi2Instantiate"]
        self.instantiate.argtypes = [TEXT, INT, TEXT, TEXT, POINTER, INT, INT]
        self.instantiate.restype = POINTER
        self.free = self.dll["fmi2FreeInstance"]
        self.free.argtypes, self.free.restype = [POINTER], None

    def unload(self) -> None:
        for name in (*SIGNATURES, "instantiate", "free"):
            delattr(self, name)
        handle = self.dll._handle
        del self.dll
        _ctypes.dlclose(handle)

    def new(self) -> int:
        component = self.instantiate(b"unit", 1, self.guid, self.resources, ctypes.byref(self.callbacks), 0, 0)
        assert component, self.messages[-1:]
        return component

    def array(self, causality: str, names: tuple[str, ...] | None = None) -> tuple[ctypes.Array, int]:
        """Value references of the Real variables of a causality, of the given arrays only if there are any."""
        references = [
            variable.valueReference
            for variable in self.description.modelVariables
            if variable.causality == causality
            and variable.type == "Real"
            and (names is None or variable.name.split("[")[0] in names)
        ]
        return (ctypes.c_uint * len(references))(*references), len(references)

    @property
    def outputs(self) -> tuple[ctypes.Array, int]:
        return self.array("output")


class Unit:
    """An instance that is ready for its first step at t = 0."""

    def __init__(self, library: Library, start: bool = True):
        self.library, self.component, self.steps = library, library.new(), 0
        self.references, self.size = library.array("input", INPUTS[library.kind])
        self.outputs, self.output_size = library.outputs
        self.rest = (REAL * self.size)()
        if start:
            self.do("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
            self.do("EnterInitializationMode")
            self.do("GetReal", self.references, self.size, self.rest)
            self.do("ExitInitializationMode")

    def do(self, name: str, *arguments) -> None:
        status = getattr(self.library, name)(self.component, *arguments)
        assert status == OK, f"{name} returned {status}: {self.library.messages[-1:]}"

    def step(self) -> None:
        """One step under inputs that follow from the number of the step."""
        load = 1e-4 * math.sin(self.steps + 1.0)
        values = (REAL * self.size)(*[rest + load * (1 + k % 3) for k, rest in enumerate(self.rest)])
        self.do("SetReal", self.references, self.size, values)
        self.do("DoStep", self.steps * STEP, STEP, 1)
        self.steps += 1

    def bits(self) -> bytes:
        values = (REAL * self.output_size)()
        self.do("GetReal", self.outputs, self.output_size, values)
        return bytes(values)

    def run(self, steps: int) -> bytes:
        """Everything that the outputs were after each of so many steps."""
        digest = hashlib.sha256()
        for _ in range(steps):
            self.step()
            digest.update(self.bits())
        return digest.digest()

    def state(self) -> ctypes.c_void_p:
        handle = POINTER()
        self.do("GetFMUstate", ctypes.byref(handle))
        return handle

    def serialize(self) -> bytes:
        handle, size = self.state(), SIZE()
        self.do("SerializedFMUstateSize", handle, ctypes.byref(size))
        buffer = ctypes.create_string_buffer(size.value)
        self.do("SerializeFMUstate", handle, buffer, size)
        self.do("FreeFMUstate", ctypes.byref(handle))
        return buffer.raw

    def restore(self, data: bytes, steps: int) -> None:
        handle = POINTER()
        self.do("DeSerializeFMUstate", data, len(data), ctypes.byref(handle))
        self.do("SetFMUstate", handle)
        self.do("FreeFMUstate", ctypes.byref(handle))
        self.steps = steps

    def close(self) -> None:
        self.library.free(self.component)


# ---------------------------------------------------------------- random call sequences

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


# ---------------------------------------------------------------- hostile inputs and steps

HOSTILE = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1e200, 1e100, -1e50, 1e20, -1e10, 1e6, 1e3, -1.0, 5e-324, 0.0)
STEPS = (math.nan, math.inf, -math.inf, 1e308, 1e100, 1e20, 1e9, 1e6, -1.0, 0.0, 5e-324, 1e-300, 1e-100, 1e-20)


def hostile(library: Library, count: int) -> str:
    """NaN, infinite and huge inputs, parameters and steps: an error or finite outputs, each in under 1 s."""
    chance = random.Random(1)
    unit = Unit(library)
    saved, rest = unit.state(), list(unit.rest)
    everything = [v.valueReference for v in library.description.modelVariables if v.type == "Real"]
    inputs = list(library.array("input")[0])
    parameters = list(library.array("parameter")[0])
    refused = failed = finite = 0
    slowest = 0.0

    def timed(function, *arguments) -> int:
        nonlocal slowest
        begin = time.perf_counter()
        status = function(unit.component, *arguments)
        slowest = max(slowest, time.perf_counter() - begin)
        return status

    for case in range(count):
        step = STEP
        if case % 5 == 4:  # a new instance, for parameters
            unit.close()
            unit = Unit(library, start=False)
            unit.do("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
            unit.do("EnterInitializationMode")
            reference = (ctypes.c_uint * 1)(chance.choice(parameters))
            set_status = timed(library.SetReal, reference, 1, (REAL * 1)(chance.choice(HOSTILE)))
            status = max(set_status, timed(library.ExitInitializationMode))
        else:
            unit.do("SetFMUstate", saved)
            if case % 5 == 3:
                step, status = chance.choice(STEPS), OK
            else:
                chosen = chance.sample(inputs, chance.choice([1, 2, len(inputs)]))
                value = chance.choice(HOSTILE)
                values = (REAL * len(chosen))(*[value] * len(chosen))
                status = timed(library.SetReal, (ctypes.c_uint * len(chosen))(*chosen), len(chosen), values)
        if status != OK:
            refused += 1
        elif timed(library.DoStep, 0.0, step, 1) != OK:
            failed += 1
        else:
            values = (REAL * len(everything))(*[math.nan] * len(everything))
            status = timed(library.GetReal, (ctypes.c_uint * len(everything))(*everything), len(everything), values)
            wrong = [everything[k] for k, value in enumerate(values) if not math.isfinite(value)]
            assert status != OK or not wrong, f"case {case}: {wrong} are not finite after a step of {step} with status OK"
            finite += 1
        if case % 5 == 4:
            unit.close()
            unit = Unit(library)
            saved = unit.state()
    assert slowest < 1.0, f"a call took {slowest} s"
    assert list(unit.rest) == rest
    unit.do("SetFMUstate", saved)
    unit.steps = 0
    fresh = Unit(library)
    assert unit.run(3) == fresh.run(3), "the instance is not what it was"
    return f"{refused} refused, {failed} steps failed, {finite} finite; slowest call {slowest:.2g} s"


# ---------------------------------------------------------------- states

HEADER = 62
"""Bytes before the payload of a serialized state: see crates/fmi2/src/snapshot.rs."""


def damage(data: bytes, chance: random.Random) -> bytes:
    """`data` with bits turned, bytes overwritten, cut, lengthened or moved."""
    changed = bytearray(data)
    at = chance.randrange(len(data))
    match chance.randrange(6):
        case 0:
            for _ in range(chance.randint(1, 8)):
                changed[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        case 1:
            length = chance.randint(1, 64)
            changed[at : at + length] = chance.randbytes(len(changed[at : at + length]))
        case 2:
            del changed[at:]
        case 3:
            changed += chance.randbytes(chance.randint(1, 64))
        case 4:
            del changed[at : at + chance.randint(1, 64)]
        case 5:
            changed[at:at] = chance.randbytes(chance.randint(1, 64))
    return bytes(changed)


def continues(unit: Unit, data: bytes, steps: int, expected: bytes) -> bool:
    unit.restore(data, steps)
    return unit.run(3) == expected


def corrupted(library: Library, count: int) -> str:
    """Damaged and truncated serialized states: every one refused, the instance unharmed."""
    chance = random.Random(2)
    unit = Unit(library)
    unit.run(5)
    data = unit.serialize()
    expected = unit.run(3)
    for case in range(count):
        changed, handle = damage(data, chance), POINTER()
        if changed == data:
            continue
        status = library.DeSerializeFMUstate(unit.component, changed, len(changed), ctypes.byref(handle))
        assert status == ERROR and handle.value is None, f"case {case}: status {status}"
        library.messages.clear()
        if case % 100_000 == 0:
            assert continues(unit, data, 5, expected), f"case {case} changed the instance"
    assert continues(unit, data, 5, expected), "the instance is not what it was"
    return f"states of {len(data)} bytes, all refused"


def forged(library: Library, count: int) -> str:
    """Damaged states under a right length and checksum: refused or taken, but never more than an error."""
    chance = random.Random(3)
    unit = Unit(library)
    unit.run(5)
    data = unit.serialize()
    expected = unit.run(3)
    refused = taken = errors = 0
    for case in range(count):
        payload = damage(data[HEADER:], chance)
        length_and_checksum = struct.pack("<QI", len(payload), zlib.crc32(payload))
        changed, handle = data[: HEADER - 12] + length_and_checksum + payload, POINTER()
        if library.DeSerializeFMUstate(unit.component, changed, len(changed), ctypes.byref(handle)) != OK:
            refused += 1
        else:
            taken += 1
            status = library.SetFMUstate(unit.component, handle)
            status = max(status, library.DoStep(unit.component, 5 * STEP, STEP, 1))
            values = (REAL * unit.output_size)()
            status = max(status, library.GetReal(unit.component, unit.outputs, unit.output_size, values))
            assert status in (OK, ERROR)
            assert status == ERROR or all(map(math.isfinite, values)), f"case {case}: {list(values)} with status OK"
            errors += status == ERROR
            unit.do("FreeFMUstate", ctypes.byref(handle))
        library.messages.clear()
        if case % 1000 == 0:
            assert continues(unit, data, 5, expected), f"case {case} harmed the instance"
    assert continues(unit, data, 5, expected), "the instance is not what it was"
    return f"{refused} refused, {taken} taken, of which {errors} led to an error"


def processes(library: Library, count: int) -> str:
    """Save, restore in a new process, continue: the same bits."""
    folder = library.path.parents[2]
    with tempfile.TemporaryDirectory() as place:
        for case in range(count):
            unit = Unit(library)
            unit.run(1 + case % 20)
            state = Path(place, "state")
            state.write_bytes(unit.serialize())
            command = [sys.executable, __file__, "--continue", library.kind, str(folder), str(state), str(unit.steps)]
            other = subprocess.run(command, capture_output=True, text=True, timeout=300)
            assert other.returncode == 0, other.stderr
            assert other.stdout.strip() == unit.run(10).hex(), f"case {case} continued differently"
            unit.close()
    return "bit-identical over 10 steps"


def continued(kind: str, folder: str, state: str, steps: str) -> None:
    """The other process of `processes`."""
    unit = Unit(Library(kind, Path(folder)), start=False)
    rest = Unit(unit.library)
    unit.rest = rest.rest
    unit.restore(Path(state).read_bytes(), int(steps))
    print(unit.run(10).hex())


def rollbacks(library: Library, count: int) -> str:
    """A step, a rollback over it and the step again: the bits of a run without."""
    straight, rolled = Unit(library), Unit(library)
    handle = rolled.state()
    for case in range(count):
        rolled.do("GetFMUstate", ctypes.byref(handle))
        values = (REAL * rolled.size)(*[rest * (1 + 1e-3) + 1e-4 for rest in rolled.rest])
        rolled.do("SetReal", rolled.references, rolled.size, values)
        rolled.do("DoStep", rolled.steps * STEP, 1.5 * STEP, 0)
        rolled.do("SetFMUstate", handle)
        straight.step()
        rolled.step()
        assert straight.bits() == rolled.bits(), f"rollback {case} left a trace"
    return "bit-identical"


# ---------------------------------------------------------------- the process around


def resident() -> int:
    """Resident memory of the process, bytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def instances(library: Library, count: int) -> str:
    """Instantiate, initialise, step and free: less than 1 MB of growth."""

    def cycle():
        unit = Unit(library)
        unit.step()
        handle = unit.state()  # not freed: the instance does that
        assert handle.value
        unit.close()

    for _ in range(200):
        cycle()
    before = resident()
    for _ in range(count):
        cycle()
    growth = resident() - before
    assert growth < 1 << 20, f"{growth} bytes more after {count} instances"
    return f"grew by {growth / 1024:.0f} kB"


def loads(library: Library, count: int) -> str:
    """Load, step, fail and unload: no thread, mapping or descriptor stays."""

    def traces() -> tuple[int, int, int]:
        maps = Path("/proc/self/maps").read_text().splitlines()
        ours = sum(library.path.name in line for line in maps)
        return len(os.listdir("/proc/self/task")), len(os.listdir("/proc/self/fd")), ours

    library.unload()
    before, mappings = traces(), 0
    assert before[2] == 0, "the library is still mapped after it was unloaded"
    for case in range(count):
        library.load()
        unit = Unit(library)
        unit.step()
        assert library.DoStep(unit.component, -1.0, -1.0, 0) == ERROR
        unit.close()
        library.unload()
        library.messages.clear()
        assert traces() == before, f"cycle {case}: threads, descriptors, mappings {traces()} after {before}"
        if case == min(count - 1, 100):
            mappings = len(Path("/proc/self/maps").read_text().splitlines())
    grown = len(Path("/proc/self/maps").read_text().splitlines()) - mappings
    assert grown <= 2, f"{grown} more mappings"
    return f"threads, descriptors and mappings as before; {grown:+d} mappings in all"


def threads(library: Library, count: int) -> str:
    """Instances on eight threads: the results of one after the other."""
    steps = 50
    serial = Unit(library).run(steps)
    with ThreadPoolExecutor(8) as pool:
        results = list(pool.map(lambda _: Unit(library).run(steps), range(count)))
    assert results == [serial] * count, f"{sum(result != serial for result in results)} results differ"
    return "64 bit-identical results" if count == 64 else f"{count} bit-identical results"


def _fresh(kind: str, folder: Path, answers) -> None:
    answers.put(Unit(Library(kind, folder)).run(5))


def _inherited(unit: Unit, answers) -> None:
    answers.put((unit.run(5), Unit(unit.library).run(5)))


def forks(library: Library, count: int) -> str:
    """Processes by fork, with an instance in use, and by spawn: they end, with the same bits."""
    folder = library.path.parents[2]
    fresh, unit = Unit(library).run(5), Unit(library)
    unit.run(3)
    data, after = unit.serialize(), unit.run(5)
    for case in range(count):
        unit.restore(data, 3)
        method = ("fork", "spawn")[case % 2]
        context = multiprocessing.get_context(method)
        answers = context.SimpleQueue()
        if method == "fork":
            target, arguments, expected = _inherited, (unit, answers), (after, fresh)
        else:
            target, arguments, expected = _fresh, (library.kind, folder, answers), fresh
        process = context.Process(target=target, args=arguments)
        process.start()
        process.join(300)
        assert process.exitcode == 0, f"{method} {case}: exit code {process.exitcode} (None: it hangs)"
        assert answers.get() == expected, f"{method} {case}: another result"
        assert unit.run(5) == after, f"{method} {case}: the parent's result changed"
    return "all ended, bit-identical in child and parent"


MXCSR = 28
"""Where glibc's `fenv_t` keeps the register on x86-64."""


def modes(library: Library, count: int) -> str:
    """The host's rounding direction, flush-to-zero and denormals-are-zero: no bit changes, and they stay set."""
    libm = ctypes.CDLL("libm.so.6")

    def set_modes(bits: int) -> None:
        environment = ctypes.create_string_buffer(64)
        libm.fegetenv(environment)
        struct.pack_into("<I", environment, MXCSR, 0x1F80 | bits)
        libm.fesetenv(environment)

    def get_modes() -> int:
        environment = ctypes.create_string_buffer(64)
        libm.fegetenv(environment)
        return struct.unpack_from("<I", environment, MXCSR)[0] & ~0x3F & ~0x1F80

    chance = random.Random(4)
    choices = [rounding | flush for rounding in (0, 0x2000, 0x4000, 0x6000) for flush in (0, 0x8000, 0x40, 0x8040)]
    tiny = [5e-324, 1e-310, 1 / 3, 1e-3]

    def run(mode: int, seeds: list[float]) -> bytes:
        unit = Unit(library, start=False)
        digest = hashlib.sha256()

        def call(name, *arguments):
            set_modes(mode)
            status = getattr(library, name)(unit.component, *arguments)
            left = get_modes()
            set_modes(0)
            assert (status, left) == (OK, mode), f"{name} under {mode:#x}: status {status}, modes left {left:#x}"

        call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        call("EnterInitializationMode")
        call("GetReal", unit.references, unit.size, unit.rest)
        call("ExitInitializationMode")
        for step, seed in enumerate(seeds):
            values = (REAL * unit.size)(*[rest + 1e-4 * seed for rest in unit.rest])
            call("SetReal", unit.references, unit.size, values)
            call("DoStep", step * STEP, STEP, 1)
            call("GetReal", unit.outputs, unit.output_size, read := (REAL * unit.output_size)())
            digest.update(read)
        unit.close()
        return digest.digest()

    for case in range(count):
        seeds = [chance.choice(tiny) * chance.random() for _ in range(10)]
        mode = choices[case % len(choices)]
        assert run(mode, seeds) == run(0, seeds), f"modes {mode:#x} change the result"
    return "16 combinations, bit-identical, modes as the host had them" if count >= 16 else "bit-identical"


# ---------------------------------------------------------------- all of them


@dataclass(frozen=True)
class Check:
    run: Callable[[Library, int], str]
    full: int
    quick: int
    timeout: float = 3600.0
    """How long the full form may take before it counts as hung, s."""


CHECKS = {
    check.run.__name__: check
    for check in (
        Check(sequences, 100_000, 200),
        Check(hostile, 10_000, 300),
        Check(corrupted, 1_000_000, 3000),
        Check(forged, 100_000, 1000),
        Check(processes, 200, 2),
        Check(rollbacks, 1000, 30),
        Check(instances, 100_000, 300),
        Check(loads, 5000, 20),
        Check(threads, 64, 16),
        Check(forks, 100, 4),
        Check(modes, 160, 16),
    )
}


def unpack(kind: str, folder: Path) -> Path:
    """The FMU of `SCENE`, unpacked."""
    return Path(fmpy.extract(str(package.pack(kind, SCENE, folder)), str(folder / kind)))


def one(name: str, kind: str, folder: Path, count: int, answers) -> None:
    """Run a check and answer how it went."""
    try:
        answers.put((True, CHECKS[name].run(Library(kind, folder), count)))
    except AssertionError as error:
        answers.put((False, str(error)))


def guarded(name: str, kind: str, folder: Path, count: int, timeout: float, target=one) -> tuple[bool, str]:
    """The outcome of a check in a process of its own, of which a crash and a hang are two."""
    context = multiprocessing.get_context("spawn")
    answers = context.Queue()
    process = context.Process(target=target, args=(name, kind, folder, count, answers))
    process.start()
    process.join(timeout)
    if process.exitcode is None:
        process.kill()
        process.join()
        return False, f"hung: no end after {timeout:.0f} s"
    if process.exitcode != 0:
        return False, f"crashed with exit code {process.exitcode}"
    return answers.get()


BEGIN, END = "<!-- measured -->\n", "<!-- end -->\n"
RESULTS = ROOT / "docs" / "reliability.csv"
FIELDS = ("check", "unit", "cases", "result", "seconds")


def replace(path: Path, text: str) -> None:
    unfinished = path.with_suffix(".unfinished")
    unfinished.write_text(text, encoding="utf-8")
    unfinished.replace(path)


def record(row: dict) -> None:
    """Put a result in the place of the former one of its check and unit, and write the table anew."""
    known = {}
    if RESULTS.is_file():
        with open(RESULTS, encoding="utf-8", newline="") as file:
            known = {(old["check"], old["unit"]): old for old in csv.DictReader(file)}
    known[row["check"], row["unit"]] = row
    rows = [known[name, kind] for name in CHECKS for kind in package.KINDS if (name, kind) in known]
    text = io.StringIO()
    writer = csv.DictWriter(text, FIELDS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    replace(RESULTS, text.getvalue())

    table = "| check | unit | cases | result | time, s |\n|---|---|---|---|---|\n"
    for row in rows:
        table += f"| `{row['check']}` | {row['unit']} | {int(row['cases']):,} | {row['result']} | {row['seconds']} |\n"
    path = RESULTS.with_suffix(".md")
    before, rest = path.read_text(encoding="utf-8").split(BEGIN)
    replace(path, before + BEGIN + table + END + rest.split(END)[1])


def main(
    only: Annotated[list[str] | None, typer.Option(help="Checks to run; default: all.")] = None,
    share: Annotated[float, typer.Option(help="Part of the full count.")] = 1.0,
    list_: Annotated[bool, typer.Option("--list", help="Name the checks and end.")] = False,
    write: Annotated[bool, typer.Option(help="Put the results into the table of docs/reliability.md.")] = False,
) -> None:
    """Run the reliability checks."""
    if list_:
        for name, check in CHECKS.items():
            typer.echo(f"{name:12} {check.full:9}  {check.run.__doc__.strip()}")
        return
    if unknown := set(only or ()) - set(CHECKS):
        raise typer.BadParameter(f"{', '.join(sorted(unknown))}: the checks are {', '.join(CHECKS)}")
    all_well = True
    with tempfile.TemporaryDirectory() as temporary:
        folders = {kind: unpack(kind, Path(temporary)) for kind in package.KINDS}
        for name in only or CHECKS:
            check = CHECKS[name]
            count = max(1, round(share * check.full))
            for kind in package.KINDS:
                begin = time.perf_counter()
                well, result = guarded(name, kind, folders[kind], count, check.timeout)
                seconds = round(time.perf_counter() - begin)
                all_well &= well
                result = result if well else f"**failed**: {result}"
                typer.echo(f"{name} of the {kind}, {count:,} cases in {seconds} s: {result}")
                if write:
                    record(dict(zip(FIELDS, (name, kind, count, result, seconds))))
    raise typer.Exit(0 if all_well else 1)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--continue"]:
        continued(*sys.argv[2:])
    else:
        typer.run(main)
