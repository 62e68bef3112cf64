"""Speed of the fluid beside other transforms, by phase, motion and threads, by crates/fluid/bench."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from studies import commands, show
from studies.engine import Case, Run, Study
from studies.store import Data

MANIFEST, TARGET = "crates/fluid/bench/Cargo.toml", "target/fluid-bench"

GROUPS = {
    "transforms": ("transforms, two along y", "transforms, five along x", "transforms, three back along y, and the CFL number"),
    "local solve": ("local solve", "velocities of bodies and zones"),
    "projection": ("projection",),
    "painting": ("painting of the moving bodies", "wall target"),
    "forces and loads": ("forces on the bodies", "loads and impedance of the stations"),
    "rest": ("rest",),
}
"""What users ask for, and the phases of it."""

COLUMNS = {
    "pair": {"grid": "{grid:}", "FFTW": "{FFTW:g}", "ours": "{ours:g}", "ours/FFTW": "{ours/FFTW:.2f} ({ours/FFTW, median:.2f})",
             "without the upper third of the modes in y": "{pruned:g}", "that/FFTW": "{pruned/FFTW:.2f} ({pruned/FFTW, median:.2f})"},
    "rustfft": {"grid": "{grid:}", "rustfft": "{rustfft:g}", "ours": "{ours:g}",
                "ours/rustfft": "{ours/rustfft:.2f} ({ours/rustfft, median:.2f})"},
    "step": {"scene": "{scene:}", "grid": "{grid:}", "five of FFTW": "{five of FFTW:g}", "step": "{step:g}",
             "step/FFTW": "{step/FFTW:.2f} ({step/FFTW, median:.2f})"},
    "threads": {"grid": "{grid:}"} | {
        f"{clock} {count}": f"{{{clock}, {count}:g}}" for clock in ("wall", "processor") for count in ("one", "two")
    } | {f"{clock} one/two": f"{{{clock}, one/two:.2f}} ({{{clock}, one/two, median:.2f}})" for clock in ("wall", "processor")},
}  # fmt: skip


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


def plain(table: str, data: Data) -> list[str]:
    return show.table(COLUMNS[table], found(data, "pair" if table == "rustfft" else table))


def phases(data: Data) -> list[str]:
    """Shares of a step by what users ask for."""
    columns = {"scene": "{scene:}", "grid": "{grid:}"} | {name: f"{{{name}:.0f}} ({{{name} by step:.0%}})" for name in GROUPS}
    rows = []
    for row in found(data, "phases"):
        parts = {name: sum(row[phase] for phase in group) for name, group in GROUPS.items()}
        rows.append(row | parts | {f"{name} by step": part / row["step"] for name, part in parts.items()})
    return show.table(columns | {"step": "{step:g}"}, rows)


def all_phases(data: Data) -> list[str]:
    scenes = found(data, "phases")
    names = [phase for group in GROUPS.values() for phase in group] + ["step"]
    table = [[name, *(f"{row[name]:g}" for row in scenes)] for name in names]
    return show.markdown(["phase", *(row["scene"] for row in scenes)], table)


def motion(data: Data) -> list[str]:
    rows = [(row["grid"], what, jumps(row, what)) for row in found(data, "motion") for what in ("bar", "step")]
    table = [[grid, what, *(f"{value:g}" for value in times.values())] for grid, what, times in rows]
    return show.markdown(["grid", "", *(f"{jump:g}" for jump in rows[0][2])], table)


TABLES: dict[str, Callable[[Data], list[str]]] = {
    "speed-pairs": partial(plain, "pair"),
    "speed-rustfft": partial(plain, "rustfft"),
    "speed-steps": partial(plain, "step"),
    "speed-threads": partial(plain, "threads"),
    "speed-phases": phases,
    "speed-phases-fine": all_phases,
    "speed-motion": motion,
}
STUDY = Study("fluid-speed", cases, keep, TABLES)
