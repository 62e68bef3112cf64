"""Columns of one of several rods and wings, or of a wing, under the names of a single rod."""

import numpy as np

from nervure.evaluate.statistics import Series
from nervure.scene import Scene, column_names, wings


def columns_of_units(series: Series, scene: Scene) -> dict[str, tuple[str, Series]]:
    """Return by unit the name that the fluid has for each rod and wing, and its columns without the name of the unit,
    the fluid's as `beam_…`; of only one all columns. On a flyer the tip of one of several wings moves against the
    root."""
    found: dict[str, tuple[str, Series]] = {}
    for name, (prefix, force) in column_names(scene).items():
        columns = dict(_columns(series, prefix, force) if prefix else wing_columns(series))
        for axis in "xyz" if prefix and name in wings(scene) else "":
            root = series.get(f"body_{name}_root_{axis}", np.zeros(1))
            for tip in {f"tip_u{axis}", f"rigid_tip_u{axis}"} & columns.keys():
                columns[tip] = columns[tip] - (root - root[0])
        found[name] = force, columns
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
