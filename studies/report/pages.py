"""docs/report: what is right and what is missed, error against run time, stability, where time and memory go."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D

from studies import coupling, driven_bar, fluid, fsi3, rod, show, simulate, speed, turek_hron
from studies.engine import Run, Study
from studies.report import cases, leave_out
from studies.show import COLOURS, label, markdown, percent
from studies.store import Data, Record

PEERS = ("PyElastica", "NGSolve, Taylor–Hood")

LISTED: dict[str, Any] = simulate.LISTED["report"]
QUANTITIES: dict[str, list[str]] = LISTED["quantities"]
FLOWS = {"cylinder-2d1": "2D-1", "cylinder-2d2": "2D-2"}
MASKS = {"none": "bare profile", "cosine": "cosine mask", "curvature": "wall target"}

OURS = ("wall target", "momentum load", "BDF2")  # Methods that goals are for
FIRST_SHOWN = ("600 x 120", "648 x 108")
"""Grids of the cylinder and of the driven bar on the first page."""
HALVED = (  # Exact solutions of the fluid: what is measured, on a step or grid and on half of it, along what
    ("Taylor-Green", "sbdf2, 80 steps", "sbdf2, 160 steps", "step"),
    ("Taylor-Green", "rk2, 80 steps", "rk2, 160 steps", "step"),
    ("flux", "64 cells", "128 cells", "cell"),
)

CITED: list[dict[str, Any]] = simulate.LISTED["solvers"]
SIMULATED = 8.0  # End of the FSI3 scenes, s

FSI3_METHODS: dict[str, str] = LISTED["fsi3"]
"""Changes of FSI3 that have a line of their own beside the shipped scenes."""

Point = dict[str, Any]
"""A run for error against run time: its record's view, `method`, `setting`, quartiles of `cpu` and `wall`, s, and
`QUANTITY.discretisation`, of the rod at rest the error against the exact beam."""


def kind_of(case: str) -> str:
    return "discretisation" if case == "rod-static" else "error"


def point(record: Record, **about: Any) -> Point:
    times = {name: record.times[f"{name}_s"] for name in ("cpu", "wall") if f"{name}_s" in record.times}
    quartiles = {name: spent if isinstance(spent, list) else [spent] * 3 for name, spent in times.items()}
    found = record.view | quartiles | about
    if record.name.startswith("report/rod-static"):
        beam = cases.exact("shear" in found["method"] or found["method"] in PEERS)
        found |= {f"{q}.discretisation": (found[q] - exact) / abs(exact) for q, exact in beam.items() if q in found}
    return found


def points(data: Data, case: str) -> list[Point]:
    """What is compared of a case, method by method."""
    found = []
    if case == "fsi3":
        for record in data.of("fsi3/grid/*"):
            found.append(point(record, method="momentum load", setting=record["name"]))
        changed = [(method, group) for method in FSI3_METHODS for group in fsi3.VARIED]
        for method, group in changed:
            found += [point(r, method=method, setting=group) for r in data.of(f"fsi3/{group}/{FSI3_METHODS[method]}")]
        expected = simulate.published(fsi3.COARSE)
        for row in CITED[:2]:
            errors = {f"{q}.error": (value - expected[q][0]) / expected[q][1] for q, value in row["values"].items()}
            found.append(row | errors | {"wall": [SIMULATED * row["wall"]] * 3, "failed": False})
        return found
    if case == "driven-bar":
        exact = driven_bar.LISTED["stream"]["moving mesh"]
        grids = [data.get(f"driven-bar/stream/{nx}x{ny}") for nx, ny in driven_bar.GRIDS]
        for run in filter(None, grids):
            off = {f"{q}.error": (run[q] - exact[q]) / abs(exact[q]) for q in QUANTITIES[case]}
            found.append(point(run, method="wall target", setting=run["name"], **off))
        return found
    if case in turek_hron.FLOWS:
        swings = {grid.replace("x", " x "): data.get(f"turek-hron/{case}/{grid}") for grid in turek_hron.GRIDS}
        return [point(run, method="momentum load", setting=grid) for grid, run in swings.items() if run]
    flow = FLOWS.get(case)
    found = [point(r) for r in data.of(f"report/{case}/*") if not flow or r["method"] in PEERS]
    for record in data.of("fluid/*", flow=flow) if flow else ():
        group, nx = record.name.split("/")[1], record["nx"]
        name = "thesis: sharp, uncorrected, Heun" if group == "thesis" else MASKS.get(record["mask"])
        if name and (group == "thesis" or (group == "grid" and record["scheme"] == "sbdf2")):
            found.append(point(record, method=name, setting=f"{nx} x {nx // 5}"))
    return found


# Error against run time


def machine(data: Data) -> list[str]:
    """What most of it was measured on."""
    used = Counter(record.machine for record in data.of("report/*"))
    about = data.machines[used.most_common(1)[0][0]]
    compiler = about["rustc"].split(" (")[0]
    return [f"{about['cpu']}, {about['cores']} cores, {about['system']}, {compiler}, Python {about['python']}."]


def errors(data: Data) -> list[Point]:
    """Errors by grid, mesh or step, or why there are none."""
    rows = []
    for case, quantities in QUANTITIES.items():
        for p in points(data, case):
            there = [(q, p.get(f"{q}.{kind_of(case)}")) for q in quantities]
            said = ", ".join(f"{label(q)} {percent(error)}" for q, error in there if error is not None)
            times = {f"median {name}": p[name][1] for name in ("cpu", "wall") if p.get(name)}
            rows.append(p | times | {"case": case, "errors": p["said"] if p["failed"] else said})
    return rows


def beaten(data: Data) -> list[Point]:
    """CPU time of ours and of the peers for a case's largest error: a single one may pass through zero."""
    rows = []
    for case, quantities in QUANTITIES.items():
        worst = []
        for p in points(data, case):
            there = [abs(p[name]) for q in quantities if (name := f"{q}.{kind_of(case)}") in p]
            if there and p.get("cpu") and "thesis" not in p["method"]:
                said = f"{p['method']} ({p['setting']}): {100 * max(there):.2g} % in {p['cpu'][1]:.2g} s"
                worst.append((max(there), p["cpu"][1], said, p["method"] in PEERS))
        if peers := [run for run in worst if run[3]]:
            theirs, ours = min(peers), [run for run in worst if not run[3]]
            # The cheapest of ours that is at least as exact, or else the most exact one.
            enough = [run for run in ours if run[0] <= theirs[0]]
            mine = min(enough, key=lambda run: run[1]) if enough else min(ours)
            verdict = f"{mine[1] / theirs[1]:.2g} of its CPU time" if enough else "**does not reach its error**"
            rows.append({"case": case, "theirs": theirs[2], "mine": mine[2], "verdict": verdict})
    return rows


