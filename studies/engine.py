"""Cases, their sources, and the engine that runs the cases of all studies.

A case has a digest of its scene and of the sources of its result. Each case runs in a process of its own, in the folder
`results/studies/STUDY/CASE`, and writes `run.json` there. It runs again only if the present digest is neither in that
file nor in the committed record (`store`).
"""

from __future__ import annotations

import ast
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
    "scene": ("crates/scene/src/**/*.rs", "crates/mesh/src/**/*.rs"),
    "fluid": (
        "crates/fluid/src/**/*.rs",
        "crates/fluid/Cargo.toml",
        "crates/line-fft/src/**/*.rs",
        "fmu-fluid/src/**/*.rs",
    ),
    "rod": (
        "crates/structure/src/**/*.rs",
        "crates/structure/Cargo.toml",
        "crates/rod/src/**/*.rs",
        "crates/rod/Cargo.toml",
        "fmu-rod/src/**/*.rs",
    ),
    "wing": (
        "crates/structure/src/**/*.rs",
        "crates/structure/Cargo.toml",
        "crates/wing/src/**/*.rs",
        "crates/wing/Cargo.toml",
        "fmu-wing/src/**/*.rs",
    ),
    "body": ("crates/rigid/src/**/*.rs", "crates/rigid/Cargo.toml", "fmu-body/src/**/*.rs", "examples/flyer_*.py"),
    "wing cost": ("crates/wing/examples/*.rs", "studies/peers/cholmod_factor.py"),
    "coupling": ("python/nervure/coupling/*.py", "python/nervure/simulation/loop.py"),
    "evaluation": ("python/nervure/evaluate/**/*.py", "python/nervure/simulation/summary.py"),
    "rod study": ("studies/rust/rod/src/**/*.rs", "studies/rust/rod/Cargo.toml", "crates/rod/tests/common/*.rs"),
    "contact": ("crates/contact/src/**/*.rs", "crates/geometry/src/**/*.rs"),
    "contact study": (
        "studies/rust/contact/src/*.rs",
        "studies/rust/contact/Cargo.toml",
        "crates/*/tests/**/thrown.rs",
        "crates/contact/tests/common/*.rs",
    ),
    "contact cost": ("studies/rust/contact/examples/*.rs", "crates/*/tests/**/thrown.rs"),
    "mixed contact": ("studies/mixed.py", "crates/contact/src/**/*.rs"),
    "rod roofline": ("studies/rust/rod/examples/*.rs", "studies/rust/fluid/src/machine.rs"),
    "fluid bench": ("studies/rust/fluid/src/*.rs", "studies/rust/fluid/Cargo.toml"),
    "fluid measures": ("studies/rust/fluid/src/bin/*.rs", "crates/fluid/tests/common/*.rs"),
    "verification": tuple(f"python/nervure/verification/{name}.py" for name in ("estimate", "plan", "process")),
    "keeping": ("python/nervure/simulation/checkpoint.py", "python/nervure/output/fields.py"),
    "command": ("python/nervure/**/*.py",),
    "export": ("crates/fmi-export/src/**/*.rs", "crates/adapter/src/**/*.rs", "crates/fpenv/src/**/*.rs"),
    "reliability": ("tests/reliability/*.py", "tests/reliability/scene.json"),
    "fuzz": ("tests/fuzz/*.py", "tests/fuzz/fuzz_targets/*.rs"),
    "vortices": ("studies/peers/pterasoftware_plate.py",),
    "peers": tuple(f"studies/peers/{name}.py" for name in ("fluidsim_step", "ngsolve_cylinder", "pyelastica_beam")),
    "limits": ("studies/limits.py",),
    "plate": ("studies/plate.py",),
    "driven bar": ("studies/driven_bar.py",),
    "lab": ("lab/src/*.rs", "lab/page/*.js"),
}
"""Files by the names that cases give for their dependencies."""

UNITS = ("scene", "fluid", "rod")  # Sources of the libraries of the units

FLUID = ("scene", "fluid", "evaluation")
ROD = ("scene", "rod", "evaluation")
COUPLED = ("scene", "fluid", "rod", "coupling", "evaluation")

UNREAD = ("$schema", "description", "format", "reference")  # Keys of a scene that change no result

THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


def simulated(case: Case, folder: Path) -> dict[str, Any]:
    """Run the scene of a case with its options."""
    return simulate.run(case.built(), folder, **case.options)


