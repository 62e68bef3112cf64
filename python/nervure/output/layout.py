"""Axes in true proportions, with a bar beside them that is as high as they are."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

LEFT, RIGHT, BOTTOM, TOP = 0.85, 1.1, 0.55, 0.35  # Margins, in
GAPS = (0.45, 0.3)  # Between axes side by side and below each other, in
TALLEST = 7.5  # Largest height of the axes together, in
BAR, ASIDE = 0.12, 0.22  # Width of a bar and its distance from the axes, in
TICK = (0.75, 0.3)  # Least distance of ticks along x and y, in
STEPS = [1, 2, 2.5, 5, 10]  # Distances of ticks, times a power of ten


def grid(width: float, columns: Sequence[float], rows: Sequence[float], top: float = TOP) -> tuple[Figure, np.ndarray]:
    """Return a figure of `width` (in) with axes `[rows, columns]` below a margin `top` (in). `columns` and `rows` are
    widths and heights (m), all to one scale."""
    gaps_across, gaps_up = (len(columns) - 1) * GAPS[0], (len(rows) - 1) * GAPS[1]
    room = width - LEFT - RIGHT - gaps_across
    scale = min(room / sum(columns), (TALLEST - gaps_up) / sum(rows))
    height = BOTTOM + scale * sum(rows) + gaps_up + top
    figure = Figure(figsize=(width, height))
    axes = np.empty((len(rows), len(columns)), dtype=object)
    y = height - top
    for row, high in enumerate(rows):
        y -= scale * high
        x = LEFT + (room - scale * sum(columns)) / 2  # of axes that are high and narrow
        for column, wide in enumerate(columns):
            place = (x / width, y / height, scale * wide / width, scale * high / height)
            axes[row, column] = axis = figure.add_axes(place)
            axis.xaxis.set_major_locator(ticks(scale * wide / TICK[0]))
            axis.yaxis.set_major_locator(ticks(scale * high / TICK[1]))
            x += scale * wide + GAPS[0]
        y -= GAPS[1]
    return figure, axes


def ticks(most: float) -> MaxNLocator:
    return MaxNLocator(min(10, max(2, int(most))), steps=STEPS)


def label_outer(axes: np.ndarray) -> None:
    """Keep the labels of the lowest axes of a column and of the first of a row."""
    for axis in axes[:-1].flat:
        axis.set_xlabel("")
        axis.tick_params(labelbottom=False)
    for axis in axes[:, 1:].flat:
        axis.set_ylabel("")
        axis.tick_params(labelleft=False)


def bar(figure: Figure, axes: np.ndarray) -> tuple[Axes, float, MaxNLocator]:
    """Return axes for a colour bar on the right of `axes`, as high as all of them together, the height of the triangles
    at its ends, relative to the bar, and its ticks."""
    low, high = axes[-1, -1].get_position(), axes[0, 0].get_position()
    width, inches = figure.get_figwidth(), (high.y1 - low.y0) * figure.get_figheight()
    place = figure.add_axes((low.x1 + ASIDE / width, low.y0, BAR / width, high.y1 - low.y0))
    located = MaxNLocator(min(8, max(2, int(inches / TICK[1]))), steps=STEPS)
    return place, min(0.1, 1.5 * BAR / inches), located
