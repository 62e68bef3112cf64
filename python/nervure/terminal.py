"""What terminals, pipes and logs can show: no control signs of foreign texts, and signs that their encoding has."""

import codecs
import re
import sys
from typing import Any

import rich.console
from rich.text import Text

CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")  # All but tab and line feed
STAND_INS = {"–": "-", "…": "...", "±": "+-", "²": "^2", "³": "^3", "·": "*", "→": "->", "°": " deg"}
KIND = "nervure"  # Name of the treatment of signs that an encoding lacks


def legible(text: str) -> str:
    """Return a text with its control signs spelled out: a terminal would obey them."""
    return CONTROL.sub(lambda found: f"\\x{ord(found[0]):02x}", text)


def _replace(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(STAND_INS.get(sign, "?") for sign in error.object[error.start : error.end]), error.end


codecs.register_error(KIND, _replace)


def accept_all_signs() -> None:
    """Let the standard streams replace signs that their encoding lacks, where they would raise or write codes."""
    for stream in (sys.stdout, sys.stderr):
        if getattr(stream, "errors", None) in ("strict", "backslashreplace") and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=KIND)


class Console(rich.console.Console):
    """A console that shows any text on any standard stream."""

    def __init__(self, **options: Any):
        accept_all_signs()
        super().__init__(highlight=False, **options)

    def render_str(self, text: str, **options: Any) -> Text:
        return super().render_str(legible(text), **options)
