"""Sweeps: a grid of runs on Dask's workers, which are processes of one thread, and the table of their results.

The folder of a run is named by its values and holds `row.json`, the row of the table: a sweep that is started again
makes only the runs without a row. Dask repeats a run whose worker died, `distributed.scheduler.allowed-failures` times
at most, by default 3.
"""

import copy
import hashlib
import itertools
import json
import logging
import math
import re
import signal
import sys
import threading
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache, partial
from importlib.util import find_spec
from multiprocessing import resource_tracker
from pathlib import Path
from queue import Empty, SimpleQueue
from time import perf_counter, process_time, time
from types import ModuleType
from typing import Any

from pydantic import ValidationError

from nervure.coupling.drive import MissingDrive
from nervure.errors import InputError, SceneError
from nervure.extras import require
from nervure.files import claimed, json_numbers, read_json, undone_on_error, write_csv, write_whole
from nervure.library import check, library
from nervure.scene import Document, Scene, document, files_of, json_or_text, text, validate
from nervure.simulation import results
from nervure.simulation.loop import Observer, TimeGrid, TimeLoop
from nervure.simulation.session import Session
from nervure.simulation.summary import Summary
from nervure.units.describe import unit_kinds

ROW = "row.json"
Row = dict[str, Any]  # A run in the table of a sweep, by column
Variation = dict[str, list[Any]]  # Values by dotted key, of which the first ones belong together, and so on
FINISHED, FAILED, KILLED = "finished", "failed", "killed"  # Status; killed: its worker died at every attempt
STOPPED = "stopped"  # Status of a run that the deadline ended
CONNECT_S = 5  # Time within which a scheduler must answer, s
LISTEN_S = 0.2  # Longest time until Ctrl-C is noticed, s
PROGRESS, REPORT_S = "nervure-progress", 0.5  # Topic of the reports at Dask, and time between two, s
LONGEST_FOLDER = 100  # Characters
Progress = Callable[[int, int], None]  # Called with the numbers of runs and steps done
STATISTICS = ("mean", "amplitude", "frequency_hz")
REPORTED = ("simulated_s", "steps", "periods", "amplitude_drift", "iterations_mean")
"""Values of a quantity, and of a summary, in the table."""


@dataclass(frozen=True)
class Case:
    """A run of a sweep."""

    scene: Document  # Unchecked: a refusal is a result
    varied: dict[str, Any]  # Values that differ from the base scene, by dotted key
    key: str  # Digest of the scene and the libraries of the units: a row with this key is still valid
    folder: str  # Name with the values

    @property
    def steps(self) -> int:
        """Number of communication steps; 0 where the units will refuse the times."""
        try:
            time = self.scene["time"]
            return TimeGrid(float(time["end"]), float(time["communication_step"])).steps
        except (KeyError, TypeError, ValueError, ArithmeticError):
            return 0


def path_name(scene: Document) -> str:
    """Return the name of an unchecked scene as a part of a path."""
    return re.sub(r"[^\w.-]", "_", str(scene.get("name"))).lstrip(".-")[:LONGEST_FOLDER] or "scene"


def _folder_name(scene: Document, varied: dict[str, Any], named: bool, taken: Collection[str]) -> str:
    """Return the folder name of a scene from its `varied` values, after the name of the scene if `named`; with a
    digest of the scene where the name is too long, or `taken`."""
    short = short_keys(varied)
    parts = [f"{short[key]}={_plain_value(value)}" for key, value in varied.items()]
    name = ",".join([path_name(scene), *parts] if named or not parts else parts)
    if len(name) > LONGEST_FOLDER or name in taken:
        name = f"{name[: LONGEST_FOLDER - 9]}-{hashlib.sha256(text(scene).encode()).hexdigest()[:8]}"
    return name


def _plain_value(value: Any) -> str:
    """Return a value as a part of a path."""
    return re.sub(r"[^\w.+-]+", "_", short_value(value)).strip("_")


def short_keys(keys: Iterable[str]) -> dict[str, str]:
    """Return the shortest end of each dotted key that begins with a name and is unique."""
    every = [key.split(".") for key in keys]
    short = {}
    for parts in every:
        length = next(
            n
            for n in range(1, len(parts) + 1)
            if n == len(parts) or (not parts[-n].isdecimal() and sum(other[-n:] == parts[-n:] for other in every) == 1)
        )
        short[".".join(parts)] = ".".join(parts[-length:])
    return short


