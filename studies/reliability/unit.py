"""The FMUs as files, through the C functions alone."""

import _ctypes
import ctypes
import hashlib
import math
from pathlib import Path

import fmpy


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
        "time_stepping": {"max_step": STEP, "max_cfl": 0.3},
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
