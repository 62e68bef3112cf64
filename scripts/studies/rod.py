"""Tables and figures of the rod's studies: reads docs/rod/*.csv, writes the Markdown and PNG files beside them."""

import sys
from collections import Counter, defaultdict
from pathlib import Path

import numpy as np
from matplotlib.ticker import FixedLocator, NullFormatter, StrMethodFormatter

sys.path.insert(0, str(Path(__file__).parents[1]))

from studies.tables import exponent, figure, grouped, read, write

THESIS_CONDITION = {
    (5e4, 1e-3): [527168.64, 6301043.05, 60404887.40, 530612724.29, 4606965436.28],
    (1e5, 1e-3): [705920.26, 6389968.51, 60256883.66, 532383835.99, 3850664611.25],
    (2e5, 1e-3): [1752600.66, 6571857.76, 60968369.21, 499121585.93, 4375584326.29],
    (1e5, 1e-2): [1156286.06, 9035572.09, 70029681.81, 714462652.81, 14672886774.30],
}
"""Tables 2.1 and 2.2 of the thesis: condition numbers by (k_e, dt) for n = 32 … 512."""

STEPS = 10_000
"""Time steps of the runs of the thesis' table 2.3, about."""


def counts(axes, numbers) -> None:
    """Ticks of a logarithmic axis at these numbers of segments."""
    axes.xaxis.set_major_locator(FixedLocator(list(numbers)))
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:.0f}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.tick_params(axis="x", which="minor", length=0)


def condition(folder: Path) -> None:
    """Tables 2.1 and 2.2, figure 2.5."""
    axes, save = figure(folder, "condition", ("mass points n", "condition number, 1-norm"))
    rows = []
    # One on top of the other: the larger ones below, and hollow.
    markers = zip("osv^", (13, 9.5, 6.5, 5))
    for ((k_e, dt), group), (marker, size) in zip(grouped(read(folder, "condition"), "k_e", "dt").items(), markers):
        n, full = [row["n"] for row in group], [row["full"] for row in group]
        thesis = THESIS_CONDITION[k_e, dt]
        label = f"k_e = {k_e:g} N/m, dt = {dt:g} s: n^{exponent(n, full):.2f}"
        (line,) = axes.plot(n, full, marker, markersize=size, fillstyle="none", label=label)
        axes.plot(n, thesis, "--", color=line.get_color(), linewidth=1)
        eliminated = [row["eliminated"] for row in group]
        if k_e == 1e5:
            axes.plot(n, eliminated, ":", color=line.get_color(), label=f"velocities eliminated, dt = {dt:g} s")
        for row, printed in zip(group, thesis):
            rows.append(
                [f"{k_e:g}", f"{dt:g}", f"{row['n']:.0f}", f"{row['order']:.0f}", f"{printed:.4e}", f"{row['full']:.4e}",
                 f"{row['full'] / printed:.2f}", f"{row['eliminated']:.3e}"]
            )
    axes.plot([], [], "k--", linewidth=1, label="thesis, tables 2.1 and 2.2")
    counts(axes, n)
    save(loc="lower right")
    write(
        folder,
        "condition",
        "Condition numbers (thesis tables 2.1 and 2.2, figure 2.5)",
        ["k_e", "dt", "n", "order", "thesis", "here", "ratio", "velocities eliminated"],
        rows,
        "1-norm of the full Jacobian [[1, -dt/2], [dt/2 K, m]] of order 6(n - 1), straight rod, L = EI = mu = 1, h = L/n, "
        "m = mu h, clamp spring EI/h. Last column: the matrix that the solver factorises, K + 4 m/dt².",
    )


