"""A drive that moves the root of a plate by a table of a CSV file, between its rows by a cubic Hermite spline.

nervure run examples/steered-plate.json --drive examples/drive_table.py
"""

import csv
from bisect import bisect_right
from collections.abc import Mapping
from pathlib import Path

with open(Path(__file__).with_name("drive_table.csv"), encoding="utf-8") as file:
    rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
times = [row["time"] for row in rows]


def drive(time: float, _values: Mapping[str, float]) -> dict[str, float]:
    """Return every column of the table at `time` (s); columns of rates give the slopes."""
    k = min(max(bisect_right(times, time), 1), len(rows) - 1)
    before, after, width = rows[k - 1], rows[k], times[k] - times[k - 1]
    s = min(max((time - times[k - 1]) / width, 0.0), 1.0)
    found = {}
    for value, rate in (("root.y", "root.vy"), ("root.angle", "root.omega")):
        start, end = width * before[rate], width * after[rate]
        rise = after[value] - before[value]
        c, d = 3 * rise - 2 * start - end, start + end - 2 * rise
        found[value] = before[value] + s * (start + s * (c + s * d))
        found[rate] = (start + s * (2 * c + 3 * s * d)) / width
    return found
