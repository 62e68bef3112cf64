"""Columns of one of several rods under the names of a single rod."""

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
