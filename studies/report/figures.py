"""The figures of docs/report, from rows and series of results.json."""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from .cases import QUANTITIES, references
from .convergence import front
from .store import Row

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")
"""Okabe & Ito's, told apart without colour vision; each line has a marker of its own besides, for print."""

MARKERS = "osv^Dp*hX"

LABELS = {
    "cd_mean": "$c_D$",
    "cl_mean": "$c_L$",
    "dp_mean": "$\\Delta p$",
    "cd_max": "$c_D$ max",
    "cl_peak_to_peak": "$c_L$ peak to peak",
    "st": "St",
    "tip_ux": "$u_x$",
    "tip_uy": "$u_y$",
    "drag": "drag",
    "lift": "lift",
    "frequency_hz": "frequency",
}

OUTCOMES = {"ok": "#56B4E9", "error": "#E69F00", "bad": "#000000"}


def label(quantity: str) -> str:
    return " ".join(LABELS.get(part, part) for part in quantity.split("."))


def save(fig, path: Path) -> None:
    fig.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(fig)


def few_labels(axis) -> None:
    """On a logarithmic axis: labels at 1, 2 and 5 times powers of ten where there are few decades, and no others."""
    low, high = axis.get_view_interval()
    decades = np.log10(high / low)
    axis.set_major_locator(
        LogLocator(subs=(1.0,) if decades > 2 else (1.0, 2.0, 5.0) if decades > 0.5 else np.arange(1.0, 10.0, 0.5))
    )
    axis.set_minor_formatter(NullFormatter())
    if decades <= 2:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / 1e3:g} k" if value >= 1e4 else f"{value:g}"))


def error_time(path: Path, rows: list[Row], quantities: tuple[str, ...], kind: str = "error") -> None:
    """Error over wall time (above) and CPU time (below), a column for each quantity. Failed runs are crosses at the
    upper edge."""
    methods = list(dict.fromkeys(row.method for row in rows))
    fig, axes = plt.subplots(
        2, len(quantities), figsize=(3.7 * len(quantities), 6.4), layout="constrained", squeeze=False, sharey="col"
    )
    for column, quantity in enumerate(quantities):
        for line, cost in enumerate(("wall", "cpu")):
            axis, points = axes[line, column], []
            for k, method in enumerate(methods):
                found = [
                    row
                    for row in rows
                    if row.method == method
                    and row.quantity == quantity
                    and getattr(row, f"{cost}_s")
                    and getattr(row, kind) is not None
                ]
                found.sort(key=lambda row: getattr(row, f"{cost}_s"))
                if not found:
                    continue
                x = np.array([getattr(row, f"{cost}_s") for row in found])
                y = np.array([max(abs(getattr(row, kind)), 1e-8) for row in found])
                low, high = (
                    np.array([getattr(row, f"{cost}_{q}") or v for row, v in zip(found, x)]) for q in ("q1", "q3")
                )
                cited = found[0].source == "cited"
                axis.errorbar(
                    x,
                    y,
                    xerr=[x - low, high - x],
                    marker=MARKERS[k % len(MARKERS)],
                    color=COLOURS[k % len(COLOURS)],
                    capsize=2,
                    fillstyle="none" if cited else "full",
                    markersize=5,
                    linewidth=0 if cited else 1,
                    elinewidth=0.8,
                )
                points += list(zip(x, y))
            if points:
                chosen = front(points)
                axis.step(
                    *zip(*[points[i] for i in chosen]), where="post", color="#000000", linewidth=3, alpha=0.15, zorder=0
                )
            failed = [row for row in rows if row.outcome != "ok"]
            if failed:
                axis.plot(
                    [0.98] * len(failed),
                    np.linspace(0.98, 0.9, len(failed)),
                    "x",
                    color="#000000",
                    transform=axis.transAxes,
                )
            axis.set(xscale="log", yscale="log", xlabel=f"{'wall' if cost == 'wall' else 'CPU'} time [s]")
            few_labels(axis.xaxis)
            few_labels(axis.yaxis)
            axis.grid(True, which="major", linewidth=0.4, alpha=0.6)
        axes[0, column].set_title(label(quantity), fontsize=10)
    for axis in axes[:, 0]:
        axis.set_ylabel("relative error" if kind == "error" else "discretisation error, relative")
    handles = [
        Line2D([], [], color=COLOURS[k % len(COLOURS)], marker=MARKERS[k % len(MARKERS)], label=method)
        for k, method in enumerate(methods)
    ]
    handles.append(Line2D([], [], color="#000000", linewidth=3, alpha=0.15, label="Pareto front"))
    fig.legend(handles=handles, loc="outside lower center", ncols=min(4, len(handles)), fontsize=8)
    save(fig, path)


