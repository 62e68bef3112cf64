"""What people look at: pictures, fields, animations, tables, progress."""

from nervure.scene.types import Display

READ_IN = {"m": ("mm", 1e3)}  # Units that people read in another scale


def shown_in(unit: str | None, display: Display | None = None) -> tuple[str, float]:
    """The unit in which people read values in `unit`, and what those are multiplied by; with `display` lengths and
    times are multiples of a scene's own scales, and no unit of a force or an energy is shown."""
    if display is None:
        return READ_IN.get(unit or "", (unit or "", 1.0))
    own = {
        "m": display.length,
        "s": display.time,
        "1/s": f"1/{display.time}",
        "m/s": f"{display.length}/{display.time}",
    }
    return own.get(unit or "", ""), 1.0


def with_unit(name: str, unit: str) -> str:
    """The label of an axis."""
    return f"{name} [{unit}]" if unit else name
