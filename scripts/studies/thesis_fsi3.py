"""What docs/fsi3/thesis.md has of finished runs: extremes over the thesis' window, settled motion, growth of short waves.

    python scripts/studies/thesis_fsi3.py results/fsi3-thesis-325x72 …
"""

import json
import sys
from pathlib import Path

import numpy as np

WINDOWS = ((1.1, 4.375), (3.5, 4.375))
"""Over which the thesis takes its extremes (table 4.2), and the part that it calls more accurate, s."""

PIECE, TREND = 0.02, 4
"""Length of the pieces in which short waves are looked for, s, and the degree of the polynomial that is not a wave."""

LARGE = 1.0
"""Velocity of the tip, m/s, up to which a wave grows exponentially."""


def extremes(series: np.ndarray, begin: float, end: float) -> str:
    """Largest and smallest drag and lift (N/m) and deflection (mm) from `begin` to `end` (s), unfiltered."""
    part = (series["time"] >= begin) & (series["time"] <= end)
    if not part.any():
        return f"ends before {begin} s"
    cells = [f"{begin} to {end} s:"]
    for name, factor, digits in (("drag", 1, 0), ("lift", 1, 0), ("tip_uy", 1e3, 1)):
        values = series[name][part] * factor
        cells.append(f"{name} {values.max():.{digits}f} / {values.min():.{digits}f}")
    return " ".join(cells)


def settled(summary: dict) -> str:
    """Mean ± amplitude [frequency] (mm, N/m, Hz) over the summary's own window."""
    cells = ["settled:"]
    for name, factor in (("tip_ux", 1e3), ("tip_uy", 1e3), ("drag", 1), ("lift", 1)):
        q = summary["quantities"][name]
        frequency = "–" if q["frequency_hz"] is None else f"{q['frequency_hz']:.2f}"
        cells.append(f"{name} {q['mean'] * factor:.2f} ± {q['amplitude'] * factor:.2f} [{frequency}]")
    return " ".join(cells)


def growth(series: np.ndarray) -> str:
    """Rate at which the waves in the tip's velocity that are shorter than a piece grow or decay, 1/s."""
    time, sizes = series["time"], []
    starts = np.arange(2 * PIECE, time[-1] - PIECE, PIECE)
    for start in starts:
        part = (time >= start) & (time < start + PIECE)
        t, v = time[part] - start, series["tip_vy"][part]
        waves = v - np.polyval(np.polyfit(t, v, TREND), t)
        if waves.std() > LARGE:
            break
        sizes.append(waves.std())
        strongest = np.abs(np.fft.rfft(waves * np.hanning(waves.size))).argmax() / PIECE
    rate = np.polyfit(starts[: len(sizes)], np.log(sizes), 1)[0]
    reached = starts[len(sizes) - 1] + PIECE
    return f"short waves: {rate:.1f} /s to {reached:.2f} s, there {sizes[-1]:.2g} m/s at {strongest:.0f} Hz"


if __name__ == "__main__":
    for folder in map(Path, sys.argv[1:]):
        columns = np.genfromtxt(folder / "series.csv", delimiter=",", names=True)
        numbers = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        reached = f"{folder.name} to {columns['time'][-1]:.3f} s"
        inside = [extremes(columns, *window) for window in WINDOWS]
        print(reached, *inside, settled(numbers), growth(columns), sep="\n  ")
