"""What the units do when they are mistreated: docs/reliability.md."""

from collections.abc import Callable, Iterator
from functools import partial

from nervure.resources import ROOT
from studies.tables import markdown

from ..store import Row, Rows, csv_rows

DOCS = ROOT / "docs"


def rows() -> Iterator[Row]:
    """docs/reliability.csv and docs/fuzz.csv: how many cases or inputs, and what came of them."""
    for row in csv_rows(DOCS / "reliability.csv"):
        yield Row(
            "reliability",
            row["check"],
            row["unit"],
            "cases",
            float(row["cases"]),
            wall_s=float(row["seconds"]),
            outcome="bad" if row["result"].startswith("**failed**") else "ok",
            reason=row["result"],
            command=f'make reliability ARGS="--only {row["check"]}"',
            source="docs/reliability.csv",
        )
    for row in csv_rows(DOCS / "fuzz.csv"):
        yield Row(
            "fuzz",
            row["target"],
            "",
            "inputs",
            float(row["inputs"]) if row["inputs"] else None,
            wall_s=float(row["seconds"]) if row["seconds"] else None,
            outcome="ok" if row["found"] == "nothing" else "bad",
            reason=row["found"],
            command="make fuzz",
            source="docs/fuzz.csv",
        )


def tables(rows: Rows) -> dict[str, Callable[[], list[str]]]:
    return {"reliability-checks": partial(checks, rows), "reliability-fuzz": partial(fuzz, rows)}


def checks(rows: Rows) -> list[str]:
    table = [
        [f"`{row.method}`", row.setting, f"{row.value:,.0f}", row.reason, f"{row.wall_s:.0f}"]
        for row in rows.of("reliability")
    ]
    return markdown(["check", "unit", "cases", "result", "time, s"], table)


def fuzz(rows: Rows) -> list[str]:
    def shown(number: float | None) -> str:
        return "" if number is None else f"{number:,.0f}"

    table = [[f"`{row.method}`", shown(row.value), shown(row.wall_s), row.reason] for row in rows.of("fuzz")]
    return markdown(["target", "inputs", "time, s", "found"], table)
