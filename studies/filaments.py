"""Two filaments side by side: python -m studies.filaments runs them at several distances and writes docs/flapping.

The same start, but for one case, so that it is the distance that decides; results/filaments/CASE keeps what is done.
"""

from math import cos, pi, sin
from typing import Any

import numpy as np

import nervure
from nervure.files import write_csv
from nervure.recorder import Series
from nervure.resources import ROOT
from studies import show

SCENE, RODS = "filament-pair-192x128", ("upper", "lower")
START, PARALLEL = (0.1, 0.05), (0.1, 0.1)  # Directions in which both begin, from that of the stream, by pi
END = 50.0
WINDOWS = ((20.0, 30.0), (30.0, 40.0), (40.0, 50.0))
CASES = {
    "0.2": (0.2, START),
    "0.3": (0.3, START),
    "0.5": (0.5, START),
    "1.0": (1.0, START),
    "1.0, both begin at 0.1π": (1.0, PARALLEL),
}


def changes(apart: float, start: tuple[float, float]) -> list[str]:
    """The scene with the filaments so far apart and begun in these directions."""
    keys = ["rods.0.beam.root.at", "rods.1.beam.root.at"]
    roots = [f"{key}.position=[0.0, {side * apart / 2}]" for key, side in zip(keys, (1, -1), strict=True)]
    return [*roots, *(f"{k}.direction=[{cos(a * pi)}, {sin(a * pi)}]" for k, a in zip(keys, start, strict=True))]


def correlation(series: Series, begin: float, end: float) -> float:
    """Correlation of both tips' motion across the stream: 1 in phase, −1 against each other."""
    part = (series["time"] > begin) & (series["time"] <= end)
    return float(np.corrcoef([series[f"{name}_tip_uy"][part] for name in RODS])[0, 1])


def run(case: str) -> nervure.Run:
    """The run of a case; made, where it is not there yet."""
    folder = ROOT / "results" / "filaments" / case.replace(", ", "-").replace(" ", "-")
    asked = nervure.load(SCENE, [*changes(*CASES[case]), f"time.end={END}"])
    if (folder / "summary.json").exists():
        there = nervure.read(folder)
        if there.summary.completed and there.scene == asked:
            return there
    return nervure.run(asked, folder, force=True, quiet=True)


def row(case: str) -> dict[str, Any]:
    """What the page shows of a case."""
    done = run(case)
    found: dict[str, Any] = {"case": case}
    found |= {f"from_{begin:g}": correlation(done.series, begin, end) for begin, end in WINDOWS}
    tips = {name: done.summary.quantities[f"{name}_tip_uy"] for name in RODS}
    found |= {name: tip.amplitude for name, tip in tips.items()}
    return found | {"frequency": tips[RODS[0]].frequency_hz, "cpu_s": done.summary.cpu_s}


def main() -> None:
    write_csv(show.DOCS / "flapping" / "filaments.csv", [row(case) for case in CASES])
    figure, axes = show.panel(2, 1, (9.0, 5.0), sharex=True)
    for axis, case in zip(axes[:, 0], ("0.2", "1.0"), strict=True):
        series = run(case).series
        for name in RODS:
            axis.plot(series["time"], series[f"{name}_tip_uy"], linewidth=1.0, label=name)
        axis.set(ylabel=f"tip, {case} apart", xlim=(0, END))
    axes[1, 0].set_xlabel("time")
    axes[0, 0].legend(fontsize=8, ncols=2)
    show.save(figure, "flapping/filaments", 110)


if __name__ == "__main__":
    main()
