"""What else is done to a unit and to the process around it: inputs, states, memory, threads, forks, modes."""

import ctypes
import math
import os
import random
import struct
import zlib
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .unit import ERROR, OK, STEP, Library, Unit, child, reals

HOSTILE = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1e200, 1e100, -1e50, 1e20, -1e10, 1e6, 1e3, -1.0, 5e-324, 0.0)
STEPS = (math.nan, math.inf, -math.inf, 1e308, 1e100, 1e20, 1e9, 1e6, -1.0, 0.0, 5e-324, 1e-300, 1e-100, 1e-20)


def hostile(library: Library, count: int) -> str:
    """NaN, infinite and huge inputs, parameters and steps: an error or finite outputs, each in under 1 s."""
    chance, ends, unit, fresh = random.Random(1), Counter(), Unit(library), Unit(library)
    everything = [v.valueReference for v in library.variables if v.type == "Real"]
    inputs, parameters, saved = library.references("input"), library.references("parameter"), unit.keep()
    for case in range(count):
        step, status = STEP, OK
        if case % 5 == 4:  # a new instance, for parameters
            unit.close()
            unit = Unit(library, start=False)
            unit.enter()
            status = unit.call("SetReal", *reals([chance.choice(parameters)], [chance.choice(HOSTILE)]))
            status = max(status, unit.call("ExitInitializationMode"))
        elif case % 5 == 3:
            unit.do("SetFMUstate", saved)
            step = chance.choice(STEPS)
        else:
            unit.do("SetFMUstate", saved)
            chosen = chance.sample(inputs, chance.choice([1, 2, len(inputs)]))
            status = unit.call("SetReal", *reals(chosen, [chance.choice(HOSTILE)] * len(chosen)))
        if status != OK:
            ends["refused"] += 1
        elif unit.call("DoStep", 0.0, step, 1) != OK:
            ends["failed"] += 1
        else:
            arguments = reals(everything)
            status = unit.call("GetReal", *arguments)
            wrong = [reference for reference, value in zip(everything, arguments[2]) if not math.isfinite(value)]
            assert status != OK or not wrong, (
                f"case {case}: {wrong} are not finite after a step of {step} with status OK"
            )
            ends["finite"] += 1
        if case % 5 == 4:
            unit.close()
            unit = Unit(library)
            saved = unit.keep()
    assert library.slowest < 1.0, f"a call took {library.slowest} s"
    unit.do("SetFMUstate", saved)
    assert unit.rest == fresh.rest and unit.run(3) == fresh.run(3), "the instance is not what it was"
    said = f"{ends['refused']} refused, {ends['failed']} steps failed, {ends['finite']} finite"
    return f"{said}; slowest call {library.slowest:.2g} s"


BEFORE, AFTER = 5, 3
"""Steps up to the state that is damaged, and steps that are compared after it."""
HEADER = 62
"""Bytes before the payload of a serialized state; the last twelve are its length and checksum (crates/fmi2/src/snapshot.rs)."""


