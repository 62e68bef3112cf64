"""Serialized states: damaged, forged, taken to another process, and rollbacks."""

import ctypes
import math
import random
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

from .unit import ERROR, OK, POINTER, REAL, STEP, Library, Unit


BEFORE, AFTER = 5, 3
"""Steps up to the state that is damaged, and steps that are compared after it."""

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


def serialized(library: Library) -> tuple[Unit, bytes, bytes]:
    """A unit after a few steps, its state, and what the steps after it give."""
    unit = Unit(library)
    unit.run(BEFORE)
    data = unit.serialize()
    return unit, data, unit.run(AFTER)


def continues(unit: Unit, data: bytes, expected: bytes) -> bool:
    """Whether a unit that is put back into the state of `serialized` gives the same again."""
    unit.restore(data, BEFORE)
    return unit.run(AFTER) == expected


def corrupted(library: Library, count: int) -> str:
    """Damaged and truncated serialized states: every one refused, the instance unharmed."""
    chance = random.Random(2)
    unit, data, expected = serialized(library)
    for case in range(count):
        changed, handle = damage(data, chance), POINTER()
        if changed == data:
            continue
        status = library.DeSerializeFMUstate(unit.component, changed, len(changed), ctypes.byref(handle))
        assert status == ERROR and handle.value is None, f"case {case}: status {status}"
        library.messages.clear()
        if case % 100_000 == 0:
            assert continues(unit, data, expected), f"case {case} changed the instance"
    assert continues(unit, data, expected), "the instance is not what it was"
    return f"states of {len(data)} bytes, all refused"


def forged(library: Library, count: int) -> str:
    """Damaged states under a right length and checksum: refused or taken, but never more than an error."""
    chance = random.Random(3)
    unit, data, expected = serialized(library)
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
            status = max(status, library.DoStep(unit.component, BEFORE * STEP, STEP, 1))
            values = (REAL * unit.output_size)()
            status = max(status, library.GetReal(unit.component, unit.outputs, unit.output_size, values))
            assert status in (OK, ERROR)
            assert status == ERROR or all(map(math.isfinite, values)), f"case {case}: {list(values)} with status OK"
            errors += status == ERROR
            unit.do("FreeFMUstate", ctypes.byref(handle))
        library.messages.clear()
        if case % 1000 == 0:
            assert continues(unit, data, expected), f"case {case} harmed the instance"
    assert continues(unit, data, expected), "the instance is not what it was"
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
            command = [sys.executable, Path(__file__).parent, "--continue", library.kind, str(folder), str(state), str(unit.steps)]
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