def bands(path: Path, series: dict[str, dict], spread: dict) -> None:
    """Two periods of FSI3 on each grid, in the band of the published amplitudes around the published mean."""
    names = ("tip_ux", "tip_uy", "drag", "lift")
    units = {
        "tip_ux": ("$u_x$ [mm]", 1e3),
        "tip_uy": ("$u_y$ [mm]", 1e3),
        "drag": ("drag [N/m]", 1.0),
        "lift": ("lift [N/m]", 1.0),
    }
    fig, axes = plt.subplots(2, 2, figsize=(9.5, 6), layout="constrained", sharex=True)
    published = references("fsi3")
    for axis, name in zip(axes.flat, names):
        title, factor = units[name]
        mean, amplitude = published[f"{name}.mean"][0], published[f"{name}.amplitude"][0]
        low, high = spread[name]["amplitude"]
        for sign in (-1, 1):
            edges = sorted((mean + sign * low, mean + sign * high))
            axis.axhspan(edges[0] * factor, edges[1] * factor, color="#999999", alpha=0.35, linewidth=0)
            axis.axhline((mean + sign * amplitude) * factor, color="#000000", linewidth=0.8, linestyle=":")
        for k, (grid, lines) in enumerate(series.items()):
            values = factor * np.array(lines[name])
            axis.plot(
                lines["phase"], values, ("-", "--", "-.", ":")[k % 4], color=COLOURS[k], linewidth=1.3, label=grid
            )
        axis.set_ylabel(title)
        axis.grid(True, linewidth=0.4, alpha=0.6)
    for axis in axes[1]:
        axis.set_xlabel("periods of $u_y$")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    handles += [Line2D([], [], color="#999999", alpha=0.5, linewidth=6), Line2D([], [], color="#000000", linestyle=":")]
    fig.legend(
        handles,
        [*labels, "published spread of the extremes", "FeatFlow, level 4"],
        loc="outside lower center",
        ncols=6,
        fontsize=8,
    )
    save(fig, path)


def outcome_map(axis, columns: list, lines: list, cells: dict, x: str, y: str, title: str) -> None:
    """Cells coloured by their worst outcome; failed ones have a letter as well. `cells`: outcomes by (line, column)."""
    rank = {"ok": 0, "error": 1, "bad": 2}
    table = np.full((len(lines), len(columns)), np.nan)
    for (line, column), outcomes in cells.items():
        table[lines.index(line), columns.index(column)] = max(rank[o] for o in outcomes)
    axis.imshow(table, cmap=ListedColormap(list(OUTCOMES.values())), vmin=-0.5, vmax=2.5, aspect="auto", origin="lower")
    for (i, j), value in np.ndenumerate(table):
        if value == value and value > 0:
            axis.text(
                j, i, " eb"[int(value)], ha="center", va="center", fontsize=8, color="black" if value == 1 else "white"
            )
    axis.set_xticks(range(len(columns)), columns, fontsize=7, rotation=45)
    axis.set_yticks(range(len(lines)), lines, fontsize=7)
    axis.set_xlabel(x, fontsize=8)
    axis.set_ylabel(y, fontsize=8)
    axis.set_title(title, fontsize=9)


