"""Cases, what they depend on, and the one way in which all studies run them.

A case is known by a digest of its scene and of the sources that its result depends on. A case is run in a process of
its own, in a folder `results/studies/STUDY/CASE`, and leaves `run.json` there. It is run again only where neither that
file nor the committed record (`store`) has the digest of today.
"""

from __future__ import annotations

import hashlib
import json
import os
import shlex
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, field
from fnmatch import fnmatch
from functools import cached_property, lru_cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from nervure.errors import InputError
from nervure.files import write_whole
from nervure.resources import ROOT
from studies import machine, simulate

RESULTS = ROOT / "results" / "studies"

SOURCES: dict[str, tuple[str, ...]] = {
    "scene": ("crates/scene/src/**/*.rs",),
    "fluid": (
        "crates/fluid/src/**/*.rs",
        "crates/fluid/Cargo.toml",
        "crates/line-fft/src/**/*.rs",
        "fmu-fluid/src/**/*.rs",
    ),
    "rod": ("crates/rod/src/**/*.rs", "crates/rod/Cargo.toml", "fmu-rod/src/**/*.rs"),
    "coupling": ("python/nervure/coupling/*.py", "python/nervure/simulation/loop.py"),
    "evaluation": ("python/nervure/evaluate/**/*.py", "python/nervure/simulation/summary.py"),
    "rod study": ("studies/rust/rod/src/**/*.rs", "studies/rust/rod/Cargo.toml", "crates/rod/tests/common/*.rs"),
    "rod roofline": ("studies/rust/rod/examples/*.rs", "studies/rust/fluid/src/machine.rs"),
    "fluid bench": ("studies/rust/fluid/src/*.rs", "studies/rust/fluid/Cargo.toml"),
    "fluid measures": ("studies/rust/fluid/src/bin/*.rs", "crates/fluid/tests/common/*.rs"),
    "keeping": ("python/nervure/simulation/checkpoint.py", "python/nervure/output/fields.py"),
    "command": ("python/nervure/**/*.py",),
    "export": ("crates/fmi-export/src/**/*.rs", "crates/fpenv/src/**/*.rs"),
    "reliability": ("tests/reliability/*.py", "tests/reliability/scene.json"),
    "fuzz": ("tests/fuzz/*.py", "tests/fuzz/fuzz_targets/*.rs"),
    "peers": ("studies/peers/*.py",),
    "limits": ("studies/limits.py",),
    "plate": ("studies/plate.py",),
    "driven bar": ("studies/driven_bar.py",),
}
"""Sources by the name under which a case says that it depends on them."""

UNITS = ("scene", "fluid", "rod")  # Of these the libraries of the units are built

FLUID = ("scene", "fluid", "evaluation")
ROD = ("scene", "rod", "evaluation")
COUPLED = ("scene", "fluid", "rod", "coupling", "evaluation")

UNREAD = ("$schema", "description", "reference")  # Keys of a scene that change no result

THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


def simulated(case: Case, folder: Path) -> dict[str, Any]:
    """Run the scene of a case with its options."""
    return simulate.run(case.built(), folder, **case.options)


@dataclass(frozen=True)
class Case:
    """One run: of a scene with some keys changed, or of any function."""

    name: str  # `group/label`, unique in its study
    sources: tuple[str, ...]  # Keys of `SOURCES`
    scene: str = ""
    changes: dict[str, Any] = field(default_factory=dict)
    """Values by dotted key; "absent" takes the key away."""
    options: dict[str, Any] = field(default_factory=dict)  # Further arguments of `action`; part of the digest as well
    action: Callable[..., dict[str, Any]] = simulated
    """Called with the case and its folder; what it returns is kept in run.json."""
    about: dict[str, Any] = field(default_factory=dict)
    """What tables need to know of the case: method, size, published case and the like."""
    quick: bool = True  # Run without `--full`

    def built(self) -> dict[str, Any]:
        """The scene with its changes."""
        return simulate.changed(self.scene, self.changes)

    @cached_property
    def digest(self) -> str:
        """What decides whether a result still holds."""
        built = self.built() if self.scene else {}
        scene = json.dumps({key: part for key, part in built.items() if key not in UNREAD}, sort_keys=True)
        options = json.dumps(self.options, sort_keys=True)
        parts = [scene, options, *(source_digest(name, ROOT) for name in self.sources)]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Run:
    """What a case left in its folder."""

    folder: Path
    found: dict[str, Any]  # What its action returned
    digest: str
    machine: dict[str, Any]

    @cached_property
    def series(self) -> dict[str, np.ndarray]:
        """Recorded columns by name."""
        return dict(np.load(self.folder / "series.npz"))


