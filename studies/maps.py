"""The maps of stability: outcomes of runs with stiff rods, unresolved flows and light rods in a fluid."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D

from studies import coupling, show
from studies.store import Data

Cell = tuple[dict[str, float], str]
"""Place on the axes, and outcome: `ok`, `error` or `bad`."""


def rods(data: Data) -> list[Cell]:
    """Return the cells of the stiff rods, which are stored as the values tried and those that failed."""
    extreme = data["rod/study/extreme"].tables
    tried = {row["axis"]: row["values"] for row in extreme["tried"]}
    failed = {tuple(row[key] for key in tried): row["result"] for row in extreme.get("failed", [])}
    cells = []
    for at in np.stack(np.meshgrid(*tried.values()), -1).reshape(-1, len(tried)).tolist():
        result = failed.get(tuple(at), "ok")
        # A gain of energy without an error is bad.
        outcome = "ok" if result == "ok" else "bad" if result.startswith("gain") else "error"
        cells.append((dict(zip(tried, at)), outcome))
    return cells


def fluids(data: Data, group: str) -> list[Cell]:
    rows = data["fluid-measures/crate/stability"].tables["stability"]
    return [
        ({"Re": row["reynolds"], "CFL": row["cfl"], "C_eta": row["c_eta"]}, row["outcome"])
        for row in rows
        if row["scene"] is None and row["group"].startswith(group)
    ]


def couplings(data: Data, scheme: str) -> list[Cell]:
    return [
        ({"density ratio": record["ratio"], "C_eta": record["c_eta"]}, coupling.outcome(record))
        for record in coupling.mapped(data)
        if record["scheme"].split(",")[0] == scheme
    ]


AXES = {"dt": "step [s]", "k_e": "$k_e$ [N/m]", "EI": "EI [N m²]", "C_eta": "$C_\\eta$ [s]", "Re": "Reynolds number"}
OUTCOMES = {"ok": ("#56B4E9", "ok"), "error": ("#E69F00", "error (e): says so"), "bad": ("#000000", "bad (b)")}


def draw(data: Data) -> None:
    """Draw cells coloured by their worst outcome; failed cells have a letter as well."""
    figure, axes = show.panel(2, 3, (12, 7.4))
    rank = list(OUTCOMES)
    colours = ListedColormap([colour for colour, _ in OUTCOMES.values()])
    heun, default, jump = "Heun's method, sharp mask", couplings(data, "default"), couplings(data, "pressure jump")
    drawn: list[tuple[str, list[Cell], str, str]] = [
        ("rod, worst over n and EI", rods(data), "dt", "k_e"),
        ("rod, worst over $k_e$ and step", rods(data), "n", "EI"),
        ("fluid, worst over $C_\\eta$", fluids(data, "Backward differences, log-linear mask"), "CFL", "Re"),
        ("fluid, Heun's method, worst over Re", fluids(data, heun), "C_eta", "CFL"),
        ("coupling: the default", default, "C_eta", "density ratio"),
        ("coupling: pressure jump, explicit", jump, "C_eta", "density ratio"),
    ]
    for axis, (title, found, x, y) in zip(axes.flat, drawn):
        cells = [(at[y], at[x], rank.index(outcome)) for at, outcome in found]
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
    show.save(figure, "pictures/maps")
