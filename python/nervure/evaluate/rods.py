"""Columns of one of several rods, or of a wing, under the names of a single rod."""

import numpy as np

from nervure.evaluate.statistics import Series
from nervure.scene import Own, Scene, beams


def rod_columns(series: Series, own: Own) -> Series:
    """Return the columns of one rod, without its name in front, and the fluid's columns of its beam as `beam_…`; of a
    single rod all columns."""
    return _columns(series, own.prefix, own.force) if own.prefix else series


def columns_of_units(series: Series, scene: Scene) -> dict[str, tuple[str, Series]]:
    """Return by unit the name that the fluid has for each wing and rod, and its columns. On a flyer a tip moves against
    the root."""
    found = {"wing": ("wing", wing_columns(series))} if scene.wing else {}
    for number, name in enumerate((wing.name for wing in scene.wings), 1):
        columns = dict(_columns(series, f"{name}_", f"wing_{number}"))
        for axis in "xyz":
            root = series.get(f"body_{name}_root_{axis}", np.zeros(1))
            for tip in {f"tip_u{axis}", f"rigid_tip_u{axis}"} & columns.keys():
                columns[tip] = columns[tip] - (root - root[0])
        found[name] = f"wing_{number}", columns
    return found | {own.unit: (own.force, rod_columns(series, own)) for own in beams(scene)}


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
