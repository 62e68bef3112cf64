"""Rods that the fluid meets as lines: the map of stability over mass, bending, spacing, step and schemes, the order in
time, and published cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import nervure
from nervure.evaluate.statistics import Series
from nervure.scene import validate
from studies import flapping, simulate
from studies.engine import COUPLED, Case, Study
from studies.store import Data

SCENE = "flag-massless-240x120"
MASSES = (1e-6, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1000.0)  # Of the flag over that of the fluid
BENDINGS = (1e-5, 1e-3, 0.1, 10.0, 100.0)  # EI/(rho U² L³)
SEGMENTS = (8, 12, 24)  # 2.4, 1.6 and 0.8 cells long; markers are 1.75 cells apart
STEPS = (0.01, 0.0025)  # CFL numbers of the stream 0.19 and 0.05
SCHEMES = ("bdf2", "tr_bdf2")  # Of the rod
END, WINDOW = 4.0, 200  # End of a run, s, and steps of the guards' means
COARSE = {"fluid.box.cells": [96, 48], "time.end": END, "coupling": {"guards": {"window_steps": WINDOW}}}

ADVICE = ("; take ", "helps")  # Words of an error that says what to change
MOST = 0.2
"""Difference of the powers on the rod and from the fluid by the exchanged power, over the second half: a silent run
above it is bad. The guard tells of 0.1 in a mean that reaches further back."""


def failed(error: str) -> str:
    """Return the outcome of a run that ended with an error."""
    return "error" if any(advice in error for advice in ADVICE) else "bad"


def outcome(scene: dict[str, Any], folder: Path, body: str = "beam") -> tuple[str, float]:
    """Return the outcome of a coupling with a beam or the wing: `ok`, `told` with a warning, `error` with advice, or
    `bad` where powers differ and nothing is said, or no advice is given; and the difference of both powers by the
    exchanged power over its second half."""
    with simulate.session(scene, folder) as session:
        status, columns = session.run(), session.recorder.series
        warnings = [text for text in session.warnings if not text.startswith("short waves")]  # of the flow
    if status.error:
        return failed(status.error), np.inf
    late = columns["time"] > columns["time"][-1] / 2
    on_rod, from_fluid = columns["load_power"][late], columns[f"{body}_power"][late]
    exchanged = float(np.abs(from_fluid).sum())
    difference = float(np.abs(on_rod - from_fluid).sum()) / exchanged if exchanged else 0.0
    sound = all(np.isfinite(column).all() for column in columns.values()) and difference < MOST
    return "told" if warnings else "ok" if sound else "bad", difference


def mapped(case: Case, folder: Path) -> dict[str, Any]:
    """Run the flag of a scheme and a step over masses, bendings and segments."""
    rows = []
    with TemporaryDirectory(dir=folder) as place:
        for mass, bending in product(MASSES, BENDINGS):
            section = {"line_density": mass, "bending_stiffness": bending, "axial_stiffness": 100.0}
            found, off = [], 0.0
            for segments in SEGMENTS:
                changes = case.changes | {"rod.material.section": section, "beam.segments": segments}
                said, difference = outcome(simulate.changed(SCENE, changes), Path(place))
                found.append(said)
                off = max(off, difference if said == "ok" else 0.0)
            rows.append({"mass": mass, "EI": bending, "outcomes": " ".join(found), "off": off})
    return {"tables": {"map": rows}}


def maps() -> Iterator[Case]:
    for scheme, step in product(SCHEMES, STEPS):
        changes = COARSE | {"rod.scheme": scheme, "time.communication_step": step, "fluid.time_stepping.max_step": step}
        about = {"scheme": scheme, "step": step}
        yield Case(f"map/{scheme}, {step:g} s", COUPLED, SCENE, changes, action=mapped, about=about)
        for ratio in (2, 4) if scheme == "bdf2" else ():
            box = {"x": [-3.0, 7.0], "y": [-2.5, 2.5], "cells": [192 // ratio, 96 // ratio]}
            fine = {"x": [-1.25, 2.25], "y": [-1.75, 1.75], "ratio": ratio}
            grids = {"fluid.box": box, "fluid.fine_box": fine, "fluid.sponge.x": [6.0, 7.0]}
            name = f"map/{scheme}, {step:g} s, two grids, ratio {ratio}"
            yield Case(name, COUPLED, SCENE, changes | grids, action=mapped, about=about)


ORDER_STEPS, ORDER_REFERENCE = (0.008, 0.004, 0.002), 0.00025  # s
ORDER_TIMES = np.linspace(0.04, 1.0, 25)  # At which paths of the tip are compared, s
SMOOTH: dict[str, Any] = {
    "time.end": 1.0, "fluid.box.cells": [96, 48], "beam.segments": 16,
    "fluid.sponge": "absent", "fluid.initial_velocity": [0.0, 0.0],
    "fluid.mean_flow": {
        "x": {"cosine_ramp": {"value": 1.0, "duration": 1.0}},
        "y": {"sine": {"amplitude": 0.1, "frequency": 0.5, "ramp": 0.5}},
    },
}  # fmt: skip
"""The flag in a stream that begins at rest without a jump."""
JUMP: dict[str, Any] = {"coupling": {"load": "pressure_jump", "scheme": "explicit"}}
ITERATED: dict[str, Any] = {"coupling": {"load": "pressure_jump", "scheme": {"iterated": {"tolerance": 1e-7}}}}


def way(changes: dict[str, Any], folder: Path, step: float) -> np.ndarray:
    """Return the path of the flag's tip across the stream, m, with a step of `step` s."""
    steps = {"time.communication_step": step, "fluid.time_stepping.max_step": step}
    with simulate.session(simulate.changed(SCENE, changes | steps), folder) as session:
        assert session.run().error is None
        columns = session.recorder.series
    path: np.ndarray = np.interp(ORDER_TIMES, columns["time"], columns["tip_uy"])
    return path


