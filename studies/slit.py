"""A plate of no thickness in a stream, beside a solution on a mesh with a slit (`peers/ngsolve_plate.py`), and one that
pitches up and down, beside an immersed boundary.

Box, stream and start are those of the reference, so that only the plate and the grid differ; the pitching plate is in a
far field.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import hypot, radians
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from studies import commands, show, simulate
from studies.engine import FLUID, Case, Study
from studies.flapping import PUBLISHED
from studies.store import Data

SCENE = "plate-pitched-288x384"
ANGLES, CELLS = (0, 30, 60, 90), (12, 16, 24, 48)  # °, and cells a chord
CFL = 2 / 15  # Of the stream
SHIFT = (0.13, 0.29)  # Of the plate from a grid point, cells: other places move cD and cL by at most 0.8 % on 12 cells
STEADY_END = 200.0  # s; the flow nears its steady state as exp(-t/40 s)

REFERENCE: dict[tuple[int, str], dict[str, float]] = {
    (int(row["angle"]), str(row["time"])): row for row in commands.read(PUBLISHED / "plate_re100_ngsolve.csv")
}
"""Coefficients and their errors by angle (°) and time (s), "mean" or "steady"."""


RAMP = {"cl_max": 3.132, "cd_max": 2.508, "cl_2": 2.619, "cl_3.5": 2.202}
"""Largest coefficients after t = 1.5 and lift at two times of Eldredge's ramp, 0 to 45° and back about the front, of
IBPM.jl on 50 cells a chord, the finer of its two boxes."""
RAMP_CELLS, STEADY = (12, 24, 48), 8.0  # Cells a chord; time until the ramp, s


def ramp(cells: int) -> dict[str, Any]:
    """Return the changes to Eldredge's ramp on two grids, a = 11 and t1 to t4 = 1, 3, 4, 6."""
    time = np.linspace(-0.5, 7.5, 1601)
    one, three, four, six = (np.logaddexp(11 * (time - t), -11 * (time - t)) for t in (1, 3, 4, 6))
    angle = one + six - three - four
    angle *= -radians(45) / angle.max()
    points = {"times": [0.0, *(STEADY + time).round(6)], "values": [0.0, *(angle - angle[0])]}
    body = {"shape": {"plate": {"length": 1.0}}, "pivot": [-0.5, 0.0], "motion": {"angle": {"table": points}}}
    step = 0.16 / cells
    return dict.fromkeys(("beam", "rod"), "absent") | simulate.on_grid(16 * cells, 16 * cells, step) | {
        "time.end": STEADY + 7,
        "fluid.box.x": [-12.0, 20.0],
        "fluid.box.y": [-16.0, 16.0],
        "fluid.fine_box": {"x": [-2.5, 4.0], "y": [-2.5, 2.0], "ratio": 2},
        "fluid.sponge.x": [18.0, 20.0],
        "fluid.kinematic_viscosity": 0.01,
        "fluid.mean_flow.y": {"constant": 0.0},
        "fluid.mask.log_linear.c_eta": 1e-5 * (48 / cells) ** 2,
        "fluid.bodies": [body | {"position": [0.0, 0.0]}],
    }  # fmt: skip


def pitching(case: Case, folder: Path) -> dict[str, Any]:
    """Return the values of `RAMP`."""
    begin = process_time()
    series = simulate.completed(case.built(), folder)
    time, lift, drag = series["time"] - STEADY, 2 * series["lift"], 2 * series["drag"]
    late = time > 1.5
    values = {"cl_max": lift[late].max(), "cd_max": drag[late].max()}
    values |= {f"cl_{t:g}": np.interp(t, time, lift) for t in (2, 3.5)}
    return {"values": {name: float(v) for name, v in values.items()}, "times": {"cpu_s": process_time() - begin}}


def changes(angle: int, cells: int, shift: tuple[float, float] = SHIFT, end: float = 4.0) -> dict[str, Any]:
    """Return the changes to the plate in the reference's box."""
    step = 1 / round(cells / CFL)
    place = {"position": [1.7 + shift[0] / cells, 2.0 + shift[1] / cells]}
    still = {"motion": {"angle": {"constant": -radians(angle)}}}
    return dict.fromkeys(("beam", "rod", "fluid.sponge"), "absent") | simulate.on_grid(6 * cells, 4 * cells, step) | {
        "time.end": end,
        "fluid.box.x": [0.0, 6.0],
        "fluid.box.y": [0.0, 4.0],
        "fluid.kinematic_viscosity": 0.01,
        "fluid.mean_flow.y": {"constant": 0.0},
        "fluid.mask.log_linear.c_eta": 1e-5,
        "fluid.bodies": [{"shape": {"plate": {"length": 1.0}}} | place | still],
    }  # fmt: skip


