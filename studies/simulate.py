"""Scenes of studies: changes, runs, published values, and values of summaries."""

from __future__ import annotations

import copy
import json
import tomllib
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import lru_cache
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from nervure import coupling, scene as scenes
from nervure.errors import InputError
from nervure.evaluate import coefficients, statistics
from nervure.evaluate.statistics import Series
from nervure.files import json_numbers
from nervure.output.forecast import resident_memory
from nervure.output.pictures import Pictures
from nervure.scene import validate
from nervure.simulation.session import Session
from nervure.units.describe import describe_all
from nervure.units.fmu import Unit

LISTED: dict[str, Any] = tomllib.loads(Path(__file__).with_name("cases.toml").read_text(encoding="utf-8"))
"""Data of cases.toml: changes of scenes by study, and numbers that others have printed."""

REPEATED_BELOW = 20.0
"""Processor time up to which a case is repeated, s. The first run is then not timed."""

WARM = 5
"""Steps in turns before those that count."""


@lru_cache
def shipped(name: str) -> dict[str, Any]:
    """Return a shipped scene, which callers must not change."""
    scene: dict[str, Any] = scenes.read(name)
    return scene


def changed(name: str, changes: dict[str, Any]) -> dict[str, Any]:
    """Return the shipped scene `name` with other values by dotted key; "absent" removes a key."""
    scene = copy.deepcopy(shipped(name))
    for key, value in changes.items():
        if value != "absent":
            scenes.assign(scene, key, copy.deepcopy(value))
            continue
        *parents, last = key.split(".")
        part = scene
        for parent in parents:
            part = part[parent]
        part.pop(last, None)
    return scene


def on_grid(nx: int, ny: int, step: float) -> dict[str, Any]:
    """Return the changes to another grid and step."""
    return {"fluid.box.cells": [nx, ny], "time.communication_step": step, "fluid.time_stepping.max_step": step}


SHALLOW: dict[str, Any] = {"fluid.mask.log_linear.core_depth": "absent"}
"""Change to the wall model of coarse grids."""


def shifted_grid(name: str, nx: int, ny: int, offset: tuple[float, float]) -> dict[str, Any]:
    """Return the changes to a grid shifted by parts of a cell against the bodies; the inflow zone begins with it."""
    base, box = changed(name, {})["fluid"]["box"], {}
    for axis, cells, part in (("x", nx, offset[0]), ("y", ny, offset[1])):
        low, high = base[axis]
        box[axis] = [edge + part * (high - low) / cells for edge in (low, high)]
    return {"fluid.box": box | {"cells": [nx, ny]}, "fluid.inflow.x.0": box["x"][0]}


def assignments(changes: dict[str, Any]) -> list[str]:
    """Return changes as arguments of `--set`."""

    def text(value: Any) -> str:
        return value if isinstance(value, str) else json.dumps(value, separators=(",", ":"))

    return [f"{key}={'null' if value == 'absent' else text(value)}" for key, value in changes.items()]


@lru_cache
def reference(name: str) -> dict[str, Any]:
    """Return the published `quantities` or `coefficients` of a shipped scene, and the `spread` of several sources if
    known."""
    return changed(name, {}).get("reference") or {} if name else {}


@lru_cache
def published(name: str) -> dict[str, tuple[float, float]]:
    """Return published value and scale of each quantity of a scene. The scale of a mean is at least the amplitude."""
    given = reference(name)
    if "coefficients" in given:
        return {q: (value, abs(value)) for q, value in coefficients.published(scenes.load(name).reference).items()}
    found = {}
    for quantity, values in given.get("quantities", {}).items():
        for what in ("mean", "amplitude", "frequency_hz"):
            if what in values:
                scale = max(abs(values[what]), values.get("amplitude") or 0.0 if what == "mean" else 0.0)
                found[f"{quantity}.{what}"] = values[what], scale
    return found


def unit_of(quantity: str) -> str:
    """Return the unit of a quantity of a summary."""
    name, _, what = quantity.partition(".")
    if what in ("frequency_hz", "growth"):
        return "Hz"
    return {"tip_ux": "m", "tip_uy": "m", "drag": "N/m", "lift": "N/m", "dp_mean": "Pa"}.get(name, "")


class Rigid(coupling.SingleUnit):
    """A fluid whose stations are those of a rigid rod along x, pitching about the origin."""

    def __init__(self, fluid: Unit, scene: dict[str, Any]):
        fluid.connect(["x", "y", "vx", "vy"], [])
        self.unit, self.drive = fluid, None
        self.law = pitching(scene)
        self.s = np.linspace(0, scene["beam"]["length"], scene["beam"]["segments"] + 1)

    def step(self, t: float, h: float) -> int:
        angle, rate = pitch(self.law, t + h)
        along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        self.unit.inputs[:] = np.concatenate([np.outer(along, self.s).ravel(), np.outer(rate * across, self.s).ravel()])
        return super().step(t, h)


def pitching(scene: dict[str, Any]) -> dict[str, float]:
    """Return the sine law of the root's angle."""
    law: dict[str, float] = scene["rod"]["root_motion"]["laws"]["rotations"][0]["angle"]["sine"]
    return law


def pitch(law: dict[str, float], t: float) -> tuple[float, float]:
    """Return the angle of a root under the sine `law`, rad, and its rate."""
    omega, part = 2 * np.pi * law["frequency"], np.pi * min(t / law["ramp"], 1.0)
    share, growth = (1 - np.cos(part)) / 2, np.pi / law["ramp"] * np.sin(part) / 2
    sin, cos = np.sin(omega * t), np.cos(omega * t)
    return law["amplitude"] * share * sin, law["amplitude"] * (share * omega * cos + growth * sin)


