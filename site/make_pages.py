"""Gather the Markdown of the project for its site, and write the pages of its reference.

    python site/make_pages.py target/site/pages

A document keeps its text, and gets the scripts of the gallery at their marks; a link points to the place of its target
on the site, or becomes plain text where the site has no such page. Scene keys come from the JSON Schema, variables from
the model descriptions, options from the command, messages from their record, and Python from docstrings and the
comments of fields.
"""

import ast
import csv
import dataclasses
import inspect
import itertools
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import gallery
import typer
from lxml import etree

import nervure
from nervure import cli
from nervure.evaluate import flapping, statistics
from nervure.resources import ROOT
from nervure.simulation import results, summary

LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^()\s]+)\)")
FENCE = re.compile(r"(^```.*?^```$)", re.DOTALL | re.MULTILINE)
PICTURES = {".png", ".gif", ".svg", ".mp4"}
ELEMENT = re.compile(r"(.+)\[(\d+)\]$")


def documents() -> dict[Path, Path]:
    """Return the place on the site of each page and picture, by its place in the repository."""
    found: dict[Path, Path] = {Path("README.md"): Path("index.md"), Path("docs/README.md"): Path("documents.md")}
    found[Path("lab/page/index.html")] = Path("lab/index.html")  # `make site` puts the built page in its place
    crates = [f"crates/{name}/README.md" for name in ("fmi-export", "cargo-fmu")]
    for given in ("CONTRIBUTING.md", "CHANGELOG.md", "modelDescription/README.md", *crates):
        found[Path(given)] = Path(given)
    for path in sorted((ROOT / "docs").rglob("*")):
        if path.suffix == ".md" or path.suffix in PICTURES:
            name = path.relative_to(ROOT)
            found.setdefault(name, name.relative_to("docs"))
    return found


def with_links(text: str, source: Path, pages: dict[Path, Path]) -> str:
    """Return the Markdown `text` of the file `source` with the links of the site."""

    def link(found: re.Match[str]) -> str:
        mark, label, target = found.groups()
        if re.match(r"[a-z]+:", target) or target.startswith("#"):
            return found[0]
        path, _, anchor = target.partition("#")
        wanted = Path(os.path.normpath(source.parent / path))
        if wanted not in pages:
            return label
        there = os.path.relpath(pages[wanted], pages[source].parent)
        return f"{mark}[{label}]({there}{'#' if anchor else ''}{anchor})"

    lab = os.path.relpath(ROOT / "lab" / "page" / "index.html", (ROOT / source).parent)
    text = gallery.MARK.sub(lambda found: gallery.told(found[1], lab), text)
    parts = FENCE.split(text)
    return "".join(part if part.startswith("```") else LINK.sub(link, part) for part in parts)


