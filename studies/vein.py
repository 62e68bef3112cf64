"""The flapping vein: limits with exact results, and the noise of the mask."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from nervure.evaluate import statistics
from studies import limits, show, simulate
from studies.engine import COUPLED, Case, Run, Study
from studies.limits import FORCE_WIDTH, LIMITS, PITCHING
from studies.simulate import on_grid

FORWARD, SWINGING = "vein-forward-288x144", "fsi3-648x108"
STIFFNESS = "rod.material.section.bending_stiffness"
FSI3_PERIOD = 1 / 5.46  # s, of the benchmark


def tutorial() -> dict[str, Any]:
    """Return the scene of the tutorial."""
    text = (show.DOCS / "guide" / "tutorial.md").read_text(encoding="utf-8")
    (scene,) = re.findall(r"```json\n(.*?)```", text, re.DOTALL)
    found: dict[str, Any] = json.loads(scene)
    return found


def cases() -> Iterator[Case]:
    def case(name: str, scene: str, changes: dict[str, Any], **options: Any) -> Case:
        named = {"name": name.replace("/", "-").replace(" ", "-").replace(",", "")} | changes
        return Case(name, COUPLED, scene, named, options)

    plate = {"time.end": 2.0, "beam.thickness": 0.06, "rod.material.section.line_density": 0.06}
    for nx, ny in ((128, 96), (192, 144)):
        changes = plate | on_grid(nx, ny, 1e-3 * 128 / nx)
        yield case(f"noise/{nx}x{ny}", PITCHING, changes, rigid=True)
        yield case(f"noise/{nx}x{ny}, line", PITCHING, changes | {"beam.surface": "line"}, rigid=True)
    for name, stiffness in (("the tutorial's vein", 4.0), ("the same, five times as stiff", 20.0)):
        yield case(f"noise/{name}", FORWARD, tutorial() | {STIFFNESS: stiffness})
        masked = {"beam.surface": "mask", "fluid.box.cells": [160, 96]}
        yield case(f"noise/{name}, mask on 160x96", FORWARD, tutorial() | {STIFFNESS: stiffness} | masked)
    yield case("noise/FSI3, 648 x 108", SWINGING, {})
    for name in LIMITS:
        yield Case(f"limits/{name}", (*COUPLED, "limits"), options={"limit": name}, action=limit)


def limit(case: Case, folder: Path) -> dict[str, Any]:
    """Return the quantities of a limit case beside their expected values."""
    all_found = LIMITS[case.options["limit"]](partial(limits.record, folder=folder))
    return {"tables": {"found": [asdict(found) | {"error": found.error} for found in all_found]}}


def extract(case: Case, run: Run) -> dict[str, Any]:
    if "tables" in run.found:
        return {"tables": run.found["tables"]}
    return {"values": noise(case, run), "times": simulate.times(run.found)}


def noise(case: Case, run: Run) -> dict[str, float]:
    """Return the rms, over the second half, of the part of the drag that the box filter removes, by the rms and by the
    amplitude of the remaining part."""
    time, swings = run.series["time"], case.scene == SWINGING
    drag, width = (run.series["drag"], FSI3_PERIOD / 50) if swings else (run.series["beam_drag"], FORCE_WIDTH)
    smooth, later = statistics.box_filter(time, drag, width), (time > time[-1] / 2) & (time < time[-1] - width)
    rest, left = (drag - smooth)[later].std(), smooth[later]
    return {
        "noise": float(rest / np.sqrt(np.mean(left**2))),
        "noise_by_amplitude": float(rest / (np.ptp(left) / 2)),
    }


STUDY = Study("vein", cases, extract)
