"""The bar of Turek & Hron (2006) without the fluid: the shipped scenes against what is published."""

import json

import pytest

from nervure.scene import load
from tests.conftest import run_scene

pytestmark = pytest.mark.usefixtures("libraries")

TOLERANCE = 0.003
"""Of both components at rest. Shear and clamp follow linear elasticity (docs/theory/rod.md); nothing is fitted."""


def quantities(folder, name, *arguments):
    """What the summary of the scene called `name` has of the tip."""
    done = run_scene(name, "--output", folder, "--quiet", *arguments)
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "summary.json").read_text())["quantities"]


TIP = ("tip_ux", "tip_uy")


@pytest.mark.parametrize("name", ["csm1", "csm2"])
def test_the_bar_comes_to_rest_at_the_published_deflection(name, tmp_path):
    found, published = quantities(tmp_path, name), load(name).reference.quantities
    for quantity in found.values():
        assert quantity["amplitude"] < 1e-6, "not at rest"
    assert [found[name]["mean"] for name in TIP] == pytest.approx([published[name].mean for name in TIP], rel=TOLERANCE)
