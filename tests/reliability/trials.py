"""Mistreatment of a unit and of the process around it: inputs, states, memory, threads, forks, modes."""

import ctypes
import math
import os
import random
import struct
import time
import zlib
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from fmpy.fmi1 import FMICallException

from .unit import ERROR, STEP, FMU2Unit, child

HOSTILE = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1e200, 1e100, -1e50, 1e20, -1e10, 1e6, 1e3, -1.0, 5e-324, 0.0)
STEPS = (math.nan, math.inf, -math.inf, 1e308, 1e100, 1e20, 1e9, 1e6, -1.0, 0.0, 5e-324, 1e-300, 1e-100, 1e-20)
BEFORE, AFTER = 5, 3  # Steps up to the state that is damaged, and steps that are compared after it


def header(state: bytes) -> int:
    """Return the size of a state's header; its last 12 bytes are length and checksum (fmi-export/src/snapshot.rs)."""
    (name,) = struct.unpack_from("<H", state, 12)
    return 64 + int(name)


def hostile(library: FMU2Unit, count: int) -> str:
    """Give NaN, infinite and huge inputs, parameters and steps: an error or finite outputs, each case in under 1 s."""
    chance, ends, slowest, expected = random.Random(1), Counter[str](), 0.0, library.new().run(1)
    everything = [v.valueReference for v in library.variables if v.type == "Real"]
    inputs, parameters = library.references("input"), library.references("parameter")
    for case in range(count):
        unit, step, changed = library.new(start=case % 5 < 4), STEP, []
        saved = unit.getFMUstate()
        if case % 5 == 4:
            unit.enter()
            changed = [chance.choice(parameters)]
        elif case % 5 == 3:
            step = chance.choice(STEPS)
        else:
            changed = chance.sample(inputs, chance.choice([1, 2, len(inputs)]))
        values = [chance.choice(HOSTILE)] * len(changed) if changed else []
        end, begin = "refused", time.perf_counter()
        try:
            unit.setReal(changed, values)
            if case % 5 == 4:
                unit.exitInitializationMode()
            end = "failed"
            unit.doStep(0.0, step)
            end = "finite"
            wrong = {r: value for r, value in zip(everything, unit.getReal(everything)) if not math.isfinite(value)}
            assert not wrong, f"case {case}: {wrong} after a step of {step} with status OK"
        except FMICallException:
            pass
        ends[end] += 1
        slowest = max(slowest, time.perf_counter() - begin)
        unit.setFMUstate(saved)
        if case % 5 == 4:
            unit.start()
        assert unit.run(1) == expected, f"case {case}: the stored state leads elsewhere"
        unit.close()
    assert slowest < 1.0, f"a case took {slowest} s"
    said = f"{ends['refused']} refused, {ends['failed']} steps failed, {ends['finite']} finite"
    return f"{said}; slowest case {slowest:.2g} s"


