"""Numbers in Markdown that come from results.json.

`<!--n:KEY-->1.23<!---->` is a number, and everything between `<!--table:NAME-->` and `<!--end-->` a table; both are
invisible in
what is shown, and are written anew by `make report` or `python scripts/report render`.
"""

import re
from collections.abc import Callable
from pathlib import Path

from cosim.scene import ROOT

from .values import text_of

DOCUMENTS = ("README.md", "docs/fluid.md")
"""Documents with marks, besides docs/report, which is written as a whole."""

WHOLE = ("README.md",)
"""Those of them that have no number without a mark."""

NUMBER = re.compile(r"<!--n:([^>]*?)-->(.*?)<!---->")
TABLE = re.compile(r"<!--table:(\S+)-->\n(.*?)<!--end-->", re.S)

UNMARKED = re.compile(r"\d+\.\d+|\d[\d.]* ?%")
"""What must not stand outside of a mark: decimal numbers and percentages."""

FREE = {"3.11", "2.0"}
"""Decimal numbers that are names: of Python and of FMI."""


def filled(text: str, values: dict[str, dict], tables: dict[str, Callable[[], list[str]]]) -> str:
    """`text` with its marked numbers and tables as results.json has them."""

    def number(match: re.Match) -> str:
        if match[1] not in values:
            raise KeyError(f"results.json has no value called {match[1]}")
        return f"<!--n:{match[1]}-->{text_of(values[match[1]])}<!---->"

    def table(match: re.Match) -> str:
        lines = tables[match[1]]()
        return f"<!--table:{match[1]}-->\n" + "\n".join(lines) + "\n<!--end-->"

    return TABLE.sub(table, NUMBER.sub(number, text))


def unmarked(text: str) -> list[str]:
    """Numbers of a document that no mark covers; code, links and commands do not count."""
    for pattern in (TABLE, NUMBER, re.compile(r"```.*?```", re.S), re.compile(r"`[^`]*`"), re.compile(r"\]\([^)]*\)")):
        text = pattern.sub("", text)
    return [found for found in UNMARKED.findall(text) if found not in FREE]


def paths(names: tuple[str, ...] = DOCUMENTS) -> list[Path]:
    return [ROOT / name for name in names]
