"""The rod alone: the tables and figures of the thesis' chapter 2 and what lies beyond them, by crates/rod/study."""

from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from studies import clamp, commands, show, simulate
from studies.engine import ROD, Case, Run, Study
from studies.show import COLOURS, exponent, grouped, markdown, page
from studies.store import Data

MANIFEST, TARGET = "crates/rod/study/Cargo.toml", "target/rod-study"

TABLES = ("condition", "runtime", "deflection", "order_in_n", "order_in_dt", "bending_models", "csm", "csm3_energy",
          "extreme", "situations")  # fmt: skip
"""What the program can be asked for; each is a file of that name."""

THESIS_CONDITION = {
    (5e4, 1e-3): [527168.64, 6301043.05, 60404887.40, 530612724.29, 4606965436.28],
    (1e5, 1e-3): [705920.26, 6389968.51, 60256883.66, 532383835.99, 3850664611.25],
    (2e5, 1e-3): [1752600.66, 6571857.76, 60968369.21, 499121585.93, 4375584326.29],
    (1e5, 1e-2): [1156286.06, 9035572.09, 70029681.81, 714462652.81, 14672886774.30],
}
"""Tables 2.1 and 2.2 of the thesis: condition numbers by (k_e, dt) for n = 32 … 512."""

STEPS = 10_000
"""Time steps of the runs of the thesis' table 2.3, about."""
SOLVERS = ("banded", "sparse", "dense")
SCHEMES = {"trapezoid": 1, "generalised-alpha 0.5": 1, "generalised-alpha 0.8": 1, "BDF2": 1, "TR-BDF2": 2}
"""Solves a step."""
EXTREME = ("n", "k_e", "EI", "dt")
"""What the stiff cases vary."""


def cases() -> Iterator[Case]:
    for name in TABLES:
        command = commands.cargo(MANIFEST, TARGET, "{folder}", name)
        yield Case(f"study/{name}", (*ROD, "rod study"), options={"command": command}, action=commands.tables)
    yield Case("study/clamp", ("clamp",), action=clamp.run)


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


def extremes(rows: list[dict[str, Any]]) -> dict[str, Any]:
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


def table_of(data: Data, name: str) -> list[dict[str, Any]]:
    return data[f"rod/study/{name}"].tables[name]


# Pages


def condition(data: Data) -> str:
    """Tables 2.1 and 2.2."""
    rows = []
    for (k_e, dt), group in grouped(table_of(data, "condition"), "k_e", "dt").items():
        for row, printed in zip(group, THESIS_CONDITION[k_e, dt]):
            found = [f"{printed:.4e}", f"{row['full']:.4e}", f"{row['full'] / printed:.2f}", f"{row['eliminated']:.3e}"]
            rows.append([f"{k_e:g}", f"{dt:g}", f"{row['n']:.0f}", f"{row['order']:.0f}", *found])
    return page(
        "Condition numbers (thesis tables 2.1 and 2.2, figure 2.5)",
        ["k_e", "dt", "n", "order", "thesis", "here", "ratio", "velocities eliminated"],
        rows,
        "1-norm of the full Jacobian [[1, -dt/2], [dt/2 K, m]] of order 6(n - 1), straight rod, L = EI = mu = 1, h = L/n, "
        "m = mu h, clamp spring EI/h. Last column: the matrix that the solver factorises, K + 4 m/dt².",
    )


def run_seconds(row: dict[str, Any], solver: str) -> float | None:
    """Of `STEPS` steps in space, each iteration with the factorise-and-solve of this solver."""
    if not row[solver]:
        return None
    return float(STEPS * row["iterations_per_step"] * (row["iteration_3d"] - row["banded"] + row[solver]))


def run_times(rows: list[dict[str, Any]]) -> dict[str, tuple[list[float], list[float], float, int]]:
    """n, seconds and fitted exponent of each solver, and from which n on it was fitted."""
    found = {}
    for name in (*SOLVERS, "thesis_sparse", "thesis_dense"):
        of_row = {row["n"]: run_seconds(row, name) if name in SOLVERS else row[name] for row in rows}
        there = {n: value for n, value in of_row.items() if value}
        first = 64 if name in SOLVERS else 128
        late = [n for n in there if n >= first]
        found[name] = list(there), list(there.values()), exponent(late, [there[n] for n in late]), first
    return found


