"""The fluid: docs/fluid.md and docs/fluid."""

import re
from collections.abc import Callable, Iterator

from cosim.scene import ROOT

from ..cases import QUANTITIES, references
from ..measure import unit_of
from ..store import Row, Rows, Value, csv_rows, markdown, number, value

MASKS = {
    "wall target `curvature`": "grid/2D-2-curvature-{}",
    "the same, grid aside (900: half a cell both ways; 600: a quarter both ways)": "aside",
    "`shear`": "grid/2D-2-shear-{}",
    "`none`: the bare profile": "grid/2D-2-none-{}",
    "cosine, half-width a cell, C_eta = 1e-4 s": "grid/2D-2-cosine-{}",
    "cosine, uncorrected": "grid/2D-2-cosine-uncorrected-{}",
    "sharp, C_eta = 1e-4 s": "grid/2D-2-sharp-{}",
    "thesis: Heun, sharp, uncorrected, C_eta = 1e-3 s, two-thirds rule": "thesis/{}",
}
"""Lines of the table in docs/fluid.md and the names of their cases."""


def rows() -> Iterator[Row]:
    """docs/fluid: cylinders, and the map of stability."""
    for row in csv_rows(ROOT / "docs" / "fluid" / "results.csv"):
        case, group = f"cylinder-{row['flow'].lower().replace('-', '')}", row["case"].partition("/")[0]
        published = references(case)
        setting = f"{row['nx']} x {row['ny']}, {row['case']}"
        shared = {
            "size": float(row["nx"]),
            "step": float(row["dt"]),
            "wall_s": number(row["wall_s"]),
            "source": "docs/fluid/results.csv",
            "command": f"make fluid-study ARGS=\"--only '{row['case']}'\"",
        }
        method = f"{group}: {row['mask']}, {row['scheme']}"
        if row["result"] != "ok":
            yield Row(case, method, setting, "all", outcome="error", reason=row["result"], **shared)
        for quantity in QUANTITIES[case]:
            value = number(row[quantity])
            if value is not None and row["result"] == "ok":
                expected, scale = published[quantity]
                yield Row(
                    case,
                    method,
                    setting,
                    quantity,
                    value,
                    unit_of(quantity),
                    expected,
                    (value - expected) / scale,
                    **shared,
                )
    yield from fluid_map((ROOT / "docs" / "fluid" / "stability.md").read_text(encoding="utf-8"))


def fluid_map(text: str) -> Iterator[Row]:
    """The cells of docs/fluid/stability.md; its errors are letters that are explained below the tables."""
    reasons = dict(re.findall(r"^([A-Z]) \(first case\): (.*)$", text, re.M))
    method, header = "", []
    for line in text.splitlines():
        if line.startswith("## "):
            method, header = line[3:], []
        if not line.startswith("| "):
            continue
        cells = [cell.strip() for cell in line.strip("| ").split("|")]
        if not header:
            header = cells
            continue
        fixed = 2 if header[0] == "Re" else 1
        where = ", ".join(
            f"{name} {cell}" if name != "scene" else cell for name, cell in zip(header[:fixed], cells[:fixed])
        )
        for name, cell in zip(header[fixed:], cells[fixed:]):
            row = Row(
                "map fluid", method, f"{where}, {name}", "largest speed", source="docs/fluid/stability.md", unit="m/s"
            )
            letter = re.match(r"([A-Z]) at", cell)
            if letter:
                row.outcome, row.reason = "error", f"{cell}: {reasons.get(letter[1], '')}"
            elif cell.startswith("**wild**"):
                row.outcome, row.reason, row.value = (
                    "bad",
                    "wild: ten times the inflow or more",
                    float(cell.split()[-1]),
                )
            else:
                row.value = float(cell)
            yield row


def values(rows: Rows) -> Iterator[tuple[str, Value]]:
    for quantity in QUANTITIES["cylinder-2d2"]:
        row = rows.one("cylinder-2d2", "grid: curvature, sbdf2", "900 x 180, grid/2D-2-curvature-900", quantity)
        yield f"fluid.2d2.900.{quantity}", value(row, ".2f", "%", 100 if row.error > 0 else -100, "error")


def tables(rows: Rows) -> dict[str, Callable[[], list[str]]]:
    return {"cylinder-2d2-masks": lambda: masks(rows)}


def masks(rows: Rows) -> list[str]:
    """Errors of 2D-2 by mask and grid, from the fluid's study."""
    cells: dict[str, dict[str, Row]] = {}
    for row in rows.of("cylinder-2d2", source="docs/fluid/results.csv"):
        if row.error is not None:
            cells.setdefault(row.setting.split(", ", 1)[1], {})[row.quantity] = row

    def cell(name: str) -> str:
        errors = (
            (100 * cells[name][quantity].error for quantity in QUANTITIES["cylinder-2d2"]) if name in cells else ()
        )
        return " / ".join(f"{error:.{1 if abs(error) >= 10 else 2}f}" for error in errors)

    grids = (450, 600, 800, 900, 1100)
    table = []
    for label, name in MASKS.items():
        aside = {600: "offset/2D-2-curvature-0.25-0.25", 900: "offset/2D-2-curvature-900"}
        table.append([label, *(cell(aside.get(nx, "") if name == "aside" else name.format(nx)) for nx in grids)])
    return markdown(["mask", *(f"{nx} x {nx // 5}" for nx in grids)], table)
