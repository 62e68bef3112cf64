"""The units as unpacked FMUs, called through the C functions of fmpy, and processes for trials."""

import copy
import hashlib
import json
import math
import multiprocessing
from array import array
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from fmpy.fmi1 import FMICallException

from tests.slaves import FMU2Unpacked

OK, WARNING, DISCARD, ERROR = range(4)
SCENE = json.loads(Path(__file__).with_name("scene.json").read_text(encoding="utf-8"))
"""A thick flag in a stream, small enough for a million cases."""
WING = json.loads(Path(__file__).with_name("wing.json").read_text(encoding="utf-8"))
"""A square wing with a vein at its edge, with steps of the same length."""
STEP = SCENE["time"]["communication_step"]
INPUTS = {
    "rod": ("force_x", "force_y"),
    "wing": ("force_x", "force_y", "force_z"),
    "fluid": ("x", "y", "vx", "vy"),
}
"""Inputs that the checks change."""


class FMU2Unit(FMU2Unpacked):
    """A unit whose methods raise FMICallException, while `call` returns a status; `new` makes instances of it."""

    def __init__(self, kind: str, folder: Path):
        super().__init__(folder)
        self.kind, self.steps = kind, 0
        self.inputs, self.outputs = self.references("input", INPUTS[kind]), self.references("output")

    def references(self, causality: str, names: Sequence[str] = ()) -> list[int]:
        """Return value references of the Real variables of a causality, or of the given arrays only."""
        variables = [v for v in self.variables if v.causality == causality and v.type == "Real"]
        return [v.valueReference for v in variables if not names or v.name.split("[")[0] in names]

    def new(self, start: bool = True) -> "FMU2Unit":
        """Return an instance; with `start`, it is ready for its first step at t = 0."""
        unit = copy.copy(self)
        unit.instantiate(callbacks=self.log)
        if start:
            unit.start()
        return unit

    def start(self) -> None:
        """Go through initialization, up to the first step."""
        self.enter()
        self.exitInitializationMode()

    def enter(self) -> None:
        """Enter initialization mode."""
        self.setupExperiment(startTime=0.0)
        self.enterInitializationMode()
        self.rest = self.getReal(self.inputs)

    def call(self, name: str, *arguments: object) -> int:
        return self._functions[f"fmi2{name}"](self.component, *arguments)

    def step(self, load: float | None = None) -> None:
        """Make one step with a load on the inputs, which by default follows from the number of the step."""
        load = 1e-4 * math.sin(self.steps + 1.0) if load is None else load
        self.setReal(self.inputs, [rest + load * (1 + k % 3) for k, rest in enumerate(self.rest)])
        self.doStep(self.steps * STEP, STEP)
        self.steps += 1

    def run(self, loads: int | Sequence[float]) -> bytes:
        """Return the digest of all outputs after each of several steps, or under each of these loads."""
        digest = hashlib.sha256()
        for load in [None] * loads if isinstance(loads, int) else loads:
            self.step(load)
            digest.update(array("d", self.getReal(self.outputs)))
        return digest.digest()

    def serialize(self) -> bytes:
        state = self.getFMUstate()
        data = self.serializeFMUstate(state)
        self.freeFMUstate(state)
        return data

    def restore(self, data: bytes, steps: int) -> None:
        state = self.deSerializeFMUstate(data)
        self.setFMUstate(state)
        self.freeFMUstate(state)
        self.steps = steps

    def close(self) -> None:
        self.fmi2FreeInstance(self.component)


def tried(check: Callable[[FMU2Unit, int], str], kind: str, folder: Path, count: int) -> str:
    return check(FMU2Unit(kind, folder), count)


def child(method: str, timeout: float, target: Callable[..., object], *arguments: object) -> Any:
    """Return the value of `target` in a process of its own, started by `method` (fork, spawn, forkserver). Raise
    AssertionError if it fails, crashes, or has not ended after `timeout` (s)."""
    context: Any = multiprocessing.get_context(method)
    context.set_forkserver_preload(["tests.reliability.checks"])  # Each process is then as new, and starts at once
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
    except (AssertionError, FMICallException) as error:
        answers.put((False, str(error)))
