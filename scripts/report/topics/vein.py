"""docs/vein.md: the driven rod, from docs/vein/*.csv."""

from collections.abc import Iterator

import numpy as np

from cosim.scene import load, SCENES
from studies import tables, vein
from studies.vein_limits import CANTILEVER

from ..store import Row

COMMAND = "python scripts/studies/vein.py --only '{}'"

UNITS = {
    "thrust": "N/m",
    "lift": "N/m",
    "power_in": "W/m",
    "tip_amplitude": "m",
    "phase_lag_deg": "°",
    "reached_s": "s",
    "tip_uy": "m",
    "step_ms": "ms",
    "cpu_s": "s",
    "wall_s": "s",
    "amplitude": "N/m",
    "harmonic": "N/m",
    "phase_deg": "°",
}
"""Of the columns of the tables; the others are ratios and counts."""

TIMES = ("wall_s", "cpu_s")


def of(table: str, row: dict, name: str, command: str, **further) -> Iterator[Row]:
    """A row for each number of a line of docs/vein/TABLE.csv, whose case is `GROUP/NAME`."""
    group, _, setting = name.partition("/")
    for quantity, value in row.items():
        if isinstance(value, float) and quantity not in TIMES:
            yield Row(
                f"vein {group}",
                table,
                setting,
                quantity,
                value,
                UNITS.get(quantity, ""),
                command=command,
                source=f"docs/vein/{table}.csv",
                **further,
            )
