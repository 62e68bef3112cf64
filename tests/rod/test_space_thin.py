"""Rods in a fluid of three dimensions: one exchange a step by the master of the plane, for one rod and several."""

import copy
from typing import Any

import numpy as np
import pytest

from nervure import api
from nervure.errors import SceneError
from nervure.scene import validate
from nervure.units.fmu import Unit
from tests.conftest import output

WEIGHT = 1.233e-3
"""Of a filament of 0.4 mm and 1000 kg/m³, N/m."""

HANGING: dict[str, Any] = {
    "name": "hanging",
    "time": {"end": 0.02, "communication_step": 2e-4},
    "fluid": {
        "density": 1.21,
        "kinematic_viscosity": 1.51e-5,
        "box": {"x": [-0.008, 0.016], "y": [-0.024, 0.006], "z": [-0.006, 0.006], "cells": [24, 30, 12]},
        "initial_velocity": [1.1, 0, 0],
        "mean_flow": {"x": {"constant": 1.1}},
        "mask": {"log_linear": {"c_eta": 1e-6}},
        "time_stepping": {"max_step": 2e-4, "max_cfl": 0.4},
    },
    "beam": {
        "root": {"at": {"position": [0.0, 0.0, 0.0], "direction": [0.0, -1.0, 0.0]}},
        "length": 0.02,
        "thickness": 4e-4,
        "segments": 16,
        "surface": "line",
    },
    "rod": {
        "material": {"section": {"line_density": WEIGHT / 981, "bending_stiffness": 2.8e-10, "axial_stiffness": 0.028}},
        "root": "pinned",
        "gravity": [0.0, -981.0, 0.0],
    },
}
"""A filament that hangs in a stream. It has a hundredth of its mass in a hundred times gravity, and settles sooner."""


def two() -> dict:
    """Return a scene of two filaments, each of which mirrors the other."""
    scene = copy.deepcopy(HANGING)
    beam, rod = scene.pop("beam"), scene.pop("rod")
    scene["rods"] = []
    for name, z in (("left", -0.0015), ("right", 0.0015)):
        own = copy.deepcopy(beam)
        own["root"]["at"]["position"][2] = z
        scene["rods"].append({"name": name, "beam": own, "rod": rod})
    return scene


@pytest.fixture(scope="module")
def hanging(libraries, tmp_path_factory):
    return api.run(validate(HANGING), tmp_path_factory.mktemp("hanging") / "run", quiet=True)


def test_a_filament_comes_to_the_angle_at_which_drag_and_weight_balance(hanging):
    """By the law of an experiment, at 66.7 degrees. A cell has 1 mm; a cylinder as thick as the line, of 1.7 mm, comes
    to 43 degrees."""
    series = hanging.series
    angle = np.degrees(np.arctan2(0.02 - series["tip_uy"], series["tip_ux"]))
    assert angle[20] > 75 and 62 < angle[-1] < 72 and abs(angle[-1] - angle[-10]) < 4, angle[::10]
    assert np.abs(series["tip_uz"]).max() < 1e-6
    assert series["energy_gravity"][-1] < 0
    assert series["beam_work"][-1] == pytest.approx(series["load_work"][-1], rel=0.05)
    assert series["beam_drag"][-1] == pytest.approx(series["drag"][-1])


def test_two_filaments_mirror_each_other(libraries, tmp_path):
    scene = two()
    scene["time"]["end"] = 0.004
    series = api.run(validate(scene), tmp_path / "run", quiet=True).series
    assert np.allclose(series["left_tip_ux"], series["right_tip_ux"], rtol=1e-6)
    assert np.allclose(series["left_tip_uz"], -series["right_tip_uz"], atol=1e-9)
    assert abs(series["right_tip_uz"][-1]) > 1e-7
    assert np.allclose(series["beam_1_drag"], series["beam_2_drag"], rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda scene: scene["beam"].update(surface="mask"), "`beam.surface`"),
        (lambda scene: scene["beam"]["root"]["at"].update(position=[0, 0], direction=[0, -1]), "`beam.root`"),
        (lambda scene: scene.update(coupling={"load": "pressure_jump"}), "`coupling.load`"),
        (lambda scene: scene["beam"].update(length=0.03), "`beam.root`"),
    ],
    ids=["mask", "flat", "load", "outside"],
)
def test_a_rod_in_space_is_a_line_inside_the_box_with_one_exchange(change, named, libraries, tmp_path):
    scene = copy.deepcopy(HANGING)
    change(scene)
    with pytest.raises(SceneError, match=named):
        api.run(validate(scene), tmp_path / "run", quiet=True)


def test_the_fluid_of_a_wing_takes_its_nodes_and_gives_their_loads(packed):
    scene = copy.deepcopy(HANGING)
    del scene["beam"], scene["rod"]
    scene["wing"] = {
        "mesh": {"rectangular": {"length": 0.01, "width": 0.006, "along": 5}},
        "membrane": {"areal_density": 1e-3, "stretching_stiffness": 1.0},
        "root": "root",
    }
    unit = Unit(packed("fluid", scene, 3), "fluid", scene["time"]["end"])
    nodes = unit.variables["wing.x"].size
    arrays = [f"wing.{name}{axis}" for name in ("", "v", "force_") for axis in "xyz"] + ["wing.impedance"]
    assert all(unit.variables[name].size == nodes for name in arrays) and len(unit.variables) < 100
    position = [[float(str(x)) for x in unit.variables[f"wing.{axis}"].start] for axis in "xyz"]
    assert max(position[0]) == pytest.approx(0.01) and max(position[1]) == pytest.approx(0.003)
    unit.connect([], ["wing.force_x", "wing.impedance", "wing.drag", "wing.work"])
    unit.start()
    for step in range(8):
        unit.get()
        announced = output(unit, "wing.force_x").sum()
        unit.step(step * 2e-4, 2e-4)
        unit.get()
        if step > 0:
            # Nodes at rest keep their velocities, so the announced loads come true.
            assert output(unit, "wing.drag")[0] == pytest.approx(announced, rel=1e-9)
    assert announced > 0 and output(unit, "wing.impedance").min() > 0
    assert output(unit, "wing.work")[0] == 0
    unit.close()