def short_value(value: Any) -> str:
    """Return a value of a scene as people write it: 2000000, not 2000000.0."""
    if isinstance(value, list):
        return f"[{', '.join(map(short_value, value))}]"
    if isinstance(value, float):
        return f"{value:.10g}"
    return value if isinstance(value, str) else json.dumps(value)


def variation(text: str) -> Variation:
    """Return the values of `key=v1,v2,…` or `key=[v1, v2, …]` by their dotted key; several keys, with a semicolon
    between them, change together."""
    values: Variation = {}
    for part in re.split(r";(?=\s*[\w.]+=)", text):
        key, equals, listed = (word.strip() for word in part.partition("="))
        parsed = json_or_text(listed)
        if not (key and equals and listed) or parsed == []:
            raise SceneError(f"the variation `{part.strip()}` must be of the form key=value,value,… or key=[value, …]")
        if key in values:
            raise SceneError(f"the variations name a key twice: {key}")
        values[key] = parsed if isinstance(parsed, list) else [json_or_text(one) for one in listed.split(",")]
    return values


def grid(scenes: Iterable[Scene | Document], variations: Iterable[Variation]) -> list[Case]:
    """Return a case for each scene and each combination of the `variations`; the keys of one change together."""
    axes = list(variations)
    keys = [key for axis in axes for key in axis]
    if len(set(keys)) < len(keys):
        raise SceneError(f"the variations name a key twice: {', '.join(keys)}")
    for axis in axes:
        if len({len(values) for values in axis.values()}) > 1:
            counts = ", ".join(f"{key} has {len(values)}" for key, values in axis.items())
            raise SceneError(f"keys that change together need equally many values: {counts}")
    for key, values in ((key, values) for axis in axes for key, values in axis.items()):
        try:
            json.dumps(values)
        except (TypeError, ValueError) as error:
            raise SceneError(f"the values of {key} are nothing for a scene: {error}") from error
    made: list[tuple[Document, dict[str, Any]]] = []
    bases = list(scenes)
    for base in bases:
        for combination in itertools.product(*(zip(*axis.values(), strict=True) for axis in axes)):
            scene, varied = (
                copy.deepcopy({**document(base)}),
                dict(zip(keys, itertools.chain(*combination), strict=True)),
            )
            files_of(base).change(scene, varied)
            made.append((scene, varied))
    found = [fault for scene, _ in made for fault in check(text(scene)) if fault.kind == "unknown"]
    if found:  # Other faults are results of the sweep; a key that no scene has is a slip
        raise SceneError("\n".join(dict.fromkeys(fault.text for fault in found)), found)
    cases: dict[str, Case] = {}
    folders: set[str] = set()
    for scene, varied in made:
        if (key := key_of(scene)) not in cases:
            name = _folder_name(scene, varied, len(bases) > 1, folders)
            folders.add(name)
            cases[key] = Case(scene, varied, key, name)
    return list(cases.values())


def key_of(scene: Document) -> str:
    """Return a digest of a scene and the libraries of its units; 1 and 1.0 are the same where a key may be either."""
    digest = hashlib.sha256(text(_alike(scene)).encode())
    for kind in dict.fromkeys(unit_kinds(scene).values()):
        digest.update(_library_digest(library(kind), library(kind).stat().st_mtime_ns))
    return digest.hexdigest()


def _alike(scene: Document) -> Document:
    """Return a scene with whole numbers as integers; a scene whose types do not fit as it is, as 8.0 may be no 8."""

    def whole(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: whole(part) for key, part in value.items()}
        if isinstance(value, list):
            return [whole(part) for part in value]
        return int(value) if isinstance(value, float) and value.is_integer() else value

    try:
        Scene.model_validate(scene)
    except ValidationError:
        return scene
    return {key: whole(part) for key, part in scene.items()}


@cache
def _library_digest(path: Path, _changed: int) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()


