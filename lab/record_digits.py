"""Record early outputs of the units for a wing in a flow: lab/tests/digits.rs compares them.

`make record` writes lab/tests/wing.json: only after a change of the physics that is meant. In double precision: single
precision rounds otherwise on other processors.
"""

import json
import tempfile
from pathlib import Path
from typing import Any

import nervure

RECORDED = Path(__file__).with_name("tests") / "wing.json"
SCENE, STEPS, STEP = "wing-hover-64x64x84", 40, 0.0125
CHANGES: dict[str, Any] = {
    "fluid.box": {"x": [-1.2, 3.6], "y": [-3.0, 1.8], "z": [-3.0, 3.0], "cells": [40, 40, 50]},
    "fluid.precision": "double",
    "fluid.time_stepping.max_step": STEP,
    "time.communication_step": STEP,
    "time.end": STEPS * STEP,
    "wing.mesh.insect.along": 10,
}
"""A coarse grid, on which the wing has begun to move at the end."""
COLUMNS = ("time", "drag", "lift", "side", "tip_ux", "tip_uy", "tip_uz", "section_twist")
"""Outputs in the order of a sample of the page."""


def recorded(folder: Path) -> dict[str, Any]:
    """Run the units, and return the scene, the changes of it, the steps and the outputs after these."""
    series = nervure.run(nervure.load(SCENE).copy(CHANGES), folder, quiet=True).series
    outputs = {name: float(series[name][-1]) for name in COLUMNS}
    return {"scene": SCENE, "set": CHANGES, "steps": STEPS, "outputs": outputs}


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as results:
        RECORDED.write_text(json.dumps(recorded(Path(results)), indent=2) + "\n")
