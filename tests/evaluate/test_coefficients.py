"""Drag and lift coefficients, Strouhal number and the published values that go with them."""

from typing import Any

import numpy as np
import pytest

from nervure.evaluate import coefficients, statistics
from nervure.scene import load, override, read, validate
from nervure.scene.facts import Facts


@pytest.fixture
def scene():
    return read("cylinder-2d2-900x180")


def scale_of(scene: dict[str, Any]) -> coefficients.Scale:
    """Return the scale of a scene that has one."""
    scale = coefficients.scale(Facts(validate(scene)))
    assert scale
    return scale


def test_the_scale_is_that_of_the_benchmark(scene):
    scale = scale_of(scene)
    assert 1 / scale.force == pytest.approx(20.0)
    assert scale.frequency == pytest.approx(10.0)


@pytest.mark.parametrize(
    "assignment",
    [
        'fluid.cylinders.0.motion={"x":{"constant":0.0}}',
        'beam={"root":{"at":{"position":[0,0],"direction":[1,0]}},"length":1,"thickness":0.1,"segments":9}',
        "fluid.cylinders=[]",
        "fluid.inflow=null",
        'fluid.inflow.mean_velocity={"sine":{"amplitude":1,"frequency":1}}',
    ],
)
def test_what_is_no_cylinder_alone_in_an_inflow_has_no_coefficients(scene, assignment):
    override(scene, assignment)
    assert coefficients.scale(Facts(validate(scene))) is None


def test_a_known_oscillation_gives_its_own_coefficients(scene):
    time = np.arange(0, 7, 1e-3)
    columns = {
        "time": time,
        "drag": 0.16 + 0.0016 * np.cos(4 * np.pi * 3 * time),
        "lift": 0.05 * np.sin(2 * np.pi * 3 * time),
    }
    found = coefficients.evaluate(scale_of(scene), columns, statistics.find_window(time, columns["lift"]), 0.0)
    expected = {"cd_max": 3.232, "cd_min": 3.168, "cd_mean": 3.2, "cl_max": 1.0, "cl_min": -1.0, "cl_peak_to_peak": 2.0}
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=1e-4)
    assert found["cl_mean"] == pytest.approx(0, abs=1e-3)
    assert found["st"] == pytest.approx(0.3, rel=1e-5)


def test_the_extremes_are_those_of_the_last_five_periods(scene):
    time = np.arange(0, 10, 1e-3)
    drag = np.where(time < 5, 0.15, 0.16)  # the drag still grows where the lift has settled
    columns = {"time": time, "drag": drag, "lift": 0.05 * np.sin(2 * np.pi * 3 * time)}
    found = coefficients.evaluate(scale_of(scene), columns, statistics.find_window(time, columns["lift"]), 0.0)
    assert found["cd_min"] == pytest.approx(3.2)


@pytest.mark.parametrize("amplitude", [0.0, 1e-12])
def test_a_lift_without_a_frequency_has_no_strouhal_number(scene, amplitude):
    time = np.linspace(0, 1, 101)
    still = {"time": time, "drag": 0.16 + 0 * time, "lift": amplitude * np.sin(4 * np.pi * time)}
    found = coefficients.evaluate(scale_of(scene), still, statistics.Window(0.0, 1.0, 2), 0.0)
    assert found["cd_max"] == pytest.approx(3.2) and "st" not in found


def test_the_pressure_difference_is_between_the_probes_on_the_cylinder(scene):
    override(scene, 'fluid.probes=[{"name":"b","position":[0.25,0.2]},{"name":"a","position":[0.15,0.2]}]')
    time = np.linspace(0, 1, 101)
    steady = {"drag": 0.28 + 0 * time, "lift": 0 * time, "probe_a_p": 0.11 + 0 * time, "probe_b_p": -0.01 + 0 * time}
    scale = scale_of(scene)
    found = coefficients.evaluate(scale, {"time": time} | steady, statistics.Window(0.5, 1.0, 0), 0.0)
    assert found == pytest.approx({"cd_mean": 5.6, "cl_mean": 0.0, "dp_mean": 0.12})


def test_published_mean_of_the_drag_is_that_of_its_extremes():
    assert coefficients.published(load("cylinder-2d2-900x180").reference)["cd_mean"] == pytest.approx(3.195828)
    assert coefficients.published(load("cylinder-2d1-450x90").reference)["cd_mean"] == 5.57953523384
    assert coefficients.published(None) == {}
