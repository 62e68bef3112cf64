"""Turn the equations between `$$` or `$` of all pages in a folder into MathML, and put a font for them there.

    python site/equations.py target/site/pages

Browsers show MathML without a script, but only well with a mathematical font, which few readers have.
"""

import re
import shutil
import sys
from importlib.resources import files
from pathlib import Path

from latex2mathml.converter import convert

FONT = "STIXTwoMath-Regular.ttf"  # Of the package ziamath, under the SIL Open Font License; site.css names it
CODE = re.compile(r"(^```.*?^```$|`[^`\n]*`)", re.DOTALL | re.MULTILINE)
BLOCK = re.compile(r"^\$\$\n(.*?)\n\$\$$", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"\$(?=\S)((?:[^$\n]|\n(?!\n))+?)(?<=\S)\$")  # May break at the end of a line


def converted(page: str) -> str:
    """Return the page with its equations converted; code stays."""
    return "".join(part if part.startswith("`") else _in_text(part) for part in CODE.split(page))


def _in_text(text: str) -> str:
    text = BLOCK.sub(lambda found: f'<div class="equation">{convert(found[1], display="block")}</div>', text)
    # Markdown takes a `math` at the beginning of a line for a block of its own.
    text = INLINE.sub(lambda found: f"<span>{convert(found[1])}</span>", text)
    if "$" in text:
        raise SystemExit(f"this is no equation: {text[text.index('$') :].splitlines()[0]}")
    return text


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for path in folder.rglob("*.md"):
        path.write_text(converted(path.read_text(encoding="utf-8")), encoding="utf-8")
    with (files("ziamath") / "fonts" / FONT).open("rb") as font, (folder / FONT).open("wb") as copy:
        shutil.copyfileobj(font, copy)
