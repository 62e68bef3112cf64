"""Draws fmu-rod/model.png and fmu-fluid/model.png, the pictures that masters show of the units.

PYTHONPATH=scripts python scripts/studies/icons.py
"""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from nervure.resources import ROOT

SIZE = 2.0
"""Edge of a picture, inches of 100 pixels."""


def canvas(low: float, high: float):
    figure = plt.figure(figsize=(SIZE, SIZE), dpi=100)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(low, high), ylim=(low, high), aspect="equal")
    axes.axis("off")
    return figure, axes


def rod() -> plt.Figure:
    """A clamped chain of mass points, bent."""
    figure, axes = canvas(-0.15, 1.15)
    s = np.linspace(0, 1, 8)
    axes.plot(0.05 + s, 0.35 + 0.4 * s**2, "o-", color="#D55E00", linewidth=4, markersize=9)
    axes.fill_between([-0.05, 0.05], 0.1, 0.6, hatch="///", facecolor="none", edgecolor="#444444", linewidth=2)
    return figure


def fluid() -> plt.Figure:
    """Streamlines of the flow around a cylinder."""
    figure, axes = canvas(-3, 3)
    x, y = np.meshgrid(np.linspace(-3, 3, 400), np.linspace(-3, 3, 400))
    radius2 = x**2 + y**2
    stream = np.where(radius2 > 1, y * (1 - 1 / np.maximum(radius2, 1e-9)), np.nan)
    axes.contour(x, y, stream, levels=np.linspace(-2.85, 2.85, 20), colors="#0072B2", linestyles="solid", linewidths=1.5)
    axes.add_patch(plt.Circle((0, 0), 1, color="#444444"))
    return figure


if __name__ == "__main__":
    for draw in (rod, fluid):
        draw().savefig(ROOT / f"fmu-{draw.__name__}" / "model.png", metadata={"Software": None})
