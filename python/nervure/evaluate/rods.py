"""Columns of one of several rods, or of a wing, under the names of a single rod."""

from nervure.evaluate.statistics import Series
from nervure.scene import Own


def rod_columns(series: Series, own: Own) -> Series:
    """Return the columns of one rod, without its name in front, and the fluid's columns of its beam as `beam_…`; of a
    single rod all columns."""
    if not own.prefix:
        return series
    known = {"time": series["time"]}
    for begins, here in ((own.prefix, ""), (f"{own.force}_", "beam_")):
        known |= {
            here + name.removeprefix(begins): values for name, values in series.items() if name.startswith(begins)
        }
    return known


def wing_columns(series: Series) -> Series:
    """Return all columns, and those of the fluid on a wing as `beam_…` too."""
    return {**series, **{f"beam_{name[5:]}": values for name, values in series.items() if name.startswith("wing_")}}
