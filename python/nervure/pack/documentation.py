"""What an FMU carries to be read: `documentation/index.html`, and its arrays as terminals."""

from html import escape
from pathlib import Path
from typing import Any

from lxml import etree
from lxml.builder import E

from nervure.resources import ROOT

PAGE = Path(__file__).with_name("page.html").read_text(encoding="utf-8")


def _arrays(description: str) -> dict[str, list[Any]]:
    """The `ScalarVariable` elements of a model description, those of an array together, by name without index."""
    arrays: dict[str, list[Any]] = {}
    for scalar in etree.fromstring(description.encode("utf-8")).iterfind("ModelVariables/ScalarVariable"):
        name = scalar.get("name")
        arrays.setdefault(name.rpartition("[")[0] if name.endswith("]") else name, []).append(scalar)
    return arrays


def _row(name: str, scalars: list[Any]) -> str:
    """A line of the table of variables."""
    first, value = scalars[0], scalars[0][0]
    starts = list(dict.fromkeys(scalar[0].get("start", "") for scalar in scalars))
    references = [scalar.get("valueReference") for scalar in (scalars[0], scalars[-1])]
    limits = " ".join(f"{sign} {value.get(bound)}" for bound, sign in (("min", "≥"), ("max", "≤")) if value.get(bound))
    cells = [
        name if first.get("name") == name else f"{name}[1] … {name}[{len(scalars)}]",
        first.get("causality"),
        value.tag,
        value.get("unit", ""),
        starts[0] if len(starts) == 1 else f"{starts[0]} … {starts[-1]}",
        limits,
        " – ".join(dict.fromkeys(references)),
        first.get("description"),
    ]
    return "<tr>" + "".join(f"<td>{escape(cell)}" for cell in cells)


def page(kind: str, description: str) -> str:
    """The page about unit `kind` under a model description."""
    title = etree.fromstring(description.encode("utf-8")).get("modelName")
    text = (ROOT / f"fmu-{kind}" / "documentation.html").read_text(encoding="utf-8").strip()
    rows = "\n".join(_row(name, scalars) for name, scalars in _arrays(description).items())
    return PAGE.format(title=escape(title), text=text, rows=rows)


def terminals(description: str) -> str:
    """terminalsAndIcons.xml (FMI 3.0): each array of inputs or outputs is a terminal with its elements as members."""
    listed = []
    for name, scalars in _arrays(description).items():
        if scalars[0].get("name") != name and scalars[0].get("causality") in ("input", "output"):
            members = [scalar.get("name") for scalar in scalars]
            elements = [E.TerminalMemberVariable(variableName=m, memberName=m, variableKind="signal") for m in members]
            about = {"name": name, "matchingRule": "plug", "description": scalars[0].get("description")}
            listed.append(E.Terminal(*elements, **about))
    root = E.fmiTerminalsAndIcons(*([E.Terminals(*listed)] if listed else []), fmiVersion="3.0")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{etree.tostring(root, encoding="unicode", pretty_print=True)}'