def earlier_row(case: Case, folder: Path) -> Row | None:
    """Return the row of `case` from an earlier sweep into `folder`; None without one."""
    try:
        row: Row = read_json(folder / case.folder / ROW)
        return row if row["key"] == case.key and row["status"] else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def missing_cases(cases: list[Case], folder: Path, retry_failed: bool) -> list[Case]:
    """Return the `cases` without a row in `folder`; with `retry_failed`, without a row of a finished run."""
    rows = [(case, earlier_row(case, folder)) for case in cases]
    return [case for case, row in rows if row is None or (retry_failed and row["status"] != FINISHED)]


def check_drives(scenes: Iterable[Document], command: str) -> None:
    """Raise `InputError` where one of `scenes` needs a drive, which no run of the `command` has. One stands for all
    that leave the same keys to the master; another fault of a scene is left to its run."""
    undriven: list[set[str]] = []
    for scene in scenes:
        keys = {*_left_to_master(scene)}
        if not keys or keys in undriven:
            continue
        try:
            Session(validate(scene)).close()
        except MissingDrive as error:
            raise InputError(f"{error.left}, but runs of {command} have no drive: give laws of time") from error
        except (InputError, OSError):
            continue
        undriven.append(keys)


def _left_to_master(part: Any, key: str = "") -> Iterator[str]:
    """Yield the dotted keys of an unchecked scene whose value is `master`."""
    if part == "master":
        yield key
    elif isinstance(part, dict | list):
        parts = part.items() if isinstance(part, dict) else enumerate(part)
        yield from (found for name, own in parts for found in _left_to_master(own, f"{key}.{name}"))


class Reporter(Observer):
    """Reports the steps of a run to `tell`."""

    def __init__(self, tell: Callable[[int], None]):
        self.tell, self.due = tell, 0.0

    def step(self, loop: TimeLoop) -> None:
        if (wall := loop.wall) >= self.due:
            self.tell(loop.steps)
            self.due = wall + REPORT_S


def _run_on_worker(scene: Document, folder: Path, deadline: float) -> Row:
    """Run a case on a worker of Dask, which reports to the process of the sweep, and return its row."""
    import distributed

    worker = distributed.get_worker()

    def tell(steps: int) -> None:
        worker.log_event(PROGRESS, {"folder": folder.name, "steps": steps})

    return run_case(scene, folder, deadline, tell)


def run_case(
    scene: Document,
    folder: Path,
    deadline: float = math.inf,
    tell: Callable[[int], None] = lambda _: None,
    by_cpu: bool = False,
) -> Row:
    """Run a case and return its row; packing and pictures, which outlast a short run, are left out. The deadline is a
    time of the wall, or of the processor."""
    now = process_time if by_cpu else time
    wall, cpu = perf_counter(), process_time()
    row: Row = {"status": FINISHED, "reason": None}
    found: Row = {}
    try:
        with Session(validate(scene), folder) as session:
            session.observers = [Reporter(tell)]
            status = session.run(lambda: now() > deadline)
            summary = session.finish().summary
        if status.stopped:
            row = {"status": STOPPED, "reason": f"at t = {status.simulated:g} s: it took longer than was left for it"}
        elif not summary.completed:
            row = {"status": FAILED, "reason": summary.error}
        found = _reported(summary)
    except (InputError, OSError) as error:
        row = {"status": FAILED, "reason": str(error)}
    times = {"wall_s": perf_counter() - wall, "cpu_s": process_time() - cpu}
    return {name: json_numbers(value) for name, value in (row | times | found).items()}


def _reported(summary: Summary) -> Row:
    """Return the values of a summary that the table has."""
    found: Row = {name: getattr(summary, name) for name in REPORTED}
    for name, quantity in summary.quantities.items():
        found |= {f"{name}_{what}": getattr(quantity, what) for what in STATISTICS}
    found |= summary.coefficients.values if summary.coefficients else {}
    flapping = vars(summary.flapping).items() if summary.flapping else ()
    return found | {name: value for name, value in flapping if isinstance(value, float)}


