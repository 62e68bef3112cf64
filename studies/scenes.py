"""Every shipped scene that has a `reference`: its run beside it; and all compared cases in one table and one figure."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator
from fnmatch import fnmatch
from functools import lru_cache
from itertools import cycle
from typing import Any

import numpy as np

from nervure.resources import SCENES
from nervure.scene import Scene
from studies import show, simulate
from studies.engine import UNREAD, Case, Run, Study
from studies.show import COLOURS, MARKERS
from studies.store import Data, Record, rounded

SHOWN: list[dict[str, Any]] = simulate.LISTED["right"]
"""Name, source, and pattern of the cases of each part of the table."""
QUANTITIES: dict[str, str] = simulate.LISTED["quantities"]
FRONTS: dict[str, dict[str, str]] = simulate.LISTED["fronts"]
"""Patterns of the cases of each panel by method."""
WORST = 10


def same(scene: dict[str, Any]) -> str:
    """Return all of a scene that its result depends on, with defaults and up to rounding."""
    parts = {key: part for key, part in scene.items() if key not in (*UNREAD, "name")} | {"name": "any"}
    return json.dumps(rounded(Scene.model_validate(parts).document()), sort_keys=True)


def cases_beside(others: Iterable[Study]) -> Callable[[], Iterator[Case]]:
    """Return the function that yields the shipped scenes with a reference that no other study runs as they are."""

    @lru_cache
    def listed() -> tuple[Case, ...]:
        shipped = {path.stem: simulate.shipped(path.stem) for path in sorted(SCENES.glob("*.json"))}
        compared = {name: scene for name, scene in shipped.items() if scene.get("reference")}
        cases = [case for study in others for case in study.cases() if case.scene]
        run = {same(case.built()) for case in cases if case.about.get("published") or case.about.get("expected")}
        found: list[Case] = []
        for name, scene in compared.items():
            if same(scene) not in run:
                units = [kind for kind in ("fluid", "rod", "wing") if {kind, f"{kind}s"} & scene.keys()]
                sources = ("scene", *units, *(("coupling",) if len(units) > 1 else ()), "evaluation")
                cells = " x ".join(map(str, scene["fluid"]["box"]["cells"])) if "fluid" in scene else ""
                about = {"published": name, "grid": cells}
                found.append(Case(f"shipped/{name}", sources, name, about=about))
        return tuple(found)

    return lambda: iter(listed())


def extract(case: Case, run: Run) -> dict[str, Any]:
    return {"values": simulate.quantities(run.found), "times": simulate.times(run.found)}


def of(data: Data, patterns: str) -> list[Record]:
    """Return the compared records of some patterns, the most expensive last."""
    found = [record for pattern in patterns.split() for record in data.of(pattern) if record.errors()]
    return sorted(found, key=lambda record: record.get("cpu_s") or 0.0)


def parts(data: Data) -> Iterator[tuple[dict[str, Any], list[Record]]]:
    """Yield each part of the table with its records; scenes that no part names have one of their own."""
    named = [pattern for part in SHOWN for pattern in part["of"].split()]
    for part in SHOWN:
        if found := of(data, part["of"]):
            yield part, found
    for record in of(data, "scenes/*"):
        if not any(fnmatch(record.name, pattern) for pattern in named):
            source = simulate.reference(record["published"])["source"].split(":")[0]
            yield {"case": record["label"], "source": source}, [record]


def said(record: Record) -> str:
    """Return grid, processor time, s, and errors of a run, %."""
    named = ((QUANTITIES.get(name, name), error) for name, error in record.errors().items())
    errors = ", ".join(f"{name} {100 * e:+.{1 if abs(e) >= 0.001 else 2}f}" for name, e in named if name)
    cpu = record.get("cpu_s") or 0.0
    cost = f"{cpu:.{0 if cpu >= 10 else 1 if cpu >= 1 else 2}f} s" if cpu else ""
    return ": ".join(filter(None, (", ".join(filter(None, (grid(record), cost))), errors)))


def grid(record: Record) -> str:
    return re.sub(r" *x *", "x", record.get("grid", ""))


def every(data: Data) -> list[dict[str, Any]]:
    """Return the compared runs of each part."""
    return [part | {"runs": "<br>".join(map(said, records))} for part, records in parts(data)]


def worst(data: Data) -> list[str]:
    """Return the largest errors of the finest or last run of each part, as a list."""
    found = [
        (error, f"{part['case']}, {grid(records[-1])}: {QUANTITIES.get(name, name)} {100 * error:+.1f} %")
        for part, records in parts(data)
        if not part.get("faulty")
        for name, error in records[-1].errors().items()
    ]
    return [f"1. {line}" for _, line in sorted(found, key=lambda one: -abs(one[0]))[:WORST]]


def headlines(data: Data) -> list[dict[str, Any]]:
    """Return the cases of the first page with their errors."""
    rows = []
    for part in simulate.LISTED["headlines"]:
        record = data[part["of"]]
        rows.append(part | {"off": show.form(part["off"], record.view), "cpu_s": record["cpu_s"]})
    return rows


def fronts(data: Data) -> dict[str, dict[str, list[tuple[float, float]]]]:
    """Return CPU time, s, and largest error of the runs by panel and method."""
    found: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for panel, methods in FRONTS.items():
        for method, pattern in methods.items():
            for record in of(data, pattern):
                cpu, errors = record.get("cpu_s"), record.errors().values()
                if cpu:
                    found.setdefault(panel, {}).setdefault(method, []).append((cpu, max(map(abs, errors))))
    return found


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    """Draw the largest error of each run over its processor time, with the Pareto fronts in grey."""
    panels = fronts(data)
    figure, axes = show.panel(2, 4, (14, 7.6))
    for axis, (name, methods) in zip(axes.flat, panels.items()):
        for (method, found), colour, marker in zip(methods.items(), cycle(COLOURS), cycle(MARKERS)):
            axis.plot(*zip(*sorted(found)), marker=marker, color=colour, markersize=4, linewidth=1, label=method)
        x, y = np.array(sorted(point for found in methods.values() for point in found)).T
        axis.step(x, np.minimum.accumulate(y), where="post", color="#000000", linewidth=3, alpha=0.15, zorder=0)
        axis.set(xscale="log", yscale="log", xlabel="processor time [s]", ylabel="largest relative error", title=name)
        show.few_labels(axis.xaxis)
        show.few_labels(axis.yaxis)
        axis.legend(fontsize=7)
    for axis in axes.flat[len(panels) :]:
        axis.set_visible(False)
    show.save(figure, "pictures/fronts")


def study(others: Iterable[Study]) -> Study:
    tables: dict[str, Callable[[Data], Any]] = {"right": every, "worst": worst, "headlines": headlines}
    return Study("scenes", cases_beside(others), extract, tables, draw)