def runtime(data: Data) -> str:
    """Table 2.3."""
    rows = data["rod/study/runtime"].times["rows"]
    table = []
    for row in rows:
        cells = [show.number(run_seconds(row, solver), ".3g") for solver in SOLVERS]
        cells += [show.number(row[key], ".6g") for key in ("thesis_sparse", "thesis_dense")]
        cells += [f"{1e6 * row[key]:.1f}" if row[key] else "" for key in ("iteration_3d", "iteration_2d", *SOLVERS)]
        ratios = [f"{row['iteration_3d'] / row['iteration_2d']:.2f}", f"{row['sparse'] / row['banded']:.2f}"]
        table.append([f"{row['n']:.0f}", *cells, *ratios])
    fitted = [
        f"{name.replace('_', ' ')} n^{slope:.2f}" + (f" from {first} on" if first > 64 else "")
        for name, (_, _, slope, first) in run_times(rows).items()
    ]
    late = [row for row in rows if row["n"] >= 64]
    iteration = exponent([row["n"] for row in late], [row["iteration_3d"] for row in late])
    return page(
        "Run time against n (thesis table 2.3, figure 2.6)",
        ["n", "banded, s", "sparse, s", "dense, s", "thesis sparse, s", "thesis dense, s", "iteration 3D, µs",
         "iteration 2D, µs", "banded solve, µs", "faer sparse, µs", "faer dense, µs", "3D/2D", "sparse/banded"],
        table,
        f"Seconds for {STEPS} steps of TR-BDF2 in space, one core: two solves a step, each iteration with the library's "
        "derivatives, assembly and check and the factorise-and-solve of the column. The thesis: MATLAB. "
        f"Exponents from n = 64 on: {', '.join(fitted)}; one iteration n^{iteration:.2f}.",
    )  # fmt: skip


def order_of_n(group: list[dict[str, Any]]) -> float:
    """From 32 to 128 segments."""
    return -exponent([row["n"] for row in group[2:5]], [row["error"] for row in group[2:5]])


def order_in_n(data: Data) -> str:
    table = []
    for (calibration, plane, _), group in grouped(table_of(data, "order_in_n"), "calibration", "plane", "gravity").items():
        errors = [f"{row['error']:.2e}" for row in group]
        table.append([calibration, plane, f"{group[-1]['tip_angle']:.1f}", *errors, f"{order_of_n(group):.2f}"])
    header = ["calibration", "plane", "tip angle, °", *(f"n = {row['n']:.0f}" for row in group), "order, 32 … 128"]
    return page("Error of the tip against the exact elastica, relative to the deflection", header, table)


def order_of_dt(group: list[dict[str, Any]]) -> float:
    """From 0.005 s to 0.00031 s."""
    return exponent([row["dt"] for row in group[2:7]], [row["error"] for row in group[2:7]])


def order_in_dt(data: Data) -> str:
    table = []
    for (case, scheme), group in grouped(table_of(data, "order_in_dt"), "case", "scheme").items():
        table.append([case, scheme, *(f"{row['error']:.1e}" for row in group[::2]), f"{order_of_dt(group):.2f}"])
    header = ["case", "scheme", *(f"dt = {row['dt']:.3g}" for row in group[::2]), "order, dt = 0.005 … 0.00031"]
    return page("Error of the tip at t = 1 s against dt", header, table)


def bending_models(data: Data) -> str:
    names = ("invariant_diagonal", "projected_plane", "projected_diagonal")
    rows = [
        [f"{row['gravity']:g}", f"{row['tip_angle']:.1f}", *(f"{row[name]:.1e}" for name in names)]
        for row in table_of(data, "bending_models")
    ]
    header = ["g", "tip angle, °", "invariant, diagonal plane", "projected, plane", "projected, diagonal plane"]
    return page("Deflection against the invariant model in the plane, n = 128", header, rows)


