"""Quantities along a beam, as the units read them off a scene: a number, or a law of the place."""

import numpy as np

from nervure.scene.types import Beam, SpanwiseProfile, SpanwiseProfileTaper


def along(quantity: float | SpanwiseProfile, s: np.ndarray) -> np.ndarray:
    """Values at the places `s`, 0 at the root and 1 at the tip."""
    if isinstance(quantity, SpanwiseProfileTaper):
        law = quantity.taper
        root, tip = law.root ** (1 / law.power), law.tip ** (1 / law.power)
        return np.asarray(((1 - s) * root + s * tip) ** law.power)
    if isinstance(quantity, int | float):
        return np.full(np.shape(s), float(quantity))
    return np.asarray(np.interp(s, quantity.points.s, quantity.points.values))


def places(beam: Beam) -> np.ndarray:
    """Of the stations of `beam`, `[segments + 1]`."""
    return np.linspace(0, 1, beam.segments + 1)


def thickness(beam: Beam) -> np.ndarray:
    """Thickness at the stations of `beam`, m: `[segments + 1]`."""
    return along(beam.thickness, places(beam))