def missed(data: Data) -> list[str]:
    """What was wanted and is not met, from the numbers."""
    rows = []
    for goal in LISTED["goals"]:
        if "case" in goal:
            there = (p for p in points(data, goal["case"]) if p["setting"] == goal["setting"])
            run = next((p for p in there if p["method"] in OURS), {})
            where, known = f"{goal['case']}, {goal['setting']}", [
                (label(name), run.get(f"{name}.error"), most) for name, most in goal["goals"].items()
            ]  # fmt: skip
            off = [(name, percent(x), f"{100 * most:g} %") for name, x, most in known if x and abs(x) > most]
        else:
            line = speed.of_grid(data, goal["bench"], goal["grid"])
            where = f"a step of the fluid, {goal['grid']}"
            off = [(name, f"{line[name]:.2f}", f"{most:g}") for name, most in goal.get("most", {}).items()
                   if line[name] > most]  # fmt: skip
            off += [(name, f"{line[name]:.2f}", f"at least {least:g}") for name, least in goal.get("least", {}).items()
                    if line[name] < least]  # fmt: skip
        rows += [[where, name, found, wanted, goal["reason"]] for name, found, wanted in off]
    return markdown(["", "of", "found", "wanted", "reason"], rows)


def verdicts(data: Data) -> list[str]:
    """Largest error over the quantities of each benchmark on one grid, by extremes and by the harmonic fit, what it
    costs, and what others have."""
    theirs = {row["case"]: row["theirs"] for row in beaten(data)} | turek_hron.LISTED["overall"]
    rows = []
    for name in turek_hron.QUANTITIES:
        grid = "rod" if name in turek_hron.SOLIDS else turek_hron.SHIPPED
        found, fit = (max(map(abs, turek_hron.errors(data, name, grid, fitted))) for fitted in (False, True))
        cpu = data[f"turek-hron/{name}/{grid}"]["cpu_s"]
        rows.append((name.upper(), grid.replace("x", " x "), found, fit, cpu, theirs.get(name, "")))
    for case in (*FLOWS, "driven-bar"):
        run = next(p for p in points(data, case) if p["setting"] in FIRST_SHOWN and p["method"] == "wall target")
        found = max(abs(run[f"{q}.error"]) for q in QUANTITIES[case])
        rows.append((case, run["setting"], found, found, run["cpu_s"], theirs.get(case, "")))
    told = [
        [
            name,
            grid,
            f"{100 * found:.1f} %",
            f"{100 * fit:.1f} %" if fit != found and grid != "rod" else "",
            f"{cpu:.2g}",
            other,
        ]
        for name, grid, found, fit, cpu, other in rows
    ]
    return markdown(["case", "grid", "largest error", "by the fit", "CPU, s", "others"], told)