def completed(scene: dict[str, Any], folder: Path) -> Series:
    """Return the series of a run of a scene; raise `InputError` where it ends with an error."""
    with session(scene, folder) as own:
        status, series = own.run(), own.recorder.series
    if status.error:
        raise InputError(status.error)
    return series


def session(
    scene: dict[str, Any], folder: Path | None = None, rigid: bool = False, drive: coupling.Drive | None = None
) -> Session:
    """Open a session of a scene. `rigid` replaces the rod by a rigid one that follows its root; `drive` moves a root
    that the scene leaves to the master."""
    packed = {key: part for key, part in scene.items() if key not in ("rod", "coupling")} if rigid else scene
    scheme = (lambda units: Rigid(units["fluid"], scene)) if rigid else None
    if drive is None and (packed.get("rod") or {}).get("root_motion") == "master":
        drive = coupling.stand_still
    return Session(validate(packed), folder, drive=drive, scheme=scheme)


def timed(call: Callable[..., Any], seconds: dict[str, float], phase: str) -> Callable[..., Any]:
    """Return `call` such that its wall time is added to `seconds[phase]`."""

    def wrapped(*arguments: Any) -> Any:
        begin = perf_counter()
        result = call(*arguments)
        seconds[phase] += perf_counter() - begin
        return result

    return wrapped


def once(scene: dict[str, Any], folder: Path, rigid: bool = False, pictures: bool = False) -> dict[str, Any]:
    """Run a scene into `folder` once. Return its summary, with wall times of FMI, Python and recording, and with the
    memory of units and record, MB, which is right only for the first run in a process."""
    before = resident_memory()
    with session(scene, folder, rigid) as run:
        seconds = {"fmi": 0.0, "recording": 0.0}
        for unit in run.units.values():
            for name in ("set", "get"):
                setattr(unit, name, timed(getattr(unit, name), seconds, "fmi"))
        setattr(run.recorder, "record", timed(run.recorder.record, seconds, "recording"))  # noqa: B010
        status = run.run()
        memory = resident_memory() - before
        run.observers = [Pictures(run)] if pictures else []
        made = run.finish()
        summary = made.summary.document()
        phases = summary["phases_s"]
        phases["python"] = phases.pop("exchange_and_python") - seconds["fmi"] - seconds["recording"]
        phases |= seconds
        columns: Any = made.series
        np.savez_compressed(folder / "series.npz", **columns)
        last = {name: float(values[-1]) for name, values in columns.items()}
        return summary | {"wall_s": status.wall, "cpu_s": status.cpu, "last": last, "memory": 1e-6 * memory}


def run(scene: dict[str, Any], folder: Path, repeats: int = 0, **options: Any) -> dict[str, Any]:
    """Run a scene once and `repeats` times more; return the summary of the first run, with the quartiles of the times
    (lower, median, upper, s) and the shortest phases of the other runs."""
    first = once(scene, folder, **options)
    again = []
    if first["error"] is None and first["cpu_s"] <= REPEATED_BELOW:
        again = [once(scene, folder, **options) for _ in range(repeats)]
    if any(other["last"] != first["last"] for other in again):
        return {"error": "another run of it gave other numbers"}
    runs = again or [first]
    for clock in ("wall_s", "cpu_s"):
        first[clock] = np.percentile([other[clock] for other in runs], [25, 50, 75]).tolist()
    first["phases_s"] = {phase: min(other["phases_s"][phase] for other in runs) for phase in first["phases_s"]}
    found: dict[str, Any] = json_numbers(first | {"runs": len(runs)})
    return found


def first_decile(times: list[float]) -> float:
    return float(np.quantile(times, 0.1))


def in_turns(
    scenes: Sequence[dict[str, Any]],
    folder: Path,
    steps: int,
    clock: Callable[[Session], float],
    typical: Callable[[list[float]], float] = first_decile,
) -> list[float]:
    """Return the time of a step of each scene by `clock`, ms. They step in turns, so that all find the machine and its
    caches alike; `typical` of their times is by default the first decile, as other programs lengthen the rest."""
    spent: list[list[float]] = [[] for _ in scenes]
    with ExitStack() as stack:
        runs = [stack.enter_context(session(scene, folder / str(number))) for number, scene in enumerate(scenes)]
        for run in runs:
            run.start()
        for _ in range(WARM + steps):
            for run, times in zip(runs, spent, strict=True):
                begin = clock(run)
                run.step()
                times.append(clock(run) - begin)
    return [1e3 * typical(times[WARM:]) for times in spent]


def sizes(scene: dict[str, Any]) -> tuple[int, int]:
    """Return bytes of the XML descriptions and number of scalar variables of a scene's units."""
    texts = [unit.xml for unit in describe_all(scene).values()]
    return sum(len(text.encode()) for text in texts), sum(text.count("<ScalarVariable") for text in texts)


def quantities(summary: dict[str, Any]) -> dict[str, float]:
    """Return the statistics of a summary by `signal.what`, and coefficients, without missing ones."""
    found = dict((summary["coefficients"] or {}).get("values", {}))
    for name, part in summary["quantities"].items():
        for what in ("mean", "amplitude", "frequency_hz"):
            found[f"{name}.{what}"] = part[what]
        if part["fit"]:
            found[f"{name}.fit"] = part["fit"]["amplitude"]
    return {name: value for name, value in found.items() if value is not None}


def window(summary: dict[str, Any]) -> statistics.Window:
    """Return the evaluated window of a run."""
    begin, end = summary["window_s"]
    return statistics.Window(begin, end, summary["periods"])


def times(summary: dict[str, Any]) -> dict[str, Any]:
    """Return the recorded times of a run."""
    return {name: summary[name] for name in ("wall_s", "cpu_s", "runs", "phases_s")}