def runtime(folder: Path) -> None:
    """Table 2.3 and figure 2.6."""
    rows = read(folder, "runtime")
    n = np.array([row["n"] for row in rows])
    table = []
    totals = {"banded": [], "sparse": [], "dense": []}
    for row in rows:
        rest = row["iteration_3d"] - row["banded"]
        cells = [f"{row['n']:.0f}"]
        for solver, values in totals.items():
            total = STEPS * row["iterations_per_step"] * (rest + row[solver]) if row[solver] else None
            values.append(total or np.nan)
            cells.append(f"{total:.3g}" if total else "")
        cells += [f"{row[key]:.6g}" if row[key] else "" for key in ("thesis_sparse", "thesis_dense")]
        cells += [f"{1e6 * row[key]:.1f}" if row[key] else "" for key in
                  ("iteration_3d", "iteration_2d", "banded", "sparse", "dense")]
        cells += [f"{row['iteration_3d'] / row['iteration_2d']:.2f}", f"{row['sparse'] / row['banded']:.2f}"]
        table.append(cells)
    axes, save = figure(folder, "runtime", ("segments n", f"seconds for {STEPS} steps"))
    fitted = []
    for (name, values), marker in zip(totals.items(), "osv"):
        values = np.array(values)
        used = np.isfinite(values) & (n >= 64)
        slope = exponent(n[used], values[used])
        fitted.append(f"{name} n^{slope:.2f}")
        axes.plot(n, values, marker + "-", label=f"{name}: n^{slope:.2f} from 64 on")
    for key, style in (("thesis_sparse", "k--"), ("thesis_dense", "k:")):
        known = [row for row in rows if row[key]]
        late = [row for row in known if row["n"] >= 128]
        slope = exponent([row["n"] for row in late], [row[key] for row in late])
        fitted.append(f"{key.replace('_', ' ')} n^{slope:.2f} from 128 on")
        axes.plot([row["n"] for row in known], [row[key] for row in known], style,
                  label=f"{key.replace('_', ', ')}: n^{slope:.2f} from 128 on")
    counts(axes, n)
    save()
    iteration = exponent(n[n >= 64], [row["iteration_3d"] for row in rows if row["n"] >= 64])
    write(
        folder,
        "runtime",
        "Run time against n (thesis table 2.3, figure 2.6)",
        ["n", "banded, s", "sparse, s", "dense, s", "thesis sparse, s", "thesis dense, s", "iteration 3D, µs",
         "iteration 2D, µs", "banded solve, µs", "faer sparse, µs", "faer dense, µs", "3D/2D", "sparse/banded"],
        table,
        f"Seconds for {STEPS} steps of TR-BDF2 in space, one core: two solves a step, each iteration with the library's derivatives, "
        "assembly and check and the factorise-and-solve of the column. The thesis: MATLAB. "
        f"Exponents from n = 64 on: {', '.join(fitted)}; one iteration n^{iteration:.2f}.",
    )


def deflection(folder: Path) -> None:
    """Figure 2.7."""
    axes, save = figure(folder, "deflection", ("x/L", "y/L"), log=False)
    colours = {"second order": "C0", "thesis k_e=1e3": "C1"}
    styles = {8.0: ":", 32.0: "--", 128.0: "-"}
    for (model, n), group in grouped(read(folder, "deflection"), "model", "n").items():
        x, y = [row["x"] for row in group], [row["y"] for row in group]
        if model == "elastica":
            axes.plot(x, y, "k-", linewidth=5, alpha=0.25, label="exact elastica")
        elif model in colours:
            axes.plot(x, y, styles[n], color=colours[model], linewidth=1.4, label=f"{model}, n = {n:.0f}")
    save(loc="lower left")


def orders(folder: Path) -> None:
    """Order of convergence in n and dt, error against run time."""
    rows = read(folder, "order_in_n")
    axes, save = figure(folder, "order_in_n", ("segments n", "error of the tip / deflection"))
    table = []
    for (calibration, plane, gravity), group in grouped(rows, "calibration", "plane", "gravity").items():
        n, error = [row["n"] for row in group], [row["error"] for row in group]
        if plane == "diagonal" and gravity != 2.0 and "inextensible" not in calibration:
            # What falls together is told apart by size.
            marker = {"second order": "o-", "thesis k_e=1e3": "s--", "thesis k_e=1e6": "^:"}[calibration]
            axes.plot(n, error, marker, markersize=8 if "1e3" in calibration else 4.5, fillstyle="none",
                      label=f"{calibration}, tip at {group[-1]['tip_angle']:.0f}°: n^{exponent(n[2:5], error[2:5]):.2f}")
        table.append([calibration, plane, f"{group[-1]['tip_angle']:.1f}", *(f"{e:.2e}" for e in error),
                      f"{-exponent(n[2:5], error[2:5]):.2f}"])
    counts(axes, n)
    axes.set_ylim(bottom=3e-8)
    save(loc="lower left")
    write(folder, "order_in_n", "Error of the tip against the exact elastica, relative to the deflection",
          ["calibration", "plane", "tip angle, °", *(f"n = {row['n']:.0f}" for row in group), "order, 32 … 128"], table)

    rows = read(folder, "order_in_dt")
    table = []
    for (case,), of_case in grouped(rows, "case").items():
        name = "pushed" if "pushed" in case else "free"
        by_dt, save_dt = figure(folder, f"order_in_dt_{name}", ("dt, s", "error of the tip, relative"))
        by_time, save_time = figure(folder, f"work_precision_{name}", ("run time, s", "error of the tip, relative"))
        sizes = dict(zip("osv^D", (8, 6.5, 5, 5, 4.5)))
        for ((scheme,), group), marker in zip(grouped(of_case, "scheme").items(), "osv^D"):
            dt, error = [row["dt"] for row in group], [row["error"] for row in group]
            order = exponent(dt[2:7], error[2:7])
            style = {"markersize": sizes[marker], "fillstyle": "none", "linewidth": 1.2}
            by_dt.plot(dt, error, marker + "-", **style, label=scheme if name == "free" else f"{scheme}: dt^{order:.2f}")
            by_time.plot([row["seconds"] for row in group], error, marker + "-", **style, label=scheme)
            table.append([case, scheme, *(f"{e:.1e}" for e in error[::2]), f"{order:.2f}"])
        save_dt()
        save_time()
    write(folder, "order_in_dt", "Error of the tip at t = 1 s against dt",
          ["case", "scheme", *(f"dt = {row['dt']:.3g}" for row in group[::2]), "order, dt = 0.005 … 0.00031"], table)


