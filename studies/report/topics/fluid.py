"""The fluid: docs/fluid.md and docs/fluid."""

from collections.abc import Callable, Iterator
from math import ceil, log2
from pathlib import Path

from nervure.resources import ROOT
from studies import fluid as study
from studies.tables import markdown

from ..cases import QUANTITIES, references
from ..measure import unit_of
from ..store import Row, Rows, Value, csv_rows, number, value

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


RESULTS, STABILITY, MEASURES = (f"docs/fluid/{name}.csv" for name in ("results", "stability", "measures"))

CLOCKS = ("wall_s", "wall_q1", "wall_q3", "cpu_s", "cpu_q1", "cpu_q3")

BESIDE = {"cd_mean": "1", "flow_rate": "m2/s", "u_max": "m/s", "cfl": "1"}
"""What a run has beside the quantities that are compared, and its unit."""


# Rows


def rows() -> Iterator[Row]:
    """docs/fluid: cylinders, the map of stability, exact solutions and invariants."""
    yield from cylinders()
    for row in csv_rows(ROOT / STABILITY):
        at = f"Re {float(row['reynolds']):g}"
        c_eta = f"{float(row['c_eta']):.0e}".replace("e-0", "e-")
        setting = f"{row['scene']}, {at}" if row["scene"] else f"{at}, CFL {row['cfl']}, C_eta {c_eta}"
        yield Row(
            "map fluid",
            row["group"],
            setting,
            "largest speed",
            number(row["speed"]),
            "m/s",
            outcome=row["outcome"],
            reason=row["message"],
            source=STABILITY,
            command="make fluid-measures",
        )
    for row in csv_rows(ROOT / MEASURES):
        found, expected = float(row["value"]), number(row["expected"])
        yield Row(
            "fluid measures",
            row["measure"],
            row["setting"],
            row["quantity"],
            found,
            row["unit"],
            expected,
            None if expected is None else found / expected - 1,
            source=MEASURES,
            command="make fluid-measures",
        )
    for nx, printed in study.THESIS_TABLE_3_3.items():
        for quantity, found in printed.items():
            yield Row(PRINTED, "table 3.3", f"{nx} x {nx // 5}", quantity, found, "1", size=nx, source="cited")
    for nx, found in study.THESIS_TABLE_3_4.items():
        yield Row(PRINTED, "table 3.4", f"{nx} x {nx // 5}", "cd_mean", found, "1", size=nx, source="cited")


PRINTED = "cylinder-2d2, printed in the thesis"


def cylinders() -> Iterator[Row]:
    for row in csv_rows(ROOT / RESULTS):
        case, group = f"cylinder-{row['flow'].lower().replace('-', '')}", row["case"].partition("/")[0]
        published = references(case)
        setting = f"{row['nx']} x {row['ny']}, {row['case']}"
        shared = {
            "size": float(row["nx"]),
            "step": float(row["dt"]),
            "repeats": int(row["repeats"]) if row["repeats"] else None,
            "source": RESULTS,
            "command": f"make fluid-study ARGS=\"--only '{row['case']}'\"",
        } | {clock: number(row[clock]) for clock in CLOCKS}
        method = f"{group}: {row['mask']}, {row['scheme']}"
        if row["result"] != "ok":
            yield Row(case, method, setting, "all", outcome="error", reason=row["result"], **shared)
            continue
        for quantity in QUANTITIES[case]:
            found = number(row[quantity])
            if found is not None:
                expected, scale = published[quantity]
                error = (found - expected) / scale
                yield Row(case, method, setting, quantity, found, unit_of(quantity), expected, error, **shared)
        for quantity, unit in BESIDE.items():
            if row[quantity] and quantity not in QUANTITIES[case]:
                yield Row(f"{case}, the run", method, setting, quantity, number(row[quantity]), unit, **shared)


# Values


def values(rows: Rows) -> Iterator[tuple[str, Value]]:
    for quantity in QUANTITIES["cylinder-2d2"]:
        row = rows.one("cylinder-2d2", "grid: curvature, sbdf2", "900 x 180, grid/2D-2-curvature-900", quantity)
        yield f"fluid.2d2.900.{quantity}", value(row, ".2f", "%", 100 if row.error > 0 else -100, "error")
    yield from values_of_places(rows)
    yield from values_of_the_thesis(rows)
    yield from values_of_measures(rows)
    yield from values_of_the_map(rows)


