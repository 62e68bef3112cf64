"""Random contacts of rods, wings and bodies, and what contact costs, by studies/rust/contact and `mixed`; `near`."""

from collections.abc import Iterator
from typing import Any

from studies import commands, mixed, near
from studies.engine import Case, Run, Study
from studies.store import Data

SOURCES = ("rod", "wing", "contact study")
MIXED = ("scene", "fluid", "rod", "wing", "coupling", "mixed contact")
COST = ("rod", "wing", "contact cost")


def cases() -> Iterator[Case]:
    command = commands.cargo("contact-study", "{folder}")
    yield Case("random", SOURCES, options={"command": command}, action=commands.tables)
    yield Case("mixed", MIXED, action=mixed.throw_all)
    command = commands.cargo("contact-study", "{folder}", example="cost")
    yield Case("cost", COST, options={"command": command}, action=commands.tables)
    yield from near.cases()


def extract(case: Case, run: Run) -> dict[str, Any]:
    """Return the table, with the times apart."""
    if case.name.startswith("near/"):
        return run.found
    rows = run.found["tables"]["cost" if case.name == "cost" else "random"]
    if case.name == "cost":
        milliseconds = ("without", "apart", "touching")
        seconds = [[1e-3 * row.pop(name) for name in milliseconds] for row in rows]
        return {"tables": {"cost": rows}, "times": {"seconds": seconds}}
    seconds = [row.pop("seconds") for row in rows]
    return {"tables": {"random": rows}, "times": {"seconds": seconds}}


def thrown(data: Data) -> list[dict[str, Any]]:
    """Return a row for each kind."""
    records = [*data.of("contact/random"), *data.of("contact/mixed")]
    return [row for record in records for row in record.tables["random"]]


def cost(data: Data) -> list[dict[str, Any]]:
    """Return a row for rod and wing: a step without contact, and by how much it is longer with it."""
    return [
        row | {"step": 1e3 * none, "apart": apart / none, "touching": touching / none}
        for own in data.of("contact/cost")
        for row, (none, apart, touching) in zip(own.tables["cost"], own.times["seconds"], strict=True)
    ]


STUDY = Study("contact", cases, extract, {"contact-random": thrown, "contact-cost": cost, "contact-near": near.rows})