def apart(path: np.ndarray, other: np.ndarray) -> float:
    """Return the largest difference of two paths by the largest way of the second."""
    return float(np.abs(path - other).max() / np.abs(other).max())


def ordered(case: Case, folder: Path) -> dict[str, Any]:
    """Return how far the tip's path is from that of the reference step, for each step."""
    fine = way(case.changes, folder, ORDER_REFERENCE)
    off = [apart(way(case.changes, folder, step), fine) for step in ORDER_STEPS]
    values = {f"off_{step * 1e3:g}": found for step, found in zip(ORDER_STEPS, off)}
    return {"values": values | {"order": float(np.log2(off[0] / off[-1]) / 2)}}


def orders() -> Iterator[Case]:
    for scheme, coupling, mass, c_eta, bending in (
        ("explicit", {}, 0.01, 1e-8, 1e-4), ("explicit", {}, 1.0, 1e-8, 1e-4), ("explicit", {}, 1.0, 1e-8, 0.1),
        ("iterated", ITERATED, 1.0, 1e-8, 1e-4), ("explicit", {}, 0.01, 1e-4, 1e-4), ("explicit", {}, 1.0, 1e-4, 1e-4),
    ):  # fmt: skip
        section = {"line_density": mass, "bending_stiffness": bending, "axial_stiffness": 100.0}
        changes = {"rod.material.section": section, "fluid.mask.log_linear.c_eta": c_eta} | coupling
        about = {"scheme": scheme, "mass": mass, "EI": bending, "c_eta": c_eta}
        name = f"order/{scheme}, {mass:g}, {bending:g}, {c_eta:g}"
        yield Case(name, COUPLED, SCENE, SMOOTH | changes, action=ordered, about=about)


LOAD_GRIDS = (1, 2, 4)  # Times 96 x 48 points and 16 segments
LOAD_STEP = 0.002  # On the coarsest grid, s


def loads(case: Case, folder: Path) -> dict[str, Any]:
    """Return, for each grid, how far the tip's path with the pressure jump is from that with the momentum load, and one
    exchange from the iterated scheme, both with the pressure jump."""
    rows = []
    for times in LOAD_GRIDS:
        grid = {"fluid.box.cells": [96 * times, 48 * times], "beam.segments": 16 * times}
        momentum, once, repeated = (
            way(case.changes | grid | scheme, folder, LOAD_STEP / times) for scheme in ({}, JUMP, ITERATED)
        )
        label = f"{96 * times} x {48 * times}"
        rows.append({"grid": label, "loads": apart(once, momentum), "schemes": apart(once, repeated)} | case.about)
    return {"tables": {"loads": rows}}