def values_of_places(rows: Rows) -> Iterator[tuple[str, Value]]:
    """2D-1 at 450 x 90 over four places of the grid."""
    for mask in ("curvature", "none", "cosine", "sharp"):
        found = [
            row
            for group in ("grid", "offset")
            for row in rows.of("cylinder-2d1", method=f"{group}: {mask}, sbdf2", size=450, quantity="cd_mean")
        ]
        for name, row in (("least", min(found, key=_error)), ("most", max(found, key=_error))):
            yield f"fluid.2d1.{mask}.cd.{name}", value(row, "+.2f", "%", 100, "error")
    pressures = [
        row
        for group in ("grid", "offset")
        for row in rows.of("cylinder-2d1", method=f"{group}: curvature, sbdf2", quantity="dp_mean")
    ]
    yield "fluid.2d1.dp", _bound(pressures, ".1f")


def values_of_the_thesis(rows: Rows) -> Iterator[tuple[str, Value]]:
    """Table 3.3 at 900 x 180, and the same settings here."""
    method, setting = "thesis: sharp, uncorrected, rk2", "900 x 180, thesis/900"
    for quantity, form in (("cd_mean", ".3f"), ("cl_peak_to_peak", ".3f"), ("st", ".4f")):
        printed = rows.one(PRINTED, "table 3.3", "900 x 180", quantity)
        case = "cylinder-2d2" if quantity in QUANTITIES["cylinder-2d2"] else "cylinder-2d2, the run"
        yield f"fluid.thesis.{quantity}.printed", value(printed, form)
        yield f"fluid.thesis.{quantity}.repeated", value(rows.one(case, method, setting, quantity), form)


def values_of_measures(rows: Rows) -> Iterator[tuple[str, Value]]:
    def of(measure: str, setting: str, quantity: str) -> Row:
        return rows.one("fluid measures", measure, setting, quantity)

    for scheme in ("sbdf2", "rk2"):
        for steps in (80, 160):
            row = of("Taylor-Green", f"{scheme}, {steps} steps", "error")
            yield f"fluid.taylor_green.{scheme}.{steps}", value(row, ".1e")
    boxes = rows.of("fluid measures", method="added mass")
    for row in boxes:
        name = row.setting.split()[2]
        yield f"fluid.added_mass.{name}", value(row, ".3f")
        yield f"fluid.added_mass.{name}.expected", value(row, ".3f", field="reference")
    yield "fluid.added_mass.error", _bound(boxes, ".1f")
    yield "fluid.enstrophy.none", value(of("made by advection", "none", "enstrophy"), ".1e")
    for name, setting in (("smooth", "smooth"), ("resolved", "smooth, waves up to two thirds")):
        row = of("made by advection", setting, "energy")
        yield f"fluid.energy.{name}", Value(abs(row.value), ".0e" if name == "resolved" else ".2f", "1", row.command)
    aliased = of("aliasing", "7 and 6, none", "share").value
    for name, form in (("two_thirds", ".0e"), ("smooth", ".1e")):
        yield f"fluid.aliasing.{name}", value(of("aliasing", f"7 and 6, {name}", "share"), form, scale=1 / aliased)
    for e_fold in ("0.2", "0.25", "0.3"):
        least, most = (of("wall", f"e-fold {e_fold}", name) for name in ("least", "most"))
        if e_fold == "0.2":
            yield "fluid.wall.0.2.least", value(least, ".2f")
            yield "fluid.wall.0.2.most", value(most, ".2f")
        else:
            row = max((least, most), key=lambda row: abs(row.value))
            yield f"fluid.wall.{e_fold}", Value(_up(abs(row.value), 3), ".3f", "cells", row.command)
    coarse, fine = (of("flux", f"{cells} cells", "error") for cells in (64, 128))
    yield "fluid.flux.order", Value(log2(coarse.value / fine.value), ".1f", "1", fine.command)
    yield "fluid.arrays", value(of("memory", "320 x 120, with a beam", "arrays of the grid's size"), ".0f")


