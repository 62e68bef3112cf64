"""What files of surfaces and of wings have in common: their size, their unit and the numbers of their nodes."""

from pathlib import Path

import numpy as np

from nervure.scene.keys import Document

MOST_BYTES = 64 << 20  # Largest file


def unit(place: Document) -> float | None:
    """Return the length of the unit of the file beside it, m; None where the units say what is wrong with it."""
    value = place.get("unit")
    if value is None:
        return 1.0
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return float(value) if is_number and value > 0 else None


def check_size(path: Path) -> None:
    """Raise `ValueError` for a file that is too large to read."""
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(f"it is larger than {MOST_BYTES >> 20} MB")


def check_nodes(corners: np.ndarray, count: int) -> None:
    """Raise `ValueError` where cells name a node, counted from 0, that a file of `count` nodes does not have: readers
    take a negative number as it is, and Python counts it from the end."""
    wrong = corners[(corners < 0) | (corners >= count)]
    if len(wrong):
        raise ValueError(
            f"it names the node {wrong[0]}, counted from 0, and has {count} nodes; numbers that count from the end of "
            "the list are not read"
        )
