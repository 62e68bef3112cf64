"""Speed of the fluid beside other transforms, by phase, motion and threads, by crates/fluid/bench."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from studies import commands, show, simulate
from studies.engine import Case, Run, Study
from studies.store import Data

MANIFEST, TARGET = "crates/fluid/bench/Cargo.toml", "target/fluid-bench"

GROUPS: dict[str, list[str]] = simulate.LISTED["fluid-speed"]["groups"]  # What users ask for, and the phases of it


def cases() -> Iterator[Case]:
    command = commands.cargo(MANIFEST, TARGET, "{folder}/speed.csv")
    yield Case("bench/speed", ("scene", "fluid", "fluid bench"), options={"command": command}, action=commands.tables)


def keep(case: Case, run: Run) -> dict[str, Any]:
    """All of it is times."""
    return {"times": {"rows": [list(row.values()) for row in run.found["tables"]["speed"]]}}


def found(data: Data, table: str) -> list[dict[str, Any]]:
    """Values of a table by scene and grid: those, the number of points, and µs by what was measured."""
    lines: dict[tuple[str, str], dict[str, Any]] = {}
    for name, scene, grid, what, value, unit in data["fluid-speed/bench/speed"].times["rows"]:
        if name == table:
            nx, ny = map(int, grid.split(" x "))
            line = lines.setdefault((scene, grid), {"scene": scene or "", "grid": grid, "points": nx * ny})
            line[what] = float(f"{value:.0f}" if unit == "µs" and value >= 10 else f"{value:.3g}")
    return list(lines.values())


def jumps(row: dict[str, Any], what: str) -> dict[float, float]:
    """Times of a scene by the distance that the bar jumps, cells."""
    return {float(name.split()[0]): value for name, value in row.items() if name.endswith(what)}


def phases(data: Data) -> list[dict[str, Any]]:
    """A step by what users ask for: µs and share of each."""
    rows = []
    for row in found(data, "phases"):
        parts = {name: sum(row[phase] for phase in group) for name, group in GROUPS.items()}
        rows.append(row | parts | {f"{name} by step": part / row["step"] for name, part in parts.items()})
    return rows


def all_phases(data: Data) -> list[str]:
    names = {name: name for group in (*GROUPS.values(), ("step",)) for name in group}
    scenes = {row["scene"]: row for row in found(data, "phases")}
    return show.matrix("phase", names, scenes, lambda name, row: f"{row[name]:g}")


def motion(data: Data) -> list[str]:
    rows = [(row["grid"], what, jumps(row, what)) for row in found(data, "motion") for what in ("bar", "step")]
    table = [[grid, what, *(f"{value:g}" for value in times.values())] for grid, what, times in rows]
    return show.markdown(["grid", "", *(f"{jump:g}" for jump in rows[0][2])], table)


TABLES: dict[str, Callable[[Data], Any]] = {
    "speed-pairs": partial(found, table="pair"),
    "speed-steps": partial(found, table="step"),
    "speed-threads": partial(found, table="threads"),
    "speed-phases": phases,
    "speed-phases-fine": all_phases,
    "speed-motion": motion,
}
STUDY = Study("fluid-speed", cases, keep, TABLES)