@dataclass(frozen=True)
class Study:
    """A list of cases, what is kept of each, and what is shown of all; `data` is a `store.Data`."""

    name: str
    cases: Callable[[], Iterable[Case]]
    extract: Callable[[Case, Run], dict[str, Any]]
    """`values` by quantity, `tables` (lists of rows) and `times`, of a case that did not fail."""
    tables: dict[str, Callable[[Any], Any]] = field(default_factory=dict)
    """Lines of a block of a document by its key, or the rows of it where tables.toml has its columns."""
    draw: Callable[[Any, Callable[[str], Run | None]], None] = lambda data, runs: None
    """Writes the figures; `runs` gives what a case left on this machine, for figures of whole series."""

    def folder(self, case: Case) -> Path:
        return RESULTS / self.name / "".join(c if c.isalnum() or c in ".-" else "_" for c in case.name)

    def run_of(self, case: Case) -> Run | None:
        """What was run on this machine, whatever the digest."""
        path = self.folder(case) / "run.json"
        if not path.is_file():
            return None
        return Run(self.folder(case), **json.loads(path.read_text(encoding="utf-8")))

    def command(self, case: Case) -> str:
        """That repeats a case."""
        return f"python -m studies {self.name} --force --only {shlex.quote(case.name)}"


# Sources


@lru_cache
def source_digest(room: str, root: Path) -> str:
    """Digest of the code of a room in a checkout: comment lines, empty lines and the tests at the end of a file do not
    count."""
    digest = hashlib.sha256()
    paths = sorted({path for pattern in SOURCES[room] for path in root.glob(pattern)})
    if not paths:
        raise FileNotFoundError(f"no file of {room!r} is where studies/engine.py looks for it: {SOURCES[room]}")
    for path in paths:
        digest.update(path.relative_to(root).as_posix().encode())
        for line in path.read_text(encoding="utf-8").splitlines():
            code = line.strip()
            if code == "#[cfg(test)]":
                break
            if code and not code.startswith(("//", "# ")):
                digest.update(code.encode() + b"\n")
    return digest.hexdigest()


# Running


def execute(case: Case, folder: Path) -> None:
    """Run a case, in this process, and leave run.json."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "run.json").unlink(missing_ok=True)
    about, digest = machine.here(), case.digest  # before the run: the sources may change on the way
    try:
        found = case.action(case, folder)
    except InputError as error:
        found = {"error": str(error)}
    text = json.dumps({"found": found, "digest": digest, "machine": about})
    write_whole(folder / "run.json", lambda path: path.write_text(text, encoding="utf-8"))


@contextmanager
def workers(jobs: int, scheduler: str | None) -> Iterator[Executor]:
    """Processes of one thread on this machine, or the workers of a Dask scheduler."""
    if scheduler:
        import distributed

        with distributed.Client(scheduler, timeout=5) as client:
            yield client.get_executor(pure=False)
        return
    os.environ |= THREADS
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        yield pool


def run(
    todo: list[tuple[Study, Case]], jobs: int = 1, scheduler: str | None = None
) -> Iterator[tuple[Study, Case, Run]]:
    """Run all of `todo`; gives each when it has ended. What has ended stays when the rest is interrupted."""
    with workers(jobs, scheduler) as pool:
        futures: dict[Future[None], tuple[Study, Case]] = {}
        for study, case in todo:
            futures[pool.submit(execute, case, study.folder(case))] = study, case
        try:
            for future in as_completed(futures):
                future.result()
                study, case = futures[future]
                ended = study.run_of(case)
                assert ended is not None, study.folder(case)
                yield study, case, ended
        except BaseException:
            for future in futures:
                future.cancel()
            raise


def chosen(studies: Iterable[Study], only: str = "*", full: bool = True) -> list[tuple[Study, Case]]:
    """Cases whose names match `only`; long ones where `full` or where `only` asks for them."""
    return [
        (study, case)
        for study in studies
        for case in study.cases()
        if (case.name == only or fnmatch(case.name, only)) and (full or case.quick or only != "*")
    ]
