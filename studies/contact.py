"""Random contacts of rods, wings and bodies, by studies/rust/contact."""

from collections.abc import Iterator
from typing import Any

from studies import commands
from studies.engine import Case, Run, Study
from studies.store import Data

SOURCES = ("rod", "wing", "contact study")


def cases() -> Iterator[Case]:
    command = commands.cargo("contact-study", "{folder}")
    yield Case("random", SOURCES, options={"command": command}, action=commands.tables)


def extract(case: Case, run: Run) -> dict[str, Any]:
    """Return the table, with the times apart."""
    rows = run.found["tables"]["random"]
    seconds = [row.pop("seconds") for row in rows]
    return {"tables": {"random": rows}, "times": {"seconds": seconds}}


def thrown(data: Data) -> list[dict[str, Any]]:
    """Return a row for each kind."""
    return data["contact/random"].tables["random"]


STUDY = Study("contact", cases, extract, {"contact-random": thrown})
