"""The rod alone: tables and figures of chapter 2 of the thesis and beyond, by studies/rust/rod."""

from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from studies import commands, plate, roofline, show, simulate
from studies.engine import ROD, Case, Run, Study
from studies.show import exponent, grouped
from studies.store import Data

Rows = list[dict[str, Any]]

FILES = ("condition", "runtime", "order_in_n", "order_in_dt", "bending_models", "taper", "csm",
          "csm3_energy", "extreme", "situations")  # fmt: skip
"""Tables of the program; each is a file of that name."""

STEPS = 10_000  # Time steps of the runs of the thesis' table 2.3, about
SOLVERS = ("banded", "sparse", "dense")
SCHEMES = {"trapezoid, unwatched": 1, "trapezoid": 1, "generalised-alpha 0.5": 1, "generalised-alpha 0.8": 1,
           "BDF2": 1, "TR-BDF2": 2}  # fmt: skip
"""Solves of each scheme in a step."""
EXTREME = ("n", "k_e", "EI", "dt")  # Varied parameters of the stiff cases


def cases() -> Iterator[Case]:
    for name in FILES:
        command = commands.cargo("rod-study", "{folder}", name)
        yield Case(f"study/{name}", (*ROD, "rod study"), options={"command": command}, action=commands.tables)
    command = commands.cargo("rod-study", "{folder}/roofline.csv", example="roofline")
    yield Case("study/roofline", ("scene", "rod", "rod roofline"), options={"command": command}, action=commands.tables)
    yield Case("study/clamp", ("plate",), action=plate.run)


def extract(case: Case, run: Run) -> dict[str, Any]:
    """Return the table, with values that depend on the machine apart; of long tables only the shown part."""
    name = case.name.split("/")[1]
    rows = run.found["tables"][name]
    if name in ("runtime", "roofline"):
        return {"times": {"rows": rows}}
    if name == "extreme":
        return extremes(rows)
    if name == "csm3_energy":
        rows = [group[-1] for group in grouped(rows, "scheme", "n", "dt").values()]
    seconds = [row.pop("seconds", None) for row in rows]
    for row in rows:
        row.pop("worst_step_seconds", None)
    return {"tables": {name: rows}, "times": {"seconds": seconds} if any(seconds) else {}}


def extremes(rows: Rows) -> dict[str, Any]:
    """Return outcomes of the stiff cases by n and dt, the failed cases, and the values that were tried."""
    table, longest = [], []
    for (n, dt), group in grouped(rows, "n", "dt").items():
        good = [row for row in group if row["result"] == "ok"]
        kinds = Counter(row["result"].split(" in step")[0] for row in group if row["result"] != "ok")
        largest = {f"largest {what}": max((row[what] for row in good), default=0.0) for what in ("gain", "loss")}
        others = ", ".join(f"{kind} {count}" for kind, count in kinds.items())
        table.append({"n": n, "dt": dt, "cells": len(group), "ok": len(good), "other": others} | largest
                     | {"iterations": max(row["iterations"] for row in group)})  # fmt: skip
        longest.append(max(row["worst_step_seconds"] for row in group))
    failed = [{key: row[key] for key in (*EXTREME, "result")} for row in rows if row["result"] != "ok"]
    tried = [{"axis": key, "values": sorted({row[key] for row in rows})} for key in EXTREME]
    tables = {"extreme": table, "tried": tried} | ({"failed": failed} if failed else {})
    return {"tables": tables, "times": {"longest step": longest}}


def table_of(data: Data, name: str) -> Rows:
    return data[f"rod/study/{name}"].tables[name]


def run_times(data: Data) -> Rows:
    """Return the cost of an iteration, and seconds of `STEPS` steps in space with each solver."""
    rows = []
    for row in data["rod/study/runtime"].times["rows"]:
        solvers = [name for name in SOLVERS if row[name]]
        times, rest = STEPS * row["iterations_per_step"], row["iteration_3d"] - row["banded"]
        runs = {f"run {name}": times * (rest + row[name]) for name in solvers}
        runs |= {f"run thesis {name}": row[f"thesis_{name}"] for name in ("sparse", "dense")}
        micro = {name: 1e6 * row[name] for name in ("iteration_3d", "iteration_2d", *solvers)}
        ratios = {"3D/2D": row["iteration_3d"] / row["iteration_2d"], "sparse/banded": row["sparse"] / row["banded"]}
        rows.append({"n": row["n"]} | runs | micro | ratios)
    return rows


