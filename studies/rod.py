"""The rod alone: the tables and figures of the thesis' chapter 2 and what lies beyond them, by studies/rust/rod."""

from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from studies import commands, plate, roofline, show, simulate
from studies.engine import ROD, Case, Run, Study
from studies.show import COLOURS, exponent, grouped
from studies.store import Data

Rows = list[dict[str, Any]]

FILES = ("condition", "runtime", "deflection", "order_in_n", "order_in_dt", "bending_models", "taper", "csm",
          "csm3_energy", "extreme", "situations")  # fmt: skip
"""What the program can be asked for; each is a file of that name."""

THESIS_CONDITION = [number for row in simulate.LISTED["thesis"]["condition"] for number in row["numbers"]]
"""Tables 2.1 and 2.2 of the thesis, in the order of the study's rows."""

STEPS = 10_000  # Time steps of the runs of the thesis' table 2.3, about
SOLVERS = ("banded", "sparse", "dense")
SCHEMES = {"trapezoid, unwatched": 1, "trapezoid": 1, "generalised-alpha 0.5": 1, "generalised-alpha 0.8": 1,
           "BDF2": 1, "TR-BDF2": 2}  # fmt: skip
"""Solves a step."""
EXTREME = ("n", "k_e", "EI", "dt")  # What the stiff cases vary


def cases() -> Iterator[Case]:
    for name in FILES:
        command = commands.cargo("rod-study", "{folder}", name)
        yield Case(f"study/{name}", (*ROD, "rod study"), options={"command": command}, action=commands.tables)
    command = commands.cargo("rod-study", "{folder}/roofline.csv", example="roofline")
    yield Case("study/roofline", ("scene", "rod", "rod roofline"), options={"command": command}, action=commands.tables)
    yield Case("study/clamp", ("plate",), action=plate.run)


def extract(case: Case, run: Run) -> dict[str, Any]:
    """The table, with what depends on the machine apart from it; of the long ones what is shown."""
    name = case.name.split("/")[1]
    rows = run.found["tables"][name]
    if name in ("runtime", "roofline"):
        return {"times": {"rows": rows}}
    if name == "deflection":  # only drawn
        return {"values": {"points": len(rows)}}
    if name == "extreme":
        return extremes(rows)
    if name == "csm3_energy":
        rows = [group[-1] for group in grouped(rows, "scheme", "n", "dt").values()]
    seconds = [row.pop("seconds", None) for row in rows]
    for row in rows:
        row.pop("worst_step_seconds", None)
    return {"tables": {name: rows}, "times": {"seconds": seconds} if any(seconds) else {}}


def extremes(rows: Rows) -> dict[str, Any]:
    """What came of the stiff cases by n and dt, those that did not end well, and the values that were tried."""
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


def conditions(data: Data) -> Rows:
    """Condition numbers here and as printed."""
    rows = zip(table_of(data, "condition"), THESIS_CONDITION)
    return [row | {"printed": printed, "ratio": row["full"] / printed} for row, printed in rows]


def run_times(data: Data) -> Rows:
    """What an iteration costs, and seconds of `STEPS` steps in space with the factorise-and-solve of each solver."""
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
    """The parts of a Newton iteration in space and their sum, beside both roofs and the longest chain of divisions."""
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
    """Rows of a convergence study by sequence: errors by `along`, and the observed order over a part of them."""
    found = []
    for group in grouped(table_of(data, name), *keys).values():
        x, y = ([row[key] for row in group[part]] for key in (along, "error"))
        errors = {f"{row[along]:.3g}": row["error"] for row in group}
        found.append(group[-1] | errors | {"order": sign * exponent(x, y), "group": group})
    return found


ERRORS_IN_N = partial(
    orders, name="order_in_n", keys=("calibration", "plane", "gravity"), along="n", sign=-1, part=slice(2, 5)
)
ERRORS_IN_DT = partial(orders, name="order_in_dt", keys=("case", "scheme"), along="dt", sign=1, part=slice(2, 7))