def energy_cell(row: dict[str, Any]) -> str:
    ended = "" if row["time"] > 59 else f" (ended at {row['time']:.0f} s)"
    halved = f" ({row['halvings']:.0f} halvings)" if row["halvings"] else ""
    return f"{row['energy']:+.1e}{ended}{halved}"


def csm3_energy(data: Data) -> str:
    rows = table_of(data, "csm3_energy")
    columns = list(grouped(rows, "n", "dt"))
    table = []
    for (scheme,), group in grouped(rows, "scheme").items():
        cells = {(row["n"], row["dt"]): energy_cell(row) for row in group}
        table.append([scheme, *(cells.get(column, "") for column in columns)])
    header = ["scheme", *(f"n = {n:.0f}, dt = {dt:g} s" for n, dt in columns)]
    note = (
        "A run ends where the gain reaches what there is. Trapezoid, unwatched: without the energy guard, under a root that "
        "is driven, but to where it is."
    )
    return page("Energy at the end of 60 s of CSM3, relative to the largest energy in gravity", header, table, note)


def extreme(data: Data) -> str:
    record = data["rod/study/extreme"]
    table = []
    for row, longest in zip(record.tables["extreme"], record.times["longest step"]):
        cells = [f"{row['n']:.0f}", f"{row['dt']:g}", f"{row['cells']:.0f}", f"{row['ok']:.0f}", row["other"] or ""]
        largest = [f"{row['largest gain']:.1e}", f"{row['largest loss']:.1e}"]
        table.append([*cells, *largest, f"{row['iterations']:.0f}", f"{longest:.3f}"])
    header = ["n", "dt, s", "cells", "ok", "other", "largest gain (ok)", "largest loss (ok)", "most iterations a step",
              "longest step, s"]  # fmt: skip
    note = (
        "Each row: k_e = 1e3 … 1e9 N/m a segment times EI = 1e-6 … 1e3 N m², 50 steps of the default scheme from rest under "
        "the weight; gain and loss of energy relative to the largest energy that moved."
    )
    return page("Stiff cases", header, table, note)


def situations(data: Data) -> str:
    table = [
        [row["situation"], row["scheme"], row["result"].split(":")[0], f"{row['gain']:.1e}", f"{row['loss']:.1e}",
         f"{row['iterations']:.0f}", f"{row['substeps']:.0f}"]
        for row in table_of(data, "situations")
    ]  # fmt: skip
    header = ["situation", "scheme", "result", "gain", "loss", "most iterations a step", "most sub-steps"]
    note = "Energies count from the third step after the load is gone."
    return page("Extreme situations, n = 64 in space", header, table, note)


def clamps(data: Data) -> str:
    header = ["wall", "Poisson's ratio", "elements", "d/h by the moment", "d/h by the force", "k", "10/(12 − ν)"]
    rows = []
    for row in table_of(data, "clamp"):
        numbers = [f"{row[name]:.4f}" for name in ("by_moment", "by_force", "shear_factor")]
        rows.append([row["wall"], row["poisson"], row["elements"], *numbers, f"{10 / (12 - row['poisson']):.4f}"])
    note = "Linear elasticity in plane strain; the plate is 6 h long."
    return page("The clamp of a plate and its shear", header, rows, note)


PAGES: dict[str, Callable[[Data], str]] = {
    "condition": condition, "runtime": runtime, "order_in_n": order_in_n, "order_in_dt": order_in_dt,
    "bending_models": bending_models, "csm3_energy": csm3_energy, "extreme": extreme, "situations": situations,
    "clamp": clamps,
}  # fmt: skip


def pages(data: Data) -> dict[str, str]:
    return {f"rod/{name}.md": made(data) for name, made in PAGES.items()}


