"""Tables and figures of the rod's studies, from docs/rod/*.csv, beside them."""

import sys
from collections import Counter, defaultdict
from functools import partial
from pathlib import Path

from matplotlib.ticker import FixedLocator, NullFormatter, StrMethodFormatter



from nervure.resources import ROOT
from studies import clamp, tables
from studies.tables import exponent, grouped, page

DOCS = ROOT / "docs" / "rod"
read, figure = partial(tables.read, DOCS), partial(tables.figure, DOCS)

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


def counts(axes, numbers) -> None:
    """Ticks of a logarithmic axis at these numbers of segments."""
    axes.xaxis.set_major_locator(FixedLocator(list(numbers)))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:.0f}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="x", which="minor", length=0)


def condition() -> str:
    """Tables 2.1 and 2.2."""
    rows = []
    for (k_e, dt), group in grouped(read("condition"), "k_e", "dt").items():
        for row, printed in zip(group, THESIS_CONDITION[k_e, dt]):
            rows.append(
                [f"{k_e:g}", f"{dt:g}", f"{row['n']:.0f}", f"{row['order']:.0f}", f"{printed:.4e}", f"{row['full']:.4e}",
                 f"{row['full'] / printed:.2f}", f"{row['eliminated']:.3e}"]
            )
    return page(
        "Condition numbers (thesis tables 2.1 and 2.2, figure 2.5)",
        ["k_e", "dt", "n", "order", "thesis", "here", "ratio", "velocities eliminated"],
        rows,
        "1-norm of the full Jacobian [[1, -dt/2], [dt/2 K, m]] of order 6(n - 1), straight rod, L = EI = mu = 1, h = L/n, "
        "m = mu h, clamp spring EI/h. Last column: the matrix that the solver factorises, K + 4 m/dt².",
    )


def draw_condition() -> None:
    """Figure 2.5."""
    axes, save = figure("condition", ("mass points n", "condition number, 1-norm"))
    # One on top of the other: the larger ones below, and hollow.
    markers = zip("osv^", (13, 9.5, 6.5, 5))
    for ((k_e, dt), group), (marker, size) in zip(grouped(read("condition"), "k_e", "dt").items(), markers):
        n, full = [row["n"] for row in group], [row["full"] for row in group]
        label = f"k_e = {k_e:g} N/m, dt = {dt:g} s: n^{exponent(n, full):.2f}"
        (line,) = axes.plot(n, full, marker, markersize=size, fillstyle="none", label=label)
        axes.plot(n, THESIS_CONDITION[k_e, dt], "--", color=line.get_color(), linewidth=1)
        eliminated = [row["eliminated"] for row in group]
        if k_e == 1e5:
            axes.plot(n, eliminated, ":", color=line.get_color(), label=f"velocities eliminated, dt = {dt:g} s")
    axes.plot([], [], "k--", linewidth=1, label="thesis, tables 2.1 and 2.2")
    counts(axes, n)
    save(loc="lower right")


def run_seconds(row: dict, solver: str) -> float | None:
    """Of `STEPS` steps in space, each iteration with the factorise-and-solve of this solver."""
    if not row[solver]:
        return None
    return STEPS * row["iterations_per_step"] * (row["iteration_3d"] - row["banded"] + row[solver])


def run_times(rows: list[dict]) -> dict[str, tuple[list, list, float, int]]:
    """n, seconds and fitted exponent of each solver, and from which n on it was fitted."""
    found = {}
    for name in (*SOLVERS, "thesis_sparse", "thesis_dense"):
        of_row = {row["n"]: run_seconds(row, name) if name in SOLVERS else row[name] for row in rows}
        n, seconds = zip(*((n, value) for n, value in of_row.items() if value))
        first = 64 if name in SOLVERS else 128
        late = [k for k, count in enumerate(n) if count >= first]
        found[name] = n, seconds, exponent([n[k] for k in late], [seconds[k] for k in late]), first
    return found


def runtime() -> str:
    """Table 2.3."""
    rows = read("runtime")
    table = []
    for row in rows:
        cells = [f"{row['n']:.0f}"]
        cells += [f"{seconds:.3g}" if (seconds := run_seconds(row, solver)) else "" for solver in SOLVERS]
        cells += [f"{row[key]:.6g}" if row[key] else "" for key in ("thesis_sparse", "thesis_dense")]
        cells += [f"{1e6 * row[key]:.1f}" if row[key] else "" for key in ("iteration_3d", "iteration_2d", *SOLVERS)]
        cells += [f"{row['iteration_3d'] / row['iteration_2d']:.2f}", f"{row['sparse'] / row['banded']:.2f}"]
        table.append(cells)
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
        f"Seconds for {STEPS} steps of TR-BDF2 in space, one core: two solves a step, each iteration with the library's derivatives, "
        "assembly and check and the factorise-and-solve of the column. The thesis: MATLAB. "
        f"Exponents from n = 64 on: {', '.join(fitted)}; one iteration n^{iteration:.2f}.",
    )


