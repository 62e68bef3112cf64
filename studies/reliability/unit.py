"""The FMUs as files, through their C functions alone, and the processes in which they are tried."""

import ctypes
import hashlib
import json
import math
import multiprocessing
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

OK, WARNING, DISCARD, ERROR = range(4)
SCENE = json.loads(Path(__file__).with_name("scene.json").read_text(encoding="utf-8"))
"""A thick flag in a stream, small enough for a million cases."""
STEP = SCENE["time"]["communication_step"]
INPUTS = {"rod": ("force_x", "force_y"), "fluid": ("x", "y", "vx", "vy")}
"""Inputs that the checks change."""


def array(kind: Any, values: Sequence[Any]) -> ctypes.Array:
    return (kind * len(values))(*values)


def reals(references: Sequence[int], values: Sequence[float] | None = None) -> tuple[ctypes.Array, int, ctypes.Array]:
    """Arguments of GetReal and SetReal after the instance."""
    room = array(ctypes.c_double, [math.nan] * len(references) if values is None else values)
    return array(ctypes.c_uint, references), len(references), room


class Library:
    """An unpacked FMU with its library loaded; fmpy makes the prototypes of the C functions."""

    def __init__(self, kind: str, folder: Path):
        self.kind, self.folder = kind, folder
        self.description = fmpy.read_model_description(str(folder), validate=False)
        self.variables = self.description.modelVariables
        self.inputs, self.outputs = self.references("input", INPUTS[kind]), self.references("output")
        self.stations = self.references("output", INPUTS["fluid"])
        self.resources: bytes | None = (folder / "resources").as_uri().encode()
        self.messages: list[str] = []
        log = fmi2CallbackLoggerTYPE(lambda *said: self.messages.append(said[-1].decode()))
        self.callbacks = fmi2CallbackFunctions(logger=log)
        self.slowest = 0.0
        """Time of the slowest call, s."""
        self.load()

    def references(self, causality: str, names: Sequence[str] = ()) -> list[int]:
        """Value references of the Real variables of a causality, of the given arrays only if there are any."""
        variables = [v for v in self.variables if v.causality == causality and v.type == "Real"]
        return [v.valueReference for v in variables if not names or v.name.split("[")[0] in names]

    def load(self) -> None:
        self.fmu = FMU2Slave(guid="", modelIdentifier=f"fmu_{self.kind}", unzipDirectory=str(self.folder))
        self.functions = self.fmu._functions

    def call(self, name: str, *arguments: object) -> Any:
        begin = time.perf_counter()
        status = self.functions[f"fmi2{name}"](*arguments)
        self.slowest = max(self.slowest, time.perf_counter() - begin)
        return status

    def instantiate(self) -> int | None:
        guid = self.description.guid.encode()
        return self.call("Instantiate", b"unit", 1, guid, self.resources, self.callbacks, 0, 0)


class Unit:
    """An instance; with `start`, it is ready for its first step at t = 0."""

    def __init__(self, library: Library, start: bool = True):
        self.library, self.component, self.steps = library, library.instantiate(), 0
        assert self.component, library.messages[-1:]
        if start:
            self.start()

    def start(self) -> None:
        self.enter()
        self.rest = list(self.read(self.library.inputs))
        self.do("ExitInitializationMode")

    def enter(self) -> None:
        """Enter initialization mode."""
        self.do("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
        self.do("EnterInitializationMode")

    def call(self, name: str, *arguments: object) -> int:
        return self.library.call(name, self.component, *arguments)

    def do(self, name: str, *arguments: object) -> None:
        """Call a function that must not fail."""
        status = self.call(name, *arguments)
        assert status == OK, f"{name} returned {status}: {self.library.messages[-1:]}"

    def read(self, references: Sequence[int]) -> ctypes.Array:
        arguments = reals(references)
        self.do("GetReal", *arguments)
        return arguments[2]

    def step(self, load: float | None = None) -> None:
        """One step with a load on the inputs, which else follows from the number of the step."""
        load = 1e-4 * math.sin(self.steps + 1.0) if load is None else load
        values = [rest + load * (1 + k % 3) for k, rest in enumerate(self.rest)]
        self.do("SetReal", *reals(self.library.inputs, values))
        self.do("DoStep", self.steps * STEP, STEP, 1)
        self.steps += 1

    def run(self, loads: int | Sequence[float]) -> bytes:
        """Digest of all outputs after each of so many steps, or under each of these loads."""
        digest = hashlib.sha256()
        for load in [None] * loads if isinstance(loads, int) else loads:
            self.step(load)
            digest.update(self.read(self.library.outputs))
        return digest.digest()

    def keep(self) -> ctypes.c_void_p:
        """Handle of the state."""
        handle = ctypes.c_void_p()
        self.do("GetFMUstate", handle)
        return handle

    def serialize(self) -> bytes:
        handle, size = self.keep(), ctypes.c_size_t()
        self.do("SerializedFMUstateSize", handle, size)
        buffer = ctypes.create_string_buffer(size.value)
        self.do("SerializeFMUstate", handle, buffer, size)
        self.do("FreeFMUstate", handle)
        return buffer.raw

    def deserialize(self, data: bytes) -> tuple[int, ctypes.c_void_p]:
        """Status of the call, and the handle of the state."""
        handle, buffer = ctypes.c_void_p(), (ctypes.c_char * len(data)).from_buffer_copy(data)
        return self.call("DeSerializeFMUstate", buffer, len(data), handle), handle

    def restore(self, data: bytes, steps: int) -> None:
        status, handle = self.deserialize(data)
        assert status == OK, self.library.messages[-1:]
        self.do("SetFMUstate", handle)
        self.do("FreeFMUstate", handle)
        self.steps = steps

    def close(self) -> None:
        self.library.call("FreeInstance", self.component)


def tried(check: Callable[[Library, int], str], kind: str, folder: Path, count: int) -> str:
    return check(Library(kind, folder), count)


def child(method: str, timeout: float, target: Callable[..., object], *arguments: object) -> Any:
    """What `target` returns in a process of its own by `method` (fork, spawn); AssertionError where it fails, crashes
    or has not ended after `timeout` (s)."""
    context = multiprocessing.get_context(method)
    answers = context.SimpleQueue()
    process = context.Process(target=_answer, args=(answers, target, *arguments))
    process.start()
    process.join(timeout)
    code = process.exitcode
    process.kill()
    process.join()
    assert code is not None, f"hung: no end after {timeout:.0f} s"
    assert code == 0, f"crashed with exit code {code}"
    well, answer = answers.get()
    assert well, answer
    return answer


def _answer(answers: Any, target: Callable[..., object], *arguments: object) -> None:
    try:
        answers.put((True, target(*arguments)))
    except AssertionError as error:
        answers.put((False, str(error)))
