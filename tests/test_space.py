"""Fluids of three dimensions: the unit, a run with its fields and pictures, refusals, a state of checkpoints."""

import copy

import numpy as np
import pytest

from nervure import api
from nervure.errors import SceneError
from nervure.scene import validate
from nervure.simulation.results import FLUID_FIELDS

SPHERE = {
    "name": "sphere",
    "time": {"end": 0.1, "communication_step": 0.02},
    "fluid": {
        "density": 2.0,
        "kinematic_viscosity": 0.05,
        "box": {"x": [-1.5, 2.5], "y": [-1.0, 1.0], "z": [-1.0, 1.0], "cells": [32, 16, 16]},
        "initial_velocity": [1.0, 0.0, 0.0],
        "mean_flow": {"x": {"constant": 1.0}},
        "bodies": [{"shape": {"sphere": {"radius": 0.4}}, "position": [0.0, 0.0, 0.0]}],
        "mask": {"log_linear": {"c_eta": 1e-4}},
        "probes": [{"name": "wake", "position": [1.0, 0.0, 0.0]}],
        "time_stepping": {"max_step": 0.02, "max_cfl": 0.4},
    },
}
"""A sphere in a stream that starts at once."""


def changed(**parts: object) -> dict:
    """Return `SPHERE` with other parts of the fluid."""
    scene = copy.deepcopy(SPHERE)
    scene["fluid"] |= parts
    return scene


@pytest.fixture(scope="module")
def run(libraries, tmp_path_factory):
    folder = tmp_path_factory.mktemp("space")
    return api.run(validate(SPHERE), folder / "run", fields_every=0.04, quiet=True), folder / "run"


def test_forces_and_probes_of_a_sphere_are_recorded_and_evaluated(run):
    found, _ = run
    series, drag = found.series, found.series["drag"]
    assert {"drag", "lift", "side", "body_1_moment_z", "body_1_z", "probe_wake_w", "probe_wake_p"} <= series.keys()
    assert drag[-1] > 0 and np.allclose(drag, series["body_1_drag"])
    assert abs(series["lift"][-1]) < 1e-9 * drag[-1] and abs(series["side"][-1]) < 1e-9 * drag[-1]
    # The flow rate through the box is that of the mean flow.
    assert np.allclose(series["flow_rate"], 4.0, rtol=1e-12)
    pressure = 0.5 * 2.0 * np.pi * 0.4**2
    assert found.summary.quantities["drag"].unit == "N"
    mean = found.summary.quantities["drag"].mean
    assert found.summary.bodies["body_1"].cd_mean == pytest.approx(mean / pressure)


def test_fields_are_those_of_the_flow_in_a_container_of_vtk(run):
    h5py = pytest.importorskip("h5py")
    _, folder = run
    with h5py.File(folder / FLUID_FIELDS) as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"ImageData" and list(root.attrs["WholeExtent"]) == [0, 31, 0, 15, 0, 15]
        assert np.allclose(root.attrs["Spacing"], 0.125) and np.allclose(root.attrs["Origin"], [-1.5, -1, -1])
        assert root["Steps"].attrs["NSteps"] == 3
        u, omega = (root["PointData"][name][-1] for name in ("velocity", "vorticity"))
        assert u.shape == omega.shape == (16, 16, 32, 3) and root["PointData/pressure"].shape == (3, 16, 16, 32)
    # The mean flow, and a ring of vortices around the sphere: about y above it, about -z beside it.
    assert np.allclose(u.mean(axis=(0, 1, 2)), [1, 0, 0], atol=1e-6)
    assert omega[11, 8, 12, 1] > 0.1 and omega[8, 11, 12, 2] == pytest.approx(-omega[11, 8, 12, 1], abs=1e-4)
    assert (folder / "vorticity.png").stat().st_size > 5000


def test_both_versions_of_the_unit_give_the_same_numbers(run, tmp_path):
    other = api.run(validate(SPHERE), tmp_path / "run", fmi=3, quiet=True)
    assert np.array_equal(other.series["drag"], run[0].series["drag"])


@pytest.mark.parametrize(
    ("parts", "named"),
    [
        ({"box": SPHERE["fluid"]["box"] | {"cells": [32, 16]}}, ["fluid.box.cells", "3 numbers"]),
        ({"box": SPHERE["fluid"]["box"] | {"z": [1.0, -1.0]}}, ["fluid.box.z"]),
        ({"box": {"x": [-1.5, 2.5], "y": [-1.0, 1.0], "cells": [32, 16]}}, ["two dimensions", "sphere"]),
        ({"cylinders": [{"center": [0.0, 0.0], "radius": 0.1}]}, ["fluid.cylinders", "bodies"]),
        ({"bodies": [{"shape": {"circle": {"radius": 0.1}}, "position": [0, 0, 0]}]}, ["circle", "sphere"]),
        ({"bodies": [{"shape": {"sphere": {"radius": 0.1}}, "position": [0, 0]}]}, ["position", "3 components"]),
        ({"bodies": [{"shape": {"cuboid": {"lengths": [1, 0, 1]}}, "position": [0, 0, 0]}]}, ["lengths", "> 0"]),
        ({"time_stepping": {"max_step": 0.02, "max_cfl": 0.4, "scheme": "rk2"}}, ["scheme", "sbdf2"]),
        ({"box": SPHERE["fluid"]["box"] | {"cells": [4096, 4096, 4096]}}, ["fluid.box.cells", "67108864"]),
    ],
)
def test_parts_of_other_dimensions_are_refused_by_their_key(parts, named, libraries, tmp_path):
    with pytest.raises(SceneError) as refused:
        api.run(validate(changed(**parts)), tmp_path / "run", quiet=True)
    assert all(part in str(refused.value) for part in named), refused.value
