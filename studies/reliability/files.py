"""What is on the disk when a run is killed while it writes, or when the disk is full: the old or the new file."""

import json
import os
import random
import resource
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np

from nervure import checkpoint, coupling, report
from nervure.recorder import Recorder
from nervure.unit import Unit

from .unit import SCENE, STEP, Library

LONGEST = 100
"""Steps of a run that is killed again and again; then it begins anew."""

MOST_S = 0.05
"""A run is killed within this time, s: it writes all its files in 3 to 10 ms."""

TABLES = ("scene.json", "series.csv", "summary.json")

DISK = 1 << 20
"""Size of the disk that gets full, bytes."""


class Run:
    """A unit alone that writes a checkpoint and its results after every step, as a run does at intervals and at its end."""

    def __init__(self, library: Library, folder: Path):
        fmu = library.path.parents[3] / f"{SCENE['name']}-{library.kind}.fmu"
        self.unit = Unit(fmu, library.kind, SCENE["time"]["end"])
        self.scheme = coupling.Single(self.unit)
        self.recorder = Recorder({library.kind: self.unit}, LONGEST + 1)
        self.scheme.start()
        self.recorder.record(0, 0.0, 0)
        self.place(folder)

    def place(self, folder: Path) -> None:
        """Write into `folder` from now on."""
        self.folder = folder
        self.saved = checkpoint.Checkpoint(folder, SCENE, {}, {self.unit.name: self.unit}, self.scheme, self.recorder)

    def step(self, done: int) -> None:
        """Make step number `done`, counted from 1."""
        self.scheme.step((done - 1) * STEP, STEP)
        self.recorder.record(done, done * STEP, 1)

    def save(self, done: int) -> None:
        self.saved.save(done, 0.0)

    def write(self, done: int) -> None:
        report.write(self.folder, SCENE, self.recorder, self.scheme, {"steps": done})

    def restore(self) -> int:
        """Put the run back to its checkpoint; returns the steps that it had made."""
        return self.saved.restore(checkpoint.read(self.folder))[0]


class Reference:
    """The files of a run that nothing happens to, by steps."""

    def __init__(self, run: Run, folder: Path):
        run.place(folder)
        run.save(0)
        self.start = checkpoint.read(folder)
        self.outputs, self.tables = [run.unit.outputs.copy()], [{}]
        for done in range(1, LONGEST + 2):
            run.step(done)
            run.write(done)
            self.outputs.append(run.unit.outputs.copy())
            self.tables.append({name: (folder / name).read_bytes() for name in TABLES})

    def compare(self, run: Run, saved: int, written: int, most: int) -> tuple[int, int]:
        """Load all that is in the folder of `run`: the checkpoint must be of `saved` to `most` steps and go on as the
        reference did, the tables of `written` to `most`. Returns the steps of which they are."""
        done = run.restore()
        assert saved <= done <= most, f"the checkpoint is of step {done}, not of {saved} to {most}"
        for name in TABLES:
            found = (run.folder / name).read_bytes() if (run.folder / name).exists() else None
            allowed = [self.tables[k].get(name) for k in range(written, most + 1)]
            assert found in allowed, f"{name} is not that of step {written} to {most}"
        run.step(done + 1)
        assert np.array_equal(run.unit.outputs, self.outputs[done + 1]), f"step {done + 1} is another one after the checkpoint"
        last = run.folder / "summary.json"
        return done, json.loads(last.read_text(encoding="utf-8"))["steps"] if last.exists() else 0


def kills(library: Library, count: int) -> str:
    """SIGKILL while checkpoint and results are written: the old or the new ones load, and the run goes on from them."""
    chance = random.Random(5)
    with tempfile.TemporaryDirectory() as temporary:
        folder, apart = Path(temporary, "run"), Path(temporary, "reference")
        folder.mkdir()
        apart.mkdir()
        run = Run(library, apart)
        reference = Reference(run, apart)
        run.place(folder)
        run.saved.restore(reference.start)
        run.save(0)
        done = written = inside = 0
        for case in range(count):
            if done > LONGEST // 2:
                for path in folder.iterdir():
                    path.unlink()
                run.saved.restore(reference.start)
                run.save(0)
                done = written = 0
            begin = time.time_ns()
            began, finished = _killed(run, chance.uniform(0.0, MOST_S))
            inside += any(path.stat().st_mtime_ns > begin for path in folder.glob("unfinished-*"))
            try:
                done, written = reference.compare(run, max(finished, done), max(finished, written), max(began, done))
            except (AssertionError, checkpoint.CheckpointError) as error:
                raise AssertionError(f"case {case}: {error}") from None
        run.unit.close()
    return f"old or new, and on to the same bits; {inside} were killed within a file"


