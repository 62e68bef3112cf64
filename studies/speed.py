"""Speed of the fluid beside FFTW's transforms, by phase, motion and threads, by crates/fluid/bench."""

from collections.abc import Iterator
from typing import Any

from studies import commands
from studies.engine import Case, Run, Study
from studies.show import markdown
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

Cells = dict[str, float]


def cases() -> Iterator[Case]:
    command = commands.cargo(MANIFEST, TARGET, "{folder}/speed.csv")
    yield Case("bench/speed", ("scene", "fluid", "fluid bench"), options={"command": command}, action=commands.tables)


def keep(case: Case, run: Run) -> dict[str, Any]:
    """All of it is times."""
    return {"times": {"rows": [list(row.values()) for row in run.found["tables"]["speed"]]}}


def found(data: Data, table: str) -> dict[tuple[str, str], Cells]:
    """Values of a table by scene and grid, and by what they are, µs."""
    lines: dict[tuple[str, str], Cells] = {}
    for name, scene, grid, what, value, _ in data["fluid-speed/bench/speed"].times["rows"]:
        if name == table:
            lines.setdefault((scene or "", grid), {})[what] = value
    return lines


def points_of(grid: str) -> int:
    nx, ny = map(int, grid.split(" x "))
    return nx * ny


def ratio(cells: Cells, what: str) -> str:
    return f"{cells[what]:.2f} ({cells[f'{what}, median']:.2f})"


def micro(value: float) -> str:
    return f"{value:.0f}" if value >= 10 else f"{value:.1f}"


def jumps(cells: Cells, what: str) -> dict[float, float]:
    """Times of a scene by the distance that the bar jumps, cells."""
    return {float(name.split()[0]): value for name, value in cells.items() if name.endswith(what)}


def pairs(data: Data) -> list[str]:
    table = [
        [grid, micro(c["FFTW"]), micro(c["ours"]), ratio(c, "ours/FFTW"), micro(c["pruned"]), ratio(c, "pruned/FFTW")]
        for (_, grid), c in found(data, "pair").items()
    ]
    header = ["grid", "FFTW", "ours", "ours/FFTW", "without the upper third of the modes in y", "that/FFTW"]
    return markdown(header, table)


def steps(data: Data) -> list[str]:
    table = [
        [scene, grid, micro(c["five of FFTW"]), micro(c["step"]), ratio(c, "step/FFTW")]
        for (scene, grid), c in found(data, "step").items()
    ]
    return markdown(["scene", "grid", "five of FFTW", "step", "step/FFTW"], table)


def phases(data: Data) -> list[str]:
    """Shares of a step by what users ask for."""
    table = []
    for (scene, grid), cells in found(data, "phases").items():
        parts = (sum(cells[phase] for phase in group) for group in GROUPS.values())
        whole = cells["step"]
        table.append([scene, grid, *(f"{part:.0f} ({100 * part / whole:.0f} %)" for part in parts), micro(whole)])
    return markdown(["scene", "grid", *GROUPS, "step"], table)


def all_phases(data: Data) -> list[str]:
    scenes = found(data, "phases")
    names = [phase for group in GROUPS.values() for phase in group] + ["step"]
    table = [[name, *(micro(cells[name]) for cells in scenes.values())] for name in names]
    return markdown(["phase", *(scene for scene, _ in scenes)], table)


def motion(data: Data) -> list[str]:
    table = []
    for (_, grid), cells in found(data, "motion").items():
        for what in ("bar", "step"):
            times = jumps(cells, what)
            table.append([grid, what, *map(micro, times.values())])
    return markdown(["grid", "", *(f"{jump:g}" for jump in times)], table)


def threads(data: Data) -> list[str]:
    table = []
    for (_, grid), c in found(data, "threads").items():
        clocks = ([micro(c[f"{k}, one"]), micro(c[f"{k}, two"]), ratio(c, f"{k}, one/two")] for k in ("wall", "processor"))
        table.append([grid, *(cell for clock in clocks for cell in clock)])
    return markdown(["grid", "one", "two", "one/two", "processor time one", "two", "one/two"], table)


TABLES = {
    "speed-pairs": pairs,
    "speed-steps": steps,
    "speed-phases": phases,
    "speed-phases-fine": all_phases,
    "speed-motion": motion,
    "speed-threads": threads,
}
STUDY = Study("fluid-speed", cases, keep, TABLES)
