"""Speed of the fluid: docs/fluid-speed.md."""

from collections.abc import Callable, Iterator
from functools import partial

from nervure.resources import ROOT
from studies.tables import exponent, markdown

from ..store import Row, Rows, Value, csv_rows, value

SOURCE = "docs/fluid/speed.csv"

CASES = {
    "about": "fluid speed, beside",
    "pair": "fluid speed, a pair of transforms",
    "step": "cost of a fluid step",
    "phases": "phases of a fluid step",
    "motion": "fluid speed, motion of the stations",
    "threads": "fluid speed, threads",
}

GROUPS = {
    "transforms": ("transforms, two along y", "transforms, five along x", "transforms, three back along y, and the CFL number"),
    "local solve": ("local solve", "velocities of bodies and zones"),
    "projection": ("projection",),
    "painting": ("painting of the moving bodies", "wall target"),
    "forces and loads": ("forces on the bodies", "loads and impedance of the stations"),
    "rest": ("rest",),
}
"""What users ask for, and the phases of it."""


def rows() -> Iterator[Row]:
    for row in csv_rows(ROOT / SOURCE):
        nx, ny = map(int, row["grid"].split(" x "))
        yield Row(
            CASES[row["table"]],
            row["scene"],
            row["grid"],
            row["what"],
            float(row["value"]),
            row["unit"],
            size=nx * ny,
            source=SOURCE,
            command="make bench-fluid",
        )


def found(rows: Rows, table: str, **fixed) -> dict[tuple[str, str], dict[str, Row]]:
    """Rows of a table by scene and grid, and by what they are."""
    lines: dict[tuple[str, str], dict[str, Row]] = {}
    for row in rows.of(CASES[table], **fixed):
        lines.setdefault((row.method, row.setting), {})[row.quantity] = row
    return lines


# Values


def values(rows: Rows) -> Iterator[tuple[str, Value]]:
    steps, pairs = found(rows, "step"), found(rows, "pair")
    ratios = [cells["step/FFTW"] for cells in steps.values()]
    yield from between("speed.step", ratios, ".1f")
    yield from between("speed.pair", [cells["ours/FFTW"] for cells in pairs.values()], ".2f")
    phases = found(rows, "phases")
    fsi3 = [cells for (scene, _), cells in phases.items() if scene.startswith("fsi3")]
    for name, group in (("transforms", "transforms"), ("painting", "painting"), ("loads", "forces and loads")):
        shares = [share(cells, group) for cells in fsi3]
        for end, number in (("least", min(shares)), ("most", max(shares))):
            yield f"speed.{name}.{end}", Value(number, ".0f", "%", "make bench-fluid")
    point = {grid: cells["ours"].value / cells["ours"].size for (_, grid), cells in pairs.items()}
    for name, grid, beside in (("650", "650 x 144", "640 x 144"), ("prime", "646 x 144", "650 x 144")):
        yield f"speed.point.{name}", Value(point[grid] / point[beside], ".1f", "1", "make bench-fluid")
    for (_, grid), cells in found(rows, "threads").items():
        yield f"speed.threads.{grid.split()[0]}", value(cells["wall, one/two"], ".1f")
        yield f"speed.threads.{grid.split()[0]}.work", value(cells["processor, one/two"], ".1f")
    for (_, grid), cells in found(rows, "motion").items():
        times = [row.value for what, row in cells.items() if what.endswith("bar")]
        yield f"speed.motion.{grid.split()[0]}", Value(100 * (max(times) / min(times) - 1), ".0f", "%", "make bench-fluid")
        yield f"speed.motion.{grid.split()[0]}.exponent", Value(exponent(*zip(*moved(cells))), ".2f", "1", "make bench-fluid")


def between(key: str, rows: list[Row], form: str) -> Iterator[tuple[str, Value]]:
    ordered = sorted(rows, key=lambda row: row.value)
    yield f"{key}.least", value(ordered[0], form)
    yield f"{key}.most", value(ordered[-1], form)


