"""Speed of the fluid beside other transforms and the machine's peaks, by phase, motion and threads, by
studies/rust/fluid."""

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from studies import commands, roofline, simulate
from studies.engine import Case, Run, Study
from studies.store import Data

ROOFLINES = (("roofline", "325 x 72", ""), ("roofline", "650 x 144", ""), ("roofline", "1300 x 288", ""),
             ("roofline-single", "650 x 144", ", single"))  # fmt: skip
"""Shown rooflines: table of the program, grid, and a suffix."""

GROUPS: dict[str, list[str]] = simulate.LISTED["fluid-speed"]["groups"]  # What users ask for, and the phases of it


def cases() -> Iterator[Case]:
    command = commands.cargo("fluid-bench", "{folder}/speed.csv")
    yield Case("bench/speed", ("scene", "fluid", "fluid bench"), options={"command": command}, action=commands.tables)


def extract(case: Case, run: Run) -> dict[str, Any]:
    """Return all rows as times."""
    return {"times": {"rows": [list(row.values()) for row in run.found["tables"]["speed"]]}}


def found(data: Data, table: str) -> list[dict[str, Any]]:
    """Return values of a table by scene and grid, with the number of points and µs by phase."""
    lines: dict[tuple[str, str], dict[str, Any]] = {}
    for name, scene, grid, what, value, unit in data["fluid-speed/bench/speed"].times["rows"]:
        if name == table:
            points = math.prod(map(int, grid.split(" x ")))
            line = lines.setdefault((scene, grid), {"scene": scene or "", "grid": grid, "points": points})
            line[what] = float(f"{value:.0f}" if unit == "µs" and value >= 10 else f"{value:.3g}")
    return list(lines.values())


def of_grid(data: Data, table: str, grid: str) -> dict[str, Any]:
    return next(line for line in found(data, table) if line["grid"] == grid)


def jumps(row: dict[str, Any], what: str) -> dict[float, float]:
    """Return times of a scene by the distance that the bar jumps, cells."""
    return {float(name.split()[0]): value for name, value in row.items() if name.endswith(what)}


def phases(data: Data) -> list[dict[str, Any]]:
    """Return µs and share of each group of phases in a step."""
    rows = []
    for row in found(data, "phases"):
        parts = {name: sum(row[phase] for phase in group) for name, group in GROUPS.items()}
        rows.append(row | parts | {f"{name} by step": part / row["step"] for name, part in parts.items()})
    return rows


def rooflines(data: Data) -> list[dict[str, Any]]:
    """Return the phases that pass through whole arrays, and their sums, beside both roofs. Waits are the excess over
    the time with the data in the cache. The other phases have only a time."""
    rows = []
    columns = {"µs": "", "in cache, µs": ": in cache", "MB": ": moved", "Mflop": ": operations"}
    for table, grid, behind in ROOFLINES:
        line, times = (of_grid(data, name, grid) for name in (table, table.replace("roofline", "phases")))
        phases = [name.removesuffix(": moved") for name in line if name.endswith(": moved")]
        parts = [{"part": name} | {to: line[name + of] for to, of in columns.items()} for name in phases]
        parts.append({"part": "all four"} | {to: sum(part[to] for part in parts) for to in columns})
        for part in parts:
            waits = max(0.0, 1 - part["in cache, µs"] / part["µs"])
            bound = {"waits": waits, "bound": "data" if waits > 0.5 else "instructions"}
            rows.append(
                {"grid": grid + behind} | part | bound | roofline.reached(part, line["bandwidth"], line["peak"])
            )
        rows.append({"grid": grid + behind, "part": "the other phases", "µs": times["step"] - parts[-1]["µs"]})
    return rows


def in_space(data: Data) -> list[dict[str, Any]]:
    """Return the phases of a step in space that take a hundredth of it or more: ms on one thread and on two, bytes, and
    the share of the machine's bandwidth that a thread reaches."""
    rows = []
    for line in found(data, "roofline-space"):
        names = [name.removesuffix(": one thread") for name in line if name.endswith(": one thread")]
        for name in names:
            one, two = (line[f"{name}: {threads}"] / 1e3 for threads in ("one thread", "two threads"))
            if one < line["step: one thread"] / 1e5:
                continue
            row = {"grid": f"{line['grid']}, {line['scene']}", "phase": name, "one": one, "two": two, "gain": one / two}
            if moved := line.get(f"{name}: moved"):
                rate = moved / one
                row |= {"moved": moved, "must": line[f"{name}: must"], "rate": rate, "share": rate / line["bandwidth"]}
            rows.append(row)
    return rows


TABLES: dict[str, Callable[[Data], Any]] = {
    "speed-pairs": partial(found, table="pair"),
    "speed-steps": partial(found, table="step"),
    "speed-volume": partial(found, table="volume"),
    "speed-threads": partial(found, table="threads"),
    "speed-phases": phases,
    "speed-roofline": rooflines,
    "speed-space": in_space,
    "speed-bandwidth": lambda data: [row for row in rooflines(data) if row["part"] == "all four"],
}
STUDY = Study("fluid-speed", cases, extract, TABLES)
