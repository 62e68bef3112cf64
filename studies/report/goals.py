"""What was wanted (`report.goals` of cases.toml) and is not met, from the numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from studies import simulate, speed, turek_hron
from studies.report.maps import map_cells
from studies.report.points import OURS, points
from studies.show import label, markdown
from studies.store import Data

TIMES = {"wall_s": "wall time", "start_s": "processor time"}
Goal = dict[str, Any]
Checks = Iterator[tuple[str, float, float, str]]
"""Of what, found, the limit of its absolute value, and a unit: per cent, s, or nothing."""


def of_case(data: Data, goal: Goal) -> Checks:
    """Errors of a run, and its time."""
    there = (p for p in points(data, goal["case"]) if p["setting"] == goal["setting"])
    run = next(p for p in there if p["method"] in OURS)
    for name, limit in goal.get("most", {}).items():
        yield label(name), run[f"{name}.error"], limit, "%"
    for kind, limit in goal.get("times", {}).items():
        yield f"{kind} time", run[kind][1], limit, "s"


def of_halves(data: Data, goal: Goal) -> Checks:
    """Share of an error that is left on a grid twice as fine."""
    runs = {p["setting"]: p for p in points(data, goal["halves"]) if p["method"] in OURS}
    coarse, fine = (runs[setting] for setting in goal["settings"])
    for name in goal["left"]:
        yield label(name), fine[f"{name}.error"] / coarse[f"{name}.error"], 0.5 ** goal["order"], ""


def of_record(data: Data, goal: Goal) -> Checks:
    for name, limit in goal.get("most", {}).items():
        yield name.replace("_", " "), data[goal["record"]][name], limit, "%"
    for name, limit in goal.get("times", {}).items():
        yield TIMES[name], data[goal["record"]][name], limit, "s"


def of_still(data: Data, goal: Goal) -> Checks:
    """Of the bar in prescribed motion in still fluid: beside the moving mesh."""
    found, mesh = data[goal["still"]], simulate.LISTED["driven-bar"]["still"]["moving mesh"]
    for name, limit in goal["most"].items():
        yield label(name), found[name] / mesh[name] - 1.0, limit, "%"
    for name, limit in goal["apart"].items():
        yield label(name), found[name] - mesh[name], limit, "N/m"


def of_records(data: Data, goal: Goal) -> Checks:
    """How far several are apart, by the last."""
    for name, limit in goal["apart"].items():
        found = [data[record][name] for record in goal["records"]]
        yield label(name), (max(found) - min(found)) / abs(found[-1]), limit, "%"


def of_places(data: Data, goal: Goal) -> Checks:
    """Of a benchmark of Turek and Hron at several places of the grid: from the reference, and from each other."""
    for kind in ("most", "apart"):
        for name, limit in goal.get(kind, {}).items():
            off = turek_hron.over_places(data, goal["places"], goal["grid"], name)
            yield label(name), max(map(abs, off)) if kind == "most" else max(off) - min(off), limit, "%"


def of_fit(data: Data, goal: Goal) -> Checks:
    """Rms over the quantities of such a benchmark, by the harmonic fit."""
    off = turek_hron.errors(data, goal["fit"], goal["grid"], fitted=True)
    yield "rms by the fit", float(np.sqrt(np.mean(np.square(off)))), goal["rms"], "%"


def of_map(data: Data, goal: Goal) -> Checks:
    """Cells that end in a way in which none should."""
    wrong = [cell for cell in map_cells(data)[goal["map"]] if cell[2] in goal["none"]]
    yield "cells", sum(cell[0].startswith(goal.get("begin", "")) for cell in wrong), 0, ""


def of_rod(data: Data, goal: Goal) -> Checks:
    rows = data["rod/study/runtime"].times["rows"]
    yield "iteration", next(row for row in rows if row["n"] == goal["rod"])["iteration_3d"], goal["seconds"], "s"


def of_exchange(data: Data, goal: Goal) -> Checks:
    """The part of a run's time that is neither the rod's nor the fluid's."""
    yield "exchange and Python", data[goal["exchange"]]["exchange_share"], goal["share"], "%"


def of_bench(data: Data, goal: Goal) -> Checks:
    """Of the fluid's speed; a gain by two threads is told the other way round, so that less is better."""
    line = speed.of_grid(data, goal["bench"], goal["grid"])
    for name, limit in goal.get("most", {}).items():
        yield name, line[name], limit, ""
    for name, least in goal.get("least", {}).items():
        yield name.replace("one/two", "two/one"), 1 / line[name], 1 / least, ""


KINDS: dict[str, Callable[[Data, Goal], Checks]] = {
    "case": of_case, "halves": of_halves, "record": of_record, "still": of_still, "records": of_records,
    "places": of_places, "fit": of_fit, "map": of_map, "rod": of_rod, "exchange": of_exchange, "bench": of_bench,
}  # fmt: skip
"""By the key that a goal has."""


def told(value: float, unit: str) -> str:
    if unit == "%":
        return f"{100 * value:.2g} %"
    return f"{1e6 * value:.3g} µs" if unit == "s" and value < 1e-3 else f"{value:.3g} {unit}".strip()


def missed(data: Data) -> list[str]:
    rows = []
    for goal in simulate.LISTED["report"]["goals"]:
        (kind,) = KINDS.keys() & goal.keys()
        for what, found, limit, unit in KINDS[kind](data, goal):
            if abs(found) > limit:
                rows.append([goal["of"], what, told(found, unit), told(limit, unit), goal["reason"]])
    return markdown(["case", "of", "found", "wanted, at most", "reason"], rows)
