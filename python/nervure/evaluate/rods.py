"""The columns of one of several rods under the names that those of a single one have."""

from nervure.evaluate.statistics import Series
from nervure.scene import Own


def seen(series: Series, own: Own) -> Series:
    """What of a run belongs to one rod: its columns without its name in front, and `beam_…` for what the fluid says of
    its beam. All columns where it is the only one."""
    if not own.prefix:
        return series
    known = {"time": series["time"]}
    for begins, here in ((own.prefix, ""), (f"{own.force}_", "beam_")):
        known |= {
            here + name.removeprefix(begins): values for name, values in series.items() if name.startswith(begins)
        }
    return known
