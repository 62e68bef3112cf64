"""Excessive or foreign input of a unit: wild inputs, edited scenes, foreign states, little memory. The checks use the
shipped FSI3 pair."""

import ctypes
import json
import math
import random
import shutil
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fmpy.fmi1 import FMICallException

from nervure.errors import SceneError
from nervure.units import package
from nervure.units.describe import describe

from .trials import header
from .unit import FMU2Unit

FINITE = (
    1e308,
    -1e308,
    1e200,
    -1e100,
    1e50,
    -1e20,
    1e10,
    -1e6,
    1e4,
    -1e3,
    300.0,
    -100.0,
    30.0,
    -10.0,
    3.0,
    1e-300,
    0.0,
)
BEFORE = 5  # Steps up to the state in which an input turns wild
ANSWER_S = 1.0  # Each of the next two steps is to be answered within this processor time
PROBE = Path(__file__).with_name("probe.py")
LIMITS_MB = (50, 250)  # Address space of a process that tries a unit
OTHERS = 20  # Other scenes whose states are tried


def inputs(library: FMU2Unit, count: int) -> str:
    """Set one finite hostile input: each of the next two steps gives an error or finite outputs, in under 1 s."""
    chance, ends, slowest = random.Random(5), Counter[str](), 0.0
    scene = json.loads((library.folder / "resources" / "scene.json").read_text(encoding="utf-8"))
    h, wild = scene["time"]["communication_step"], library.references("input")
    unit = library.new()
    for step in range(BEFORE):
        unit.doStep(step * h, h)
    saved = unit.getFMUstate()
    for case in range(count):
        reference, value, end = chance.choice(wild), chance.choice(FINITE) * chance.random(), "finite"
        for step in (BEFORE, BEFORE + 1):
            begin = time.process_time()
            try:
                unit.setReal([reference], [value])
                unit.doStep(step * h, h)
                values = unit.getReal(library.outputs)
                assert all(map(math.isfinite, values)), f"case {case}: {value:.3e} gives a value that is not finite"
            except FMICallException:
                end = "failed"
            took = time.process_time() - begin
            assert took < ANSWER_S, f"case {case}: {value:.3e} for the reference {reference} took {took:.2f} s"
            slowest = max(slowest, took)
            if end == "failed":
                break
        ends[end] += 1
        unit.setFMUstate(saved)
    return f"{ends['failed']} refused with a reason, {ends['finite']} finite; slowest step {slowest:.2g} s"


def edit(text: str, chance: random.Random) -> str:
    """Return the text of a scene with one change: a digit, a byte, a missing or repeated piece, white space."""
    at, length = chance.randrange(len(text)), chance.randint(1, 30)
    digits = [k for k, letter in enumerate(text) if letter.isdigit()]
    k = chance.choice(digits)
    return chance.choice(
        [
            text[:k] + chance.choice("0123456789") + text[k + 1 :],
            text[:at] + chr(chance.randrange(32, 127)) + text[at + 1 :],
            text[:at] + text[at + length :],
            text[:at] + text[at : at + length] + text[at:],
            text + " " * length,
            text[:at],
        ]
    )


def edited(library: FMU2Unit, count: int) -> str:
    """Edit the scene in the FMU before it is instantiated: the unit refuses it by name, in at most 0.1 s."""
    chance, slowest, path = random.Random(6), 0.0, library.folder / "resources" / "scene.json"
    text = path.read_text(encoding="utf-8")
    with TemporaryDirectory() as folder:
        location = Path(folder).as_uri().encode()
        for case in range(count):
            changed = edit(text, chance)
            if changed == text:
                continue
            Path(folder, "scene.json").write_text(changed, encoding="utf-8")
            library.messages.clear()
            begin = time.process_time()
            found = library.fmi2Instantiate(b"unit", 1, library.guid.encode(), location, library.log, 0, 0)
            slowest = max(slowest, time.process_time() - begin)
            said = library.messages[-1:]
            assert found is None and said and "scene.json changed after the FMU was packed" in said[0], (
                f"{case}: {said}"
            )
    assert slowest < 0.1, f"a refusal took {slowest:.2g} s"
    return f"all refused by name; slowest {1e3 * slowest:.2g} ms"


def foreign(library: FMU2Unit, count: int) -> str:
    """Restore states of other scenes, of a scene of another name, and of other versions: each is refused by name."""
    chance, unit, ends = random.Random(7), library.new(), Counter[str]()
    own = unit.serialize()
    scene = json.loads((library.folder / "resources" / "scene.json").read_text(encoding="utf-8"))
    states: list[bytes] = []
    while len(states) < OTHERS:
        changed = dict(scene, name=f"{scene['name']}-{len(states)}") if len(states) % 2 else other_values(scene, chance)
        with TemporaryDirectory() as folder:
            try:
                there = FMU2Unit(library.kind, package.lay_out(describe(library.kind, changed), Path(folder)))
            except SceneError:
                continue
            states.append(there.new().serialize())
    for case in range(count):
        state = states[case % OTHERS]
        if case % 3 == 0:  # another version of the library, by the name in the header
            begin = header(own) - 50
            name = own[14:begin].replace(b"0.", b"%d." % chance.randrange(1, 10), 1)
            state = own[:14] + name + own[begin:]
        place = ctypes.c_void_p()
        library.messages.clear()
        try:
            unit.deSerializeFMUstate(state, place)
        except FMICallException:
            ends["refused"] += "the serialized state belongs to" in (library.messages or [""])[-1]
    assert ends["refused"] == count, f"only {ends['refused']} of {count} were refused by name"
    return "all refused by name"


def other_values(scene: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    """Return the scene with another density of the fluid, which changes no length of an array."""
    return scene | {"fluid": scene["fluid"] | {"density": scene["fluid"]["density"] * (1.0 - 0.1 * chance.random())}}


def memory(library: FMU2Unit, count: int) -> str:
    """Make instances and states in a process with little memory: an error with a message, never the end of the
    process."""
    chance, ends = random.Random(8), Counter[str]()
    with TemporaryDirectory() as folder:
        shutil.copy(PROBE, folder)  # its own folder is first on the path of a script
        for case in range(count):
            limit = chance.randint(*LIMITS_MB)
            binary = next(library.folder.glob("binaries/*/*"))
            command = [sys.executable, "-S", "-E", str(Path(folder, PROBE.name)), str(binary), library.guid]
            command += [(library.folder / "resources").as_uri(), str(limit)]
            answer = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
            said = answer.stdout.strip()
            assert answer.returncode == 0 and said, (
                f"{case}: {limit} MB: {answer.returncode}, {said}, {answer.stderr[-300:]}"
            )
            ends[said] += 1
    return ", ".join(f"{number} {what}" for what, number in sorted(ends.items()))
