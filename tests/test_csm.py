"""The bar of Turek & Hron (2006) without the fluid: the shipped scenes against what is published."""

import json

import numpy as np
import pytest
from conftest import run_scene
from cosim.scene import ROOT, reference

pytestmark = pytest.mark.usefixtures("libraries")

TOLERANCE = 0.01
"""Of the deflection, the amplitude and the frequency: the rod has no shear and no curved root (docs/rod.md)."""

SET_BACK_TOLERANCE = 0.0015
"""The same with the clamp 0.64 mm further back, which makes up for both."""


def quantities(folder, name, *arguments):
    """What the summary of the scene called `name` has of the tip."""
    done = run_scene(ROOT / "scenes" / f"{name}.json", "--output", folder, "--quiet", *arguments)
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "summary.json").read_text())["quantities"]


def means(numbers):
    return np.array([numbers[name]["mean"] for name in ("tip_ux", "tip_uy")])


def test_csm1_comes_to_rest_at_the_published_deflection(tmp_path):
    found, published = quantities(tmp_path, "csm1"), means(reference("csm1")["primary"]["quantities"])
    for quantity in found.values():
        assert quantity["amplitude"] < 1e-6, "not at rest"
    error = np.linalg.norm(means(found) - published) / np.linalg.norm(published)
    assert error < TOLERANCE, f"{means(found)} against {published} m"


def test_csm1_with_the_clamp_set_back_has_both_components(tmp_path):
    found = means(quantities(tmp_path, "csm1", "--set", "rod.clamp_setback=0.64e-3"))
    assert found == pytest.approx(means(reference("csm1")["primary"]["quantities"]), rel=SET_BACK_TOLERANCE)
