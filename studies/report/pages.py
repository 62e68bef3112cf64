"""docs/report: error against run time, stability, what a scene leaves out, where the time goes, what is missed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D

from studies import coupling, fsi3, rod, show, simulate, speed
from studies.engine import Run, Study
from studies.report import cases, leave_out
from studies.report.convergence import MOST_ORDER, front, limit
from studies.show import COLOURS, MARKERS, label, markdown, percent
from studies.store import Data, Record

PEERS = ("PyElastica", "NGSolve, Taylor–Hood")

QUANTITIES = {
    "rod-static": ("tip_ux.mean", "tip_uy.mean"),
    "csm3": ("tip_uy.mean", "tip_uy.amplitude", "tip_uy.frequency_hz"),
    "cylinder-2d1": ("cd_mean", "cl_mean", "dp_mean"),
    "cylinder-2d2": ("cd_max", "cl_peak_to_peak", "st"),
    "fsi3": ("tip_uy.amplitude", "tip_uy.frequency_hz", "drag.mean", "lift.amplitude"),
}
MAIN = {
    "rod-static": "tip_uy.mean",
    "csm3": "tip_uy.frequency_hz",
    "cylinder-2d1": "cd_mean",
    "cylinder-2d2": "cl_peak_to_peak",
}
"""The quantity by which methods are compared in one line."""

CITED = [(row["method"], row["setting"], row["wall"], row["values"]) for row in simulate.LISTED["solvers"]]
SIMULATED = 8.0
"""End of the FSI3 scenes, s."""

FSI3_METHODS: dict[str, dict[str, Any]] = {
    "bare profile": fsi3.BARE, "cosine mask": fsi3.COSINE, "two-thirds filter": fsi3.TWO_THIRDS,
    "pressure jump, iterated": fsi3.PRESSURE_JUMP,
}  # fmt: skip
"""Changes of FSI3 that have a line of their own beside the shipped scenes."""

PHASES = ("rod", "fluid", "fmi", "python", "recording", "output")


@dataclass(frozen=True)
class Point:
    """A run of a method on a case, for error against run time."""

    method: str
    setting: str
    values: dict[str, float]
    errors: dict[str, float]
    """Against the published value; of the rod at rest as `discretisation`, against the exact beam."""
    discretisation: dict[str, float]
    cpu: list[float]
    wall: list[float]
    size: float = 0.0
    step: float | None = None
    runs: int = 1
    failed: str = ""

    def of(self, kind: str) -> dict[str, float]:
        return self.discretisation if kind == "discretisation" else self.errors


def point(record: Record, method: str, setting: str, kind: str, size: float = 0.0, step: float | None = None) -> Point:
    errors = {q: off for q in QUANTITIES[kind] if (off := record.off(q)) is not None}
    exact = {}
    if kind == "rod-static":
        beam = cases.exact("shear" in method or method in PEERS)
        exact = {q: (record[q] - beam[q]) / abs(beam[q]) for q in beam if q in record.values}
    clocks = (record.times.get(name, []) for name in ("cpu_s", "wall_s"))
    cpu, wall = (clock if isinstance(clock, list) else [clock] * 3 for clock in clocks)
    runs, failed = record.times.get("runs", 1), record.error or ""
    return Point(method, setting, record.values, errors, exact, cpu, wall, size, step, runs, failed)


def points(data: Data, kind: str) -> list[Point]:
    """What is compared of a case, method by method."""
    found = []
    if kind == "fsi3":
        for grid in fsi3.GRIDS:
            if record := data.get(f"fsi3/grid/{grid}"):
                found.append(point(record, "momentum load", grid.replace("x", " x "), kind, int(grid.split("x")[0])))
        for method, change in FSI3_METHODS.items():
            for group in fsi3.VARIED:
                if record := data.get(f"fsi3/{group}/{fsi3.label_of(change)}"):
                    found.append(point(record, method, group, kind))
        expected = simulate.published(fsi3.COARSE)
        for method, setting, wall, values in CITED[:2]:
            errors = {q: (value - expected[q][0]) / expected[q][1] for q, value in values.items()}
            found.append(Point(method, setting, values, errors, {}, [], [SIMULATED * wall] * 3))
        return found
    for record in data.of(f"report/{kind}/*"):
        a = record.about
        if not kind.startswith("cylinder") or a["method"] in PEERS:
            found.append(point(record, a["method"], a["setting"], kind, a["size"] or record.get("dofs", 0), a["step"]))
    if kind.startswith("cylinder"):
        flow = {"cylinder-2d1": "2D-1", "cylinder-2d2": "2D-2"}[kind]
        methods = {"none": "bare profile", "cosine": "cosine mask", "curvature": "wall target"}
        for record in data.of("fluid/*", flow=flow):
            group, a = record.name.split("/")[1], record.about
            name = "thesis: sharp, uncorrected, Heun" if group == "thesis" else methods.get(a["mask"])
            if name and (group == "thesis" or (group == "grid" and a["scheme"] == "sbdf2")):
                found.append(point(record, name, f"{a['nx']} x {a['nx'] // 5}", kind, a["nx"], a["dt"]))
    return found


def by_method(found: Iterable[Point]) -> dict[str, list[Point]]:
    groups: dict[str, list[Point]] = {}
    for one in found:
        groups.setdefault(one.method, []).append(one)
    return groups


# Sections


def sequences(data: Data) -> list[list[str]]:
    """Observed order and extrapolation of every sequence of sizes or steps."""
    found: list[list[str]] = []

    def add(name: str, kind: str, part: Iterable[Point], key: Callable[[Point], float]) -> None:
        chosen = sorted((p for p in part if not p.failed), key=key)
        for quantity in QUANTITIES[kind]:
            line = {key(p): p for p in chosen if quantity in p.values}
            if len(line) < 3:
                continue
            values = [p.values[quantity] for p in line.values()]
            got = limit(list(line), values, 8.0 if "NGSolve" in name else MOST_ORDER)
            unit = simulate.unit_of(quantity)
            factor, unit = (1e3, " mm") if unit == "m" else (1.0, f" {unit}" if unit else "")
            expected = simulate.published(cases.SCENES[kind]).get(quantity, (0.0, 0.0))[0]
            told = ["", "", ""]
            if got.value is not None:
                model = percent((got.value - expected) / abs(expected)) if expected else ""
                told = [f"{got.value * factor:.5g}{unit}", percent((values[-1] - got.value) / abs(got.value)), model]
            shown = ", ".join(f"{value * factor:.5g}" for value in values)
            found.append([name, label(quantity), shown, show.number(got.order, ".2f"), *told, got.verdict])

    def size(p: Point) -> float:
        return p.size

    for method, part in by_method(points(data, "rod-static")).items():
        if "thesis" not in method:
            add(f"rod at rest, {method}, n", "rod-static", part, size)
    for method, part in by_method(points(data, "csm3")).items():
        if method in cases.SCHEMES:
            add(f"CSM3, 1/H, {method} (n = 32)", "csm3", part, lambda p: 1 / (p.step or 1.0))
        else:
            add(f"CSM3, n, {method}", "csm3", part, size)
    for kind in ("cylinder-2d1", "cylinder-2d2"):
        for method, part in by_method(points(data, kind)).items():
            if method in ("wall target", "cosine mask"):
                add(f"{kind}, {method}, nx", kind, part, size)
            elif method in PEERS:
                add(f"{kind}, NGSolve, √dofs", kind, part, lambda p: p.size**0.5)
    add("FSI3, nx", "fsi3", by_method(points(data, "fsi3"))["momentum load"], size)
    return found


FIGURES = (("rod-static", "discretisation"), *((case, "error") for case in QUANTITIES))
"""Case and kind of error of each figure."""


def machine(data: Data) -> list[str]:
    """What most of it was measured on."""
    used = Counter(record.machine for record in data.of("report/*"))
    about = data.machines[used.most_common(1)[0][0]]
    compiler = about["rustc"].split(" (")[0]
    return [f"{about['cpu']}, {about['cores']} cores, {about['system']}, {compiler}, Python {about['python']}."]


def failures(data: Data) -> list[str]:
    rows = [[case, p.method, p.setting, p.failed[:90]] for case in QUANTITIES for p in points(data, case) if p.failed]
    return markdown(["case", "method", "setting", "it failed with"], rows)


def orders(data: Data) -> list[str]:
    header = ["sequence", "quantity", "values", "order", "extrapolated", "discretisation", "model", "verdict"]
    return markdown(header, sequences(data))


def best(data: Data) -> list[str]:
    table = []
    for case, main in MAIN.items():
        kind = "discretisation" if case == "rod-static" else "error"
        for method, part in by_method(points(data, case)).items():
            there = [p for p in part if main in p.of(kind) and p.cpu]
            if there:
                p = min(there, key=lambda p: abs(p.of(kind)[main]))
                wall = f"{p.wall[1]:.3g}" + (f" ({p.wall[0]:.3g} – {p.wall[2]:.3g})" if p.runs > 1 else "")
                error = f"{100 * p.of(kind)[main]:+.3f} %"
                table.append([case, method, p.setting, label(main), error, kind, f"{p.cpu[1]:.3g}", wall, p.runs])
    return markdown(["case", "method", "setting", "quantity", "error", "of", "CPU, s", "wall, s", "runs"], table)


def bands(data: Data) -> list[dict[str, Any]]:
    return [fsi3.LEVEL_4, *fsi3.costs(data)]


def cited(data: Data) -> list[str]:
    rows = []
    for method, setting, wall, values in CITED:
        told = [f"{value * 1e3:.3g} mm" if "amplitude" in q else f"{value:.3g} Hz" for q, value in values.items()] or [
            ""
        ]
        rows += [[f"{method}, {setting}", cell, f"{wall:g}"] for cell in told]
    return markdown(["", "value", "wall s a simulated s"], rows)


# Stability

Cell = tuple[str, dict[str, float], str, str]
"""Label, place on the axes, outcome (`ok`, `error`, `bad`) and what was said."""


def map_cells(data: Data) -> dict[str, list[Cell]]:
    """Cells of the maps, as far as each is kept; the stiff rods are kept by the values tried and those that failed."""
    found: dict[str, list[Cell]] = {"rod": [], "situations": [], "fluid": [], "coupling": []}
    extreme = data["rod/study/extreme"].tables
    tried = {row["axis"]: row["values"] for row in extreme["tried"]}
    said = {tuple(row[key] for key in tried): row["result"] for row in extreme.get("failed", [])}
    for at in np.stack(np.meshgrid(*tried.values()), -1).reshape(-1, len(tried)).tolist():
        result = said.get(tuple(at), "ok")
        place = dict(zip(tried, at))
        found["rod"].append((", ".join(f"{k} = {v:g}" for k, v in place.items()), place, kind_of(result), result))
    for row in data["rod/study/situations"].tables["situations"]:
        found["situations"].append((f"{row['scheme']}, {row['situation']}", {}, kind_of(row["result"]), row["result"]))
    for row in data["fluid-measures/crate/stability"].tables["stability"]:
        place = {"Re": row["reynolds"], "CFL": row["cfl"], "C_eta": row["c_eta"]}
        name = f"{row['scene'] or row['group']}, " + ", ".join(f"{k} {v:g}" for k, v in place.items())
        found["fluid"].append((name, place, row["outcome"], row["message"] or ""))
    for record in data.of("coupling/*"):
        a, outcome = record.about, coupling.outcome(record)
        place = {"density ratio": a["ratio"], "C_eta": a["c_eta"]}
        name = f"{a['scheme']}, density ratio {a['ratio']:g}, C_eta {a['c_eta']:g}, H {a['step']:g}, to {a['end']:g} s"
        found["coupling"].append((name, place, outcome, record.error or ""))
    return found


def kind_of(result: str) -> str:
    """A gain of energy is what a rod must not have without saying so."""
    return "ok" if result == "ok" else "bad" if result.startswith("gain") else "error"


OVER = {
    "rod": "stiffness, bending, segments and step",
    "situations": "snap, folding back, buckling, blows",
    "fluid": "Reynolds number, CFL number, C_eta, scheme, mask, hard scenes",
    "coupling": "density ratio, C_eta, communication step, scheme",
}


def maps(data: Data) -> list[str]:
    """Cells by outcome."""
    found = map_cells(data)
    counts = {name: Counter(outcome for _, _, outcome, _ in cells) for name, cells in found.items()}
    rows = [[name, OVER[name], len(found[name]), c["ok"], c["error"], c["bad"]] for name, c in counts.items()]
    return markdown(["map", "over", "cells", "ok", "error", "bad"], rows)


def failed(data: Data) -> list[str]:
    """Cells that did not end well."""
    cells = [(name, *cell) for name, part in map_cells(data).items() for cell in part if cell[2] != "ok"]
    return markdown(
        ["map", "cell", "outcome", "reason"],
        [[name, cell, outcome, said[:110]] for name, cell, _, outcome, said in cells],
    )


MAPS = (
    ("rod", "", "dt", "k_e", "rod, worst over n and EI"),
    ("rod", "", "n", "EI", "rod, worst over $k_e$ and step"),
    ("fluid", "Backward differences, log-linear mask", "CFL", "Re", "fluid, worst over $C_\\eta$"),
    ("fluid", "Heun's method, sharp mask", "C_eta", "CFL", "fluid, Heun's method, worst over Re"),
    ("coupling", "default,", "C_eta", "density ratio", "coupling: the default"),
    ("coupling", "pressure jump,", "C_eta", "density ratio", "coupling: pressure jump, explicit"),
)
"""Map, beginning of the cells' names, axes and title."""
AXES = {"dt": "step [s]", "k_e": "$k_e$ [N/m]", "EI": "EI [N m²]", "C_eta": "$C_\\eta$ [s]", "Re": "Reynolds number"}
OUTCOMES = {"ok": "#56B4E9", "error": "#E69F00", "bad": "#000000"}


