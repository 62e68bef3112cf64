"""Columns of one of several rods, or of a wing, under the names of a single rod."""

from collections.abc import Sequence

import numpy as np

from nervure.evaluate.statistics import Series
from nervure.scene import Own


def rod_columns(series: Series, own: Own) -> Series:
    """Return the columns of one rod, without its name in front, and the fluid's columns of its beam as `beam_…`; of a
    single rod all columns."""
    return _columns(series, own.prefix, own.force) if own.prefix else series


def columns_of_wings(series: Series, names: Sequence[str]) -> dict[str, Series]:
    """Return the same of several wings by name. On a flyer a tip moves against the root."""
    found: dict[str, Series] = {}
    for number, name in enumerate(names, 1):
        own = dict(_columns(series, f"{name}_", f"wing_{number}"))
        for axis in "xyz":
            root = series.get(f"body_{name}_root_{axis}", np.zeros(1))
            for tip in {f"tip_u{axis}", f"rigid_tip_u{axis}"} & own.keys():
                own[tip] = own[tip] - (root - root[0])
        found[name] = own
    return found


def _columns(series: Series, prefix: str, force: str) -> Series:
    """Return the columns with a prefix without it, and those of the fluid on the part as `beam_…`."""
    known = {"time": series["time"]}
    for begins, here in ((prefix, ""), (f"{force}_", "beam_")):
        known |= {
            here + name.removeprefix(begins): values for name, values in series.items() if name.startswith(begins)
        }
    return known


def wing_columns(series: Series) -> Series:
    """Return all columns, and those of the fluid on a wing as `beam_…` too."""
    return {**series, **{f"beam_{name[5:]}": values for name, values in series.items() if name.startswith("wing_")}}
