"""Takes what the studies left under docs/ into results.json, and makes the numbers that documents show."""

from dataclasses import asdict

from nervure.files import rounded

from . import leave_out, topics
from .cases import cases
from .store import Row, Rows
from .topics import fsi3


def everything(data: dict) -> None:
    """Replace what was taken in before; what the report itself has measured stays while it has such a case, and goes
    before the same from a study."""
    known = {(case.method, case.setting) for case in cases()}
    measured = Rows(
        row
        for row in data["rows"]
        if row.source == "measured" and (row.case == leave_out.CASE or (row.method, row.setting) in known)
    )
    keys = {(row.case, row.method, row.setting) for row in measured}
    found = [row for row in topics.rows() if (row.case, row.method, row.setting) not in keys]
    data["rows"] = Rows(Row(**rounded(asdict(row))) for row in measured + found)
    data["values"] = {key: asdict(value) for key, value in topics.values(data["rows"]).items()}
    data["machine"] |= fsi3.machines()
    data["series"] = fsi3.series()
