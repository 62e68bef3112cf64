"""A flapping vein of one's own, and how its stiffness changes what it gives: thrust and efficiency by three runs.

    python scripts/gallery/flapping_vein.py

The scene is that of the tutorial: a vein of chord 1 goes up and down by 0.4 once in a unit of time, in a stream of 2.
"""

import argparse
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

import nervure

SCENE = {
    "name": "my-vein",
    "display": {"length": "chords", "time": "periods"},
    "time": {"end": 4.1, "communication_step": 2e-3},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 0.01,
        "box": {"x": [-1.0, 4.0], "y": [-1.5, 1.5], "cells": [120, 72]},
        "initial_velocity": [2.0, 0.0],
        "mean_flow": {"x": {"constant": 2.0}},
        "sponge": {"x": [3.0, 4.0], "mean_velocity": {"constant": 2.0}, "c_eta": 0.05},
        "mask": {"log_linear": {"c_eta": 1e-5}},
        "time_stepping": {"max_step": 2e-3, "max_cfl": 0.4},
    },
    "beam": {
        "root": {"at": {"position": [0.0, 0.0], "direction": [1.0, 0.0]}},
        "length": 1.0,
        "thickness": 0.08,
        "segments": 20,
        "surface": "line",
    },
    "rod": {
        "material": {"section": {"line_density": 0.16, "bending_stiffness": 4.0, "axial_stiffness": 1e4}},
        "root_motion": {"laws": {"y": {"sine": {"amplitude": 0.4, "frequency": 1.0, "ramp": 1.0}}}},
        "scheme": "bdf2",
    },
}

parser = argparse.ArgumentParser(description="Run a flapping vein of several stiffnesses.")
parser.add_argument("--end", type=float, default=4.1, help="end of the runs, periods (4.1)")
parser.add_argument("--output", type=Path, default=Path("gallery-vein"), help="folder of the results")
given = parser.parse_args()

stiffnesses, thrusts, efficiencies = [2.0, 8.0, 32.0], [], []
for stiffness in stiffnesses:
    scene = nervure.Scene.model_validate(SCENE)
    scene.time.end = given.end
    scene.rod.material.section.bending_stiffness = stiffness
    run = nervure.run(scene, given.output / f"stiffness-{stiffness:g}", quiet=True)
    found = run.summary.flapping
    if found is None:
        parser.error(f"argument --end: {given.end:g} is too short for a whole period after the start")
    thrusts.append(found.thrust)
    efficiencies.append(found.efficiency)
    print(f"EI = {stiffness:g}: thrust {found.thrust:.3f}, efficiency {found.efficiency:.1%}")

figure = Figure(figsize=(8, 3), layout="constrained")
left, right = figure.subplots(1, 2)
left.plot(stiffnesses, thrusts, "o-")
left.set(ylabel="thrust")
right.plot(stiffnesses, efficiencies, "o-")
right.set(ylabel="efficiency")
for axes in (left, right):
    axes.set(xscale="log", xlabel="bending stiffness")
    axes.set_xticks(stiffnesses, [f"{stiffness:g}" for stiffness in stiffnesses])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(axis="x", which="minor", color="0.88", linewidth=0.5)
figure.savefig(given.output / "stiffness.png", dpi=150)