def energies(data: Data) -> Rows:
    """The end of each run of CSM3 by scheme; cells by n and dt."""
    found = []
    for scheme, group in grouped(table_of(data, "csm3_energy"), "scheme").items():
        cells = {}
        for row in group:
            ended = "" if row["time"] > 59 else f" (ended at {row['time']:.0f} s)"
            halved = f" ({row['halvings']:.0f} halvings)" if row["halvings"] else ""
            cells[f"n = {row['n']:.0f}, dt = {row['dt']:g} s"] = f"{row['energy']:+.1e}{ended}{halved}"
        found.append({"scheme": scheme} | cells)
    return found


def stiff(data: Data) -> Rows:
    """Stiff cases by n and dt."""
    longest = data["rod/study/extreme"].times["longest step"]
    return [row | {"longest": seconds} for row, seconds in zip(table_of(data, "extreme"), longest)]


def schemes(data: Data) -> Rows:
    """What the schemes do to the energy."""
    rows = {row["scheme"]: row for row in energies(data)}
    for scheme, row in rows.items():
        cells = [cell for cell in table_of(data, "situations") if cell["scheme"] == scheme]
        bad = [cell for cell in cells if cell["result"] != "ok"]
        others = [f"{cell['situation'].split(':')[0]}: {cell['result'].split(' in step')[0]}" for cell in bad]
        row |= {"solves": SCHEMES[scheme], "others": "; ".join(others)}
        row["good"] = f"{len(cells) - len(bad)} of {len(cells)}" if cells else ""
    return [rows[scheme] for scheme in SCHEMES]


def csm(data: Data) -> Rows:
    """Against Turek & Hron."""
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


def tapers(data: Data) -> Rows:
    """The tapered cantilever by n: errors with their observed order from 32 to 128 in a last row, and conditions."""
    rows = table_of(data, "taper")
    part = [row for row in rows if 32 <= row["n"] <= 128]
    errors = ("deflection", "first", "second", "third")
    orders = {key: -exponent([row["n"] for row in part], [abs(row[key]) for row in part]) for key in errors}
    return [
        *({"name": f"{row['n']:.0f}"} | {key: f"{row[key]:+.2e}" for key in errors}
          | {key: f"{row[key]:.2e}" for key in ("tapered", "even")} for row in rows),
        {"name": "order, 32 … 128", "tapered": "", "even": ""} | {key: f"{orders[key]:.2f}" for key in errors},
    ]  # fmt: skip


TABLES: dict[str, Callable[[Data], Any]] = {
    "rod-condition": conditions,
    "rod-runtime": run_times,
    "rod-roofline": rooflines,
    "rod-order-in-n": ERRORS_IN_N,
    "rod-order-in-dt": ERRORS_IN_DT,
    "rod-taper": tapers,
    "rod-energy": energies,
    "rod-extreme": stiff,
    "rod-clamp": lambda data: [row | {"cowper": 10 / (12 - row["poisson"])} for row in table_of(data, "clamp")],
    "rod-schemes": schemes,
    "rod-csm": csm,
}


