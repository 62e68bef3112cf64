"""Files of a run that is killed while it writes, or whose disk is full: each is the old or the new one."""

import json
import multiprocessing
import os
import random
import resource
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from mmap import mmap
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import numpy as np

from nervure.scene import validate
from nervure.simulation import checkpoint, results
from nervure.simulation.session import Session
from nervure.units import package
from nervure.units.describe import describe

from .unit import SCENE, FMU2Unit

LONGEST = 100  # Steps of a run that is killed again and again; then it begins anew
MOST_S = 0.05  # A run is killed within this time, s: it writes all its files in 3 to 10 ms
OPTIONS: checkpoint.Options = dict.fromkeys(("checkpoint_every", "fields_every", "series_every"))
TABLES = ("scene.json", "series.csv", "summary.json")
DISK = 1 << 20  # Size of the disk that gets full, bytes


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


class Run:
    """A unit alone that writes checkpoint and results after every step, as a run does at intervals and at its end.
    `outputs` and `tables` are those of an undisturbed run, by steps."""

    def __init__(self, kind: str, folder: Path, stack: ExitStack):
        fmus = {kind: package.pack(describe(kind, SCENE), folder)}
        self.session = session = stack.enter_context(Session(validate(SCENE), folder, fmus))
        self.unit, self.kept = session.units[kind], checkpoint.Checkpoint(session, OPTIONS)
        session.start()
        session.scheme.start = lambda: None  # `restore` starts the units of a new session
        self.kept.save()
        self.start = checkpoint.read(folder)
        self.outputs = [self.unit.outputs.copy()]
        self.tables: list[dict[str, bytes]] = [{}]
        for _ in range(LONGEST + 1):
            session.step()
            self.write()
            self.outputs.append(self.unit.outputs.copy())
            self.tables.append({name: data for name, data in contents(folder).items() if name in TABLES})

    def write(self) -> None:
        summary: Any = SimpleNamespace(document=lambda: {"steps": self.session.steps})
        recorder = self.session.recorder
        results.write(results.Results(self.session.facts, self.folder, summary, recorder.series, recorder.units), {})

    @property
    def folder(self) -> Path:
        return self.kept.path.parent

    def load(self) -> int:
        """Go to the checkpoint in the folder; return the steps done."""
        checkpoint.restore(self.session, checkpoint.read(self.folder))
        return self.session.steps

    def begin(self, folder: Path) -> None:
        """Go back to the start, with nothing but its checkpoint in `folder`."""
        self.kept.path = folder / results.CHECKPOINT
        folder.mkdir(exist_ok=True)
        for path in folder.iterdir():
            path.unlink()
        checkpoint.restore(self.session, self.start)
        self.kept.save()

    def go_on(self, progress: mmap) -> None:
        """Make steps from the checkpoint on, and note the step whose files are begun and the one whose files are
        written."""
        for done in range(self.load() + 1, LONGEST + 1):
            self.session.step()
            progress[0] = done
            self.kept.save()
            self.write()
            progress[1] = done

    def check(self, saved: range, written: range) -> tuple[int, int]:
        """Check that the checkpoint is of one of the steps `saved`, that a step from it is that of an undisturbed run,
        and that the tables are of one of the steps `written`. Return both steps."""
        done = self.load()
        assert done in saved, f"the checkpoint is of step {done}, not of {saved}"
        found = contents(self.folder)
        for name in TABLES:
            allowed = [self.tables[k].get(name) for k in written]
            assert found.get(name) in allowed, f"{name} is not that of a step in {written}"
        self.session.step()
        same = np.array_equal(self.unit.outputs, self.outputs[done + 1])
        assert same, f"step {done + 1} is another one after the checkpoint"
        return done, json.loads(found["summary.json"])["steps"] if "summary.json" in found else 0


def kills(unit: FMU2Unit, count: int) -> str:
    """Kill a run while it writes checkpoint and results: the old or the new ones load, and the run continues from
    them."""
    chance, progress, inside, done = random.Random(5), mmap(-1, 2), 0, LONGEST
    with TemporaryDirectory() as place, ExitStack() as stack:
        run = Run(unit.kind, Path(place), stack)
        for case in range(count):
            if done > LONGEST // 2:
                run.begin(Path(place, "run"))
                done = written = 0
            progress[:], begin = bytes(2), time.time_ns()
            process = multiprocessing.get_context("fork").Process(target=run.go_on, args=(progress,))
            process.start()
            time.sleep(chance.uniform(0.0, MOST_S))
            process.kill()
            process.join()
            began, finished = progress[:]
            assert process.exitcode == -signal.SIGKILL or finished == LONGEST, f"case {case} ended by itself"
            inside += any(path.stat().st_mtime_ns > begin for path in run.folder.glob("unfinished-*"))
            end = max(began, done) + 1
            done, written = run.check(range(max(finished, done), end), range(max(finished, written), end))
    return f"old or new, and on to the same bits; {inside} were killed within a file"


def full_disks(unit: FMU2Unit, count: int) -> str:
    """Fill the disk while checkpoint and results are written: the old or the new ones load, none is half-written."""
    chance = random.Random(6)
    with ExitStack() as stack:
        place = Path(stack.enter_context(TemporaryDirectory()))
        disk = place / "disk"
        disk.mkdir()
        run = Run(unit.kind, place, stack)
        refused = filled(run, place / "run", None, chance, count)
        said = f"limit on the size of files: {refused} writes refused, {2 * count - refused} made"
        mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "tmpfs", str(disk)]
        if subprocess.run(mount, check=False, capture_output=True).returncode:
            return f"{said}; no full disk, which takes the right to mount one"
        stack.callback(subprocess.run, ["umount", "-l", str(disk)], check=True)
        refused = filled(run, disk, disk, chance, count)
        return f"{said}; full tmpfs: {refused} refused, {2 * count - refused} made; old or new after each"


def filled(run: Run, folder: Path, disk: Path | None, chance: random.Random, count: int) -> int:
    """Write checkpoint and results `count` times with little room; return how many of both were refused."""
    refused, saved = 0, LONGEST
    for _ in range(count):
        if saved == LONGEST:
            run.begin(folder)
            run.session.step()
            saved = written = 0
        done, before = saved + 1, contents(folder)
        writes = {run.kept.save: {results.CHECKPOINT: before[results.CHECKPOINT]}, run.write: run.tables[done]}
        for write, files in writes.items():
            try:
                with scarce(disk, chance.uniform(0.0, 1.5), [len(data) for data in files.values()]):
                    write()
            except OSError:
                refused, after = refused + 1, contents(folder)
                changed = [name for name in files if after.get(name) != before.get(name)]
                assert not changed, f"step {done}: {', '.join(changed)} changed, though the write was refused"
            else:
                saved, written = (done, written) if write == run.kept.save else (saved, done)
        left = contents(folder).keys() - {results.CHECKPOINT, *TABLES}
        assert not left, f"step {done}: {sorted(left)} is left"
        run.check(range(saved, saved + 1), range(written, written + 1))
    return refused


@contextmanager
def scarce(disk: Path | None, share: float, sizes: list[int]) -> Iterator[None]:
    """Leave about `share` of the room for files of these sizes on `disk`; without a disk, limit the size of a file to
    `share` of the longest."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        if disk:
            free = os.statvfs(disk)
            room = int(share * sum(-(-size // free.f_frsize) for size in sizes))
            (disk / "filler").write_bytes(bytes(max(0, free.f_bavail - room) * free.f_frsize))
        else:
            resource.setrlimit(resource.RLIMIT_FSIZE, (int(share * max(sizes)), hard))
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        if disk:
            (disk / "filler").unlink()