def schemes(data: Data) -> list[str]:
    """What the schemes do to the energy."""
    energies = {(row["scheme"], row["n"], row["dt"]): energy_cell(row) for row in table_of(data, "csm3_energy")}
    table = []
    for scheme, solves in {"trapezoid, unwatched": 1, **SCHEMES}.items():
        cells = [row for row in table_of(data, "situations") if row["scheme"] == scheme]
        good = sum(row["result"] == "ok" for row in cells)
        others = [
            f"{row['situation'].split(':')[0]}: {row['result'].split(' in step')[0]}" for row in cells if row["result"] != "ok"
        ]
        found = [energies[scheme, 32, dt] for dt in (0.01, 0.02)]
        table.append([scheme, solves, *found, f"{good} of {len(cells)}" if cells else "", "; ".join(others)])
    header = ["scheme", "solves a step", "energy after 60 s of CSM3, n = 32, dt = 0.01 s", "dt = 0.02 s"]
    return markdown([*header, "situations that end well", "the others"], table)


def csm(data: Data) -> list[str]:
    """Against Turek & Hron."""
    names, table = {"tip_ux": "ux", "tip_uy": "uy"}, []
    rows = {(row["scene"], row["quantity"], row["rod"]): row["value"] for row in table_of(data, "csm")}
    for (scene, quantity, rod), _ in rows.items():
        expected, extent = simulate.published(scene).get(quantity, (None, 0.0))
        if rod != "as shipped" or not extent or expected is None:
            continue
        runs = [rows[scene, quantity, rod] for rod in ("as shipped", "without shear and set-back")]
        name, _, what = quantity.partition(".")
        scale, unit, digits = (1, "Hz", 4) if what == "frequency_hz" else (1e3, "mm", 3)
        cells = [f"{scale * value:.{digits}f} ({100 * (value - expected) / extent:+.2f} %)" for value in runs]
        label = f"{scene.upper()}, {names[name]}, {what.replace('_hz', '')}, {unit}"
        table.append([label, f"{scale * expected:.{digits}f}", *cells])
    return markdown(["", "Turek & Hron", "as shipped", "without shear and set-back"], table)


# Figures


def curves(name: str, labels: tuple[str, str], log: bool = True):
    """Axes, and a function that saves them as docs/rod/NAME.png."""
    figure, axes = show.panel()
    axes[0, 0].set(xlabel=labels[0], ylabel=labels[1])
    if log:
        axes[0, 0].set(xscale="log", yscale="log")

    def save(**legend: Any) -> None:
        axes[0, 0].legend(fontsize=8, **legend)
        show.save(figure, f"rod/{name}", 130)

    return axes[0, 0], save


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    draw_condition(data)
    draw_runtime(data)
    draw_order_in_n(data)
    draw_order_in_dt(data)
    if run := runs("rod/study/deflection"):
        draw_deflection(run.found["tables"]["deflection"])
    if run := runs("rod/study/csm3_energy"):
        draw_csm3_energy(run.found["tables"]["csm3_energy"])


def draw_condition(data: Data) -> None:
    """Figure 2.5."""
    axes, save = curves("condition", ("mass points n", "condition number, 1-norm"))
    # One on top of the other: the larger ones below, and hollow.
    markers = zip("osv^", (13, 9.5, 6.5, 5))
    for ((k_e, dt), group), (marker, size) in zip(grouped(table_of(data, "condition"), "k_e", "dt").items(), markers):
        n, full = [row["n"] for row in group], [row["full"] for row in group]
        label = f"k_e = {k_e:g} N/m, dt = {dt:g} s: n^{exponent(n, full):.2f}"
        (line,) = axes.plot(n, full, marker, markersize=size, fillstyle="none", label=label)
        axes.plot(n, THESIS_CONDITION[k_e, dt], "--", color=line.get_color(), linewidth=1)
        if k_e == 1e5:
            eliminated = [row["eliminated"] for row in group]
            axes.plot(n, eliminated, ":", color=line.get_color(), label=f"velocities eliminated, dt = {dt:g} s")
    axes.plot([], [], "k--", linewidth=1, label="thesis, tables 2.1 and 2.2")
    show.counts(axes, n)
    save(loc="lower right")


