"""The rod alone: the tables and figures of the thesis' chapter 2 and what lies beyond them, by crates/rod/study."""

from collections import Counter
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from studies import commands, show, simulate
from studies.engine import ROD, Case, Run, Study
from studies.show import COLOURS, exponent, grouped
from studies.store import Data
from tests import plate

MANIFEST, TARGET = "crates/rod/study/Cargo.toml", "target/rod-study"

Rows = list[dict[str, Any]]

FILES = ("condition", "runtime", "deflection", "order_in_n", "order_in_dt", "bending_models", "csm", "csm3_energy",
          "extreme", "situations")  # fmt: skip
"""What the program can be asked for; each is a file of that name."""

THESIS_CONDITION = {(row["k_e"], row["dt"]): row["numbers"] for row in simulate.LISTED["thesis"]["condition"]}
"""Tables 2.1 and 2.2 of the thesis by (k_e, dt)."""

STEPS = 10_000
"""Time steps of the runs of the thesis' table 2.3, about."""
SOLVERS = ("banded", "sparse", "dense")
SCHEMES = {
    "trapezoid, unwatched": 1,
    "trapezoid": 1,
    "generalised-alpha 0.5": 1,
    "generalised-alpha 0.8": 1,
    "BDF2": 1,
    "TR-BDF2": 2,
}
"""Solves a step."""
EXTREME = ("n", "k_e", "EI", "dt")
"""What the stiff cases vary."""


def cases() -> Iterator[Case]:
    for name in FILES:
        command = commands.cargo(MANIFEST, TARGET, "{folder}", name)
        yield Case(f"study/{name}", (*ROD, "rod study"), options={"command": command}, action=commands.tables)
    yield Case("study/clamp", ("plate",), action=plate.run)


def keep(case: Case, run: Run) -> dict[str, Any]:
    """The table, with what depends on the machine apart from it; of the long ones what is shown."""
    name = case.name.split("/")[1]
    rows = run.found["tables"][name]
    if name == "runtime":
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


# Pages


def table_of(data: Data, name: str) -> Rows:
    return data[f"rod/study/{name}"].tables[name]


def condition_rows(data: Data) -> Rows:
    """Condition numbers here and as printed."""
    groups = grouped(table_of(data, "condition"), "k_e", "dt")
    return [
        row | {"printed": printed, "ratio": row["full"] / printed}
        for key, group in groups.items() for row, printed in zip(group, THESIS_CONDITION[key])
    ]  # fmt: skip


def run_times(data: Data) -> Rows:
    """What an iteration costs, and seconds of `STEPS` steps in space with the factorise-and-solve of each solver."""
    rows = []
    for row in data["rod/study/runtime"].times["rows"]:
        times = STEPS * row["iterations_per_step"]
        runs = {
            f"run {name}": times * (row["iteration_3d"] - row["banded"] + row[name]) for name in SOLVERS if row[name]
        }
        runs |= {f"run thesis {name}": row[f"thesis_{name}"] for name in ("sparse", "dense")}
        micro = {name: 1e6 * row[name] for name in ("iteration_3d", "iteration_2d", *SOLVERS) if row[name]}
        ratios = {"3D/2D": row["iteration_3d"] / row["iteration_2d"], "sparse/banded": row["sparse"] / row["banded"]}
        rows.append({"n": row["n"]} | runs | micro | ratios)
    return rows


def fit(rows: Rows, name: str) -> tuple[list[float], list[float], float, int]:
    """n, the column `name`, its exponent and from which n on it was fitted."""
    there = {row["n"]: row[name] for row in rows if row.get(name)}
    first = 128 if "thesis" in name else 64
    late = [n for n in there if n >= first]
    return list(there), list(there.values()), exponent(late, [there[n] for n in late]), first


def orders(data: Data, name: str, along: str, sign: int, part: slice) -> Rows:
    """Rows of a convergence study by sequence: errors by `along`, and the observed order over a part of them."""
    found = []
    for group in grouped(table_of(data, name), *SEQUENCES[name]).values():
        x, y = ([row[key] for row in group[part]] for key in (along, "error"))
        errors = {f"{row[along]:.3g}": row["error"] for row in group}
        found.append(
            group[-1] | errors | {"order": sign * exponent(x, y), "x": [row[along] for row in group], "group": group}
        )
    return found


SEQUENCES = {"order_in_n": ("calibration", "plane", "gravity"), "order_in_dt": ("case", "scheme")}
ERRORS_IN_N = partial(orders, name="order_in_n", along="n", sign=-1, part=slice(2, 5))
ERRORS_IN_DT = partial(orders, name="order_in_dt", along="dt", sign=1, part=slice(2, 7))


def energies(data: Data) -> Rows:
    """The end of each run of CSM3 by scheme; cells by n and dt."""
    found = []
    for (scheme,), group in grouped(table_of(data, "csm3_energy"), "scheme").items():
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


def csm(data: Data) -> list[str]:
    """Against Turek & Hron."""
    rows, table = {(row["scene"], row["quantity"], row["rod"]): row["value"] for row in table_of(data, "csm")}, []
    for scene, quantity, rod in rows:
        expected, extent = simulate.published(scene).get(quantity, (0.0, 0.0))
        if rod == "as shipped" and extent:
            name, _, what = quantity.partition(".")
            scale, unit, digits = (1, "Hz", 4) if what == "frequency_hz" else (1e3, "mm", 3)
            runs = [rows[scene, quantity, rod] for rod in ("as shipped", "without shear and set-back")]
            cells = [f"{scale * value:.{digits}f} ({100 * (value - expected) / extent:+.2f} %)" for value in runs]
            label = f"{scene.upper()}, {name[4:]}, {what.replace('_hz', '')}, {unit}"
            table.append([label, f"{scale * expected:.{digits}f}", *cells])
    return show.markdown(["", "Turek & Hron", "as shipped", "without shear and set-back"], table)