def table(headings: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    lines = [list(headings), *([cell.replace("|", "\\|").replace("\n", " ") for cell in row] for row in rows)]
    lines.insert(1, ["---"] * len(lines[0]))
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def scene_page() -> str:
    """Return the page of all scene keys, with a section for each part."""
    schema = json.loads((ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8"))
    parts: dict[str, Any] = schema["$defs"]
    sections = [
        "# Scene keys\n\nA scene is one JSON file, and each section of this page is one of its parts. A part needs its "
        "*required* keys; every other key has a default. A part that is absent is not simulated.\n"
    ]
    for name, part in {"Scene": schema, **parts}.items():
        sections.append(f"## {name}\n\n{part.get('description', '')}\n")
        variants = part.get("oneOf") or part.get("anyOf") or []
        if part.get("properties"):
            sections.append(_keys(part))
        for variant in variants:
            if variant.get("properties"):
                sections.append(f"One of: {variant.get('description', variant.get('title', ''))}\n\n{_keys(variant)}")
            else:
                sections.append(f"One of: {_type(variant)}. {variant.get('description', '')}\n")
        if not part.get("properties") and not variants:
            sections.append(f"Type: {_type(part)}\n")
    return "\n".join(sections)


def _keys(part: dict[str, Any]) -> str:
    required = part.get("required", [])
    rows = []
    for key, about in part["properties"].items():
        default = "*required*" if key in required else f"`{json.dumps(about.get('default'), ensure_ascii=False)}`"
        rows.append((f"`{key}`", _type(about), default, about.get("description", "")))
    return table(("key", "type", "default", "meaning"), rows)


LIMITS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}


def _type(about: dict[str, Any]) -> str:
    """Return the type of a key in words, with links to parts."""
    if reference := about.get("$ref"):
        name = reference.rsplit("/", 1)[-1]
        return f"[{name}](#{name.lower()})"
    if several := about.get("anyOf") or about.get("oneOf"):
        return " or ".join(_type(one) for one in several if one.get("type") != "null")
    if "const" in about:
        return f"`{json.dumps(about['const'])}`"
    if "enum" in about:
        return " or ".join(f"`{json.dumps(value)}`" for value in about["enum"] if value is not None)
    kinds = about.get("type", "anything")
    words = [kind for kind in (kinds if isinstance(kinds, list) else [kinds]) if kind != "null"]
    said = " or ".join({"number": "number", "integer": "whole number", "array": "list"}.get(w, w) for w in words)
    if isinstance(items := about.get("items"), dict):
        said += f" of {_type(items)}"
    return " ".join([said, *(f"{sign} {about[limit]:g}" for limit, sign in LIMITS.items() if limit in about)])


def variables_page(kind: str) -> str:
    """Return the page of the variables of a unit, from its model description for FSI3; an array is one row."""
    root = etree.parse(ROOT / "modelDescription" / f"fmu_{kind}.xml").getroot()
    found: dict[str, tuple[int, Any]] = {}
    for scalar in root.iter("ScalarVariable"):
        element = ELEMENT.match(scalar.get("name"))
        name, number = (element[1], int(element[2])) if element else (scalar.get("name"), 0)
        known, first = found.get(name, (0, scalar))
        found[name] = max(number, known), first
    rows = []
    for name, (number, scalar) in found.items():
        (typed,) = (part for part in scalar if part.tag in ("Real", "Integer", "Boolean", "String"))
        shown = f"`{name}[1 … {number}]`" if number else f"`{name}`"
        about = typed.get("unit") or "", typed.get("start") or "", scalar.get("description") or ""
        rows.append((shown, scalar.get("causality") or "local", typed.tag, *about))
    head = (
        f"# Variables of the {kind}\n\n{root.get('description')}. The table lists the variables of FSI3 on 325 x 72; "
        "another scene has the variables of its own parts. [The contract](../modelDescription/README.md) lists the "
        "variables of any unit in this place.\n\n"
    )
    return head + table(("variable", "causality", "type", "unit", "start", "meaning"), rows)


def command_page() -> str:
    """Return the page of all commands with their arguments and options."""
    group: Any = typer.main.get_command(cli.app)
    sections = [f"# The command\n\n{group.help}\n"]
    for name, command in group.commands.items():
        context = typer.Context(command, info_name=f"nervure {name}")
        usage = command.get_usage(context).removeprefix("Usage: ")
        records = [parameter.get_help_record(context) for parameter in command.params]
        rows = [(f"`{shown}`", said) for shown, said in filter(None, records)]
        sections.append(f"## {name}\n\n```text\n{usage}\n```\n\n{inspect.cleandoc(command.help or '')}\n")
        sections.append(table(("argument or option", "meaning"), rows))
    return "\n".join(sections)


def python_page() -> str:
    """Return the page of the functions of `nervure` and of the fields of a run."""
    lead, _, example = inspect.cleandoc(nervure.__doc__ or "").partition("\n\n")
    code, _, rest = example.partition("\n\n")
    sections = [f"# Python\n\n{lead}\n\n```python\n{inspect.cleandoc(code)}\n```\n\n{rest}\n"]
    for name in nervure.__all__:
        sections.extend(_describe(f"nervure.{name}", getattr(nervure, name)))
    sections.append("## Fields of a run\n\n`run.summary` is a `Summary`, the content of `summary.json`.\n")
    for part in (results.Results, summary.Summary, summary.Quantity, statistics.Statistics, summary.Coefficients,
                 flapping.Flapping, summary.Interface, summary.Method, summary.UnitInfo):  # fmt: skip
        fields = table(("field", "type", "meaning"), _fields(part))
        sections.append(f"### {part.__name__}\n\n{inspect.getdoc(part)}\n\n{fields}")
    return "\n".join(sections)


def _describe(name: str, thing: Any) -> Iterator[str]:
    if inspect.isclass(thing):
        yield f"## {name}\n\n{inspect.getdoc(thing)}\n"
        methods = {"copy": nervure.Scene.copy} if thing is nervure.Scene else vars(thing)
        for method, function in methods.items():
            if inspect.isfunction(function) and not method.startswith("_"):
                owner = name.rpartition(".")[2].lower()
                yield f"### {method}\n\n```python\n{owner}.{method}{_signature(function)}\n```\n"
                yield f"{_told(function)}\n"
    else:
        yield f"## {name}\n\n```python\n{name}{_signature(thing)}\n```\n\n{_told(thing)}\n"


def _told(thing: Any) -> str:
    """Return a docstring with its examples as code."""
    paragraphs = (inspect.getdoc(thing) or "").split("\n\n")
    return "\n\n".join(f"```pycon\n{part}\n```" if part.startswith(">>>") else part for part in paragraphs)


def _signature(function: Any) -> str:
    signature = inspect.signature(function)
    own = [parameter for key, parameter in signature.parameters.items() if key != "self"]
    text = str(signature.replace(parameters=own))
    return re.sub(r"'([A-Z]\w*)'", r"\1", re.sub(r"\b(?:[a-z_]+\.)+(?=[A-Z])", "", text))


def _fields(part: Any) -> Iterator[tuple[str, str, str]]:
    """Yield name, type and comment of the fields of a dataclass, inherited fields included."""
    told: dict[str, tuple[str, str]] = {}
    for one in reversed([base for base in part.__mro__ if dataclasses.is_dataclass(base)]):
        source = inspect.getsource(one)  # type: ignore[arg-type]
        lines = source.splitlines()
        (tree,) = ast.parse(source).body
        assert isinstance(tree, ast.ClassDef)
        for node in tree.body:
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                _, _, comment = lines[node.lineno - 1].partition("  # ")
                told[node.target.id] = ast.unparse(node.annotation), comment
    for name, (kind, comment) in told.items():
        yield f"`{name}`", f"`{kind}`", comment


MESSAGES = """\
# Messages

nervure's messages about scenes, files and arguments that it refuses. Each ends with exit status 2, and nothing is
written. Types and ranges are those of the [scene keys](scene.md) and stand in the JSON Schema, so that an editor shows
them. An editor and nervure differ in two points: the schema accepts `8.0` for a whole number, and it does not see
contradictions between keys.
"""


def messages_page() -> str:
    """Return the page of the recorded messages about bad input."""

    def cell(text: str) -> str:
        return text.replace("|", "\\|").replace("<", "&lt;").replace("\n", "<br>")

    page = [MESSAGES]
    with (ROOT / "tests" / "scene" / "messages.csv").open(encoding="utf-8", newline="") as file:
        for heading, rows in itertools.groupby(csv.DictReader(file), lambda row: row["heading"]):
            page.append(f"\n## {heading}\n\n| given | message |\n|---|---|\n")
            page += (f"| `{cell(row['given'])}` | {cell(row['message'])} |\n" for row in rows)
    return "".join(page)


def make(folder: Path) -> None:
    """Write the pages into `folder`, and delete what the folder held before."""
    shutil.rmtree(folder, ignore_errors=True)
    shown = documents()
    for source, target in shown.items():
        (folder / target).parent.mkdir(parents=True, exist_ok=True)
        if source.suffix == ".md":
            text = with_links((ROOT / source).read_text(encoding="utf-8"), source, shown)
            (folder / target).write_text(text, encoding="utf-8")
        else:
            shutil.copy(ROOT / source, folder / target)
    reference = folder / "reference"
    reference.mkdir(exist_ok=True)
    pages = {"scene": scene_page, "command": command_page, "python": python_page, "messages": messages_page}
    for name, page in pages.items():
        (reference / f"{name}.md").write_text(page(), encoding="utf-8")
    for kind in ("rod", "fluid"):
        (reference / f"{kind}.md").write_text(variables_page(kind), encoding="utf-8")
    command = [sys.executable, "-m", "studies", "--tables", str(folder.resolve() / "tables")]
    subprocess.run(command, cwd=ROOT, check=True)
    shutil.copy(Path(__file__).with_name("site.css"), folder)


if __name__ == "__main__":
    make(Path(sys.argv[1]))
