"""What people look at: pictures, fields, animations, tables, progress."""

DISPLAY = {"m": ("mm", 1e3)}  # Units that people read in another scale


def shown_in(unit: str | None) -> tuple[str, float]:
    """The unit in which people read values in `unit`, and what those are multiplied by."""
    return DISPLAY.get(unit or "", (unit or "", 1.0))