def draw_maps(data: Data) -> None:
    """Cells coloured by their worst outcome; failed ones have a letter as well."""
    figure, axes = show.panel(2, 3, (12, 7.4))
    found, rank = map_cells(data), list(OUTCOMES)
    for axis, (name, begin, x, y, title) in zip(axes.flat, MAPS):
        cells = [(at[y], at[x], rank.index(outcome)) for cell, at, outcome, _ in found[name] if cell.startswith(begin)]
        lines, columns = (sorted({cell[i] for cell in cells}) for i in (0, 1))
        table = np.full((len(lines), len(columns)), np.nan)
        for line, column, worst in cells:
            i, j = lines.index(line), columns.index(column)
            table[i, j] = np.nanmax([table[i, j], worst])
        axis.grid(False)
        axis.imshow(
            table, cmap=ListedColormap(list(OUTCOMES.values())), vmin=-0.5, vmax=2.5, aspect="auto", origin="lower"
        )
        for (i, j), worst in np.ndenumerate(table):
            if worst > 0:
                axis.text(j, i, " eb"[int(worst)], ha="center", va="center", fontsize=8)
        axis.set_xticks(range(len(columns)), [f"{v:g}" for v in columns], fontsize=7, rotation=45)
        axis.set_yticks(range(len(lines)), [f"{v:g}" for v in lines], fontsize=7)
        axis.set_xlabel(AXES.get(x, x), fontsize=8)
        axis.set_ylabel(AXES.get(y, y), fontsize=8)
        axis.set_title(title, fontsize=9)
    said = {"ok": "ok", "error": "error (e): says so", "bad": "bad (b)"}
    handles = [
        Line2D([], [], marker="s", linewidth=0, color=colour, label=said[name]) for name, colour in OUTCOMES.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8)
    show.save(figure, "report/maps")


