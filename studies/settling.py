"""Bodies that settle in a closed tank: their largest speed beside published values."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from studies import simulate
from studies.engine import FLUID, Case, Run, Study

SPHERE, CYLINDER = "sphere-settling-80x80x120", "cylinder-settling-140x392"
TANKS = {1.5: (970, 0.373, 4.2, 0.0363), 4.1: (965, 0.212, 2.45, 0.0571), 11.6: (962, 0.113, 1.7, 0.0869),
         31.9: (960, 0.058, 1.28, 0.1226)}  # fmt: skip
"""By the Reynolds number: density, kg/m³, and viscosity, Pa s, of the fluid, end of the run, s, and largest speed, m/s,
of the spheres of ten Cate et al. (2002)."""
STEP = 0.0028 * 0.1226  # Length of a step by the speed, m
REYNOLDS = 495
"""Largest Reynolds number of the cylinder (Uhlmann 2005; from 438 to 466 by Glowinski et al. 2001, 503 by Wang et al.
2008), with the density of the body. That is inferred: only so does the case of a density ratio of 1.25 and ten times
the viscosity, published at 17.3, agree (17.4 on 16 cells)."""


def cases() -> Iterator[Case]:
    for reynolds, (density, viscosity, end, speed) in TANKS.items():
        changes: dict[str, Any] = {"fluid.density": density, "fluid.kinematic_viscosity": viscosity / density}
        changes |= {"time.end": end} | dict.fromkeys(
            ("time.communication_step", "fluid.time_stepping.max_step"), STEP / speed
        )
        about = {"expected": {"speed": speed}, "grid": f"Re {reynolds}"}
        yield Case(f"sphere/Re {reynolds}", FLUID, SPHERE, changes, about=about)
    expected = {"reynolds": REYNOLDS}
    finer = {"fluid.box.cells": [210, 588]} | dict.fromkeys(
        ("time.communication_step", "fluid.time_stepping.max_step"), 1e-4
    )
    for n, changes in ((16, {}), (24, finer)):
        about = {"expected": expected, "grid": f"{n} cells"}
        yield Case(f"cylinder/{n} cells", FLUID, CYLINDER, changes, about=about)


def extract(case: Case, run: Run) -> dict[str, Any]:
    """Return the largest speed, m/s, of the cylinder as a Reynolds number."""
    if case.scene == SPHERE:
        values = {"speed": float(-run.series["body_1_vz"].min())}
    else:
        values = {"reynolds": float(-run.series["body_1_vy"].min()) * 2.5e-3 / 1e-6 * 1.5}
    return {"values": values, "times": simulate.times(run.found)}


STUDY = Study("settling", cases, extract)
