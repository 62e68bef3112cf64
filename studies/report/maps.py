"""The maps of stability: which runs on stiff and extreme cases went to the end, and which did not."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D

from studies import coupling, show, simulate
from studies.show import markdown
from studies.store import Data

LISTED: dict[str, Any] = simulate.LISTED["report"]

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
    for record in coupling.mapped(data):
        place = {"density ratio": record["ratio"], "C_eta": record["c_eta"]}
        name = f"{record['scheme']}, {told(place)}, H {record['step']:g}, to {record['end']:g} s"
        found["coupling"].append((name, place, coupling.outcome(record), record.error or ""))
    return found


def counts(data: Data) -> list[dict[str, Any]]:
    """Cells by outcome."""
    by_map = {name: Counter(outcome for _, _, outcome, _ in cells) for name, cells in map_cells(data).items()}
    none = {"ok": 0, "error": 0, "bad": 0}
    return [
        none | count | {"map": name, "over": LISTED["maps"][name], "cells": count.total()}
        for name, count in by_map.items()
    ]


def failed(data: Data) -> list[str]:
    """Cells that did not end well."""
    cells = [(name, *cell) for name, part in map_cells(data).items() for cell in part if cell[2] != "ok"]
    rows = [[name, cell, outcome, said[:110]] for name, cell, _, outcome, said in cells]
    return markdown(["map", "cell", "outcome", "reason"], rows)


AXES = {"dt": "step [s]", "k_e": "$k_e$ [N/m]", "EI": "EI [N m²]", "C_eta": "$C_\\eta$ [s]", "Re": "Reynolds number"}
OUTCOMES = {"ok": ("#56B4E9", "ok"), "error": ("#E69F00", "error (e): says so"), "bad": ("#000000", "bad (b)")}


def draw(data: Data) -> None:
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
    show.save(figure, "pictures/maps")