# Cost


def cost_groups(data: Data) -> dict[str, tuple[str, list[tuple[float, float]]]]:
    """Cost in µs over size by what is measured; the label of the size first."""

    def of_step(method: str, phase: str) -> list[tuple[float, float]]:
        return [(r.about["size"], part_of(r, phase) or np.nan) for r in data.of("report/cost/*", method=method)]

    bench = [(row["points"], row["step"]) for row in speed.found(data, "step")]
    iterations = [
        (row["n"], 1e6 * row["iteration_2d"]) for row in data["rod/study/runtime"].times["rows"] if row["n"] >= 64
    ]
    bar = next(row for row in speed.found(data, "motion") if row["grid"] == "650 x 144")
    return {
        "a step of the fluid": ("points of the grid", bench),
        "a Newton iteration of the rod in the plane": ("segments n", iterations),
        "a step of FSI3, all of it": ("points of the grid", of_step("grid", "step")),
        "a step of FSI3, the rod's part": ("segments", of_step("stations", "rod")),
        "the bar in a step of the fluid, 650 x 144": (
            "cells that its stations move in it",
            [(jump, value) for jump, value in speed.jumps(bar, "bar").items() if jump > 0]
        ),
    }  # fmt: skip


def part_of(record: Record, phase: str) -> float | None:
    """Time of a step, µs: the median CPU time of the whole, the shortest wall time of a part."""
    seconds = record.clock("cpu_s") if phase == "step" else record.times["phases_s"].get(phase)
    return None if seconds is None else float(1e6 * seconds / record["steps"])


