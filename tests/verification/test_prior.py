"""Errors to expect before any run."""

import pytest

import nervure
from nervure.output import prior
from nervure.scene.facts import Facts
from tests.conftest import nervure as tool

pytestmark = pytest.mark.usefixtures("libraries")


def expected(name):
    return prior.expected(Facts(nervure.load(name)))


def test_a_recorded_scene_is_expected_to_have_about_its_recorded_errors():
    said = expected("fsi3-648x108")
    print(said)
    assert said.startswith("expect some ") and "in drag" in said and "in motion" in said and "fsi3" in said
    assert float(said.split()[2]) < 5


def test_coarser_cells_are_expected_to_be_worse():
    coarse, fine = (float(expected(name).split()[2]) for name in ("fsi3-324x54", "fsi3-1296x216"))
    print(coarse, fine)
    assert coarse > 2 * fine


def test_nothing_is_expected_of_scenes_that_no_run_is_like():
    assert expected("csm1") is None
    slow = nervure.load("cylinder-2d1-450x90").copy({"fluid.kinematic_viscosity": 1.0})
    assert prior.expected(Facts(slow)) is None


def test_inspect_says_what_to_expect():
    assert "expect some" in tool("inspect", "cylinder-2d1-450x90").stdout