def load_cases() -> Iterator[Case]:
    for mass, bending in ((1.0, 1e-4), (1.0, 0.1), (10.0, 0.1)):
        section = {"line_density": mass, "bending_stiffness": bending, "axial_stiffness": 100.0}
        changes = SMOOTH | {"rod.material.section": section, "fluid.mask.log_linear.c_eta": 1e-8}
        about = {"mass": mass, "EI": bending}
        yield Case(f"load/{mass:g}, {bending:g}", COUPLED, SCENE, changes, action=loads, about=about)


COSTS = {
    "line in the plane": SCENE, "rod in space": "rod-hanging-160x160x48", "wing": "wing-hover-64x64x84"
}  # fmt: skip
THIN = ("beam", "rod", "wing")  # Parts of a scene that the fluid meets as markers
TIMED = 195  # Steps


def cost(case: Case, folder: Path) -> dict[str, Any]:
    """Time steps of the fluid with the thin body and without."""
    less = case.changes | {part: "absent" for part in THIN if part in simulate.changed(case.scene, {})}
    scenes = [simulate.changed(case.scene, changes) for changes in (case.changes, less)]
    loaded, bare = simulate.in_turns(scenes, folder, TIMED, lambda run: run.units["fluid"].seconds)
    return {"times": {"with_ms": loaded, "without_ms": bare, "ratio": loaded / bare}}


def costs() -> Iterator[Case]:
    for name, scene in COSTS.items():
        step = simulate.changed(scene, {})["time"]["communication_step"]
        changes = {"time.end": (simulate.WARM + TIMED) * step, "fluid.threads": 1}
        yield Case(f"cost/{name}", COUPLED, scene, changes, action=cost, about={"scene": scene})


FLAG, FILAMENT, INVERTED, PLATE = (
    "flag-line-480x240", "filament-line-192x192", "flag-inverted-192x126", "plate-pitched-288x384",
)  # fmt: skip
RAMP = 2.0  # Begin of the ramp of the plate, s
STIFFNESS = "rod.material.section.bending_stiffness"
BEGIN = {"flag": 8.0, "filament": 12.0, "inverted": 12.0}  # Of the evaluation, s

THREE, NAMES = "filament-trio-144x96", ("upper", "middle", "lower")
SIDE = 25.0  # Begin of the correlation of filaments side by side, s


EXPECTED: dict[str, dict[str, float]] = simulate.LISTED["thin"]
"""Published values by group."""


def side_by_side(apart: float) -> dict[str, Any]:
    """Return the changes to two filaments at a distance, as lines on a coarse grid."""
    lines = {
        f"rods.{i}.beam.{key}": value for i in (0, 1) for key, value in {"surface": "line", "segments": 24}.items()
    }
    box = simulate.on_grid(144, 96, 0.0075) | {"fluid.box.x": [-1.0, 5.0]}
    return flapping.two_filaments(apart) | box | lines | {"time.end": 40.0}


def three(apart: float) -> dict[str, Any]:
    return {f"rods.{i}.beam.root.at.position": [0.0, y * apart] for i, y in enumerate((1, 0, -1))}


CHANGES: dict[str, tuple[str, dict[str, Any]]] = {
    "flag/240x120": (FLAG, simulate.on_grid(240, 120, 0.0025)),
    "flag/480x240": (FLAG, {}),
    "flag/480x480, 5 high": (FLAG, simulate.on_grid(480, 480, 0.002) | {"fluid.box.y": [-2.5, 2.5]}),
    "filament/128x128": (FILAMENT, simulate.on_grid(128, 128, 0.0075)),
    "filament/192x192": (FILAMENT, {}),
    "filament/288x288": (FILAMENT, simulate.on_grid(288, 288, 0.004) | {"beam.segments": 36}),
    **{f"inverted/{bending:g}": (INVERTED, {STIFFNESS: bending}) for bending in (0.6, 0.45, 0.35, 0.2, 0.1, 0.03)},
    **{f"two/{apart:g}": (flapping.FILAMENTS, side_by_side(apart)) for apart in (0.2, 0.3, 0.5, 1.0)},
    **{f"three/{apart:g}": (THREE, three(apart)) for apart in (0.2, 0.3, 0.5, 1.0)},
    "plate/216x288": (PLATE, simulate.on_grid(216, 288, 0.005) | {"beam.segments": 12}),
    "plate/288x384": (PLATE, {}),
    "plate/432x576": (PLATE, simulate.on_grid(432, 576, 0.0025) | {"beam.segments": 24}),
}