def draw_runtime() -> None:
    """Figure 2.6."""
    rows = read("runtime")
    axes, save = figure("runtime", ("segments n", f"seconds for {STEPS} steps"))
    styles = dict(zip((*SOLVERS, "thesis_sparse", "thesis_dense"), ("o-", "s-", "v-", "k--", "k:")))
    for name, (n, seconds, slope, first) in run_times(rows).items():
        axes.plot(n, seconds, styles[name], label=f"{name.replace('_', ', ')}: n^{slope:.2f} from {first} on")
    counts(axes, [row["n"] for row in rows])
    save()


def draw_deflection() -> None:
    """Figure 2.7."""
    axes, save = figure("deflection", ("x/L", "y/L"), log=False)
    colours = {"second order": "C0", "thesis k_e=1e3": "C1"}
    styles = {8.0: ":", 32.0: "--", 128.0: "-"}
    for (model, n), group in grouped(read("deflection"), "model", "n").items():
        x, y = [row["x"] for row in group], [row["y"] for row in group]
        if model == "elastica":
            axes.plot(x, y, "k-", linewidth=5, alpha=0.25, label="exact elastica")
        elif model in colours:
            axes.plot(x, y, styles[n], color=colours[model], linewidth=1.4, label=f"{model}, n = {n:.0f}")
    save(loc="lower left")


def order_of_n(group: list[dict]) -> float:
    """From 32 to 128 segments."""
    return -exponent([row["n"] for row in group[2:5]], [row["error"] for row in group[2:5]])


def order_in_n() -> str:
    table = []
    for (calibration, plane, _), group in grouped(read("order_in_n"), "calibration", "plane", "gravity").items():
        errors = [f"{row['error']:.2e}" for row in group]
        table.append([calibration, plane, f"{group[-1]['tip_angle']:.1f}", *errors, f"{order_of_n(group):.2f}"])
    return page("Error of the tip against the exact elastica, relative to the deflection",
                ["calibration", "plane", "tip angle, °", *(f"n = {row['n']:.0f}" for row in group), "order, 32 … 128"], table)


def draw_order_in_n() -> None:
    axes, save = figure("order_in_n", ("segments n", "error of the tip / deflection"))
    for (calibration, plane, gravity), group in grouped(read("order_in_n"), "calibration", "plane", "gravity").items():
        n, error = [row["n"] for row in group], [row["error"] for row in group]
        if plane == "diagonal" and gravity != 2.0 and "inextensible" not in calibration:
            # What falls together is told apart by size.
            marker = {"second order": "o-", "thesis k_e=1e3": "s--", "thesis k_e=1e6": "^:"}[calibration]
            axes.plot(n, error, marker, markersize=8 if "1e3" in calibration else 4.5, fillstyle="none",
                      label=f"{calibration}, tip at {group[-1]['tip_angle']:.0f}°: n^{-order_of_n(group):.2f}")
    counts(axes, n)
    axes.set_ylim(bottom=3e-8)
    save(loc="lower left")


def order_of_dt(group: list[dict]) -> float:
    """From 0.005 s to 0.00031 s."""
    return exponent([row["dt"] for row in group[2:7]], [row["error"] for row in group[2:7]])


def order_in_dt() -> str:
    table = []
    for (case, scheme), group in grouped(read("order_in_dt"), "case", "scheme").items():
        table.append([case, scheme, *(f"{row['error']:.1e}" for row in group[::2]), f"{order_of_dt(group):.2f}"])
    return page("Error of the tip at t = 1 s against dt",
                ["case", "scheme", *(f"dt = {row['dt']:.3g}" for row in group[::2]), "order, dt = 0.005 … 0.00031"], table)


def draw_order_in_dt() -> None:
    """Error over the step, and over run time."""
    for (case,), of_case in grouped(read("order_in_dt"), "case").items():
        name = "pushed" if "pushed" in case else "free"
        by_dt, save_dt = figure(f"order_in_dt_{name}", ("dt, s", "error of the tip, relative"))
        by_time, save_time = figure(f"work_precision_{name}", ("run time, s", "error of the tip, relative"))
        sizes = dict(zip("osv^D", (8, 6.5, 5, 5, 4.5)))
        for ((scheme,), group), marker in zip(grouped(of_case, "scheme").items(), "osv^D"):
            dt, error = [row["dt"] for row in group], [row["error"] for row in group]
            style = {"markersize": sizes[marker], "fillstyle": "none", "linewidth": 1.2}
            label = scheme if name == "free" else f"{scheme}: dt^{order_of_dt(group):.2f}"
            by_dt.plot(dt, error, marker + "-", **style, label=label)
            by_time.plot([row["seconds"] for row in group], error, marker + "-", **style, label=scheme)
        save_dt()
        save_time()


