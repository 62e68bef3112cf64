"""Costs of a run: frames and checkpoints, start and end, the exchange with the units, and FMI 2.0 beside 3.0."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import fmpy

from nervure import coupling
from nervure.output import fields
from nervure.scene import Scene, validate
from nervure.simulation import checkpoint
from nervure.simulation.results import field_files
from nervure.units import package
from nervure.units.describe import describe_all
from nervure.units.fmu import Unit
from studies import simulate
from studies.engine import COUPLED, Case, Study
from studies.store import Data

SCENES = ("fsi3-325x72", "fsi3-650x144", "fsi3-1300x288")
REPEATS, STEPS = 10, 10  # Frames and checkpoints that are written, and steps before a frame
STARTS = 7  # Runs of one step, and of `SOME` steps
SOME = 500  # Steps
OPTIONS: checkpoint.Options = dict.fromkeys(("checkpoint_every", "fields_every", "series_every"))
ROUNDS, EXCHANGES = 30, 1000  # Measurements of each version, and exchanges in one of them


def timed(call: Callable[..., Any], *arguments: Any) -> float:
    """Return the wall time of a call, ms."""
    begin = perf_counter()
    call(*arguments)
    return 1e3 * (perf_counter() - begin)


def measure(case: Case, folder: Path) -> dict[str, Any]:
    """Return shortest wall times of a step, a frame and a checkpoint, ms, on the disk of `results`, and the size of a
    checkpoint at the end of the run, MB."""
    scene = case.built()
    spent: dict[str, list[float]] = {"step": [], "frame": [], "checkpoint": []}

    with simulate.session(scene, folder) as session:
        interval = STEPS * session.grid.communication_step
        frames, saved = fields.Fields(session, interval, print), checkpoint.Checkpoint(session, OPTIONS)
        session.recorder.table[:] = 0.0
        session.start()
        for _ in range(REPEATS * STEPS):
            spent["step"].append(timed(session.step))
            if session.steps % STEPS == 0:
                spent["frame"].append(timed(frames.step, session))
        session.recorder.rows = len(session.recorder.table)  # the number of rows at the end of a whole run
        for _ in range(REPEATS):
            spent["checkpoint"].append(timed(saved.save))
        frames.end(None)
        size = saved.path.stat().st_size
    for path in (saved.path, *field_files(folder)):
        path.unlink()
    shortest = {f"{what}_ms": round(min(found), 3) for what, found in spent.items()}
    return shortest | {"checkpoint_mb": round(size / 1e6, 2)}


def start(case: Case, folder: Path) -> dict[str, Any]:
    """Return the median processor time of the command for a run of one step, s: imports, packing, pictures and exit."""
    end, spent = f"--end-time={case.built()['time']['communication_step']}", []
    for _ in range(STARTS):
        before = getrusage(RUSAGE_CHILDREN)
        command = [sys.executable, "-m", "nervure", "run", case.scene, end, "--quiet", "--force"]
        subprocess.run([*command, f"--output={folder / 'start'}"], check=True)
        after = getrusage(RUSAGE_CHILDREN)
        spent.append(after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)
    return {"start_s": median(spent)}


def exchange(case: Case, folder: Path) -> dict[str, Any]:
    """Return the median share of a run's wall time outside of the units: setting, getting, recording, and Python."""
    scene, shares = case.built(), []
    scene["time"]["end"] = SOME * scene["time"]["communication_step"]
    for _ in range(STARTS):
        with simulate.session(scene, folder) as session:
            wall = session.run().wall
            shares.append(1 - sum(unit.seconds for unit in session.units.values()) / wall)
    return {"exchange_share": median(shares)}


class Pair:
    """The unpacked units of a scene under a version of FMI."""

    def __init__(self, scene: Scene, version: int, folder: Path):
        self.scene = scene
        self.places: dict[str, Path] = {}
        for kind, unit in describe_all(self.scene, version).items():
            packed = package.pack(unit, folder / str(version))
            self.places[kind] = Path(fmpy.extract(str(packed), str(folder / f"{version}-{kind}")))

    def parse(self) -> dict[str, Any]:
        """Parse the model descriptions and check them against their schema."""
        return {kind: fmpy.read_model_description(str(place)) for kind, place in self.places.items()}

    def instantiate(self) -> None:
        end = self.scene.time.end
        self.units = {kind: Unit(place, kind, end) for kind, place in self.places.items()}

    def connect(self) -> None:
        coupling.couple(self.units, self.scene.coupling).start()

    def exchange(self) -> None:
        for _ in range(EXCHANGES):
            for unit in self.units.values():
                unit.set()
                unit.get_exchanged()

    def measure(self) -> dict[str, Any]:
        """Return times in ms, and one exchange in µs."""
        times = {step.__name__: timed(step) for step in (self.parse, self.instantiate, self.connect, self.exchange)}
        for unit in self.units.values():
            unit.close()
        return times | {"exchange": 1e3 * times["exchange"] / EXCHANGES}

    def sizes(self) -> dict[str, Any]:
        """Return the variables of each unit, and the size of both model descriptions, kB."""
        texts = [(place / "modelDescription.xml").stat().st_size for place in self.places.values()]
        counts = {kind: len(description.modelVariables) for kind, description in self.parse().items()}
        return counts | {"size": 1e-3 * sum(texts)}


def versions(case: Case, folder: Path) -> dict[str, Any]:
    """Measure both versions of FMI in turn; return sizes and shortest times of each."""
    with TemporaryDirectory() as place:
        pairs = {version: Pair(validate(case.built()), version, Path(place)) for version in (2, 3)}
        rounds = [{version: pair.measure() for version, pair in pairs.items()} for _ in range(ROUNDS)]
        sizes = {version: pair.sizes() for version, pair in pairs.items()}
    rows: list[dict[str, Any]] = []
    for version in pairs:
        least = {name: min(times[version][name] for times in rounds) for name in rounds[0][version]}
        rows.append({"version": f"{version}.0"} | sizes[version] | least)
    return {"versions": rows}


def cases() -> Iterator[Case]:
    for scene in SCENES:
        yield Case(f"keeping/{scene}", (*COUPLED, "keeping"), scene, action=measure)
    yield Case(f"start/{SCENES[0]}", (*COUPLED, "command"), SCENES[0], action=start)
    yield Case("versions/fmi", (*COUPLED, "export", "command"), SCENES[0], action=versions)
    yield Case(f"exchange/{SCENES[1]}", (*COUPLED, "command"), SCENES[1], action=exchange)


def version_rows(data: Data) -> Any:
    return data["running/versions/fmi"].times["versions"]


TABLES: dict[str, Callable[[Data], Any]] = {"masters-versions": version_rows}
STUDY = Study("running", cases, lambda case, run: {"times": run.found}, TABLES)