def rooflines(data: Data) -> Rows:
    """Return the parts of a Newton iteration in space and their sum, beside both roofs and the longest chain of
    divisions."""
    rows = []
    for group in grouped(data["rod/study/roofline"].times["rows"], "n").values():
        columns = {"µs": "seconds", "MB": "bytes", "Mflop": "flops"}
        parts = [
            {"part": row["part"]}
            | {to: (1e6 if to == "µs" else 1e-6) * row[of] for to, of in columns.items()}
            | {"chain": row["chain"] and 1e6 * row["chain"]}
            for row in group
        ]
        whole = {"part": "iteration", "chain": None} | {to: sum(part[to] for part in parts) for to in columns}
        about, (bandwidth, peak) = {"n": group[0]["n"]}, (1e-9 * group[0][name] for name in ("bandwidth", "peak"))
        rows += [about | part | roofline.reached(part, bandwidth, peak) for part in (*parts, whole)]
    return rows


def orders(data: Data, name: str, keys: tuple[str, ...], along: str, sign: int, part: slice) -> Rows:
    """Return rows of a convergence study by sequence: errors by `along`, and the observed order over a part of them."""
    found = []
    for group in grouped(table_of(data, name), *keys).values():
        x, y = ([row[key] for row in group[part]] for key in (along, "error"))
        errors = {f"{row[along]:.3g}": row["error"] for row in group}
        found.append(group[-1] | errors | {"order": sign * exponent(x, y), "group": group})
    return found


ERRORS_IN_N = partial(
    orders, name="order_in_n", keys=("calibration", "plane", "gravity"), along="n", sign=-1, part=slice(2, 5)
)


def energies(data: Data) -> Rows:
    """Return the end of each run of CSM3 by scheme; cells by n and dt."""
    found = []
    for scheme, group in grouped(table_of(data, "csm3_energy"), "scheme").items():
        cells = {}
        for row in group:
            ended = "" if row["time"] > 59 else f" (ended at {row['time']:.0f} s)"
            halved = f" ({row['halvings']:.0f} halvings)" if row["halvings"] else ""
            cells[f"n = {row['n']:.0f}, dt = {row['dt']:g} s"] = f"{row['energy']:+.1e}{ended}{halved}"
        found.append({"scheme": scheme} | cells)
    return found


def schemes(data: Data) -> Rows:
    """Return the effect of the schemes on the energy."""
    rows = {row["scheme"]: row for row in energies(data)}
    for scheme, row in rows.items():
        cells = [cell for cell in table_of(data, "situations") if cell["scheme"] == scheme]
        bad = [cell for cell in cells if cell["result"] != "ok"]
        others = [f"{cell['situation'].split(':')[0]}: {cell['result'].split(' in step')[0]}" for cell in bad]
        row |= {"solves": SCHEMES[scheme], "others": "; ".join(others)}
        row["good"] = f"{len(cells) - len(bad)} of {len(cells)}" if cells else ""
    return [rows[scheme] for scheme in SCHEMES]


def csm(data: Data) -> Rows:
    """Return quantities of CSM beside Turek & Hron."""
    table = []
    for (scene, quantity), runs in grouped(table_of(data, "csm"), "scene", "quantity").items():
        expected, extent = simulate.published(scene).get(quantity, (0.0, 0.0))
        if extent:
            name, _, what = quantity.partition(".")
            scale, unit, digits = (1, "Hz", 4) if what == "frequency_hz" else (1e3, "mm", 3)
            cells = {
                row["rod"]: f"{scale * row['value']:.{digits}f} ({100 * (row['value'] - expected) / extent:+.2f} %)"
                for row in runs
            }
            said = f"{scene.upper()}, {name[4:]}, {what.replace('_hz', '')}, {unit}"
            table.append(cells | {"name": said, "expected": f"{scale * expected:.{digits}f}"})
    return table


TABLES: dict[str, Callable[[Data], Any]] = {
    "rod-runtime": run_times,
    "rod-roofline": rooflines,
    "rod-order-in-n": ERRORS_IN_N,
    "rod-clamp": lambda data: [row | {"cowper": 10 / (12 - row["poisson"])} for row in table_of(data, "clamp")],
    "rod-schemes": schemes,
    "rod-csm": csm,
}


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    """Draw the energy of CSM3 over time by scheme."""
    if run := runs("rod/study/csm3_energy"):
        groups = grouped(run.found["tables"]["csm3_energy"], "scheme", "n", "dt")
        lines = [
            {
                "x": [row["time"] for row in rows],
                "y": [row["energy"] for row in rows],
                "label": f"{scheme}, dt = 0.02 s",
            }
            for (scheme, n, dt), rows in groups.items()
            if (n, dt) == (32.0, 0.02)
        ]
        labels = ("time, s", "gain of energy / largest energy in gravity")
        show.curves("pictures/rod-energy", labels, lines, ylim=(-0.15, 0.5), loc="upper left")


STUDY = Study("rod", cases, extract, TABLES, draw)