def _killed(run: Run, after: float) -> tuple[int, int]:
    """Go on with `run` in a process that is killed `after` so many seconds; returns the last steps whose files it began
    to write and had written."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            for done in range(run.restore() + 1, LONGEST + 1):
                run.step(done)
                os.write(writer, bytes((done,)))
                run.save(done)
                run.write(done)
        finally:
            os._exit(1)
    os.close(writer)
    time.sleep(after)
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    with open(reader, "rb") as said:
        steps = said.read()
    reached_end = bool(steps) and steps[-1] == LONGEST
    assert os.WIFSIGNALED(status) or reached_end, "the process ended by itself"
    return steps[-1] if steps else 0, steps[-2] if len(steps) > 1 else 0


def full_disks(library: Library, count: int) -> str:
    """A disk that gets full while checkpoint and results are written: the old or the new ones load, nothing half-written."""
    chance = random.Random(6)
    with ExitStack() as stack:
        temporary = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        folder, apart, disk = (temporary / name for name in ("run", "reference", "disk"))
        for path in (folder, apart, disk):
            path.mkdir()
        run = Run(library, apart)
        stack.callback(run.unit.close)
        reference = Reference(run, apart)
        mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "tmpfs", str(disk)]
        mounted = subprocess.run(mount, capture_output=True).returncode == 0
        if mounted:
            stack.callback(subprocess.run, ["umount", "-l", str(disk)], check=True)
        refused = [_filled(run, reference, folder, chance, count, _limited)]
        said = f"limit on the size of files: {refused[0]} writes refused, {2 * count - refused[0]} made"
        if not mounted:
            return f"{said}; no full disk, which takes the right to mount one"
        refused.append(_filled(run, reference, disk, chance, count, _crowded))
        return f"{said}; full tmpfs: {refused[1]} refused, {2 * count - refused[1]} made; old or new after each"


def _filled(run: Run, reference: Reference, folder: Path, chance: random.Random, count: int, scarce) -> int:
    """Write checkpoint and results `count` times where room is `scarce`; returns how many of both were refused."""
    run.place(folder)
    refused, saved = 0, LONGEST
    for case in range(count):
        if saved == LONGEST:
            for path in folder.iterdir():
                path.unlink()
            run.saved.restore(reference.start)
            run.step(1)
            run.save(1)
            run.write(1)
            run.step(2)
            saved = written = 1
        done = saved + 1
        before = {path.name: path.read_bytes() for path in folder.iterdir()}
        for write, files in ((run.save, (checkpoint.FILE,)), (run.write, TABLES)):
            try:
                with scarce(folder, chance.uniform(0.0, 1.5), [len(before[name]) for name in files]):
                    write(done)
            except OSError:
                refused += 1
                changed = [name for name in files if (folder / name).read_bytes() != before[name]]
                assert not changed, f"case {case}: {', '.join(changed)} changed, though the write was refused"
                continue
            if write == run.save:
                saved = done
            else:
                written = done
        left = {path.name for path in folder.iterdir()}
        assert left == before.keys(), f"case {case}: {sorted(left ^ before.keys())} is left"
        tables = {name: (folder / name).read_bytes() for name in TABLES}
        assert tables == reference.tables[written], f"case {case}: the results are not those of step {written}"
        assert run.restore() == saved, f"case {case}: the checkpoint is not of step {saved}"
        run.step(saved + 1)
        assert np.array_equal(run.unit.outputs, reference.outputs[saved + 1]), f"case {case}: another step {saved + 1}"
    return refused


@contextmanager
def _limited(_folder: Path, share: float, sizes: list[int]) -> Iterator[None]:
    """No file may be longer than `share` of the longest one."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (int(share * max(sizes)), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@contextmanager
def _crowded(folder: Path, share: float, sizes: list[int]) -> Iterator[None]:
    """The disk of `folder` has about `share` of the room left that the files take on it."""
    filler = folder / "filler"
    disk = os.statvfs(folder)
    needed = sum(-(-size // disk.f_frsize) for size in sizes)
    with open(filler, "wb") as file:
        file.write(bytes(max(0, disk.f_bavail - int(share * needed)) * disk.f_frsize))
    try:
        yield
    finally:
        filler.unlink()