@dataclass(frozen=True)
class Case:
    """A run of a scene with some changed keys, or of any function."""

    name: str  # `group/label`, unique in its study
    sources: tuple[str, ...]  # Keys of `SOURCES`
    scene: str = ""
    changes: dict[str, Any] = field(default_factory=dict)
    """Values by dotted key; "absent" removes the key."""
    options: dict[str, Any] = field(default_factory=dict)  # Arguments of `action`; part of the digest
    action: Callable[..., dict[str, Any]] = simulated
    """Function of the case and its folder; run.json stores the returned value."""
    about: dict[str, Any] = field(default_factory=dict)
    """Attributes for tables, such as method, size, and scene with published values."""
    quick: bool = True  # Run without `--full`

    def built(self) -> dict[str, Any]:
        """Return the scene with its changes."""
        return simulate.changed(self.scene, self.changes)

    @cached_property
    def digest(self) -> str:
        """Digest of scene, options and sources; a result is stale if this has changed."""
        built = self.built() if self.scene else {}
        scene = json.dumps({key: part for key, part in built.items() if key not in UNREAD}, sort_keys=True)
        options = json.dumps(self.options, sort_keys=True)
        parts = [scene, options, *(source_digest(name, ROOT) for name in self.sources)]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Run:
    """Results of a case in its folder."""

    folder: Path
    found: dict[str, Any]  # What its action returned
    digest: str
    machine: dict[str, Any]

    @cached_property
    def series(self) -> dict[str, np.ndarray]:
        """Recorded columns, by name."""
        return dict(np.load(self.folder / "series.npz"))


@dataclass(frozen=True)
class Study:
    """Cases, the values to record of each, and the tables and figures of all. `data` is a `store.Data`."""

    name: str
    cases: Callable[[], Iterable[Case]]
    extract: Callable[[Case, Run], dict[str, Any]]
    """Returns `values` by quantity, `tables` (lists of rows) and `times` of a case that did not fail."""
    tables: dict[str, Callable[[Any], Any]] = field(default_factory=dict)
    """Functions by the key of a table: they return its lines, or its rows if tables.toml has the columns."""
    draw: Callable[[Any, Callable[[str], Run | None]], None] = lambda data, runs: None
    """Draws the figures; `runs` returns the run of a case on this machine, for figures of whole series."""

    def folder(self, case: Case) -> Path:
        return RESULTS / self.name / "".join(c if c.isalnum() or c in ".-" else "_" for c in case.name)

    def run_of(self, case: Case) -> Run | None:
        """Return the last run of a case on this machine, of any digest."""
        path = self.folder(case) / "run.json"
        if not path.is_file():
            return None
        return Run(self.folder(case), **json.loads(path.read_text(encoding="utf-8")))

    def command(self, case: Case) -> str:
        """Return the command that repeats a case."""
        return f"python -m studies {self.name} --force --only {shlex.quote(case.name)}"


# Sources


def code(path: Path) -> Iterator[str]:
    """Yield the lines of code of a file, without comments, docstrings, and the tests at the end."""
    text, prose = path.read_text(encoding="utf-8"), set[int]()
    for node in ast.walk(ast.parse(text)) if path.suffix == ".py" else ():
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            prose.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    for number, line in enumerate(map(str.strip, text.splitlines()), 1):
        if line == "#[cfg(test)]":
            return
        if line and number not in prose and not line.startswith(("//", "# ")):
            yield line


@lru_cache
def source_digest(name: str, root: Path) -> str:
    """Return the digest of the code of an entry of `SOURCES` in a checkout."""
    digest = hashlib.sha256()
    paths = sorted({path for pattern in SOURCES[name] for path in root.glob(pattern)})
    if not paths:
        raise FileNotFoundError(f"studies/engine.py finds no file of {name!r}: {SOURCES[name]}")
    for path in paths:
        digest.update(path.relative_to(root).as_posix().encode())
        for line in code(path):
            digest.update(line.encode() + b"\n")
    return digest.hexdigest()


# Running


def execute(case: Case, folder: Path) -> None:
    """Run a case in this process and write run.json."""
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
    """Open processes of one thread on this machine, or the workers of a Dask scheduler."""
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
    """Run all of `todo` and yield each when it has ended. An interruption keeps what has ended. Raise
    `ChildProcessError` after the last one for programs that failed, whose results stay what they were."""
    failed = []
    with workers(jobs, scheduler) as pool:
        futures: dict[Future[None], tuple[Study, Case]] = {}
        for study, case in todo:
            futures[pool.submit(execute, case, study.folder(case))] = study, case
        try:
            for future in as_completed(futures):
                try:
                    future.result()
                except ChildProcessError as error:
                    failed.append(str(error))
                    continue
                study, case = futures[future]
                ended = study.run_of(case)
                assert ended is not None, study.folder(case)
                yield study, case, ended
        except BaseException:
            for future in futures:
                future.cancel()
            raise
    if failed:
        raise ChildProcessError("\n".join(failed))


def chosen(studies: Iterable[Study], only: str = "*", full: bool = True) -> list[tuple[Study, Case]]:
    """Return the cases whose names match `only`; long ones only with `full` or a pattern."""
    return [
        (study, case)
        for study in studies
        for case in study.cases()
        if (case.name == only or fnmatch(case.name, only)) and (full or case.quick or only != "*")
    ]
