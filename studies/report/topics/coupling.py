"""How the two are coupled: docs/coupling.md and docs/fsi3/stability.md."""

from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from nervure.resources import ROOT
from studies import coupling as study
from studies.fsi3 import ACCELERATIONS, EXCHANGE_STEPS, EXCHANGE_WINDOWS, RATIOS
from studies.tables import markdown

from ..store import Row, Rows, Value, csv_rows, number, value


def rows() -> Iterator[Row]:
    """docs/fsi3/stability.csv."""
    for row in csv_rows(ROOT / "docs" / "fsi3" / "stability.csv"):
        ratio, c_eta, step, end = (float(row[name]) for name in ("ratio", "c_eta", "step", "end"))
        setting = f"density ratio {ratio:g}, C_eta {c_eta:g}, H {step:g}, to {end:g} s"
        reason = (
            row["message"]
            if row["outcome"] == "error"
            else f"noise of the lift {float(row['noise']):.2f}"
            if row["outcome"] == "bad"
            else ""
        )
        yield Row(
            "map coupling",
            row["scheme"],
            setting,
            "noise of the lift",
            number(row["noise"]),
            step=float(row["step"]),
            wall_s=number(row["wall_s"]),
            outcome=row["outcome"],
            reason=reason,
            source="docs/fsi3/stability.csv",
            command=f"make coupling-study ARGS=\"--only '{row['cell']}'\"",
        )


def iterations(rows: Rows) -> list[str]:
    """Mean iterations a step, by density ratio and acceleration."""

    def cell(ratio: float, name: str) -> str:
        label = f"{ratio:g}, {name}"
        ended = rows.one("fsi3, iterations, the run", label, GRID, "reached")
        if ended.outcome == "error":
            return f"stops at t = {1e3 * ended.value:.0f} ms"
        return str(value(rows.one("fsi3, iterations", label, GRID, "iterations a step"), ".1f"))

    return markdown(
        ["density ratio", *(f"`{name}`" for name in ACCELERATIONS)],
        [[f"{ratio:g}", *(cell(ratio, name) for name in ACCELERATIONS)] for ratio in RATIOS],
    )


def exchange(rows: Rows) -> list[str]:
    """Differences of both sides of the interface, over window and step."""
    table = []
    for window, (begin, end) in EXCHANGE_WINDOWS.items():
        for step in EXCHANGE_STEPS:
            found = {row.quantity: row.value for row in rows.of("fsi3, exchange", method=f"30, {step:g}")}
            if f"{window}.lift" not in found:
                continue
            tip = 1e3 * found[f"{window}.tip"]
            where = f"{begin:g} to {end:g} s" + (f", tip ± {tip:.0f} mm" if tip > 1 else "")
            cells = (f"{100 * found[f'{window}.{name}']:.2f} %" for name in ("lift", "work"))
            table.append([where, f"{step:g}", *cells, f"{100 * found[f'{window}.net']:+.2f} %"])
    return markdown(["", "H [s]", "lift", "work, magnitudes", "work, net"], table)


def tables(rows: Rows) -> dict[str, Callable[[], list[str]]]:
    return {"coupling-iterations": partial(iterations, rows), "coupling-exchange": partial(exchange, rows)}


def values(rows: Rows) -> Iterator[tuple[str, Value]]:
    cells = rows.of("map coupling")
    counts = Counter(row.outcome for row in cells)
    for outcome in ("ok", "error", "bad"):
        yield f"coupling.{outcome}", Value(counts[outcome], "d", "cells", "make coupling-study")
    default = [row for row in cells if row.method == "default"]
    yield "coupling.default", Value(len(default), "d", "cells", "make coupling-study")
    yield "coupling.default.ok", Value(sum(row.outcome == "ok" for row in default), "d", "cells", "make coupling-study")
    for name, step in zip(("long", "middle", "short"), EXCHANGE_STEPS):
        yield f"coupling.zigzag.{name}", value(rows.one("fsi3, exchange", f"42, {step:g}", GRID, "first.work"), ".1f", "%", 100)
    for grid in (GRID, "650 x 144"):
        row = rows.one("fsi3, the run", "momentum load", grid, "imbalance")
        yield f"coupling.imbalance.{grid.replace(' ', '')}", value(row, ".1f", "%", 100)
    yield "coupling.powers", value(rows.one("fsi3, the run", "momentum load", GRID, "powers"), ".2f")


GRID = "325 x 72"


def pages() -> dict[Path, str]:
    return study.pages()
