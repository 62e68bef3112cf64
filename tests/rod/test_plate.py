"""The shear factor and the set-back of the clamp in the shipped scenes are those of a plate in plane strain."""

import numpy as np
import pytest

from nervure.scene import read
from studies import plate

MESH = (24, 6)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.4])
def test_shear_factor_is_that_of_a_rectangle(poisson):
    """Cowper 1966 for plane strain: 10/(12 - nu)."""
    _, _, factor = plate.measure(np.inf, poisson, *MESH)
    print(f"nu = {poisson}: {factor:.5f} against {10 / (12 - poisson):.5f}")
    assert factor == pytest.approx(10 / (12 - poisson), rel=2e-3)


def test_scenes_have_the_set_back_and_the_shear_factor_of_their_bar():
    """The bar of Turek and Hron: nu = 0.4, clamped on a cylinder of 2.5 times its thickness."""
    scene = read("fsi3-325x72")
    by_moment, by_force, factor = plate.measure(2.5, 0.4, *MESH)
    thickness = scene["beam"]["thickness"]
    print(f"set-back {by_moment * thickness:.3e} m, {by_force * thickness:.3e} m; shear factor {factor:.4f}")
    assert scene["rod"]["clamp_compliance_length"] == pytest.approx(by_moment * thickness, rel=0.03)
    assert scene["rod"]["material"]["plane_strain"]["shear_factor"] == pytest.approx(factor, rel=3e-3)
