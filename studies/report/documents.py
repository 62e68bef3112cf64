"""Numbers in Markdown that come from results.json.

`<!--n:KEY-->1.23<!---->` is a number, and everything between `<!--table:NAME-->` and `<!--end-->` a table; both are
invisible in what is shown, and are written anew by `make report` or `python scripts/report render`.
"""

import re
from collections.abc import Callable

from nervure.resources import ROOT

from .store import Value

DOCUMENTS = tuple(
    ROOT / name
    for name in (
        "README.md",
        "docs/coupling.md",
        "docs/fluid.md",
        "docs/fluid-speed.md",
        "docs/fsi3.md",
        "docs/fsi3/thesis.md",
        "docs/reliability.md",
        "docs/rod.md",
        "docs/running.md",
        "docs/tutorial.md",
        "docs/vein.md",
    )
)
"""Documents with marks; docs/report and the studies' pages are written as a whole."""

NUMBER = re.compile(r"<!--n:([^>]*?)-->(.*?)<!---->")
TABLE = re.compile(r"<!--table:(\S+)-->\n(.*?)<!--end-->", re.S)

UNITS = "%|°|mm|cm|m|µs|ms|s|h|Hz|kHz|N|kN|W|MB|GB|kB|times|minutes|hours|cells"

FIGURE = r"[-+±]?(?:\d+\.\d+(?:e-?\d+)?|\d+e-?\d+)"

UNMARKED = re.compile(rf"(?<![\w.-])(?:{FIGURE}(?: ?(?:{UNITS})(?![\w/]))?|\d+ ?(?:{UNITS})(?![\w/]))")
"""What must not stand outside of a mark: decimal numbers, powers of ten, and numbers with a unit."""

FREE = {"3.11", "2.0"}
"""Decimal numbers that are names: of Python and of FMI."""

UNSEEN = (
    TABLE,
    NUMBER,
    re.compile(r"```.*?```", re.S),
    re.compile(r"`[^`]*`"),
    re.compile(r"^    .*$", re.M),
    re.compile(r"!\[[^\]]*\]"),
    re.compile(r"\]\([^)]*\)"),
    re.compile(r"\b(?:[Ee]qs?\.|[Tt]ables?|[Ff]igures?|[Ss]ections?|[Cc]hapters?) [\d.]+(?:(?:,| to| and| –) [\d.]+)*"),
)
"""Where numbers need no mark: settings and commands stand in code, links and pictures have them in names, other texts
in what they are cited by."""


def filled(text: str, values: dict[str, Value], tables: dict[str, Callable[[], list[str]]]) -> str:
    """`text` with its marked numbers and tables as they are now."""

    def number(match: re.Match) -> str:
        if match[1] not in values:
            raise KeyError(f"there is no value called {match[1]}")
        return f"<!--n:{match[1]}-->{values[match[1]]}<!---->"

    def table(match: re.Match) -> str:
        if match[1] not in tables:
            raise KeyError(f"there is no table called {match[1]}")
        lines = tables[match[1]]()
        return f"<!--table:{match[1]}-->\n" + "\n".join(lines) + "\n<!--end-->"

    return TABLE.sub(table, NUMBER.sub(number, text))


def unmarked(text: str) -> list[str]:
    """Numbers of a document that no mark covers."""
    for pattern in UNSEEN:
        text = pattern.sub("", text)
    return [found for found in UNMARKED.findall(text) if found not in FREE]


def used() -> tuple[set[str], set[str]]:
    """Keys of the numbers and names of the tables in all documents."""
    texts = [path.read_text(encoding="utf-8") for path in DOCUMENTS]
    return tuple({match[1] for text in texts for match in pattern.finditer(text)} for pattern in (NUMBER, TABLE))