TABLES: dict[str, Callable[[Data], Any]] = {
    "rod-condition": condition_rows,
    "rod-runtime": run_times,
    "rod-order-in-n": ERRORS_IN_N,
    "rod-order-in-dt": ERRORS_IN_DT,
    "rod-bending": partial(table_of, name="bending_models"),
    "rod-energy": energies,
    "rod-extreme": stiff,
    "rod-situations": partial(table_of, name="situations"),
    "rod-clamp": lambda data: [row | {"cowper": 10 / (12 - row["poisson"])} for row in table_of(data, "clamp")],
    "rod-schemes": schemes,
    "rod-csm": csm,
}


# Figures


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    conditions, times = condition_rows(data), run_times(data)
    lines: Rows = []
    # One on top of the other: the larger ones below.
    for ((k_e, dt), group), marker, size, colour in zip(
        grouped(conditions, "k_e", "dt").items(), "osv^", (13, 9.5, 6.5, 5), COLOURS
    ):
        n, full, printed = ([row[key] for row in group] for key in ("n", "full", "printed"))
        label = f"k_e = {k_e:g} N/m, dt = {dt:g} s: n^{exponent(n, full):.2f}"
        lines.append(
            {"x": n, "y": full, "marker": marker, "linewidth": 0, "markersize": size, "label": label, "color": colour}
        )
        lines.append(
            {"x": n, "y": printed, "linestyle": "--", "color": colour, "label": "thesis" if not lines[2:] else None}
        )
        if k_e == 1e5:
            eliminated = [row["eliminated"] for row in group]
            lines.append(
                {
                    "x": n,
                    "y": eliminated,
                    "linestyle": ":",
                    "color": colour,
                    "label": f"velocities eliminated, dt = {dt:g} s",
                }
            )
    labels = ("mass points n", "condition number, 1-norm")
    show.curves("rod/condition", labels, lines, ticks=n, loc="lower right")

    lines = []
    for name, marker in zip((name for name in times[0] if name.startswith("run")), "osv^D"):
        n, seconds, slope, first = fit(times, name)
        lines.append({"x": n, "y": seconds, "marker": marker, "label": f"{name[4:]}: n^{slope:.2f} from {first} on"})
    show.curves("rod/runtime", ("segments n", f"seconds for {STEPS} steps"), lines, ticks=[row["n"] for row in times])

    lines = []
    for row in ERRORS_IN_N(data):
        if row["plane"] == "diagonal" and row["gravity"] != 2.0 and "inextensible" not in row["calibration"]:
            style = {"second order": "-", "thesis k_e=1e3": "--", "thesis k_e=1e6": ":"}[row["calibration"]]
            label = f"{row['calibration']}, tip at {row['tip_angle']:.0f}°: n^{-row['order']:.2f}"
            errors = [one["error"] for one in row["group"]]
            lines.append({"x": row["x"], "y": errors, "linestyle": style, "marker": "o", "label": label})
    show.curves(
        "rod/order_in_n",
        ("segments n", "error of the tip / deflection"),
        lines,
        ticks=row["x"],
        limits={"ylim": (3e-8, None)},
    )

    by_dt, by_time, seconds = [], [], iter(data["rod/study/order_in_dt"].times["seconds"])
    for row, marker in zip(ERRORS_IN_DT(data), "osv^D" * 2):
        line = {"y": [one["error"] for one in row["group"]], "marker": marker}
        spent = [next(seconds) for _ in row["group"]]
        if "pushed" in row["case"]:
            by_dt.append(line | {"x": row["x"], "label": f"{row['scheme']}: dt^{row['order']:.2f}"})
            by_time.append(line | {"x": spent, "label": row["scheme"]})
    show.curves("rod/order_in_dt_pushed", ("dt, s", "error of the tip, relative"), by_dt)
    show.curves("rod/work_precision_pushed", ("run time, s", "error of the tip, relative"), by_time)

    if run := runs("rod/study/deflection"):
        lines = []
        for (model, n), group in grouped(run.found["tables"]["deflection"], "model", "n").items():
            shape: dict[str, Any] = {"x": [row["x"] for row in group], "y": [row["y"] for row in group]}
            if model == "elastica":
                lines.append(shape | {"linewidth": 5, "alpha": 0.25, "color": "k", "label": "exact elastica"})
            elif model in ("second order", "thesis k_e=1e3"):
                look = {"linestyle": {8.0: ":", 32.0: "--", 128.0: "-"}[n], "color": COLOURS["thesis" in model]}
                lines.append(shape | look | {"label": f"{model}, n = {n:.0f}"})
        show.curves("rod/deflection", ("x/L", "y/L"), lines, log=False, loc="lower left")
    if run := runs("rod/study/csm3_energy"):
        lines = []
        for (scheme, n, dt), group in grouped(run.found["tables"]["csm3_energy"], "scheme", "n", "dt").items():
            if (n, dt) == (32.0, 0.02):
                time, energy = ([row[key] for row in group] for key in ("time", "energy"))
                lines.append({"x": time, "y": energy, "label": f"{scheme}, dt = 0.02 s"})
        labels = ("time, s", "gain of energy / largest energy in gravity")
        show.curves("rod/csm3_energy", labels, lines, log=False, limits={"ylim": (-0.15, 0.5)}, loc="upper left")


STUDY = Study("rod", cases, keep, TABLES, draw)
