"""What the studies share: CSV in, Markdown tables and figures out."""

import csv
from collections import defaultdict
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

# Okabe & Ito's colours, told apart without colour vision and in print.
plt.rcParams["axes.prop_cycle"] = plt.cycler(
    color=["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]
)


def read(folder: Path, name: str) -> list[dict]:
    """Rows of NAME.csv with numbers as floats and empty cells as None."""

    def value(text):
        try:
            return float(text) if text else None
        except ValueError:
            return text

    with open(folder / f"{name}.csv", encoding="utf-8", newline="") as file:
        return [{key: value(text) for key, text in row.items()} for row in csv.DictReader(file)]


def markdown(header: list[str], rows: list[list]) -> list[str]:
    """Lines of a table."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]


def page(title: str, header: list[str], rows: list[list], note: str = "") -> str:
    """One table as a page of its own."""
    lines = [f"# {title}", ""]
    if note:
        lines += [note, ""]
    return "\n".join(lines + markdown(header, rows)) + "\n"


def exponent(x, y) -> float:
    """Slope of the straight line through log y over log x."""
    return np.polyfit(np.log(x), np.log(y), 1)[0]


def figure(folder: Path, name: str, axes_labels: tuple[str, str], log: bool = True):
    """A figure to draw on, and a function that saves it."""
    fig, axes = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
    axes.set(xlabel=axes_labels[0], ylabel=axes_labels[1])
    if log:
        axes.set(xscale="log", yscale="log")
    axes.grid(True, which="major", linewidth=0.4, alpha=0.6)

    def save(**legend):
        axes.legend(fontsize=8, **legend)
        fig.savefig(folder / f"{name}.png", dpi=130, metadata={"Software": None})
        plt.close(fig)

    return axes, save


def grouped(rows: list[dict], *keys: str) -> dict[tuple, list[dict]]:
    groups = defaultdict(list)
    for row in rows:
        groups[tuple(row[key] for key in keys)].append(row)
    return groups