def orders(data: Data) -> list[str]:
    """Observed orders of what is made to be of second order."""
    found = [
        (f"rod at rest, tip at {row['tip_angle']:.0f}°", "n, 32 to 128", row["order"])
        for row in rod.ERRORS_IN_N(data)
        if (row["calibration"], row["plane"]) == ("second order", "xz")
    ]
    found += [(f"{row['case']}, {row['scheme']}", "step", row["order"]) for row in rod.ERRORS_IN_DT(data)]
    measured = {(row["measure"], row["setting"]): row["value"] for row in fluid.measures(data, walls=False)}
    for measure, coarse, fine, along in HALVED:
        order = float(np.log2(measured[measure, coarse] / measured[measure, fine]))
        found.append((f"{measure}, {coarse} and twice as many", along, order))
    rows = [[what, along, f"{order:.2f}", "second" if abs(order - 2) < 0.25 else "**not second**"]
            for what, along, order in found]  # fmt: skip
    return markdown(["error of", "over", "observed order", "verdict"], rows)


# Stability

Cell = tuple[str, dict[str, float], str, str]
"""Label, place on the axes, outcome (`ok`, `error`, `bad`) and what was said."""


def map_cells(data: Data) -> dict[str, list[Cell]]:
    """Cells of the maps, as far as each is kept; the stiff rods are kept by the values tried and those that failed."""

    def told(place: dict[str, float], sign: str = " ") -> str:
        return ", ".join(f"{name}{sign}{value:g}" for name, value in place.items())

    def judged(result: str) -> str:
        """A gain of energy is what a rod must not have without saying so."""
        return "ok" if result == "ok" else "bad" if result.startswith("gain") else "error"

    found: dict[str, list[Cell]] = {name: [] for name in LISTED["maps"]}
    extreme = data["rod/study/extreme"].tables
    tried = {row["axis"]: row["values"] for row in extreme["tried"]}
    said = {tuple(row[key] for key in tried): row["result"] for row in extreme.get("failed", [])}
    for at in np.stack(np.meshgrid(*tried.values()), -1).reshape(-1, len(tried)).tolist():
        place, result = dict(zip(tried, at)), said.get(tuple(at), "ok")
        found["rod"].append((told(place, " = "), place, judged(result), result))
    for row in data["rod/study/situations"].tables["situations"]:
        result = row["result"]
        found["situations"].append((f"{row['scheme']}, {row['situation']}", {}, judged(result), result))
    for row in data["fluid-measures/crate/stability"].tables["stability"]:
        place = {"Re": row["reynolds"], "CFL": row["cfl"], "C_eta": row["c_eta"]}
        name = f"{row['scene'] or row['group']}, {told(place)}"
        found["fluid"].append((name, place, row["outcome"], row["message"] or ""))
    for record in data.of("coupling/*"):
        place = {"density ratio": record["ratio"], "C_eta": record["c_eta"]}
        name = f"{record['scheme']}, {told(place)}, H {record['step']:g}, to {record['end']:g} s"
        found["coupling"].append((name, place, coupling.outcome(record), record.error or ""))
    return found


