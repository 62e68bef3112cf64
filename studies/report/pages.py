"""docs/report: what is right and what is missed, error against run time, stability, where time and memory go."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from studies import fluid, fsi3, rod, show, simulate, speed, turek_hron
from studies.engine import Run, Study
from studies.report import cases, leave_out, maps
from studies.report.points import CITED, FLOWS, PEERS, QUANTITIES, Point, kind_of, points
from studies.show import COLOURS, label, markdown, percent
from studies.store import Data

FIRST_SHOWN = ("600 x 120", "648 x 108")
"""Grids of the cylinder and of the driven bar on the first page."""
HALVED = (  # Exact solutions of the fluid: what is measured, on a step or grid and on half of it, along what
    ("Taylor-Green", "sbdf2, 80 steps", "sbdf2, 160 steps", "step"),
    ("Taylor-Green", "rk2, 80 steps", "rk2, 160 steps", "step"),
    ("flux", "64 cells", "128 cells", "cell"),
)


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
    """CPU time of ours and of the peers for a case's largest error: a single one may pass through zero. The most exact
    run of a peer comes last."""
    rows = []
    for case, quantities in QUANTITIES.items():
        worst = []
        for p in points(data, case):
            there = [abs(p[name]) for q in quantities if (name := f"{q}.{kind_of(case)}") in p]
            if there and p.get("cpu") and "thesis" not in p["method"]:
                cpu = float(f"{p['cpu'][1]:.2g}")
                said = f"{p['method']} ({p['setting']}): {100 * max(there):.2g} % in {cpu:g} s"
                worst.append((max(there), p["cpu"][1], said, p["method"] in PEERS))
        ours = [run for run in worst if not run[3]]
        for theirs in sorted((run for run in worst if run[3]), reverse=True):
            # The cheapest of ours that is at least as exact, or else the most exact one.
            enough = [run for run in ours if run[0] <= theirs[0]]
            mine = min(enough, key=lambda run: run[1]) if enough else min(ours)
            verdict = f"{mine[1] / theirs[1]:.2g} of its CPU time" if enough else "**does not reach its error**"
            rows.append({"case": case, "theirs": theirs[2], "mine": mine[2], "verdict": verdict})
    return rows


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
            f"{float(f'{cpu:.2g}'):g}",
            other,
        ]
        for name, grid, found, fit, cpu, other in rows
    ]
    return markdown(["case", "grid", "largest error", "by the fit", "CPU, s", "others"], told)


def cited(data: Data) -> list[Point]:
    """Swinging benchmarks by ours and as cited of others."""
    rows = []
    for name, grid in (("fsi2", "648x108"), ("fsi3", "648x108"), ("fsi3", "1296x216")):
        record = data[f"turek-hron/{name}/{grid}"]
        about = {"case": name.upper(), "method": "ours", "setting": grid.replace("x", " x "), "on": "1"}
        end = simulate.changed(turek_hron.scene_of(name), {})["time"]["end"]
        rows.append(record.view | about | {"wall": float(f"{record['wall_s'] / end:.2g}")})
    return rows + [row | row["values"] for row in CITED]


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
    grids = {p["setting"]: p for p in points(data, "cylinder-2d2") if p["method"] == "wall target"}
    if "1600 x 320" in grids:
        for quantity in QUANTITIES["cylinder-2d2"]:
            off, left = (grids[setting][f"{quantity}.error"] for setting in ("800 x 160", "1600 x 320"))
            found.append(
                (f"2D-2, {label(quantity)}, 800 x 160 and 1600 x 320", "cell", float(np.log2(abs(off / left))))
            )
    rows = [[what, along, f"{order:.2f}", "second" if abs(order - 2) < 0.25 else "**not second**"]
            for what, along, order in found]  # fmt: skip
    return markdown(["error of", "over", "observed order", "verdict"], rows)


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
    show.save(figure, "pictures/cost")


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    for case in ("cylinder-2d2", "fsi3"):
        groups = show.grouped(points(data, case), "method")
        times = {"wall": "wall time [s]", "cpu": "CPU time [s]"}
        show.errors(f"pictures/{case}-error", groups, QUANTITIES[case], times)
    maps.draw(data)
    draw_cost(data)


TABLES: dict[str, Callable[[Data], Any]] = {
    "report-peers": beaten, "report-machine": machine, "report-errors": errors,
    "report-bands": lambda data: [fsi3.LEVEL_4, *fsi3.costs(data)],
    "report-maps": maps.counts, "report-failed": maps.failed,
    "report-cited": cited, "report-lacking": leave_out.lacking,
    "report-left-out": leave_out.added, "report-exponents": exponents, "report-steps": steps,
    "report-verdicts": verdicts, "report-orders": orders,
}  # fmt: skip
STUDY = Study("report", cases.cases, cases.extract, TABLES, draw)
