"""Numbers that documents show: `key → value, unit, digits, command, tolerance`, made of the rows of results.json."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .store import Row

SCALE = {"m": (1e3, "mm")}

SIMULATED = 8.0
"""End of the FSI3 scenes, s."""

DIGITS = {"tip_ux.frequency_hz": 2, "tip_uy.frequency_hz": 2, "tip_ux": 2, "tip_uy": 2, "drag": 1, "lift": 1}
"""Of FSI3's quantities, in the unit that is shown."""


def values_of(rows: list[Row]) -> dict[str, dict]:
    """All of them."""
    values: dict[str, dict] = {}

    def put(key: str, value: float, unit: str, digits: int, row: Row, tolerance: float | None = None) -> None:
        values[key] = {"value": value, "unit": unit, "digits": digits, "command": row.command, "tolerance": tolerance}

    runs: dict[str, dict[str, Row]] = {}
    for row in rows:
        if row.case == "fsi3" and row.method == "momentum load" and row.outcome == "ok":
            runs.setdefault(row.setting.replace(" ", ""), {})[row.quantity] = row
    for grid, found in runs.items():
        for quantity, row in found.items():
            factor, unit = SCALE.get(row.unit, (1.0, row.unit))
            digits = DIGITS.get(quantity, DIGITS.get(quantity.split(".")[0], 3))
            put(f"fsi3.{grid}.{quantity}", row.value * factor, unit, digits, row, row.tolerance)
            put(f"fsi3.{grid}.{quantity}.reference", row.reference * factor, unit, digits, row)
            put(f"fsi3.{grid}.{quantity}.error", 100 * row.error, "%", 1, row)
            put(f"fsi3.{grid}.{quantity}.error.whole", 100 * row.error, "%", 0, row)
        if "tip_uy.amplitude" in found:
            row = found["tip_uy.amplitude"]
            seconds = (row.cpu_s or row.wall_s) / SIMULATED
            put(f"fsi3.{grid}.time", seconds, "s a simulated s", 1 if seconds < 20 else 0, row)
            best = max(abs(found[q].error) for q in ("tip_uy.amplitude", "tip_uy.frequency_hz", "drag.mean"))
            put(f"fsi3.{grid}.uy_f_drag.error", 100 * best, "%", 1, row)
    for row in rows:
        if row.source == "docs/fluid/results.csv" and row.error is not None:
            name = row.setting.split(", ")[1].replace("/", ".")
            put(f"cylinder.{name}.{row.quantity}.error", 100 * row.error, "%", 2, row)
            put(f"cylinder.{name}.{row.quantity}.distance", 100 * abs(row.error), "%", 2, row)
        if row.case == "cfd3" and row.error is not None:
            put(f"cfd3.{row.quantity}.error", 100 * row.error, "%", 1, row)
        if row.case in ("rod-static", "csm3") and row.value is not None:
            factor, unit = SCALE.get(row.unit, (1.0, row.unit))
            key = f"{row.case}.{row.method}.{row.setting}.{row.quantity}".replace(" ", "")
            put(key, row.value * factor, unit, 4, row, row.tolerance)
    still = [
        row
        for row in rows
        if row.case == "cfd3" and row.quantity in ("drag.mean", "lift.amplitude", "lift.frequency_hz")
    ]
    if still:
        put("cfd3.most", 100 * max(abs(row.error) for row in still), "%", 1, still[0])
    shares = [
        row.value
        for row in rows
        if row.case == "phases fsi3"
        and row.quantity == "exchange_and_python"
        and row.setting in ("325 x 72", "650 x 144", "1300 x 288")
    ]
    if shares:
        row = next(row for row in rows if row.case == "phases fsi3")
        put("fsi3.exchange.least", 100 * min(shares), "%", 0, row)
        put("fsi3.exchange.most", 100 * max(shares), "%", 0, row)
    for name in ("rod", "fluid", "coupling"):
        cells = [row.outcome for row in rows if row.case.split(" situations")[0] == f"map {name}"]
        for outcome in ("ok", "error", "bad"):
            values[f"map.{name}.{outcome}"] = {
                "value": cells.count(outcome),
                "unit": "cells",
                "digits": 0,
                "command": "",
                "tolerance": None,
            }
    return values


def text_of(value: dict) -> str:
    """A value as documents show it."""
    return f"{value['value']:.{value['digits']}f}"