def parsed(setting: str) -> dict[str, str]:
    """`a = 1, b 2` as a dictionary."""
    found = {}
    for part in setting.split(", "):
        name, _, value = part.replace(" = ", " ").rpartition(" ")
        found[name] = value
    return found


def ordered(values) -> list[str]:
    return sorted(set(values), key=float)


MAPS = (
    ("map rod", None, "dt", "k_e", "rod, worst over n and EI"),
    ("map rod", None, "n", "EI", "rod, worst over $k_e$ and step"),
    ("map fluid", "Backward differences, log-linear mask", "CFL", "Re", "fluid, worst over $C_\\eta$"),
    ("map fluid", "Heun's method, sharp mask", "C_eta", "CFL", "fluid, Heun's method, worst over Re"),
    ("map coupling", "default", "C_eta", "density ratio", "coupling: the default"),
    ("map coupling", "pressure jump", "C_eta", "density ratio", "coupling: pressure jump, explicit"),
)

AXES = {
    "dt": "step [s]",
    "k_e": "$k_e$ [N/m]",
    "EI": "EI [N m²]",
    "n": "segments n",
    "C_eta": "$C_\\eta$ [s]",
    "Re": "Reynolds number",
}


def maps(path: Path, rows: list[Row]) -> None:
    """Rod over stiffness, step and segments, fluid over C_eta, CFL and Re, coupling over density ratio and C_eta."""
    fig, axes = plt.subplots(2, 3, figsize=(12, 7.4), layout="constrained")
    for axis, (name, method, x, y, title) in zip(axes.flat, MAPS):
        cells: dict = {}
        for row in rows:
            if row.case == name and method in (None, row.method):
                at = parsed(row.setting)
                cells.setdefault((at[y], at[x]), []).append(row.outcome)
        columns, lines = ordered(column for _, column in cells), ordered(line for line, _ in cells)
        outcome_map(axis, columns, lines, cells, AXES.get(x, x), AXES.get(y, y), title)
    handles = [
        Line2D(
            [],
            [],
            marker="s",
            linewidth=0,
            color=colour,
            label=name + {"error": " (e): says so", "bad": " (b)"}.get(name, ""),
        )
        for name, colour in OUTCOMES.items()
    ]
    fig.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8)
    save(fig, path)


def cost(path: Path, groups: dict[str, tuple[str, list[tuple[float, float]]]]) -> None:
    """Cost over size with the fitted exponent. `groups`: name → (label of x, points)."""
    fig, axes = plt.subplots(
        -(-len(groups) // 3), 3, figsize=(12, 3.6 * -(-len(groups) // 3)), layout="constrained", squeeze=False
    )
    for axis in axes.flat[len(groups) :]:
        axis.set_visible(False)
    for axis, (name, (xlabel, points)) in zip(axes.flat, groups.items()):
        x, y = map(np.array, zip(*sorted(points)))
        slope, offset = np.polyfit(np.log(x), np.log(y), 1)
        axis.plot(x, y, "o", color=COLOURS[0])
        axis.plot(x, np.exp(offset) * x**slope, "--", color=COLOURS[1], label=f"exponent {slope:.2f}")
        axis.set(xscale="log", yscale="log", xlabel=xlabel, ylabel="µs")
        if max(y) < 2 * min(y):
            axis.set_ylim(min(y) / 3, max(y) * 3)  # what does not depend on x shall look like it
        axis.set_title(name, fontsize=9)
        few_labels(axis.xaxis)
        axis.grid(True, which="major", linewidth=0.4, alpha=0.6)
        axis.legend(fontsize=8)
    save(fig, path)


def quantities_of(case: str) -> tuple[str, ...]:
    return {"fsi3": ("tip_uy.amplitude", "tip_uy.frequency_hz", "drag.mean", "lift.amplitude")}.get(
        case, QUANTITIES[case]
    )
