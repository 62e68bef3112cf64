"""The run of the shipped FSI3 scene that test_fsi3.py checks, and the numbers recorded from it.

`make record` writes tests/simulation/recorded.json anew: only after a change of the physics that is meant.
"""

import json
import tempfile
from pathlib import Path

import numpy as np

from tests.conftest import FSI3, run_scene

RECORDED = Path(__file__).with_name("recorded.json")
EARLY_TIMES = (0.1, 0.2, 0.3)
"""Times (s) at which single values are compared: rounding has not yet grown to anything that could be seen."""

EARLY_QUANTITIES = ("tip_ux", "tip_uy", "drag", "lift")


def run(folder: Path) -> dict:
    """Run the scene into `folder` and return what is recorded of it."""
    done = run_scene(FSI3, "--output", folder)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    series = np.genfromtxt(folder / "series.csv", delimiter=",", names=True)
    summary = json.loads((folder / "summary.json").read_text())
    rows = [int(np.argmin(np.abs(series["time"] - t))) for t in EARLY_TIMES]
    return {
        "early": {name: [float(series[name][row]) for row in rows] for name in EARLY_QUANTITIES},
        "settled": {
            name: {what: quantity[what] for what in ("mean", "amplitude", "frequency_hz")}
            for name, quantity in summary["quantities"].items()
        },
    }


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as results:
        RECORDED.write_text(json.dumps(run(Path(results)), indent=2) + "\n")