def values_of_the_map(rows: Rows) -> Iterator[tuple[str, Value]]:
    cells = rows.of("map fluid")
    for outcome in ("ok", "error", "bad"):
        count = sum(row.outcome == outcome for row in cells)
        yield f"fluid.map.{outcome}", Value(count, "d", "runs", "make fluid-measures")
    # How much faster than with a CFL number of 0.1 the flow is in places, from Re 1000 on.
    maps = {row.setting: row for row in rows.of("map fluid", method="Backward differences, log-linear mask")}
    for cfl in ("0.25", "0.4"):
        ratios = [
            row.value / maps[setting.replace(f"CFL {cfl},", "CFL 0.1,")].value
            for setting, row in maps.items()
            if f"CFL {cfl}," in setting and setting.startswith(("Re 1000,", "Re 10000,"))
        ]
        yield f"fluid.map.faster.{cfl}", Value(max(ratios), ".1f", "1", "make fluid-measures")


def _error(row: Row) -> float:
    return row.error


def _up(number: float, digits: int) -> float:
    """Rounded up, for a bound."""
    return ceil(number * 10**digits) / 10**digits


def _bound(rows: list[Row], form: str) -> Value:
    """The largest error of rows in per cent, rounded up."""
    row = max(rows, key=lambda row: abs(row.error))
    return Value(_up(100 * abs(row.error), int(form[1])), form, "%", row.command)


# Tables


def tables(rows: Rows) -> dict[str, Callable[[], list[str]]]:
    return {
        "cylinder-2d2-masks": lambda: masks(rows),
        "cylinder-2d2-c_eta": lambda: hardness(rows),
        "wall-target": lambda: wall_targets(rows),
    }


def wall_targets(rows: Rows) -> list[str]:
    """Weights of the wall target by the e-fold length."""
    found: dict[str, dict[str, Row]] = {}
    for row in rows.of("fluid measures", method="wall target"):
        found.setdefault(row.setting, {})[row.quantity] = row
    names = {"m": ".4f", "c": ".4f", "D_c": ".3f", "shift": ".4f"}
    table = []
    for setting, cells in found.items():
        shown = setting.removeprefix("e-fold ").removesuffix(", curvature").replace("shear", "`shear`")
        table.append([shown, *(format(cells[q].value, form) if q in cells else "" for q, form in names.items())])
    return markdown(["e-fold λ, cells", "m", "c", "D_c", "shift, cells"], table)


def hardness(rows: Rows) -> list[str]:
    """Errors of 2D-2 with the default mask by C_eta and grid."""
    names = {
        450: "c_eta/curvature-{}",
        600: "hard/curvature-600-{}",
        900: "hard/curvature-900-{}",
    }
    shipped = "1e-05"
    table = []
    for c_eta in ("0.0001", shipped, "1e-06"):
        cells = [
            errors_of(rows, f"grid/2D-2-curvature-{nx}" if c_eta == shipped else name.format(c_eta))
            for nx, name in names.items()
        ]
        table.append([f"{float(c_eta):.0e}".replace("e-0", "e-"), *cells])
    return markdown(["C_eta, s", *(f"{nx} x {nx // 5}" for nx in names)], table)


def errors_of(rows: Rows, case: str) -> str:
    """Errors of cD max, cL from peak to peak and St of a case of 2D-2 in per cent; empty where it has not been run."""
    found = {row.quantity: row for row in rows.of("cylinder-2d2", source=RESULTS) if row.setting.endswith(f", {case}")}
    if not all(quantity in found for quantity in QUANTITIES["cylinder-2d2"]):
        return ""
    errors = (100 * found[quantity].error for quantity in QUANTITIES["cylinder-2d2"])
    return " / ".join(f"{error:.{1 if abs(error) >= 10 else 2}f}" for error in errors)


def masks(rows: Rows) -> list[str]:
    """Errors of 2D-2 by mask and grid, from the fluid's study."""
    grids = (450, 600, 800, 900, 1100)
    aside = {600: "offset/2D-2-curvature-0.25-0.25", 900: "offset/2D-2-curvature-900"}
    table = [
        [label, *(errors_of(rows, aside.get(nx, "none") if name == "aside" else name.format(nx)) for nx in grids)]
        for label, name in MASKS.items()
    ]
    return markdown(["mask", *(f"{nx} x {nx // 5}" for nx in grids)], table)


def pages() -> dict[Path, str]:
    return study.pages()
