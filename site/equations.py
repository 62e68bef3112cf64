"""Turn equations between `$$` or `$` into MathML, and ship a font for them: a hook of mkdocs.

Browsers show MathML without a script, but only well with a mathematical font, which few readers have.
"""

import re
import shutil
from importlib.resources import files
from typing import Any

from latex2mathml.converter import convert

FONT = "STIXTwoMath-Regular.ttf"  # Of the package ziamath, under the SIL Open Font License
CODE = re.compile(r"(^```.*?^```$|`[^`\n]*`)", re.DOTALL | re.MULTILINE)
BLOCK = re.compile(r"^\$\$\n(.*?)\n\$\$$", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"\$(?=\S)([^$\n]+?)(?<=\S)\$")


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return the page with its equations converted; code stays."""
    parts = CODE.split(markdown)
    return "".join(part if part.startswith("`") else _converted(part) for part in parts)


def on_post_build(config: dict[str, Any], **_: Any) -> None:
    """Copy the font beside site.css, which names it."""
    with (files("ziamath") / "fonts" / FONT).open("rb") as font, open(f"{config['site_dir']}/{FONT}", "wb") as copy:
        shutil.copyfileobj(font, copy)


def _converted(text: str) -> str:
    text = BLOCK.sub(lambda found: f'<div class="equation">{convert(found[1], display="block")}</div>', text)
    # Markdown takes a `math` at the beginning of a line for a block of its own.
    return INLINE.sub(lambda found: f"<span>{convert(found[1])}</span>", text)