def run(
    cases: list[Case],
    folder: Path,
    scheduler: str | None = None,
    todo: Sequence[Case] | None = None,
    force: bool = False,
    say: Callable[[str], None] = lambda _: None,
    progress: Progress = lambda _runs, _steps: None,
    workers: int | None = None,
    admit: Callable[[Case], bool] = lambda _: True,
    deadline: float = math.inf,
    by_cpu: bool = False,
) -> list[Row]:
    """Run `todo`, by default the `cases` without a row, write sweep.csv and sweep.json into `folder`, and return all
    rows. Raise `InputError` where a run needs a drive, or results of another scene would be replaced, unless `force`
    allows it. Without a `scheduler` the runs are on this machine, at most `workers` at a time, by default as many as it
    has cores.

    `say` is called with a line for each run that ends, `progress` at any time with the runs and steps done. A run
    begins only if `admit` returns True right before, and ends at the `deadline`, seconds since the epoch. One run at a
    time with a deadline is made in this process, and the deadline then may be one of its processor time, `by_cpu`.
    """
    rows = {case.folder: earlier_row(case, folder) for case in cases}
    todo = missing_cases(cases, folder, False) if todo is None else todo
    check_drives((case.scene for case in todo), "a sweep")
    for case in [] if force else todo:
        if held := results.conflicting_results(folder / case.folder, case.scene, {}):
            raise InputError(
                f"{folder / case.folder} holds {held}; give another --output, or --force to replace what is there"
            )
    done = dict.fromkeys((case.folder for case in todo), 0)  # Steps
    ended = 0

    def reached(name: str, steps: int) -> None:
        done[name] = steps
        progress(ended, sum(done.values()))

    def keep(case: Case, result: Row) -> None:
        nonlocal ended
        row = {"folder": case.folder, "scene": case.scene.get("name"), **case.varied, **result, "key": case.key}
        rows[case.folder] = row
        started()
        (folder / case.folder).mkdir(exist_ok=True)
        write_whole(folder / case.folder / ROW, partial(Path.write_text, data=json.dumps(row) + "\n"))
        _collect(folder, rows)
        ended += 1
        reached(case.folder, case.steps)
        how = row["reason"] or f"in {row['wall_s']:.1f} s"
        say(f"{case.folder}: {row['status']} {how}")

    try:
        with claimed(folder), undone_on_error(folder) as started:
            _collect(folder, rows)
            if todo and scheduler is None and workers == 1 and deadline < math.inf:
                for case in filter(admit, todo):
                    place = (folder / case.folder).resolve()
                    keep(case, run_case(case.scene, place, deadline, partial(reached, case.folder), by_cpu))
            elif todo:
                _distribute(todo, folder, scheduler, workers, reached, keep, admit, deadline)
    except OSError as error:
        raise InputError(f"cannot write into {folder}: {error.strerror or error}") from error
    return [row for row in rows.values() if row]


@contextmanager
def _interruption() -> Iterator[Callable[[], None]]:
    """Yield a function that raises KeyboardInterrupt after the first Ctrl-C. Python loses an exception that a signal
    raises within a destructor, and the libraries of the workers have many."""
    interrupted = False

    def remember(*_: object) -> None:
        nonlocal interrupted
        if interrupted:
            raise KeyboardInterrupt
        interrupted = True

    def check() -> None:
        if interrupted:
            raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield check
        return
    before = signal.signal(signal.SIGINT, remember)
    try:
        yield check
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Block Ctrl-C for the threads and processes that start meanwhile, and their children: the sweep ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield  # In Windows, Ctrl-C ends the workers as well as the sweep
        return
    resource_tracker.ensure_running()  # A later start would end the blocking
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


