"""Output for people: pictures, fields, animations, tables, progress."""

from nervure.scene.types import Display

READ_IN = {"m": ("mm", 1e3)}  # Units that are shown in another scale


def displayed_unit(unit: str | None, display: Display | None = None) -> tuple[str, float]:
    """Return the unit in which values in `unit` are shown, and the factor to it. With `display`, lengths and times are
    in a scene's own scales, and forces and energies have no unit."""
    if display is None:
        return READ_IN.get(unit or "", (unit or "", 1.0))
    own = {
        "m": display.length,
        "s": display.time,
        "1/s": f"1/{display.time}",
        "m/s": f"{display.length}/{display.time}",
    }
    return own.get(unit or "", ""), 1.0


def axis_label(name: str, unit: str) -> str:
    """Return the label of an axis."""
    return f"{name} [{unit}]" if unit else name
