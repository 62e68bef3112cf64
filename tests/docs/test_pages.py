"""All pages together keep to their number of words, and one page explains every warning."""

import ast
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from nervure.resources import ROOT
from studies.show import TABLE

MOST_WORDS = 30_000

WARN = ("crates/**/*warnings.rs", "crates/**/monitor.rs", "python/nervure/**/oscillations.py",
        "python/nervure/**/ranges.py")  # fmt: skip
"""Sources in which a sentence of some length that is yielded, or in Rust any, is a warning."""

LONG = 7
"""Least number of fixed words of such a sentence."""

PARTS = ("as a linear beam", "its weight", "`fluid.mask` has", "a short pulse of", "near …", "… near …")
"""Beginnings of those that are parts of another."""


def test_the_pages_have_at_most_30000_words_without_generated_tables():
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=True)
    words = {name: len(TABLE.sub("", (ROOT / name).read_text(encoding="utf-8")).split())
             for name in listed.stdout.split()}  # fmt: skip
    longest = sorted(words, key=lambda name: -words[name])[:5]
    assert sum(words.values()) <= MOST_WORDS, f"{sum(words.values())} words, most in {longest}"


def sentences(path: Path, told: bool = False) -> list[str]:
    """Texts of a source file, with `…` in the place of values; if asked so, of Python only what is yielded, at once or
    as `text`."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".rs":
        code = re.sub(r"\\\n\s*", "", re.sub(r"^\s*//.*$", "", text, flags=re.MULTILINE))
        return [re.sub(r"\{[^}]*\}", "…", found) for found in re.findall(r'"((?:[^"\\]|\\.)*)"', code)]

    def texts(node: ast.AST) -> Iterator[str]:
        if isinstance(node, ast.JoinedStr):
            yield "".join(str(part.value) if isinstance(part, ast.Constant) else "…" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value
        else:
            yield from (found for child in ast.iter_child_nodes(node) for found in texts(child))

    tree = ast.parse(text)
    assigned = [
        node for node in ast.walk(tree) if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "text"
    ]
    yielded = [node for node in ast.walk(tree) if isinstance(node, ast.Yield)]
    return [found for node in ([*assigned, *yielded] if told else [tree]) for found in texts(node)]


@pytest.fixture(scope="module")
def rows() -> list[str]:
    """First cells of the tables of the page."""
    text = (ROOT / "docs" / "guide" / "warnings.md").read_text(encoding="utf-8")
    cells = [line.split(" | ")[0].removeprefix("| ") for line in text.splitlines() if line.startswith("| ")]
    return [cell for cell in cells if cell != "warning"]


def tells(row: str, sentence: str) -> bool:
    """Whether the words of a row stand in a sentence in their order."""
    return re.search(".*".join(re.escape(part.strip()) for part in row.split("…")), sentence) is not None


def test_every_row_about_a_warning_has_the_words_of_one(rows):
    sources = [*ROOT.glob("crates/scene/src/**/*.rs"), *ROOT.glob("python/nervure/**/*.py")]
    known = [sentence for path in sources for sentence in sentences(path)]
    unknown = [row for row in rows if not any(tells(row, sentence) for sentence in known)]
    assert len(rows) > 30 and not unknown, unknown


@pytest.mark.parametrize("where", WARN)
def test_every_warning_has_its_row(where, rows):
    found = [sentence for path in ROOT.glob(where) for sentence in sentences(path, told=True)]
    long = [sentence for sentence in found if len(re.findall(r"\w+", sentence.replace("…", ""))) >= LONG]
    missing = [sentence for sentence in long if not any(tells(row, sentence) for row in rows)]
    missing = [sentence for sentence in missing if not sentence.startswith(PARTS)]
    assert long and not missing, missing
