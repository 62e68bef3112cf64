"""Bodies that propel themselves: swimming filaments beside published speeds, and the flyer of the examples."""

from __future__ import annotations

import copy
import runpy
from collections.abc import Iterator
from itertools import product
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np

import nervure
from nervure.evaluate.statistics import Series
from nervure.resources import ROOT
from nervure.scene import validate
from nervure.scene.facts import Facts
from studies import simulate, thin
from studies.engine import COUPLED, Case, Run, Study

SWIMMER, FLYER = "filament-swimming-144x48", str(ROOT / "examples" / "flyer-pid.json")

SPEEDS = {"wall": 0.708, "open": 1.73}
"""Published mean speeds by the speed U of `FILAMENTS`: of a filament .6 lengths above a wall (Park et al. 2017) and of
the first of two filaments in line (Zhu et al. 2014), both as digitised for the examples of FSILBM3D."""
FILAMENTS: dict[str, tuple[float, float, float, float, float]] = {
    "wall": (0.2, 4 * pi * 0.2, 100.0, 1.0, 1.0),
    "open": (0.5, 2 * pi * 0.5, 200.0, 0.2, 0.8),
}
"""Amplitude of the heave by the length L; speed U, the largest of the heave or, above the wall, twice that, lengths per
period; Reynolds number by U and L; mass by rho L; bending stiffness by rho U² L³."""
PERIODS = {"wall": 8, "open": 5}

STROKES = 7
"""Last strokes of a flyer that count."""
FAR: dict[str, Any] = {
    "fluid.box": {axis: [-0.0128, 0.0128] for axis in "xyz"} | {"cells": [48, 48, 48]},
    "fluid.fine_box": {"x": [-0.0072, 0.0072], "y": [-0.0072, 0.0072], "z": [-0.0048, 0.0048], "ratio": 2,
                       "follow": "body[1]"},
}  # fmt: skip
"""A box twice as long, with cells of the old size in one that follows the flyer."""
FLIGHTS: dict[str, tuple[str, dict[str, Any]]] = {
    "hovers": ("flyer_pid.py", {}),
    "hovers, two grids": ("flyer_pid.py", FAR),
    "climbs": ("flyer_climb.py", {}),
}
"""Drive and changes."""

WING: dict[str, Any] = {
    "mesh": {"rectangular": {"length": 0.2, "width": 0.1, "along": 3}},
    "membrane": {"areal_density": 50.0, "stretching_stiffness": 2500.0, "bending_stiffness": 0.09},
    "root": "root",
    "scheme": "bdf2",
    "relaxation_time": 1e-4,
}
"""A wing of 1 kg. In a fluid it is stiffer by the ratio of its added mass."""
BESIDE = (0.01, 1.0, 100.0)  # Mass of both wings by that of the body
ADDED = (0.0, 0.5, 10.0)  # Added mass of a wing by its own
TIMED = 150  # Steps of the cost
MOST, STEP = 0.2, 5e-3  # Difference of the paths of a body that counts as silent, and step, s