def exponents(data: Data) -> list[str]:
    rows = [[name, x, f"{show.exponent(*zip(*found)):.2f}"] for name, (x, found) in cost_groups(data).items()]
    return markdown(["cost of", "over", "exponent"], rows)


def steps(data: Data) -> list[dict[str, Any]]:
    """A step of FSI3 and its parts, µs."""
    return [r.about | {name: part_of(r, name) for name in ("step", *PHASES)} for r in data.of("report/cost/*")]


def loops(data: Data) -> list[dict[str, Any]]:
    """Parts of a run by the wall time of its loop."""
    rows = []
    for record in (r for pattern in ("report/*", "fsi3/grid/*") for r in data.of(pattern)):
        phases = record.times.get("phases_s")
        if phases and "/cost/" not in record.name and (record.about.get("step") or 1e-3) in (1e-3, 3e-3, 7.5e-4):
            loop = sum(seconds for phase, seconds in phases.items() if phase != "output")
            rows.append(
                {"name": record.name.partition("/")[2]} | {phase: seconds / loop for phase, seconds in phases.items()}
            )
    return rows


def draw_cost(data: Data) -> None:
    groups = cost_groups(data)
    figure, axes = show.panel(-(-len(groups) // 3), 3, (12, 3.6 * -(-len(groups) // 3)))
    for axis in axes.flat[len(groups) :]:
        axis.set_visible(False)
    for axis, (name, (xlabel, found)) in zip(axes.flat, groups.items()):
        x, y = map(np.array, zip(*sorted(found)))
        slope, offset = np.polyfit(np.log(x), np.log(y), 1)
        axis.plot(x, y, "o", color=COLOURS[0])
        axis.plot(x, np.exp(offset) * x**slope, "--", color=COLOURS[1], label=f"exponent {slope:.2f}")
        axis.set(xscale="log", yscale="log", xlabel=xlabel, ylabel="µs")
        if max(y) < 2 * min(y):
            axis.set_ylim(min(y) / 3, max(y) * 3)  # what does not depend on x shall look like it
        axis.set_title(name, fontsize=9)
        show.few_labels(axis.xaxis)
        axis.legend(fontsize=8)
    show.save(figure, "report/cost")


# What is missed


def beaten(data: Data) -> list[str]:
    """CPU time of ours and of the peers for the largest error over all quantities of a case: a single one may pass
    through zero."""
    rows = []
    for case in MAIN:
        kind = "discretisation" if case == "rod-static" else "error"
        there = [p for p in points(data, case) if p.cpu and "thesis" not in p.method and p.of(kind)]
        worst = [(max(map(abs, p.of(kind).values())), p.cpu[1], p) for p in there]
        peers, ours = ([run for run in worst if (run[2].method in PEERS) == theirs] for theirs in (True, False))
        if peers and ours:
            theirs = min(peers, key=lambda run: run[0])
            # The cheapest of ours that is at least as exact, or else the most exact one.
            enough = [run for run in ours if run[0] <= theirs[0]]
            mine = min(enough, key=lambda run: run[1]) if enough else min(ours, key=lambda run: run[0])
            verdict = f"{mine[1] / theirs[1]:.2g} of its CPU time" if enough else "**does not reach its error**"
            rows.append(
                [
                    case,
                    *(f"{p.method} ({p.setting}): {100 * e:.2g} % in {cpu:.2g} s" for e, cpu, p in (theirs, mine)),
                    verdict,
                ]
            )
    return markdown(["case", "the most exact peer", "ours, at least as exact", "ours takes"], rows)


def missed(data: Data) -> list[str]:
    """What is not met, from the numbers."""
    finest = data["fsi3/grid/1300x288"]
    off = [
        f"{label(q)} {100 * e:+.1f} %" for q in finest.published if (e := finest.off(q)) is not None and abs(e) > 0.02
    ]
    found = sequences(data)
    loose = sum(row[-1].startswith("not") for row in found)
    rows = [["FSI3 on 1300 x 288, more than 2 % off", ", ".join(off) or "nothing"]]
    for case in ("cylinder-2d1", "cylinder-2d2"):
        last = max(by_method(points(data, case))["wall target"], key=lambda p: p.size)
        rows.append([f"{case}, finest grid", ", ".join(f"{label(q)} {100 * e:+.2f} %" for q, e in last.errors.items())])
    rows.append(["sequences that are not asymptotic", f"{loose} of {len(found)}"])
    return markdown(["", "missed"], rows)


def draw_errors(data: Data, case: str, kind: str) -> None:
    """Error over wall time (above) and CPU time (below), a column for each quantity. Failed runs are crosses at the
    edge."""
    quantities, methods, failed = (
        QUANTITIES[case],
        by_method(points(data, case)),
        [p for p in points(data, case) if p.failed],
    )
    figure, axes = show.panel(2, len(quantities), (3.7 * len(quantities), 6.4), sharey="col")
    for (line, column), axis in np.ndenumerate(axes):
        quantity, clock, seen = quantities[column], ("wall", "cpu")[line], []
        for part, colour, marker in zip(methods.values(), COLOURS, MARKERS):
            good = sorted(
                (p for p in part if getattr(p, clock) and quantity in p.of(kind)), key=lambda p: getattr(p, clock)[1]
            )
            if not good:
                continue
            low, x, high = np.array([getattr(p, clock) for p in good]).T
            y = np.maximum(np.abs([p.of(kind)[quantity] for p in good]), 1e-8)
            axis.errorbar(
                x, y, xerr=[x - low, high - x], marker=marker, color=colour, capsize=2, markersize=5, linewidth=1
            )
            seen += list(zip(x, y))
        if seen:
            best = [seen[i] for i in front(seen)]
            axis.step(*zip(*best), where="post", color="#000000", linewidth=3, alpha=0.15, zorder=0)
        if failed:
            axis.plot([0.98] * len(failed), np.linspace(0.98, 0.9, len(failed)), "kx", transform=axis.transAxes)
        axis.set(xscale="log", yscale="log", xlabel=f"{'wall' if clock == 'wall' else 'CPU'} time [s]")
        show.few_labels(axis.xaxis)
        show.few_labels(axis.yaxis)
        axes[0, column].set_title(label(quantity), fontsize=10)
    for axis in axes[:, 0]:
        axis.set_ylabel("relative error" if kind == "error" else "discretisation error, relative")
    handles = [Line2D([], [], color=c, marker=m, label=method) for method, c, m in zip(methods, COLOURS, MARKERS)]
    handles.append(Line2D([], [], color="#000000", linewidth=3, alpha=0.15, label="Pareto front"))
    figure.legend(handles=handles, loc="outside lower center", ncols=min(4, len(handles)), fontsize=8)
    show.save(figure, f"report/{case.replace('-', '_')}_{kind}")


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    for case, kind in FIGURES:
        draw_errors(data, case, kind)
    draw_maps(data)
    draw_cost(data)


TABLES: dict[str, Callable[[Data], Any]] = {
    "report-missed": missed, "report-peers": beaten, "report-machine": machine, "report-failures": failures,
    "report-best": best, "report-orders": orders, "report-bands": bands,
    "report-cited": cited, "report-maps": maps, "report-failed": failed, "report-lacking": leave_out.lacking,
    "report-left-out": leave_out.added, "report-exponents": exponents, "report-iterations": rod.run_times,
    "report-steps": steps, "report-loops": loops,
}  # fmt: skip
STUDY = Study("report", cases.cases, cases.keep, TABLES, draw)