def range_of(series: Series, begin: float) -> dict[str, Any]:
    """Return the extremes of the tip across the stream from `begin` on, by the length, and the state that they show."""
    tip = series["tip_uy"][series["time"] > begin]
    low, high = float(tip.min()), float(tip.max())
    state = "straight" if max(-low, high) < 0.15 else "flaps" if low < 0.0 < high else "bent to a side"
    found = {"low": low, "high": high, "state": state}
    return found | ({"frequency": frequency(series, begin)} if state == "flaps" else {})


def frequency(series: Series, begin: float) -> float | None:
    try:
        return flapping.swing(series, "tip_uy", begin)["frequency"]
    except (IndexError, ValueError, ZeroDivisionError):
        return None


def pitched(series: Series) -> dict[str, float]:
    """Return the largest lift coefficient, the mean over the middle half of the ramp, and both coefficients 4 s after
    its begin."""
    time, lift, drag = series["time"] - RAMP, 2 * series["lift"], 2 * series["drag"]
    middle = (time > 0.25) & (time < 0.75)
    return {
        "largest": float(lift[time > -0.5].max()), "ramp": float(lift[middle].mean()),
        "lift": float(np.interp(4.0, time, lift)), "drag": float(np.interp(4.0, time, drag)),
    }  # fmt: skip


def correlated(series: Series, names: tuple[str, ...]) -> dict[str, Any]:
    """Return correlations of the tips of neighbours and of the outer ones, their amplitudes, and the frequency of the
    first."""
    part = series["time"] > SIDE
    tips = [series[f"{name}_tip_uy"] for name in names]
    matrix = np.corrcoef([tip[part] for tip in tips])
    amplitudes = [float(np.ptp(tip[part])) / 2 for tip in tips]
    return {
        "neighbours": ", ".join(f"{matrix[i, i + 1]:+.2f}" for i in range(len(names) - 1)),
        "outer": float(matrix[0, -1]), "amplitudes": ", ".join(f"{amplitude:.2f}" for amplitude in amplitudes),
        "frequency": flapping.swing(series, f"{names[0]}_tip_uy", SIDE)["frequency"],
    }  # fmt: skip


def published(case: Case, folder: Path) -> dict[str, Any]:
    """Run a scene and return what its group asks for."""
    done = nervure.run(validate(case.built()), folder, force=True, quiet=True)
    group, series = case.name.split("/")[0], done.series
    if group == "inverted":
        values: dict[str, Any] = range_of(series, BEGIN[group])
    elif group == "plate":
        values = pitched(series)
    elif group in ("two", "three"):
        values = correlated(series, NAMES if group == "three" else flapping.NAMES)
    else:
        values = flapping.swing(series, "tip_uy", BEGIN[group])
    if work := done.summary.interface:
        values["imbalance"] = work.imbalance
    return {"values": values, "times": {"cpu_s": done.summary.cpu_s}}


def cases() -> Iterator[Case]:
    yield from maps()
    yield from orders()
    yield from load_cases()
    yield from costs()
    for name, (scene, changes) in CHANGES.items():
        group, grid = name.split("/")
        about = {"expected": EXPECTED.get(group, {}), "grid": grid.replace("x", " x ")}
        yield Case(name, COUPLED, scene, changes, action=published, about=about)


def counts(data: Data) -> list[dict[str, Any]]:
    """Return, for each scheme and step, how many cells of the map came out how, and the largest differences over
    segments of those that ran without a word: median and largest over masses and bendings."""
    rows = []
    for record in data.of("thin/map/*"):
        cells = record.tables.get("map", [])
        count = Counter(found for row in cells for found in row["outcomes"].split())
        off = [row["off"] for row in cells if "ok" in row["outcomes"]]
        named = {name: count[name] for name in ("ok", "told", "error", "bad")}
        apart = {"off": float(np.median(off)), "largest": max(off)} if off else {}
        rows.append({"label": record["label"]} | apart | named)
    return rows


def load_rows(data: Data) -> list[dict[str, Any]]:
    return [row for record in data.of("thin/load/*") for row in record.tables.get("loads", [])]


STUDY = Study("thin", cases, lambda case, run: run.found, tables={"thin-map": counts, "thin-loads": load_rows})