def bending_models(folder: Path) -> None:
    rows = [[f"{row['gravity']:g}", f"{row['tip_angle']:.1f}", f"{row['invariant_diagonal']:.1e}",
             f"{row['projected_plane']:.1e}", f"{row['projected_diagonal']:.1e}"] for row in read(folder, "bending_models")]
    write(folder, "bending_models", "Deflection against the invariant model in the plane, n = 128",
          ["g", "tip angle, °", "invariant, diagonal plane", "projected, plane", "projected, diagonal plane"], rows)


def energy(folder: Path) -> None:
    groups = grouped(read(folder, "csm3_energy"), "n", "dt", "scheme")
    axes, save = figure(folder, "csm3_energy", ("time, s", "gain of energy / largest energy in gravity"), log=False)
    axes.set(ylim=(-0.15, 0.5))
    dashes = dict(zip(dict.fromkeys(scheme for *_, scheme in groups), ("-", "--", "-.", "-", ":")))
    table = defaultdict(dict)
    for (n, dt, scheme), group in groups.items():
        drift = [row["energy"] for row in group]
        ended = "" if group[-1]["time"] > 59 else f" (ended at {group[-1]['time']:.0f} s)"
        table[scheme][n, dt] = f"{drift[-1]:+.1e}{ended}"
        if (n, dt) == (32.0, 0.02):
            axes.plot([row["time"] for row in group], drift, dashes[scheme], label=f"{scheme}, dt = {dt:g} s")
    save(loc="upper left")
    cases = list(dict.fromkeys((n, dt) for n, dt, _ in groups))
    write(folder, "csm3_energy", "Energy at the end of 60 s of CSM3, relative to the largest energy in gravity",
          ["scheme", *(f"n = {n:.0f}, dt = {dt:g} s" for n, dt in cases)],
          [[scheme, *(row.get(case, "") for case in cases)] for scheme, row in table.items()],
          "A run ends where the gain reaches what there is.")


def extreme(folder: Path) -> None:
    rows = read(folder, "extreme")
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
    write(folder, "extreme", "Stiff cases", lines, table,
          "Each row: k_e = 1e3 … 1e9 N/m a segment times EI = 1e-6 … 1e3 N m², 50 steps of the default scheme from rest "
          "under the weight; gain and loss of energy relative to the largest energy that moved. `extreme.csv` has "
          "every cell with its error message.")
    table = [[row["situation"], row["scheme"], row["result"].split(":")[0], f"{row['gain']:.1e}", f"{row['loss']:.1e}",
              f"{row['iterations']:.0f}", f"{row['substeps']:.0f}"] for row in read(folder, "situations")]
    write(folder, "situations", "Extreme situations, n = 64 in space",
          ["situation", "scheme", "result", "gain", "loss", "most iterations a step", "most sub-steps"], table,
          "Energies count from the third step after the load is gone.")


def main() -> None:
    folder = Path(sys.argv[1])
    for study in (condition, runtime, deflection, orders, bending_models, energy, extreme):
        study(folder)


if __name__ == "__main__":
    main()