def maps(data: Data) -> list[Point]:
    """Cells by outcome."""
    counts = {name: Counter(outcome for _, _, outcome, _ in cells) for name, cells in map_cells(data).items()}
    none = {"ok": 0, "error": 0, "bad": 0}
    return [
        none | count | {"map": name, "over": LISTED["maps"][name], "cells": count.total()}
        for name, count in counts.items()
    ]


def failed(data: Data) -> list[str]:
    """Cells that did not end well."""
    cells = [(name, *cell) for name, part in map_cells(data).items() for cell in part if cell[2] != "ok"]
    rows = [[name, cell, outcome, said[:110]] for name, cell, _, outcome, said in cells]
    return markdown(["map", "cell", "outcome", "reason"], rows)


AXES = {"dt": "step [s]", "k_e": "$k_e$ [N/m]", "EI": "EI [N m²]", "C_eta": "$C_\\eta$ [s]", "Re": "Reynolds number"}
OUTCOMES = {"ok": ("#56B4E9", "ok"), "error": ("#E69F00", "error (e): says so"), "bad": ("#000000", "bad (b)")}


def draw_maps(data: Data) -> None:
    """Cells coloured by their worst outcome; failed ones have a letter as well."""
    figure, axes = show.panel(2, 3, (12, 7.4))
    found, rank = map_cells(data), list(OUTCOMES)
    colours = ListedColormap([colour for colour, _ in OUTCOMES.values()])
    for axis, (name, begin, x, y, title) in zip(axes.flat, LISTED["drawn"]):
        cells = [(at[y], at[x], rank.index(outcome)) for cell, at, outcome, _ in found[name] if cell.startswith(begin)]
        lines, columns = (sorted({cell[i] for cell in cells}) for i in (0, 1))
        table = np.full((len(lines), len(columns)), np.nan)
        for line, column, worst in cells:
            i, j = lines.index(line), columns.index(column)
            table[i, j] = np.nanmax([table[i, j], worst])
        axis.grid(False)
        axis.imshow(table, cmap=colours, vmin=-0.5, vmax=2.5, aspect="auto", origin="lower")
        for (i, j), worst in np.ndenumerate(table):
            if worst > 0:
                axis.text(j, i, " eb"[int(worst)], ha="center", va="center", fontsize=8)
        axis.set_xticks(range(len(columns)), [f"{v:g}" for v in columns], fontsize=7, rotation=45)
        axis.set_yticks(range(len(lines)), [f"{v:g}" for v in lines], fontsize=7)
        axis.set_xlabel(AXES.get(x, x), fontsize=8)
        axis.set_ylabel(AXES.get(y, y), fontsize=8)
        axis.set_title(title, fontsize=9)
    handles = [Line2D([], [], marker="s", linewidth=0, color=colour, label=said) for colour, said in OUTCOMES.values()]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8)
    show.save(figure, "report/maps")


# Cost


