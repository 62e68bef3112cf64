"""Documentation of an FMU, `documentation/index.html`, and its arrays as terminals."""

import re
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from lxml import etree
from lxml.builder import E

from nervure.resources import ROOT

PAGE = Path(__file__).with_name("page.html").read_text(encoding="utf-8")


STATIONS = ("x", "y", "z", "vx", "vy", "vz")
LOAD = ("force_x", "force_y", "force_z", "impedance")
BEAM = re.compile(r"(beam\[\d+\]|wing(\[\d+\])?)\.")  # Prefix of the arrays of one of several rods, or of a wing
TERMINALS = dict.fromkeys(STATIONS, "stations") | dict.fromkeys(LOAD, "load")
"""Terminals of arrays in FMI 3.0, where an array is one variable and a terminal may have several."""
DESCRIPTIONS = {"stations": "Positions and velocities of the stations", "load": "Load on the stations"}


@dataclass
class _Variable:
    """A scalar, or an array, of a model description."""

    name: str
    about: Any  # Element with causality and description
    value: Any  # Element with type and limits
    unit: str
    starts: list[str]
    references: list[int]
    members: list[str]  # Names of the elements of an array, in FMI 2.0


def _variables(description: str) -> list[_Variable]:
    """Return the variables of a model description of either version; the elements of an array are one variable."""
    root = etree.fromstring(description.encode("utf-8"))
    if root.get("fmiVersion") != "2.0":
        units = {kind.get("name"): kind.get("unit", "") for kind in root.find("TypeDefinitions")}
        return [_whole(variable, units) for variable in root.find("ModelVariables")]
    arrays: dict[str, _Variable] = {}
    for scalar in root.iterfind("ModelVariables/ScalarVariable"):
        name, is_element = scalar.get("name"), scalar.get("name").endswith("]")
        name = name.rpartition("[")[0] if is_element else name
        array = arrays.setdefault(name, _Variable(name, scalar, scalar[0], scalar[0].get("unit", ""), [], [], []))
        array.starts.append(scalar[0].get("start", ""))
        array.references.append(int(scalar.get("valueReference")))
        array.members += [scalar.get("name")] if is_element else []
    return list(arrays.values())


def _whole(variable: Any, units: dict[str, str]) -> _Variable:
    """Return a variable of FMI 3.0, with the `units` of the declared types."""
    unit, references = units.get(variable.get("declaredType"), ""), [int(variable.get("valueReference"))]
    name, dimension = variable.get("name"), variable.find("Dimension")
    starts = [start.get("value") for start in variable.iterfind("Start")] or variable.get("start", "").split()
    members = [f"{name}[{k + 1}]" for k in range(int(dimension.get("start")))] if dimension is not None else []
    return _Variable(name, variable, variable, unit, starts or [""], references, members)


def _row(variable: _Variable) -> str:
    """Return a row of the table of variables."""
    value, members, references = variable.value, variable.members, variable.references
    starts = list(dict.fromkeys(variable.starts))
    limits = " ".join(f"{sign} {value.get(bound)}" for bound, sign in (("min", "≥"), ("max", "≤")) if value.get(bound))
    cells = [
        f"{members[0]} … {members[-1]}" if members else variable.name,
        variable.about.get("causality"),
        value.tag,
        variable.unit,
        starts[0] if len(starts) == 1 else f"{starts[0]} … {starts[-1]}",
        limits,
        " – ".join(dict.fromkeys(map(str, (references[0], references[-1])))),
        variable.about.get("description"),
    ]
    return "<tr>" + "".join(f"<td>{escape(cell)}" for cell in cells)


def page(kind: str, description: str) -> str:
    """Return the page of unit `kind` with a model description."""
    root = etree.fromstring(description.encode("utf-8"))
    text = (ROOT / f"fmu-{kind}" / "documentation.html").read_text(encoding="utf-8").strip()
    rows = "\n".join(map(_row, _variables(description)))
    if root.get("fmiVersion") == "2.0":
        picture, arrays = "../model.png", "Elements of an array have value references in a row."
    else:
        picture, arrays = "../terminalsAndIcons/icon.png", "An array has one value reference."
    return PAGE.format(title=escape(root.get("modelName")), text=text, rows=rows, picture=picture, arrays=arrays)


def terminals(description: str) -> str:
    """Return terminalsAndIcons.xml (FMI 3.0) of the arrays of inputs and outputs. Under FMI 2.0 an array is a terminal
    with its elements as members; under FMI 3.0 arrays are the members, grouped by `TERMINALS`. Members have the names
    of the rod's variables, so that the terminals of a rod fit the terminals of a fluid with several rods."""
    arrays = [v for v in _variables(description) if v.members and v.about.get("causality") in ("input", "output")]
    listed: dict[str, Any] = {}
    for array in arrays:
        is_one = array.about is array.value  # In FMI 3.0
        beam = found[0] if (found := BEAM.match(array.name)) else ""
        own = array.name.removeprefix(beam)
        group = TERMINALS.get(own, own) if is_one else own
        name = beam + group
        if name not in listed:
            about = array.about.get("description") if group == own else DESCRIPTIONS[group]
            listed[name] = E.Terminal(name=name, matchingRule="plug", description=about)
        for member in [array.name] if is_one else array.members:
            names = {"variableName": member, "memberName": member.removeprefix(beam)}
            listed[name].append(E.TerminalMemberVariable(**names, variableKind="signal"))
    root = E.fmiTerminalsAndIcons(*([E.Terminals(*listed.values())] if listed else []), fmiVersion="3.0")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{etree.tostring(root, encoding="unicode", pretty_print=True)}'
