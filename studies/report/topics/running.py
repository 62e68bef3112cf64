"""What it costs to keep something of a run: docs/running.md."""

from collections.abc import Iterator

from nervure.resources import ROOT

from ..store import Row, Rows, Value, csv_rows, value

UNITS = {"step_ms": "ms", "frame_ms": "ms", "checkpoint_ms": "ms", "checkpoint_mb": "MB"}

INTERVAL = 300.0
"""Time between checkpoints in the document's example, s."""


def rows() -> Iterator[Row]:
    """docs/running.csv."""
    for row in csv_rows(ROOT / "docs" / "running.csv"):
        for quantity, unit in UNITS.items():
            yield Row(
                "keeping",
                row["scene"],
                "",
                quantity,
                float(row[quantity]),
                unit,
                command="python scripts/studies/keeping.py",
                source="docs/running.csv",
            )


def values(rows: Rows) -> Iterator[tuple[str, Value]]:
    def of(quantity: str) -> Row:
        return rows.one("keeping", "fsi3-650x144", "", quantity)

    step, frame, checkpoint = of("step_ms"), of("frame_ms"), of("checkpoint_ms")
    yield "running.checkpoint.s", value(checkpoint, ".2f", "s", 1e-3)
    yield "running.checkpoint.mb", value(of("checkpoint_mb"), ".0f")
    yield "running.checkpoint.share", Value(checkpoint.value / 10 / INTERVAL, ".2f", "%", checkpoint.command)
    yield "running.frame.steps", Value(frame.value / step.value, ".0f", "steps", frame.command)
    yield "running.frame.ms", value(frame, ".0f")