@contextmanager
def main_not_imported() -> Iterator[None]:
    """Keep the workers of this machine from importing the program that starts them, as spawned processes do: a script
    without a guard would start the sweep again in each of them."""
    main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def local_cluster(workers: int) -> Any:
    """Start that many workers of one thread on this machine, and a scheduler, which Ctrl-C does not reach."""
    distributed = require("distributed", "a sweep")
    # Critical messages too: at Ctrl-C the scheduler may write to a client that has gone.
    options = {"dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL + 1}
    with _without_interrupts():
        return distributed.LocalCluster(n_workers=workers, threads_per_worker=1, memory_limit=None, **options)


def at_once(scheduler: str | None, workers: int | None) -> int:
    """Return how many runs go on at once: the workers of a `scheduler`, or else at most `workers` of this machine."""
    if scheduler is None:
        return workers or (require("dask.system", "a sweep").CPU_COUNT if find_spec("distributed") else 1)
    with connected(scheduler) as client:
        return len(client.nthreads())


@contextmanager
def connected(scheduler: Any) -> Iterator[Any]:
    """Yield a client of a scheduler, given by its address or as a cluster; raise `InputError` where none answers, or
    where it has no workers of one thread."""
    distributed = require("distributed", "a sweep")
    try:
        client = distributed.Client(scheduler, timeout=CONNECT_S)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"no scheduler answers at {scheduler}: `dask scheduler` starts one; without --scheduler the runs are on "
            "this machine"
        ) from error
    with client:
        threads = client.nthreads()
        if not threads:
            raise InputError(
                f"the scheduler at {scheduler} has no workers: `dask worker {scheduler} --nthreads 1` starts one"
            )
        if several := [f"{worker} has {count}" for worker, count in threads.items() if count != 1]:
            raise InputError(f"a run needs a worker of one thread, but {several[0]}: start it with --nthreads 1")
        yield client


def _distribute(
    cases: Sequence[Case],
    folder: Path,
    scheduler: str | None,
    workers: int | None,
    reached: Callable[[str, int], None],
    keep: Callable[[Case, Row], None],
    admit: Callable[[Case], bool],
    deadline: float,
) -> None:
    """Run `cases` on workers. `keep` is called with each case and its row, `reached` with the steps of the runs under
    way. There are never more runs than workers, so that a run that kills its worker ends no other run. The workers of
    this machine end with this function."""
    killed = require("distributed.scheduler", "a sweep").KilledWorker
    with ExitStack() as stack:
        check = stack.enter_context(_interruption())
        if scheduler is None:
            stack.enter_context(main_not_imported())
            scheduler = stack.enter_context(local_cluster(min(at_once(None, workers), len(cases))))
        client = stack.enter_context(connected(scheduler))

        def hear(event: tuple[float, Any]) -> None:
            report = event[1]
            if report["folder"] in {case.folder for case in list(running.values())}:
                reached(report["folder"], report["steps"])

        waiting, running, done = filter(admit, cases), dict[Any, Case](), SimpleQueue[Any]()
        client.subscribe_topic(PROGRESS, hear)
        while True:
            check()
            try:
                free = max(1, len(client.nthreads())) - len(running)  # below 0 while workers are being started again
                for case in itertools.islice(waiting, max(0, free)):
                    place = (folder / case.folder).resolve()
                    future = client.submit(_run_on_worker, case.scene, place, deadline, pure=False)
                    running[future] = case
                    future.add_done_callback(done.put)
                if not running:
                    return
                try:
                    future = done.get(timeout=LISTEN_S)
                except Empty:
                    continue
                case = running.pop(future)
                if future.cancelled():
                    raise CancelledError
                failure = future.exception()
            except (OSError, CancelledError) as lost:
                raise InputError(
                    f"the scheduler at {scheduler} was lost; the same command continues with the missing runs"
                ) from lost
            if isinstance(failure, killed):
                keep(case, {"status": KILLED, "reason": f"its worker died {failure.allowed_failures + 1} times"})
            elif failure is not None:
                keep(case, {"status": FAILED, "reason": f"{type(failure).__name__}: {failure}"})
            else:
                keep(case, future.result())


def _collect(folder: Path, rows: dict[str, Row | None]) -> None:
    """Write sweep.csv and sweep.json with the existing rows, in the order of the grid."""
    folder.mkdir(parents=True, exist_ok=True)
    table = [{name: value for name, value in row.items() if name != "key"} for row in rows.values() if row]
    columns = list(dict.fromkeys(name for row in table for name in row))
    cells = [{name: json.dumps(v) if isinstance(v, list | dict) else v for name, v in row.items()} for row in table]
    write_csv(folder / "sweep.csv", cells)
    text = json.dumps([{name: row.get(name) for name in columns} for row in table], indent=2) + "\n"
    write_whole(folder / "sweep.json", lambda path: path.write_text(text, encoding="utf-8"))