def line(rows: Rows, x: str, y: str, label: str | None, **style: Any) -> dict[str, Any]:
    """A line of `show.curves` through what the rows have."""
    there = [row for row in rows if row.get(y) is not None]
    return {"x": [row[x] for row in there], "y": [row[y] for row in there], "label": label} | style


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    lines: Rows = []
    # One on top of the other: the larger ones below.
    for ((k_e, dt), rows), marker, size, colour in zip(
        grouped(conditions(data), "k_e", "dt").items(), "osv^", (13, 9.5, 6.5, 5), COLOURS
    ):
        n, full = ([row[key] for row in rows] for key in ("n", "full"))
        label = f"k_e = {k_e:g} N/m, dt = {dt:g} s: n^{exponent(n, full):.2f}"
        lines.append(line(rows, "n", "full", label, marker=marker, linewidth=0, markersize=size, color=colour))
        lines.append(line(rows, "n", "printed", None if lines[2:] else "thesis", linestyle="--", color=colour))
        if k_e == 1e5:
            label = f"velocities eliminated, dt = {dt:g} s"
            lines.append(line(rows, "n", "eliminated", label, linestyle=":", color=colour))
    labels = ("mass points n", "condition number, 1-norm")
    show.curves("rod/condition", labels, lines, ticks=n, loc="lower right")

    times, lines = run_times(data), []
    for name, marker in zip((name for name in times[0] if name.startswith("run")), "osv^D"):
        first = 128 if "thesis" in name else 64
        late = [row for row in times if row["n"] >= first and row.get(name)]
        slope = exponent([row["n"] for row in late], [row[name] for row in late])
        lines.append(line(times, "n", name, f"{name[4:]}: n^{slope:.2f} from {first} on", marker=marker))
    show.curves("rod/runtime", ("segments n", f"seconds for {STEPS} steps"), lines, ticks=[row["n"] for row in times])

    styles, lines = {"second order": "-", "thesis k_e=1e3": "--", "thesis k_e=1e6": ":"}, []
    for row in ERRORS_IN_N(data):
        if row["plane"] == "diagonal" and row["gravity"] != 2.0 and row["calibration"] in styles:
            label = f"{row['calibration']}, tip at {row['tip_angle']:.0f}°: n^{-row['order']:.2f}"
            lines.append(line(row["group"], "n", "error", label, linestyle=styles[row["calibration"]], marker="o"))
    labels = ("segments n", "error of the tip / deflection")
    show.curves("rod/order_in_n", labels, lines, ticks=lines[0]["x"], limits={"ylim": (3e-8, None)})

    by_dt, by_time, seconds = [], [], iter(data["rod/study/order_in_dt"].times["seconds"])
    for row, marker in zip(ERRORS_IN_DT(data), "osv^D" * 2):
        timed = [one | {"seconds": next(seconds)} for one in row["group"]]
        if "pushed" in row["case"]:
            by_dt.append(line(timed, "dt", "error", f"{row['scheme']}: dt^{row['order']:.2f}", marker=marker))
            by_time.append(line(timed, "seconds", "error", row["scheme"], marker=marker))
    show.curves("rod/order_in_dt_pushed", ("dt, s", "error of the tip, relative"), by_dt)
    show.curves("rod/work_precision_pushed", ("run time, s", "error of the tip, relative"), by_time)

    if run := runs("rod/study/deflection"):
        lines = []
        for (model, n), rows in grouped(run.found["tables"]["deflection"], "model", "n").items():
            if model == "elastica":
                lines.append(line(rows, "x", "y", "exact elastica", linewidth=5, alpha=0.25, color="k"))
            elif model in ("second order", "thesis k_e=1e3"):
                style = {"linestyle": {8.0: ":", 32.0: "--", 128.0: "-"}[n], "color": COLOURS["thesis" in model]}
                lines.append(line(rows, "x", "y", f"{model}, n = {n:.0f}", **style))
        show.curves("rod/deflection", ("x/L", "y/L"), lines, log=False, loc="lower left")
    if run := runs("rod/study/csm3_energy"):
        groups = grouped(run.found["tables"]["csm3_energy"], "scheme", "n", "dt")
        lines = [
            line(rows, "time", "energy", f"{scheme}, dt = 0.02 s")
            for (scheme, n, dt), rows in groups.items()
            if (n, dt) == (32.0, 0.02)
        ]
        labels = ("time, s", "gain of energy / largest energy in gravity")
        show.curves("pictures/rod-energy", labels, lines, log=False, limits={"ylim": (-0.15, 0.5)}, loc="upper left")


STUDY = Study("rod", cases, extract, TABLES, draw)
