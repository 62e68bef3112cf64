"""A wing beside exact solutions: a square plate that vibrates, and the work between a hovering wing and its fluid."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import nervure
from nervure.scene import validate
from studies import flapping, space
from studies.engine import COUPLED, Case, Study

HOVER = "wing-hover-64x64x84"
LEISSA = 3.4917
"""First frequency of a square plate clamped at one side, ω L² √(ρ h/D), for Poisson's ratio 0.3 (Leissa 1973)."""
ELEMENTS = (4, 8, 16, 32)  # Along a side of the plate
PERIODS, STEPS = 12, 200  # Of the first mode, and communication steps in one
NUDGE = 1e-3  # m
PERIOD = 2 * np.pi / LEISSA  # s, with ρ h, D and L of one

PLATE: dict[str, Any] = {
    "name": "plate",
    "time": {"end": PERIODS * PERIOD, "communication_step": PERIOD / STEPS},
    "wing": {
        "membrane": {
            "areal_density": 1.0,
            "stretching_stiffness": 1e4,
            "bending_stiffness": 1.0,
            "poisson_ratio": 0.3,
        },
        "root": "root",
        "root_motion": {"z": {"table": {"times": [0.0, 0.5, 1.0], "values": [0.0, NUDGE, 0.0]}}},
    },
}


def vibrating(case: Case, folder: Path) -> dict[str, Any]:
    """Return the frequency of the tip of a plate, nudged at its root, as `LEISSA` has it."""
    mesh = {"rectangular": {"length": 1.0, "width": 1.0, "along": case.options["along"]}}
    scene = PLATE | {"wing": PLATE["wing"] | {"mesh": mesh}}
    done = nervure.run(validate(scene), folder, force=True, quiet=True)
    frequency = flapping.swing(done.series, "tip_uz", 2.0)["frequency"]
    return {"values": {"frequency": 2 * np.pi * frequency}, "times": {"cpu_s": done.summary.cpu_s}}


def hovering(case: Case, folder: Path) -> dict[str, Any]:
    """Return mean forces of a hovering wing, N, the mean power of its drive, W, and the imbalance of the works."""
    done = nervure.run(validate(case.built()), folder, force=True, quiet=True)
    wing, work = done.summary.wing, done.summary.interface
    assert wing and work
    values = {"drag": wing.drag, "lift": wing.lift, "side": wing.side, "root_power": wing.root_power}
    return {"values": values | {"imbalance": work.imbalance}, "times": {"cpu_s": done.summary.cpu_s}}


def cases() -> Iterator[Case]:
    about: dict[str, Any]
    for n in ELEMENTS:
        about = {"expected": {"frequency": LEISSA}, "grid": f"{n} a side"}
        yield Case(f"plate/{n}", ("scene", "wing"), options={"along": n}, action=vibrating, about=about)
    for cells, step in (([48, 48, 63], 0.00833333), ([64, 64, 84], 0.00625)):
        said = "x".join(map(str, cells))
        about = {"expected": {"imbalance": 0.0}, "grid": said}
        changes = {"time.end": 10.0, "fluid.threads": 1} | space.grid(cells, step)
        yield Case(f"hover/{said}", (*COUPLED, "wing"), HOVER, changes, action=hovering, about=about)


STUDY = Study("wing", cases, lambda case, run: run.found)