def steps(data: Data, **about: Any) -> list[Point]:
    """A step of FSI3, the median CPU time, and its parts, the shortest wall times, µs; and the memory of a run, MB."""
    rows = []
    for record in data.of("report/cost/*", **about):
        seconds = record.times["phases_s"] | {"step": record["cpu_s"]}
        phases = {phase: 1e6 * spent / record["steps"] for phase, spent in seconds.items()}
        rows.append(record.case.about | phases | {"memory": record.get("memory")})
    return rows


def costs(data: Data) -> list[tuple[str, str, list[float], list[float]]]:
    """What is measured, over what, and the sizes and µs."""
    times = [row for row in data["rod/study/runtime"].times["rows"] if row["n"] >= 64]
    bench, grid, stations = speed.found(data, "step"), steps(data, method="grid"), steps(data, method="stations")
    bar = next(speed.jumps(row, "bar") for row in speed.found(data, "motion") if row["grid"] == "650 x 144")

    def column(rows: list[Point], name: str, scale: float = 1.0) -> list[float]:
        return [scale * row[name] for row in rows]

    points = "points of the grid"
    return [
        ("a step of the fluid", points, column(bench, "points"), column(bench, "step")),
        ("a Newton iteration of the rod in the plane", "segments n", column(times, "n"),
         column(times, "iteration_2d", 1e6)),
        ("a step of FSI3, all of it", points, column(grid, "size"), column(grid, "step")),
        ("a step of FSI3, the rod's part", "segments", column(stations, "size"), column(stations, "rod")),
        ("the bar in a step of the fluid, 650 x 144", "cells that its stations move in it",
         [jump for jump in bar if jump > 0], [bar[jump] for jump in bar if jump > 0]),
    ]  # fmt: skip


def exponents(data: Data) -> list[str]:
    rows = [[name, over, f"{show.exponent(x, y):.2f}"] for name, over, x, y in costs(data)]
    return markdown(["cost of", "over", "exponent"], rows)


def draw_cost(data: Data) -> None:
    figure, axes = show.panel(2, 3, (12, 7.2))
    axes[1, 2].set_visible(False)
    for axis, (name, over, x, y) in zip(axes.flat, costs(data)):
        slope, offset = np.polyfit(np.log(x), np.log(y), 1)
        axis.plot(x, y, "o", color=COLOURS[0])
        axis.plot(
            sorted(x), np.exp(offset) * np.sort(x) ** slope, "--", color=COLOURS[1], label=f"exponent {slope:.2f}"
        )
        axis.set(xscale="log", yscale="log", xlabel=over, ylabel="µs")
        if max(y) < 2 * min(y):
            axis.set_ylim(min(y) / 3, max(y) * 3)  # what does not depend on x shall look like it
        axis.set_title(name, fontsize=9)
        show.few_labels(axis.xaxis)
        axis.legend(fontsize=8)
    show.save(figure, "report/cost")


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    for case, kind in (("rod-static", "discretisation"), *((case, "error") for case in QUANTITIES)):
        groups = show.grouped(points(data, case), "method")
        times = {"wall": "wall time [s]", "cpu": "CPU time [s]"}
        if len(groups) == 1:
            del times["wall"]  # Nobody else's is beside it
        show.errors(f"report/{case.replace('-', '_')}_{kind}", groups, QUANTITIES[case], times, kind)
    draw_maps(data)
    draw_cost(data)


TABLES: dict[str, Callable[[Data], Any]] = {
    "report-missed": missed, "report-peers": beaten, "report-machine": machine, "report-errors": errors,
    "report-bands": lambda data: [fsi3.LEVEL_4, *fsi3.costs(data)], "report-maps": maps, "report-failed": failed,
    "report-cited": lambda data: [row | row["values"] for row in CITED], "report-lacking": leave_out.lacking,
    "report-left-out": leave_out.added, "report-exponents": exponents, "report-steps": steps,
    "report-verdicts": verdicts, "report-orders": orders,
}  # fmt: skip
STUDY = Study("report", cases.cases, cases.keep, TABLES, draw)