def damage(data: bytes, chance: random.Random) -> bytes:
    """`data` with bits turned, bytes overwritten, cut, lengthened or moved."""
    at, length, turned = chance.randrange(len(data)), chance.randint(1, 64), bytearray(data)
    for _ in range(chance.randint(1, 8)):
        turned[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    before, after, noise = data[:at], data[at + length :], chance.randbytes(length)
    overwritten = (before + noise)[: len(data)] + after
    return chance.choice([bytes(turned), overwritten, before, data + noise, before + after, before + noise + data[at:]])


def damaged(library: Library, count: int, forge: bool) -> tuple[int, Counter]:
    """Damage a state `count` times, with `forge` under a right length and checksum; returns its size and what came of it."""
    chance, unit, ends = random.Random(3), Unit(library), Counter()
    unit.run(BEFORE)
    data, expected = unit.serialize(), unit.run(AFTER)
    for case in range(count):
        changed = damage(data[HEADER:] if forge else data, chance)
        if forge:
            changed = data[: HEADER - 12] + struct.pack("<QI", len(changed), zlib.crc32(changed)) + changed
        status, handle = unit.deserialize(changed)
        if changed == data:
            assert status == OK
        elif not forge or status != OK:
            assert status == ERROR and handle.value is None, f"case {case}: status {status}"
            ends["refused"] += 1
        else:
            arguments = reals(library.outputs)
            calls = (("SetFMUstate", handle), ("DoStep", BEFORE * STEP, STEP, 1), ("GetReal", *arguments))
            status, values = max([unit.call(*call) for call in calls]), list(arguments[2])
            assert status in (OK, ERROR)
            assert status == ERROR or all(map(math.isfinite, values)), f"case {case}: {values} with status OK"
            ends["error" if status == ERROR else "fine"] += 1
        unit.do("FreeFMUstate", handle)
        library.messages.clear()
        if case % (1000 if forge else 100_000) == 0 or case == count - 1:
            unit.restore(data, BEFORE)
            assert unit.run(AFTER) == expected, f"the instance is not what it was after case {case}"
    return len(data), ends


def corrupted(library: Library, count: int) -> str:
    """Damaged and truncated serialized states: every one refused, the instance unharmed."""
    return f"states of {damaged(library, count, forge=False)[0]} bytes, all refused"


def forged(library: Library, count: int) -> str:
    """Damaged states under a right length and checksum: refused or taken, but never more than an error."""
    ends = damaged(library, count, forge=True)[1]
    return f"{ends['refused']} refused, {ends['fine'] + ends['error']} taken, of which {ends['error']} led to an error"


def elsewhere(kind: str, folder: Path, steps: int, data: bytes = b"", done: int = 0) -> bytes:
    """A run in another process, from the start or from a serialized state after `done` steps."""
    unit = Unit(Library(kind, folder))
    if data:
        unit.restore(data, done)
    return unit.run(steps)


def processes(library: Library, count: int) -> str:
    """Save, restore in a new process, continue: the same bits."""
    for case in range(count):
        unit = Unit(library)
        unit.run(1 + case % 20)
        there = child("spawn", 300.0, elsewhere, library.kind, library.folder, 10, unit.serialize(), unit.steps)
        assert there == unit.run(10), f"case {case} continued differently"
        unit.close()
    return "bit-identical over 10 steps"


def rollbacks(library: Library, count: int) -> str:
    """A step, a rollback over it and the step again: the bits of a run without."""
    straight, rolled = Unit(library), Unit(library)
    handle = rolled.keep()
    for case in range(count):
        rolled.do("GetFMUstate", handle)
        rolled.do("SetReal", *reals(library.inputs, [rest * (1 + 1e-3) + 1e-4 for rest in rolled.rest]))
        rolled.do("DoStep", rolled.steps * STEP, 1.5 * STEP, 0)
        rolled.do("SetFMUstate", handle)
        assert straight.run(1) == rolled.run(1), f"rollback {case} left a trace"
    return "bit-identical"


def instances(library: Library, count: int) -> str:
    """Instantiate, initialise, step and free: less than 1 MB of growth."""
    pages, warm_up = [], 200
    for cycle in range(warm_up + count + 1):
        if cycle in (warm_up, warm_up + count):
            pages.append(int(Path("/proc/self/statm").read_text().split()[1]))
        unit = Unit(library)
        unit.step()
        assert unit.keep().value  # not freed: the instance does that
        unit.close()
    growth = (pages[1] - pages[0]) * os.sysconf("SC_PAGE_SIZE")
    assert growth < 1 << 20, f"{growth} bytes more after {count} instances"
    return f"grew by {growth / 1024:.0f} kB"


def loads(library: Library, count: int) -> str:
    """Load, step, fail and unload: no thread, mapping or descriptor stays."""
    library.fmu.freeLibrary()
    for case in range(count + 1):
        maps = Path("/proc/self/maps").read_text().splitlines()
        ours = sum(f"fmu_{library.kind}" in line for line in maps)
        traces = len(os.listdir("/proc/self/task")), len(os.listdir("/proc/self/fd")), ours
        if case == 0:
            before = traces
            assert ours == 0, "the library is still mapped after it was unloaded"
        assert traces == before, f"cycle {case}: threads, descriptors, mappings {traces} after {before}"
        if case == min(count, 100):
            mappings = len(maps)
        if case == count:
            break
        library.load()
        unit = Unit(library)
        unit.step()
        assert unit.call("DoStep", -1.0, -1.0, 0) == ERROR
        unit.close()
        library.fmu.freeLibrary()
        library.messages.clear()
    grown = len(maps) - mappings
    assert grown <= 2, f"{grown} more mappings"
    return f"threads, descriptors and mappings as before; {grown:+d} mappings in all"


def threads(library: Library, count: int) -> str:
    """Instances on eight threads: the results of one after the other."""
    serial = Unit(library).run(50)
    with ThreadPoolExecutor(8) as pool:
        results = list(pool.map(lambda _: Unit(library).run(50), range(count)))
    assert results == [serial] * count, f"{sum(result != serial for result in results)} results differ"
    return f"{count} bit-identical results"


def inherited(unit: Unit) -> tuple[bytes, bytes]:
    return unit.run(5), Unit(unit.library).run(5)


def forks(library: Library, count: int) -> str:
    """Processes by fork, with an instance in use, and by spawn: they end, with the same bits."""
    first, unit = Unit(library).run(5), Unit(library)
    unit.run(3)
    data, after = unit.serialize(), unit.run(5)
    for case in range(count):
        unit.restore(data, 3)
        if case % 2:
            assert child("spawn", 300.0, elsewhere, library.kind, library.folder, 5) == first, f"{case}: another result"
        else:
            assert child("fork", 300.0, inherited, unit) == (after, first), f"{case}: another result"
        assert unit.run(5) == after, f"{case}: the parent's result changed"
    return "all ended, bit-identical in child and parent"


LIBM = ctypes.CDLL("libm.so.6")
MXCSR = 28
"""Where glibc's `fenv_t` keeps the register on x86-64, whose exceptions (0x1f80 masked, 0x3f raised) are no modes."""
MODES = [rounding | flush for rounding in (0, 0x2000, 0x4000, 0x6000) for flush in (0, 0x8000, 0x40, 0x8040)]


def set_mode(mode: int) -> int:
    """Set rounding direction and flushing; returns those that were."""
    environment = ctypes.create_string_buffer(64)
    LIBM.fegetenv(environment)
    (former,) = struct.unpack_from("<I", environment, MXCSR)
    struct.pack_into("<I", environment, MXCSR, 0x1F80 | mode)
    LIBM.fesetenv(environment)
    return former & ~0x3F & ~0x1F80


class InMode(Unit):
    """A unit that is called in a floating-point mode of the host."""

    def __init__(self, library: Library, mode: int):
        self.mode = mode
        super().__init__(library)

    def do(self, name: str, *arguments: object) -> None:
        set_mode(self.mode)
        status = self.call(name, *arguments)
        left = set_mode(0)
        assert (status, left) == (OK, self.mode), f"{name} in {self.mode:#x}: status {status}, mode left {left:#x}"


def modes(library: Library, count: int) -> str:
    """The host's rounding direction, flush-to-zero and denormals-are-zero: no bit changes, and they stay set."""
    chance, tiny = random.Random(4), [5e-324, 1e-310, 1 / 3, 1e-3]
    for case in range(count):
        loads = [1e-4 * chance.choice(tiny) * chance.random() for _ in range(10)]
        there, here = InMode(library, MODES[case % len(MODES)]), InMode(library, 0)
        assert there.run(loads) == here.run(loads), f"mode {there.mode:#x} changes the result"
        there.close()
        here.close()
    return f"{min(count, len(MODES))} combinations, bit-identical, modes as the host had them"
