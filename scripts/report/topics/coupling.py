"""How the two are coupled: docs/coupling.md and docs/fsi3/stability.md."""

from collections.abc import Iterator
from pathlib import Path

from cosim.scene import ROOT
from studies import coupling as study

from ..store import Row, csv_rows, number


def rows() -> Iterator[Row]:
    """docs/fsi3/stability.csv."""
    for row in csv_rows(ROOT / "docs" / "fsi3" / "stability.csv"):
        ratio, c_eta, step, end = (float(row[name]) for name in ("ratio", "c_eta", "step", "end"))
        setting = f"density ratio {ratio:g}, C_eta {c_eta:g}, H {step:g}, to {end:g} s"
        reason = (
            row["message"]
            if row["outcome"] == "error"
            else f"noise of the lift {float(row['noise']):.2f}"
            if row["outcome"] == "bad"
            else ""
        )
        yield Row(
            "map coupling",
            row["scheme"],
            setting,
            "noise of the lift",
            number(row["noise"]),
            step=float(row["step"]),
            wall_s=number(row["wall_s"]),
            outcome=row["outcome"],
            reason=reason,
            source="docs/fsi3/stability.csv",
            command=f"make coupling-study ARGS=\"--only '{row['cell']}'\"",
        )


def pages() -> dict[Path, str]:
    return study.pages()