def bending_models() -> str:
    rows = [[f"{row['gravity']:g}", f"{row['tip_angle']:.1f}", f"{row['invariant_diagonal']:.1e}",
             f"{row['projected_plane']:.1e}", f"{row['projected_diagonal']:.1e}"] for row in read("bending_models")]
    return page("Deflection against the invariant model in the plane, n = 128",
                ["g", "tip angle, °", "invariant, diagonal plane", "projected, plane", "projected, diagonal plane"], rows)


def csm3_energy() -> str:
    groups = grouped(read("csm3_energy"), "n", "dt", "scheme")
    table = defaultdict(dict)
    for (n, dt, scheme), group in groups.items():
        last = group[-1]
        ended = "" if last["time"] > 59 else f" (ended at {last['time']:.0f} s)"
        halved = f" ({last['halvings']:.0f} halvings)" if last["halvings"] else ""
        table[scheme][n, dt] = f"{last['energy']:+.1e}{ended}{halved}"
    cases = list(dict.fromkeys((n, dt) for n, dt, _ in groups))
    return page("Energy at the end of 60 s of CSM3, relative to the largest energy in gravity",
                ["scheme", *(f"n = {n:.0f}, dt = {dt:g} s" for n, dt in cases)],
                [[scheme, *(row.get(case, "") for case in cases)] for scheme, row in table.items()],
                "A run ends where the gain reaches what there is. Unwatched: under a root that is driven, but to where it is.")


def draw_csm3_energy() -> None:
    axes, save = figure("csm3_energy", ("time, s", "gain of energy / largest energy in gravity"), log=False)
    axes.set(ylim=(-0.15, 0.5))
    groups = grouped([row for row in read("csm3_energy") if (row["n"], row["dt"]) == (32.0, 0.02)], "scheme")
    for ((scheme,), group), dashes in zip(groups.items(), ("-", "-", "--", "-.", "-", ":")):
        axes.plot([row["time"] for row in group], [row["energy"] for row in group], dashes, label=f"{scheme}, dt = 0.02 s")
    save(loc="upper left")


def extreme() -> str:
    rows = read("extreme")
    kinds = lambda group: Counter(row["result"].split(" in step")[0] for row in group)  # noqa: E731
    table = []
    for (n, dt), group in grouped(rows, "n", "dt").items():
        count = kinds(group)
        good = [row for row in group if row["result"] == "ok"]
        others = ", ".join(f"{kind} {number}" for kind, number in count.items() if kind != "ok")
        table.append([f"{n:.0f}", f"{dt:g}", len(group), count["ok"], others,
                      f"{max(row['gain'] for row in good):.1e}", f"{max(row['loss'] for row in good):.1e}",
                      f"{max(row['iterations'] for row in group):.0f}", f"{max(row['worst_step_seconds'] for row in group):.3f}"])
    lines = ["n", "dt, s", "cells", "ok", "other", "largest gain (ok)", "largest loss (ok)", "most iterations a step",
             "longest step, s"]
    return page("Stiff cases", lines, table,
                "Each row: k_e = 1e3 … 1e9 N/m a segment times EI = 1e-6 … 1e3 N m², 50 steps of the default scheme from rest "
                "under the weight; gain and loss of energy relative to the largest energy that moved. `extreme.csv` has "
                "every cell with its error message.")


def situations() -> str:
    table = [[row["situation"], row["scheme"], row["result"].split(":")[0], f"{row['gain']:.1e}", f"{row['loss']:.1e}",
              f"{row['iterations']:.0f}", f"{row['substeps']:.0f}"] for row in read("situations")]
    return page("Extreme situations, n = 64 in space",
                ["situation", "scheme", "result", "gain", "loss", "most iterations a step", "most sub-steps"], table,
                "Energies count from the third step after the load is gone. `situations.csv` has the error messages.")


PAGES = (condition, runtime, order_in_n, order_in_dt, bending_models, csm3_energy, extreme, situations)
FIGURES = (draw_condition, draw_runtime, draw_deflection, draw_order_in_n, draw_order_in_dt, draw_csm3_energy)


def pages() -> dict[Path, str]:
    """docs/rod/*.md, of the CSV files beside them."""
    return {DOCS / f"{made.__name__}.md": made() for made in PAGES} | clamp.pages()


def main() -> None:
    for path, text in pages().items():
        path.write_text(text, encoding="utf-8")
    for draw in FIGURES:
        draw()


if __name__ == "__main__":
    main()