def draw_runtime(data: Data) -> None:
    """Figure 2.6."""
    rows = data["rod/study/runtime"].times["rows"]
    axes, save = curves("runtime", ("segments n", f"seconds for {STEPS} steps"))
    styles = dict(zip((*SOLVERS, "thesis_sparse", "thesis_dense"), ("o-", "s-", "v-", "k--", "k:")))
    for name, (n, seconds, slope, first) in run_times(rows).items():
        axes.plot(n, seconds, styles[name], label=f"{name.replace('_', ', ')}: n^{slope:.2f} from {first} on")
    show.counts(axes, [row["n"] for row in rows])
    save()


def draw_deflection(rows: list[dict[str, Any]]) -> None:
    """Figure 2.7."""
    axes, save = curves("deflection", ("x/L", "y/L"), log=False)
    colours, styles = {"second order": COLOURS[0], "thesis k_e=1e3": COLOURS[1]}, {8.0: ":", 32.0: "--", 128.0: "-"}
    for (model, n), group in grouped(rows, "model", "n").items():
        x, y = [row["x"] for row in group], [row["y"] for row in group]
        if model == "elastica":
            axes.plot(x, y, "k-", linewidth=5, alpha=0.25, label="exact elastica")
        elif model in colours:
            axes.plot(x, y, styles[n], color=colours[model], linewidth=1.4, label=f"{model}, n = {n:.0f}")
    save(loc="lower left")


def draw_order_in_n(data: Data) -> None:
    axes, save = curves("order_in_n", ("segments n", "error of the tip / deflection"))
    for (calibration, plane, gravity), group in grouped(table_of(data, "order_in_n"), "calibration", "plane", "gravity").items():
        n, error = [row["n"] for row in group], [row["error"] for row in group]
        if plane == "diagonal" and gravity != 2.0 and "inextensible" not in calibration:
            # What falls together is told apart by size.
            marker = {"second order": "o-", "thesis k_e=1e3": "s--", "thesis k_e=1e6": "^:"}[calibration]
            label = f"{calibration}, tip at {group[-1]['tip_angle']:.0f}°: n^{-order_of_n(group):.2f}"
            size = 8 if "1e3" in calibration else 4.5
            axes.plot(n, error, marker, markersize=size, fillstyle="none", label=label)
    show.counts(axes, n)
    axes.set_ylim(bottom=3e-8)
    save(loc="lower left")


def draw_order_in_dt(data: Data) -> None:
    """Error over the step, and over run time."""
    record = data["rod/study/order_in_dt"]
    rows = [row | {"seconds": s} for row, s in zip(record.tables["order_in_dt"], record.times["seconds"])]
    for (case,), of_case in grouped(rows, "case").items():
        name = "pushed" if "pushed" in case else "free"
        by_dt, save_dt = curves(f"order_in_dt_{name}", ("dt, s", "error of the tip, relative"))
        by_time, save_time = curves(f"work_precision_{name}", ("run time, s", "error of the tip, relative"))
        for ((scheme,), group), marker, size in zip(grouped(of_case, "scheme").items(), "osv^D", (8, 6.5, 5, 5, 4.5)):
            dt, error = [row["dt"] for row in group], [row["error"] for row in group]
            style: dict[str, Any] = {"markersize": size, "fillstyle": "none", "linewidth": 1.2}
            label = scheme if name == "free" else f"{scheme}: dt^{order_of_dt(group):.2f}"
            by_dt.plot(dt, error, marker + "-", **style, label=label)
            by_time.plot([row["seconds"] for row in group], error, marker + "-", **style, label=scheme)
        save_dt()
        save_time()


def draw_csm3_energy(rows: list[dict[str, Any]]) -> None:
    axes, save = curves("csm3_energy", ("time, s", "gain of energy / largest energy in gravity"), log=False)
    axes.set(ylim=(-0.15, 0.5))
    groups = grouped([row for row in rows if (row["n"], row["dt"]) == (32.0, 0.02)], "scheme")
    for ((scheme,), group), dashes in zip(groups.items(), ("-", "-", "--", "-.", "-", ":")):
        axes.plot([row["time"] for row in group], [row["energy"] for row in group], dashes, label=f"{scheme}, dt = 0.02 s")
    save(loc="upper left")


STUDY = Study("rod", cases, keep, {"rod-schemes": schemes, "rod-csm": csm}, pages, draw)
