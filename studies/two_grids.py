"""A cylinder on a fine box of cells in a coarse domain, beside one grid of the fine cells."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import Any

from studies import flapping, simulate
from studies.engine import FLUID, Case, Study
from studies.store import Data

SCENE = "cylinder-stream-384x512"
GRIDS: dict[str, tuple[list[list[float]], int]] = {
    "24 x 16, one grid": ([], 1),
    "6 x 4, ratio 4": ([[-2.4, 3.6], [-2.0, 2.0]], 4),
    "8 x 6, ratio 4": ([[-2.9, 5.1], [-3.0, 3.0]], 4),
    "6 x 4, ratio 2": ([[-2.4, 3.6], [-2.0, 2.0]], 2),
}
"""Ends of the fine box, diameters, and ratio of the cells."""
FLOWS: dict[int, dict[str, Any]] = {40: {}, 100: flapping.SHEDDING}  # By Reynolds number


def cases() -> Iterator[Case]:
    for reynolds, flow in FLOWS.items():
        for label, (ends, ratio) in GRIDS.items():
            fine = {"fluid.fine_box": dict(zip("xy", ends, strict=True)) | {"ratio": ratio}} if ends else {}
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
    """Return the values on one grid, and the differences on two."""
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