def measured(case: Case, folder: Path) -> dict[str, Any]:
    """Return the mean coefficients over t = 1 to 3.9, of a steady flow those at the end."""
    begin = process_time()
    series = simulate.completed(case.built(), folder)
    time = series["time"]
    part = time == time[-1] if case.about["time"] == "steady" else (time > 1 - 1e-6) & (time < 3.9 + 1e-6)
    values = {name: 2 * float(series[force][part].mean()) for name, force in (("cd", "drag"), ("cl", "lift"))}
    return {"values": values, "times": {"cpu_s": process_time() - begin}}


def cases() -> Iterator[Case]:
    for angle, cells in product(ANGLES, CELLS):
        yield case(angle, cells, "mean", changes(angle, cells))
    for cells in CELLS[:3]:  # On a grid line, or asymmetry grows until the wake meanders
        yield case(0, cells, "steady", changes(0, cells, (SHIFT[0], 0.0), STEADY_END))
    for cells in RAMP_CELLS:
        about = {"expected": RAMP, "cells": cells, "grid": f"{cells} cells"}
        yield Case(f"ramp/{cells}", FLUID, SCENE, ramp(cells), action=pitching, about=about, quick=cells < 48)


def case(angle: int, cells: int, time: str, changes: dict[str, Any]) -> Case:
    known = REFERENCE[angle, time]
    expected = {name: known[name] for name in (("cd",) if angle in (0, 90) else ("cd", "cl"))}
    about = {"expected": expected, "angle": angle, "cells": cells, "time": time, "grid": f"{cells} cells"}
    return Case(f"{time}/{angle}°, {cells}", FLUID, SCENE, changes, action=measured, about=about, quick=cells < 48)


def beside(data: Data) -> list[dict[str, Any]]:
    """Return the reference of each angle with its error, the errors by cells a chord, and the order of that of the
    force."""
    rows = []
    for (time, angle), records in show.grouped((r.view for r in data.of("slit/[ms]*")), "time", "angle").items():
        known = REFERENCE[angle, time]
        row = {"angle": f"{angle}°" + ", steady" * (time == "steady"), "cd": known["cd"]}
        row["error"] = (abs(known["cd_mesh"]) + abs(known["cd_step"])) / known["cd"]
        if "cl.error" in records[0]:
            row["cl"] = known["cl"]
        for record in records:
            row |= {f"{name}_{record['cells']}": record.get(f"{name}.error") for name in ("cd", "cl")}
        if time == "mean":
            off = [hypot(record["cd"] - known["cd"], record["cl"] - known["cl"]) for record in records]
            row["order"] = -show.exponent([record["cells"] for record in records], off)
        rows.append(row)
    return rows


STUDY = Study("slit", cases, lambda case, run: run.found, {"slit": beside})

NUMBERS, BESIDE, OWN = (10, 100, 1000), (8, 12, 24, 48), 96  # Reynolds numbers, cells a chord, and those of the finest


def by_reynolds() -> Iterator[Case]:
    for reynolds, angle, cells in product(NUMBERS, ANGLES, (*BESIDE, OWN)):
        own = changes(angle, cells) | {"fluid.kinematic_viscosity": 1 / reynolds}
        about = {"reynolds": reynolds, "angle": angle, "cells": cells, "time": "mean"}
        yield Case(f"Re {reynolds}/{angle}°, {cells}", FLUID, SCENE, own, action=measured, about=about)


def beside_finest(data: Data) -> list[dict[str, Any]]:
    """Return the errors of each Reynolds number and angle beside the finest cells, by cells a chord."""
    rows = []
    for (reynolds, angle), records in show.grouped((r.view for r in data.of("slip/*")), "reynolds", "angle").items():
        names = ("cd",) if angle in (0, 90) else ("cd", "cl")
        finest = records[-1]
        row = {"reynolds": reynolds, "angle": f"{angle}°"} | {name: finest[name] for name in names}
        for record in records[:-1]:
            row |= {f"{name}_{record['cells']}": record[name] / finest[name] - 1 for name in names}
        rows.append(row)
    return rows


SLIP = Study("slip", by_reynolds, lambda case, run: run.found, {"slip": beside_finest})
