"""The process around the units: memory, threads, forks, floating-point modes."""

import ctypes
import hashlib
import multiprocessing
import os
import random
import struct
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from .unit import ERROR, OK, REAL, STEP, Library, Unit


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