def swimming(kind: str, cells: int) -> dict[str, Any]:
    """Return the changes of the scene for a filament of so many cells a length. In open water, a fine box follows it in
    a large one of 12 cells a length."""
    amplitude, speed, reynolds, mass, stiffness = FILAMENTS[kind]
    step = 1 / (24 * cells if kind == "wall" else 36 * cells)
    changes: dict[str, Any] = {
        "fluid.kinematic_viscosity": speed / reynolds,
        "fluid.mask.log_linear.c_eta": step / 50,
        "beam.segments": 32,
        "rod.material.section.line_density": mass,
        "rod.material.section.bending_stiffness": stiffness * speed**2,
        "rod.material.section.axial_stiffness": 1000 * speed**2,
        "rod.root_motion.laws.y.sine": {"amplitude": amplitude, "frequency": 1.0},
        "time.end": float(PERIODS[kind]),
    } | dict.fromkeys(("time.communication_step", "fluid.time_stepping.max_step"), step)
    if kind == "wall":
        box = {"x": [-21.0, 3.0], "y": [-0.5, 7.5], "cells": [24 * cells, 8 * cells]}
        return changes | {"fluid.box": box, "fluid.channel": {"y": [0.0, 7.0]}, "beam.root.at.position": [0.0, 0.6]}
    box, fine = {"x": [-45.0, 3.0], "y": [-4.0, 4.0], "cells": [576, 96]}, {"x": [-1.0, 3.0], "y": [-1.5, 1.5]}
    return changes | {"fluid.box": box, "fluid.fine_box": fine | {"ratio": cells // 12, "follow": "beam"}}


def drive_of(case: Case) -> Any:
    """Return a new drive of a case."""
    return runpy.run_path(str(ROOT / "examples" / case.options["drive"]))["drive"]


def flown(case: Case, folder: Path) -> dict[str, Any]:
    """Fly the scene of a case under a drive of the examples; return the summary."""
    done = nervure.run(validate(case.built()), folder / "flight", drive=drive_of(case), force=True, quiet=True)
    columns: Any = done.series
    np.savez_compressed(folder / "series.npz", **columns)
    return done.summary.document()


def pair(beside: float, added: float, step: float) -> dict[str, Any]:
    """Return the scene of a body with two wings that beat once, by the ratios of `BESIDE` and `ADDED`."""
    mass = 2.0 / beside
    membrane = WING["membrane"] | {
        name: max(1.0, added) * WING["membrane"][name] for name in ("stretching_stiffness", "bending_stiffness")
    }
    stroke = {"stroke": {"sine": {"amplitude": 0.8, "frequency": 1.0, "ramp": 0.5}}}
    turn = {"axis": [0.0, 1.0, 0.0], "angle": pi}
    scene: dict[str, Any] = {
        "name": "pair",
        "time": {"end": 1.0, "communication_step": step},
        "wings": [{"name": name, "wing": WING | {"membrane": membrane}} for name in ("left", "right")],
        "flyer": {
            "mass": mass,
            "inertia": [0.01 * mass, 0.014 * mass, 0.019 * mass],
            "hinges": [
                {"carries": "left", "position": [0.05, 0.0, 0.0], "motion": stroke},
                {"carries": "right", "position": [-0.05, 0.0, 0.0], "turn": turn, "motion": stroke},
            ],
        },
    }
    if added:
        scene["fluid"] = {
            "density": added / (pi / 4 * 0.1**2 * 0.2),
            "kinematic_viscosity": 1e-3,
            "box": {"x": [-0.6, 0.6], "y": [-0.6, 0.6], "z": [-0.3, 0.3], "cells": [48, 48, 24]},
            "mask": {"log_linear": {"c_eta": 1e-4}},
            "time_stepping": {"max_step": step, "max_cfl": 0.4},
        }
    return scene


def mapped(case: Case, folder: Path) -> dict[str, Any]:
    """Run a body with wings over both ratios, with the step and with half of it: the outcome is `ok`, `told` with a
    warning, `error` with advice, or `bad` where the paths of the body differ and nothing is said."""
    rows = []
    with TemporaryDirectory(dir=folder) as place:
        for beside, added in product(BESIDE, ADDED):
            paths, said, off = [], "ok", 0.0
            for step in (STEP, STEP / 2):
                with simulate.session(pair(beside, added, step), Path(place)) as session:
                    status, warnings = session.run(), session.warnings
                    paths.append(session.recorder.series["body_y"])
                if status.error:
                    said = thin.failed(status.error)
                    break
                said = "told" if warnings else said
            else:
                off = float(np.abs(paths[0] - paths[1][::2]).max() / np.abs(paths[1]).max())
                said = "bad" if said == "ok" and not off < MOST else said
            rows.append({"beside": beside, "added": added, "outcome": said, "off": off})
    return {"tables": {"map": rows}}


def tethered(flyer: dict[str, Any]) -> dict[str, Any]:
    """Return the scene of a flyer whose wings beat alike at a body that stands."""
    scene = copy.deepcopy(flyer)
    hinges = scene.pop("flyer")["hinges"]
    for body in scene["fluid"]["bodies"]:
        del body["motion"]
    for own, hinge in zip(scene["wings"], hinges, strict=True):
        turn = hinge.get("turn", {"axis": [0.0, 1.0, 0.0], "angle": 0.0})
        angles = [
            ({"constant": turn["angle"]}, turn["axis"]),
            (hinge["motion"]["stroke"], [0.0, 0.0, 1.0]),
            (hinge["motion"]["pitch"], [1.0, 0.0, 0.0]),
        ]
        place = {axis: {"constant": at} for axis, at in zip("xyz", hinge["position"], strict=True)}
        own["wing"]["root_motion"] = place | {"rotations": [{"angle": law, "axis": axis} for law, axis in angles]}
    return scene


def cost(case: Case, folder: Path) -> dict[str, Any]:
    """Time steps of a flyer and of its wings without a flight."""
    flies = case.built()
    flying, standing = simulate.in_turns([flies, tethered(flies)], folder, TIMED, lambda _: perf_counter())
    return {"times": {"flying_ms": flying, "tethered_ms": standing, "ratio": flying / standing}}


def cases() -> Iterator[Case]:
    for kind, counts in (("wall", (24, 48)), ("open", (24, 48, 96))):
        for cells in counts:
            about = {"expected": {"speed": SPEEDS[kind]}, "grid": f"{cells} cells"}
            yield Case(f"swims/{kind}, {cells}", COUPLED, SWIMMER, swimming(kind, cells), about=about)
    for name, (drive, changes) in FLIGHTS.items():
        yield Case(f"flies/{name}", (*COUPLED, "wing", "body"), FLYER, changes, {"drive": drive}, flown)
    yield Case("map/ratios", (*COUPLED, "wing", "body"), action=mapped)
    yield Case("cost/hover", (*COUPLED, "wing", "body"), str(ROOT / "examples" / "hover-flyer.json"), action=cost)


def mean(values: np.ndarray, begin: int) -> float:
    """Return the mean over the steps after one."""
    return float(values[begin + 1 :].mean())


def of_flight(case: Case, series: Series) -> dict[str, float]:
    """Return where a flyer is at the end, m, and of its last strokes the largest of its angles, rad, and its vertical
    forces less what its weight and its momentum ask for, by its weight: with the loads that its wings take, and with
    those that the fluid gives."""
    scene = case.built()
    steps = round(STROKES / drive_of(case).frequency / scene["time"]["communication_step"])
    begin = len(series["time"]) - 1 - steps
    meshes = Facts(validate(scene)).wing
    assert meshes
    corners = meshes.nodes[meshes.triangles]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    mass = scene["flyer"]["mass"] + area * scene["wings"][0]["wing"]["membrane"]["areal_density"]
    weight = -scene["flyer"]["gravity"][2] * mass
    momentum, time = series["body_momentum_z"], series["time"]
    due = weight + (momentum[-1] - momentum[begin]) / (time[-1] - time[begin])
    body = mean(series["body_1_load_force_z"], begin)
    taken = sum(mean(series[f"{wing}_load_z"], begin) for wing in ("left", "right"))
    given = sum(mean(series[f"wing_{number}_load_z"], begin) for number in (1, 2))
    leans = [np.abs(series[f"body_angle_{axis}"][begin:]).max() for axis in "xyz"]
    return {axis: float(series[f"body_{axis}"][-1]) for axis in "xyz"} | {
        "lean": float(max(leans)),
        "by_wings": float(taken + body - due) / weight,
        "by_fluid": float(given + body - due) / weight,
    }


def extract(case: Case, run: Run) -> dict[str, Any]:
    """Return the mean speed of a filament over the last period as that of the published one; see `of_flight`."""
    if case.name.startswith("flies/"):
        return {"values": of_flight(case, run.series), "times": simulate.times(run.found | {"runs": 1})}
    if case.name.startswith(("map/", "cost/")):
        return run.found
    kind = case.name.split("/")[1].split(",")[0]
    step = case.built()["time"]["communication_step"]
    x = run.series["root_ux"]
    speed = float(x[-1 - round(1 / step)] - x[-1]) / FILAMENTS[kind][1]
    return {"values": {"speed": speed}, "times": simulate.times(run.found)}


STUDY = Study("flight", cases, extract)