def damaged(library: FMU2Unit, count: int, forge: bool) -> tuple[int, Counter]:
    """Damage a state, with `forge` under a right length and checksum; return its size and the outcomes."""
    chance, unit, ends = random.Random(3), library.new(), Counter[str]()
    unit.run(BEFORE)
    whole = unit.serialize()
    begin = header(whole)
    head, data = (whole[: begin - 12], whole[begin:]) if forge else (b"", whole)
    expected = unit.run(AFTER)
    for case in range(count):
        # Bits turned, bytes overwritten, the end cut off, bytes added, cut out and put between.
        at, length, turned = chance.randrange(len(data)), chance.randint(1, 64), bytearray(data)
        for _ in range(chance.randint(1, 8)):
            turned[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        before, after, noise = data[:at], data[at + length :], chance.randbytes(length)
        ways = [bytes(turned), (before + noise)[: len(data)] + after, before, data + noise, before + after]
        changed, state = chance.choice([*ways, before + noise + data[at:]]), ctypes.c_void_p()
        if changed == data:
            continue
        try:
            sealed = head + struct.pack("<QI", len(changed), zlib.crc32(changed)) + changed
            unit.deSerializeFMUstate(sealed if forge else changed, state)
            assert forge, f"case {case}: the state is taken"
            unit.setFMUstate(state)
            unit.doStep(BEFORE * STEP, STEP)
            values = unit.getReal(library.outputs)
            assert all(map(math.isfinite, values)), f"case {case}: {values} with status OK"
            ends["fine"] += 1
        except FMICallException as error:
            assert error.status == ERROR and (forge or not state), f"case {case}: status {error.status}, {state}"
            ends["error" if state else "refused"] += 1
        unit.freeFMUstate(state)
        library.messages.clear()
        if case % (1000 if forge else 100_000) == 0 or case == count - 1:
            unit.restore(whole, BEFORE)
            assert unit.run(AFTER) == expected, f"the instance is not what it was after case {case}"
    return len(whole), ends


def corrupted(library: FMU2Unit, count: int) -> str:
    """Restore damaged and truncated serialized states: every one is refused, and the instance is unharmed."""
    return f"states of {damaged(library, count, forge=False)[0]} bytes, all refused"


def forged(library: FMU2Unit, count: int) -> str:
    """Restore damaged states under a right length and checksum: refused or taken, with an error at most."""
    ends = damaged(library, count, forge=True)[1]
    return f"{ends['refused']} refused, {ends['fine'] + ends['error']} taken, of which {ends['error']} led to an error"


def elsewhere(kind: str, folder: Path, steps: int, data: bytes = b"", done: int = 0) -> bytes:
    """Run in another process, from the start or from a serialized state after `done` steps."""
    unit = FMU2Unit(kind, folder).new()
    if data:
        unit.restore(data, done)
    return unit.run(steps)


def processes(library: FMU2Unit, count: int) -> str:
    """Save, restore in a new process, and continue: the bits are the same."""
    for case in range(count):
        unit = library.new()
        unit.run(1 + case % 20)
        there = child("spawn", 300.0, elsewhere, unit.kind, unit.folder, 10, unit.serialize(), unit.steps)
        assert there == unit.run(10), f"case {case} continued differently"
        unit.close()
    return "bit-identical over 10 steps"


def rollbacks(library: FMU2Unit, count: int) -> str:
    """Make a step, roll back, and repeat the step: the bits are those of a run without."""
    straight, rolled = library.new(), library.new()
    for case in range(count):
        state = rolled.getFMUstate()
        rolled.setReal(library.inputs, [rest * (1 + 1e-3) + 1e-4 for rest in rolled.rest])
        rolled.doStep(rolled.steps * STEP, 1.5 * STEP, 0)
        rolled.setFMUstate(state)
        rolled.freeFMUstate(state)
        assert straight.run(1) == rolled.run(1), f"rollback {case} left a trace"
    return "bit-identical"


def instances(library: FMU2Unit, count: int) -> str:
    """Instantiate, initialize, step and free: memory grows by less than 1 MB."""
    pages, warm_up = [], 200
    for cycle in range(warm_up + count + 1):
        if cycle in (warm_up, warm_up + count):
            pages.append(int(Path("/proc/self/statm").read_text().split()[1]))
        unit = library.new()
        unit.step()
        assert unit.getFMUstate()  # not freed: the instance does that
        unit.close()
    growth = (pages[1] - pages[0]) * os.sysconf("SC_PAGE_SIZE")
    assert growth < 1 << 20, f"{growth} bytes more after {count} instances"
    return f"grew by {growth / 1024:.0f} kB"


def loads(library: FMU2Unit, count: int) -> str:
    """Load, step, fail and unload: no thread, mapping or descriptor stays."""
    traces, mappings = [], []
    for case in range(count + 1):
        library.freeLibrary()
        maps = Path("/proc/self/maps").read_text().splitlines()
        mappings.append(len(maps))
        ours = sum(str(library.folder) in line for line in maps)
        traces.append((len(os.listdir("/proc/self/task")), len(os.listdir("/proc/self/fd")), ours))
        assert ours == 0 and traces[0] == traces[-1], f"cycle {case}: {traces[-1]} after {traces[0]}"
        library.load()
        unit = library.new()
        unit.step()
        assert unit.call("DoStep", -1.0, -1.0, 0) == ERROR
        unit.close()
        library.messages.clear()
    grown = mappings[-1] - mappings[min(count, 100)]
    assert grown <= 2, f"{grown} more mappings"
    return f"threads, descriptors and mappings as before; {grown:+d} mappings in all"


def threads(library: FMU2Unit, count: int) -> str:
    """Run instances on eight threads: the results are those of one after the other."""
    serial = library.new().run(50)
    with ThreadPoolExecutor(8) as pool:
        results = list(pool.map(lambda _: library.new().run(50), range(count)))
    assert results == [serial] * count, f"{sum(result != serial for result in results)} results differ"
    return f"{count} bit-identical results"


def inherited(library: FMU2Unit, unit: FMU2Unit) -> tuple[bytes, bytes]:
    return unit.run(5), library.new().run(5)


def forks(library: FMU2Unit, count: int) -> str:
    """Start processes by fork, with an instance in use, and by spawn: they end, with the same bits."""
    fresh, unit = library.new().run(5), library.new()
    unit.run(3)
    data, after = unit.serialize(), unit.run(5)
    for case in range(count):
        unit.restore(data, 3)
        if case % 2:
            assert child("spawn", 300.0, elsewhere, unit.kind, unit.folder, 5) == fresh, f"{case}: another result"
        else:
            assert child("fork", 300.0, inherited, library, unit) == (after, fresh), f"{case}: another result"
        assert unit.run(5) == after, f"{case}: the parent's result changed"
    return "all ended, bit-identical in child and parent"


LIBM = ctypes.CDLL("libm.so.6")
MXCSR = 28
"""Offset of the register in glibc's `fenv_t` on x86-64; its exceptions (0x1f80 masked, 0x3f raised) are no modes."""
MODES = [rounding | flush for rounding in (0, 0x2000, 0x4000, 0x6000) for flush in (0, 0x8000, 0x40, 0x8040)]


def set_mode(mode: int) -> int:
    """Set rounding direction and flushing; return the former ones."""
    environment = ctypes.create_string_buffer(64)
    LIBM.fegetenv(environment)
    (former,) = struct.unpack_from("<I", environment, MXCSR)
    struct.pack_into("<I", environment, MXCSR, 0x1F80 | mode)
    LIBM.fesetenv(environment)
    return former & ~0x3F & ~0x1F80


class FMU2UnitInMode(FMU2Unit):
    """A unit that runs in a floating-point mode of its host."""

    mode = 0

    def _call(self, name: str, *arguments: object) -> int:
        set_mode(self.mode)
        try:
            return super()._call(name, *arguments)
        finally:
            left = set_mode(0)
            assert left == self.mode, f"{name} in mode {self.mode:#x} left {left:#x}"


def modes(library: FMU2Unit, count: int) -> str:
    """Change the host's rounding direction, flush-to-zero and denormals-are-zero: no bit changes, and the modes stay
    set."""
    chance, tiny = random.Random(4), [5e-324, 1e-310, 1 / 3, 1e-3]
    for case in range(count):
        loads = [1e-4 * chance.choice(tiny) * chance.random() for _ in range(10)]
        there = FMU2UnitInMode(library.kind, library.folder)
        there.mode, here = MODES[case % len(MODES)], library.new()
        assert there.new().run(loads) == here.run(loads), f"mode {there.mode:#x} changes the result"
    return f"{min(count, len(MODES))} combinations, bit-identical, modes as the host had them"
