"""Bodies, flags and wings in a fine box of cells in a coarse domain, beside one grid of the fine cells."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import product
from math import pi, radians
from pathlib import Path
from statistics import mean
from time import process_time
from typing import Any

from nervure.evaluate.statistics import Series
from nervure.output.forecast import resident_memory
from studies import flapping, simulate, wing
from studies.engine import COUPLED, FLUID, Case, Study
from studies.store import Data

SCENE = "cylinder-stream-384x512"
GRIDS: dict[str, tuple[list[list[float]], int]] = {
    "24 x 16, one grid": ([], 1),
    "6 x 4, ratio 4": ([[-2.4, 3.6], [-2.0, 2.0]], 4),
    "8 x 6, ratio 4": ([[-2.9, 5.1], [-3.0, 3.0]], 4),
    "6 x 4, ratio 2": ([[-2.4, 3.6], [-2.0, 2.0]], 2),
    "6 x 4 in 12 x 8, ratio 2 x 2": ([[-2.4, 3.6], [-2.0, 2.0]], 4),
}
"""Ends of the fine box, diameters, and ratio of the cells."""
MIDDLE: dict[str, Any] = {"fluid.middle_box": {"x": [-4.8, 7.2], "y": [-4.0, 4.0]}}  # Of the last one
FLOWS: dict[int, dict[str, Any]] = {40: {}, 100: flapping.SHEDDING}  # By Reynolds number


def cases() -> Iterator[Case]:
    for reynolds, flow in FLOWS.items():
        for label, (ends, ratio) in GRIDS.items():
            fine: dict[str, Any] = MIDDLE if "x 2" in label else {}
            if ends:
                fine = fine | {"fluid.fine_box": dict(zip("xy", ends, strict=True)) | {"ratio": ratio}}
            changes = flapping.NARROW | flow | {"fluid.box.cells": [384 // ratio, 256 // ratio]} | fine
            about = {"reynolds": reynolds, "grids": label}
            yield Case(f"Re {reynolds}/{label}", FLUID, SCENE, changes, action=measured, about=about)


def measured(case: Case, folder: Path) -> dict[str, Any]:
    """Return drag, of a flow that sheds vortices lift and Strouhal number, and the processor time of the run, s."""
    begin = process_time()
    series = simulate.completed(case.built(), folder)
    sheds = case.about["reynolds"] == 100
    values = flapping.shedding(series) if sheds else {"cd": 2 * float(series["drag"][-1])}
    return {"values": values, "times": {"cpu_s": process_time() - begin}}


def beside(data: Data) -> list[dict[str, Any]]:
    """Return the values on one grid, and the differences on two and three."""
    records = {(r.view["reynolds"], r.view["grids"]): r.view for r in data.of("two-grids/*")}
    rows = []
    for label in GRIDS:
        row: dict[str, Any] = {"label": label}
        for reynolds in FLOWS:
            record, one = records[reynolds, label], records[reynolds, "24 x 16, one grid"]
            for name in ("cd", "cl", "st") if reynolds == 100 else ("cd",):
                value = record[name] if record is one else record[name] / one[name] - 1
                row[f"{name}_{reynolds}" + "_off" * (record is not one)] = value
        row["time"] = records[100, label]["cpu_s"] / records[100, "24 x 16, one grid"]["cpu_s"]
        rows.append(row)
    return rows


STUDY = Study("two-grids", cases, lambda case, run: run.found, {"two-grids": beside})

BOXES: dict[str, list[list[float]]] = {
    "3 x 3": [[-1.5, 1.5], [-1.5, 1.5]],
    "4 x 4": [[-2.0, 2.0], [-2.0, 2.0]],
    "6 x 4": [[-2.0, 4.0], [-2.0, 2.0]],
    "8 x 6": [[-3.0, 5.0], [-3.0, 3.0]],
    "12 x 8": [[-4.0, 8.0], [-4.0, 4.0]],
}
"""Ends of the fine box from the middle of the body by its size, lengths of the body."""
SHAPES: dict[str, dict[str, Any]] = {
    "cylinder": {"shape": {"circle": {"radius": 0.5}}},
    "plate": {"shape": {"plate": {"length": 1.0}}, "motion": {"angle": {"constant": -radians(30)}}},
}
ONE, CELLS, END, WINDOW = "one grid", 16, 20.0, 4.0  # Cells a length; time and its last part that counts, s
FLAGS: dict[str, list[list[float]]] = {
    "1.5 x 0.8": [[-0.2, 1.3], [-0.4, 0.4]],
    "1.75 x 1": [[-0.25, 1.5], [-0.5, 0.5]],
    "2.5 x 1.5": [[-0.5, 2.0], [-0.75, 0.75]],
}
"""The same around a flag from 0 to 1, on 96 cells a length in 5 x 2.5 lengths."""
FEWEST = 6.0  # Large cells between the body and the ends of the box: 5 are refused


def large_cells(size: str, ratio: int) -> float:
    """Return the large cells between the body and the nearest end of the box."""
    return float((min(abs(end) for ends in BOXES[size] for end in ends) - 0.5) * CELLS / ratio)


def sizes() -> Iterator[Case]:
    boxes = [(size, ratio) for size, ratio in product(BOXES, (2, 4)) if large_cells(size, ratio) >= FEWEST]
    for (name, shape), (size, ratio) in product(SHAPES.items(), [(ONE, 1), *boxes]):
        fine = dict(zip("xy", BOXES[size], strict=True)) | {"ratio": ratio} if ratio > 1 else "absent"
        changes = flapping.NARROW | {
            "time.end": END,
            "fluid.box.cells": [384 // ratio, 256 // ratio],
            "fluid.fine_box": fine,
            "fluid.bodies": [shape | {"position": [0.0, 0.0]}],
        }
        about = {"shape": name, "size": size, "ratio": ratio}
        yield Case(f"{name}/{size}, {ratio}", FLUID, SCENE, changes, action=steady, about=about)
    for size, ratio in [
        (ONE, 1),
        *((size, ratio) for size, ratio in product(FLAGS, (2, 4)) if beside_flag(size, ratio) > 5),
    ]:
        fine = dict(zip("xy", FLAGS[size], strict=True)) | {"ratio": ratio} if ratio > 1 else "absent"
        changes = {"fluid.box.cells": [480 // ratio, 240 // ratio], "fluid.fine_box": fine}
        about = {"shape": "flag", "size": size, "ratio": ratio}
        yield Case(f"flag/{size}, {ratio}", COUPLED, "flag-line-480x240", changes, action=flaps, about=about)


def beside_flag(size: str, ratio: int) -> float:
    """Return the large cells between a flag at rest and the nearest end of the box."""
    (begin, end), (_, side) = FLAGS[size]
    return min(-begin, end - 1.0, side) * 96 / ratio


def steady(case: Case, folder: Path) -> dict[str, Any]:
    """Return mean drag and lift, and the processor time of the run, s."""
    begin = process_time()
    series = simulate.completed(case.built(), folder)
    late = series["time"] > END - WINDOW
    values = {name: 2 * float(series[force][late].mean()) for name, force in (("cd", "drag"), ("cl", "lift"))}
    return {"values": values, "times": {"cpu_s": process_time() - begin}}


def flaps(case: Case, folder: Path) -> dict[str, Any]:
    """Return amplitude and frequency of the tip of a flag, and the processor time of the run, s."""
    begin = process_time()
    return {"values": tip(simulate.completed(case.built(), folder)), "times": {"cpu_s": process_time() - begin}}


def tip(series: Series) -> dict[str, float]:
    """Return amplitude (lengths) and frequency (speeds by lengths) of the tip of a flag in the gallery."""
    found = flapping.swing(series, "tip_uy", 10.0)
    return {"±uy": found["amplitude"], "f": found["frequency"]}


def by_size(data: Data) -> list[dict[str, Any]]:
    """Return the differences from one grid of each fine box."""
    records = {(r.view["size"], r.view["ratio"], r.view["shape"]): r.view for r in data.of("fine-box/*")}
    rows = []
    for size, ratio in dict.fromkeys(key[:2] for key in records if key[0] != ONE):
        beside = beside_flag(size, ratio) if size in FLAGS else large_cells(size, ratio)
        row: dict[str, Any] = {"size": size, "ratio": ratio, "beside": beside}
        for shape in ("flag",) if size in FLAGS else SHAPES:
            own, one = records[size, ratio, shape], records[ONE, 1, shape]
            row |= {f"{name}_{shape}": own[name] / one[name] - 1 for name in ("cd", "cl", "±uy", "f") if one.get(name)}
            row["time"] = own["cpu_s"] / one["cpu_s"]
        rows.append(row)
    return rows


SIZES = Study("fine-box", sizes, lambda case, run: run.found, {"fine-box": by_size})


@dataclass(frozen=True)
class Pair:
    """A flow on one grid and on two, whose fine cells are those of the one."""

    scene: str
    changes: dict[str, Any]
    quantities: Callable[[Series], dict[str, float]]
    ends: dict[int, dict[str, list[float]]]
    """Ends of the fine box by ratio; a body may be too large for one of 4."""
    sources: tuple[str, ...] = FLUID


def sheds(series: Series, begin: float) -> dict[str, float]:
    """Return mean drag coefficient and amplitude of the lift coefficient from `begin` (s) on."""
    return means(series, begin, 2.0, cD="drag") | {"±cL": 2 * flapping.swing(series, "lift", begin)["amplitude"]}


def shed_coefficients(series: Series) -> dict[str, float]:
    """Return mean drag, amplitude of the lift, and Strouhal number of a cylinder that sheds vortices."""
    found = flapping.shedding(series)
    return {"cD": found["cd"], "±cL": found["cl"], "St": found["st"]}


def means(series: Series, begin: float, scale: float, **columns: str) -> dict[str, float]:
    """Return the means of columns by name, times `scale`, from `begin` (s) on."""
    late = series["time"] >= begin
    return {name: scale * float(series[column][late].mean()) for name, column in columns.items()}


CIRCLE: dict[str, Any] = {"shape": {"circle": {"radius": 0.5}}, "position": [0.0, 0.0]}
IN_PLANE: dict[str, Any] = flapping.NARROW | {"fluid.box.cells": [384, 256]}
SHAKEN: dict[str, Any] = IN_PLANE | {
    "fluid.kinematic_viscosity": 1 / 185,
    "fluid.bodies": [CIRCLE | {"motion": {"y": {"sine": {"amplitude": 0.2, "frequency": 0.195}}}}],
}
AROUND = {ratio: {"x": [-2.4, 3.6], "y": [-2.0, 2.0]} for ratio in (2, 4)}
PAIRS: dict[str, Pair] = {
    "cylinder that shakes, Re 185": Pair(
        SCENE,
        SHAKEN,
        lambda series: sheds(series, 30.0),
        AROUND | {4: {"x": [-2.4, 3.6], "y": [-2.5, 2.5]}},
    ),
    "the same on 24 cells": Pair(
        SCENE,
        SHAKEN | simulate.on_grid(576, 384, 0.04 / 3),
        lambda series: sheds(series, 30.0),
        AROUND | {4: {"x": [-2.4, 3.6], "y": [-2.5, 2.5]}},
    ),
    "cylinder that sheds, Re 100, 24 cells": Pair(
        SCENE, IN_PLANE | flapping.SHEDDING | simulate.on_grid(576, 384, 0.04 / 3), shed_coefficients, AROUND
    ),
    "plate at 30°, Re 100": Pair(
        SCENE,
        IN_PLANE | {"fluid.kinematic_viscosity": 0.01, "fluid.bodies": [SHAPES["plate"] | {"position": [0.0, 0.0]}]},
        lambda series: means(series, 40.0, 2.0, cD="drag", cL="lift"),
        AROUND,
    ),
    "two cylinders in a row, Re 40": Pair(
        SCENE,
        IN_PLANE | {"time.end": 40.0, "fluid.bodies": [CIRCLE, CIRCLE | {"position": [3.0, 0.0]}]},
        lambda series: means(series, 36.0, 2.0, **{"cD": "body_1_drag", "cD of the second": "body_2_drag"}),
        {ratio: {"x": [-2.4, 6.6], "y": [-2.0, 2.0]} for ratio in (2, 4)},
    ),
    "sphere, Re 100": Pair(
        "sphere-stream-144x96x96",
        {"fluid.threads": 1},
        lambda series: means(series, 20.0, 8 / pi, cD="drag"),
        {
            2: {"x": [-4.03 + 14 / 6, -4.03 + 41 / 6], "y": [-5 / 3, 5 / 3], "z": [-5 / 3, 5 / 3]},
            4: {"x": [-4.03 + 4 / 3, 3.97], "y": [-8 / 3, 8 / 3], "z": [-8 / 3, 8 / 3]},
        },
    ),
    "flag, line": Pair(
        "flag-line-480x240",
        {},
        tip,
        {ratio: {"x": [-0.25, 1.5], "y": [-0.5, 0.5]} for ratio in (2, 4)},
        COUPLED,
    ),
    "wing that hovers, 8 cells a chord": Pair(
        wing.HOVER,
        {
            "fluid.box": {"x": [-2.75, 5.35], "y": [-4.75, 3.35], "z": [-5.315625, 5.315625], "cells": [64, 64, 84]},
            "fluid.threads": 1,
        },
        lambda series: means(series, wing.STROKE, 1.0, lift="lift"),
        {2: {"x": [-1.6, 4.0], "y": [-2.6, 1.7], "z": [-3.9, 3.9]}},
        (*COUPLED, "wing"),
    ),
}


def pairs() -> Iterator[Case]:
    for (name, pair), ratio in product(PAIRS.items(), (1, 2, 4)):
        if ratio > 1 and ratio not in pair.ends:
            continue
        box = simulate.changed(pair.scene, pair.changes)["fluid"]["box"]["cells"]
        fine: dict[str, Any] = {"fluid.fine_box": pair.ends[ratio] | {"ratio": ratio}} if ratio > 1 else {}
        changes = pair.changes | {"fluid.box.cells": [cells // ratio for cells in box]} | fine
        about = {"pair": name, "ratio": ratio}
        yield Case(f"{name}/{ratio}", pair.sources, pair.scene, changes, action=evaluated, about=about)


def evaluated(case: Case, folder: Path) -> dict[str, Any]:
    """Return the quantities of a pair, and the processor time of the run, s."""
    begin = process_time()
    values = PAIRS[case.about["pair"]].quantities(simulate.completed(case.built(), folder))
    return {"values": values, "times": {"cpu_s": process_time() - begin}}


def by_quantity(data: Data) -> list[dict[str, Any]]:
    """Return the quantities on one grid, and the differences on two."""
    rows = []
    for name in PAIRS:
        views = {r.view["ratio"]: r.view for r in data.of(f"grid-pairs/{name}/*")}
        for quantity in data[f"grid-pairs/{name}/1"].values:
            row = {"pair": name, "quantity": quantity, "one": views[1][quantity]}
            for ratio in PAIRS[name].ends:
                row[f"off_{ratio}"] = views[ratio][quantity] / views[1][quantity] - 1
                row[f"time_{ratio}"] = views[ratio]["cpu_s"] / views[1]["cpu_s"]
            rows.append(row)
    return rows


TWO = Study("grid-pairs", pairs, lambda case, run: run.found, {"grid-pairs": by_quantity})

FAR: dict[str, Any] = flapping.SHEDDING | {
    "time.end": 150.0,
    "fluid.box": {"x": [-24.0, 36.0], "y": [-30.0, 30.0]},
    "fluid.sponge.x": [32.0, 36.0],
}
"""A cylinder at Re 100 in 60 x 60 diameters."""
LEVELS: dict[str, tuple[int, dict[str, Any]]] = {
    "ratio 4": (4, {}),
    "ratio 2 x 2": (4, {"fluid.middle_box": {"x": [-6.0, 10.0], "y": [-6.0, 6.0]}}),
    "ratio 2": (2, {}),
}


def far() -> Iterator[Case]:
    for label, (ratio, middle) in LEVELS.items():
        fine = {"fluid.fine_box": {"x": [-3.0, 5.0], "y": [-3.0, 3.0], "ratio": ratio}}
        changes = FAR | {"fluid.box.cells": [60 * CELLS // ratio] * 2} | fine | middle
        yield Case(f"cylinder/{label}", FLUID, SCENE, changes, action=measured, about={"reynolds": 100})


DISTANT = Study("grid-far", far, lambda case, run: run.found)


APIECE: dict[str, Any] = {"fluid.precision": "single", "fluid.threads": 1}
PLATE: dict[str, Any] = APIECE | {
    "time.communication_step": 0.0125,
    "fluid.time_stepping.max_step": 0.0125,
    "fluid.box": {"x": [-6.0, 10.0], "y": [-6.0, 6.0], "z": [-6.0, 6.0]},
    "fluid.sponge.x": [8.0, 10.0],
    "fluid.bodies.0.shape": {"plate": {"length": 1.0, "width": 2.0}},
}
AROUND_PLATE: dict[str, Any] = {"x": [-2.0, 2.0], "y": [-1.5, 1.5], "z": [-2.0, 2.0], "ratio": 4}
STILL: dict[str, Any] = APIECE | dict.fromkeys(("fluid.sponge", "fluid.mean_flow", "fluid.initial_velocity"), "absent")
AROUND_SPHERE: dict[str, Any] = {"x": [-2.25, 2.75], "y": [-2.25, 2.25], "z": [-2.25, 2.25]}
DRIVEN: dict[str, Any] = {"table": {"times": [0.0, 50.0], "values": [0.0, -50.0]}}
COSTS: dict[str, tuple[str, int, list[dict[str, Any]]]] = {
    "plate on 24 cells a chord in 16 x 12 x 12 chords, beside one grid": (
        "plate-stream-96x72x72",
        8,
        [
            PLATE | {"fluid.box.cells": [96, 72, 72], "fluid.fine_box": AROUND_PLATE},
            PLATE | {"fluid.box.cells": [384, 288, 288]},
        ],
    ),
    "sphere driven along 50 diameters, beside a domain of 5 x 4.5 x 4.5": (
        "sphere-stream-144x96x96",
        40,
        [
            STILL
            | {
                "fluid.box": {"x": [-58.0, 6.0], "y": [-6.0, 6.0], "z": [-6.0, 6.0], "cells": [256, 48, 48]},
                "fluid.fine_box": AROUND_SPHERE | {"ratio": 4, "follow": "body[1]"},
                "fluid.bodies.0.motion": {"x": DRIVEN},
            },
            STILL
            | {
                "fluid.box": AROUND_SPHERE | {"cells": [80, 72, 72]},
                "fluid.bodies.0.motion": {"x": {"sine": {"amplitude": 0.3, "frequency": 0.5}}},
            },
        ],
    ),
}
"""Scene, steps in a turn, and changes to two grids and to one grid."""


def costs() -> Iterator[Case]:
    for label, (scene, steps, both) in COSTS.items():
        options = {"steps": steps, "one": both[1]}
        yield Case(f"space/{label}", FLUID, scene, both[0], options, beside_one)


def beside_one(case: Case, folder: Path) -> dict[str, Any]:
    """Return the processor time of a step on two grids and on one, ms, as a mean because the large grid takes one of
    several steps, and the ratios of time and memory."""
    scenes = [case.built(), simulate.changed(case.scene, case.options["one"])]
    of_two, of_one = held(scenes, folder)
    two, one = simulate.in_turns(scenes, folder, case.options["steps"], lambda _: process_time(), mean)
    return {"times": {"two_ms": two, "one_ms": one, "time": two / one, "memory": of_two / of_one}}


def held(scenes: list[dict[str, Any]], folder: Path) -> list[int]:
    """Return the memory that the units of each scene take in the first steps, bytes; all stay open, as what is given
    back serves the next."""
    found = []
    with ExitStack() as stack:
        for scene in scenes:
            before = resident_memory()
            session = stack.enter_context(simulate.session(scene, folder))
            session.start()
            for _ in range(simulate.WARM):
                session.step()
            found.append(resident_memory() - before)
    return found


COST = Study("grid-cost", costs, lambda case, run: run.found)