def share(cells: dict[str, Row], group: str) -> float:
    """Of a step, per cent."""
    return 100 * sum(cells[phase].value for phase in GROUPS[group]) / cells["step"].value


def jumps(cells: dict[str, Row], what: str) -> dict[float, Row]:
    """Rows of a scene by the distance that the bar jumps, cells."""
    return {float(name.split()[0]): row for name, row in cells.items() if name.endswith(what)}


def moved(cells: dict[str, Row]) -> list[tuple[float, float]]:
    """Distance of the jump, cells, and the bar's time, where it moves."""
    return [(jump, row.value) for jump, row in jumps(cells, "bar").items() if jump > 0]


# Tables


def tables(rows: Rows) -> dict[str, Callable[[], list[str]]]:
    return {
        "speed-pairs": partial(pair_table, rows),
        "speed-steps": partial(step_table, rows),
        "speed-phases": partial(phases, rows),
        "speed-phases-fine": partial(all_phases, rows),
        "speed-motion": partial(motion, rows),
        "speed-threads": partial(thread_table, rows),
    }


def ratio(cells: dict[str, Row], what: str) -> str:
    return f"{cells[what].value:.2f} ({cells[f'{what}, median'].value:.2f})"


def micro(row: Row) -> str:
    return f"{row.value:.0f}" if row.value >= 10 else f"{row.value:.1f}"


def pair_table(rows: Rows) -> list[str]:
    table = [
        [grid, micro(c["FFTW"]), micro(c["ours"]), ratio(c, "ours/FFTW"), micro(c["pruned"]), ratio(c, "pruned/FFTW")]
        for (_, grid), c in found(rows, "pair").items()
    ]
    header = ["grid", "FFTW", "ours", "ours/FFTW", "without the upper third of the modes in y", "that/FFTW"]
    return markdown(header, table)


def step_table(rows: Rows) -> list[str]:
    table = [
        [scene, grid, micro(c["five of FFTW"]), micro(c["step"]), ratio(c, "step/FFTW")]
        for (scene, grid), c in found(rows, "step").items()
    ]
    return markdown(["scene", "grid", "five of FFTW", "step", "step/FFTW"], table)


def phases(rows: Rows) -> list[str]:
    """Shares of a step by what users ask for."""
    table = []
    for (scene, grid), cells in found(rows, "phases").items():
        parts = (sum(cells[phase].value for phase in group) for group in GROUPS.values())
        whole = cells["step"].value
        table.append([scene, grid, *(f"{part:.0f} ({100 * part / whole:.0f} %)" for part in parts), micro(cells["step"])])
    return markdown(["scene", "grid", *GROUPS, "step"], table)


def all_phases(rows: Rows) -> list[str]:
    scenes = found(rows, "phases")
    names = [phase for group in GROUPS.values() for phase in group] + ["step"]
    table = [[name, *(micro(cells[name]) for cells in scenes.values())] for name in names]
    return markdown(["phase", *(f"{scene}" for scene, _ in scenes)], table)


def motion(rows: Rows) -> list[str]:
    table = []
    for (_, grid), cells in found(rows, "motion").items():
        for what in ("bar", "step"):
            times = jumps(cells, what)
            table.append([grid, what, *(micro(row) for row in times.values())])
    return markdown(["grid", "", *(f"{jump:g}" for jump in times)], table)


def thread_table(rows: Rows) -> list[str]:
    table = []
    for (_, grid), c in found(rows, "threads").items():
        clocks = ([micro(c[f"{k}, one"]), micro(c[f"{k}, two"]), ratio(c, f"{k}, one/two")] for k in ("wall", "processor"))
        table.append([grid, *(cell for clock in clocks for cell in clock)])
    return markdown(["grid", "one", "two", "one/two", "processor time one", "two", "one/two"], table)
