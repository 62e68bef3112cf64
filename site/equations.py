"""Turn equations between `$$` or `$` into MathML, a hook of mkdocs; browsers show MathML without a script."""

import re
from typing import Any

from latex2mathml.converter import convert

CODE = re.compile(r"(^```.*?^```$|`[^`\n]*`)", re.DOTALL | re.MULTILINE)
BLOCK = re.compile(r"^\$\$\n(.*?)\n\$\$$", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"\$(?=\S)([^$\n]+?)(?<=\S)\$")


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return the page with its equations converted; code stays."""
    parts = CODE.split(markdown)
    return "".join(part if part.startswith("`") else _converted(part) for part in parts)


def _converted(text: str) -> str:
    text = BLOCK.sub(lambda found: f'<div class="equation">{convert(found[1], display="block")}</div>', text)
    return INLINE.sub(lambda found: convert(found[1]), text)
