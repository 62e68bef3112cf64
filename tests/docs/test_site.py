"""Every link of the documents has a target, here and on the site, and the reference of the site is complete."""

import json
import os
import re
import subprocess
from pathlib import Path

import make_pages
import pytest
import yaml

from nervure.resources import ROOT

FENCED = re.compile(r"^```.*?^```$|`[^`\n]*`", re.DOTALL | re.MULTILINE)
ROOMS = ("guide", "theory", "validation", "reference", "dev")
HEADING = re.compile(r"^#+ +(.*)$", re.MULTILINE)


def anchors(path: Path) -> set[str]:
    """Anchors of a page as Git hosts and the site make them of headings."""
    text = re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    plain = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower() for heading in HEADING.findall(text)]
    return {re.sub(r"[^\w\- ]", "", heading).replace(" ", "-") for heading in plain}


def broken(path: Path) -> list[str]:
    """Links of a page that lead nowhere."""
    wrong = []
    for _, _, target in make_pages.LINK.findall(FENCED.sub("", path.read_text(encoding="utf-8"))):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        there = Path(os.path.normpath(path.parent / name)) if name else path
        if not there.exists() or (anchor and there.suffix == ".md" and anchor not in anchors(there)):
            wrong.append(target)
    return wrong


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    make_pages.make(folder)
    return folder


def test_links_of_the_documents_lead_somewhere():
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=True)
    found = {name: wrong for name in listed.stdout.split() if (wrong := broken(ROOT / name))}
    assert not found, found


def test_links_of_the_site_lead_somewhere(site):
    found = {str(path.relative_to(site)): wrong for path in site.rglob("*.md") if (wrong := broken(path))}
    assert not found, found


def test_every_document_is_on_the_site(site):
    def pages(part):
        return [part] if isinstance(part, str) else [name for one in part for name in pages(next(iter(one.values())))]

    described = yaml.safe_load((ROOT / "site" / "mkdocs.yml").read_text(encoding="utf-8"))
    shown = pages(described["nav"])
    assert [name for name in shown if not (site / name).is_file()] == []
    rooms = [path.relative_to(ROOT / "docs") for path in (ROOT / "docs").glob("*/*.md")]
    assert {str(path) for path in rooms if path.parent.name in ROOMS} <= set(shown)


def test_the_reference_has_every_key_variable_and_option(site):
    schema = json.loads((ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8"))
    page = (site / "reference" / "scene.md").read_text(encoding="utf-8")
    for name, part in {"Scene": schema, **schema["$defs"]}.items():
        section = page.split(f"\n## {name}\n")[1].split("\n## ")[0]
        variants = [part, *part.get("oneOf", []), *part.get("anyOf", [])]
        missing = [key for one in variants for key in one.get("properties", {}) if f"| `{key}` |" not in section]
        assert not missing, (name, missing)
    for kind in ("rod", "fluid"):
        xml = (ROOT / "modelDescription" / f"fmu_{kind}.xml").read_text(encoding="utf-8")
        page = (site / "reference" / f"{kind}.md").read_text(encoding="utf-8")
        for name in {re.sub(r"\[\d+\]$", "", found) for found in re.findall(r'<ScalarVariable name="([^"]+)', xml)}:
            assert f"`{name}`" in page or f"`{name}[1 … " in page, name
    page = (site / "reference" / "command.md").read_text(encoding="utf-8")
    for option in ("--series-every SECONDS", "--force", "--vary", "--rod-fmu"):
        assert option in page, option
    page = (site / "reference" / "python.md").read_text(encoding="utf-8")
    assert "nervure.run(scene: Scene | str | Path" in page and "| `not_compared` | `str | None`" in page.replace(
        "\\", ""
    )


def test_no_equation_is_left_open():
    for path in (ROOT / "docs").rglob("*.md"):
        lines = path.read_text(encoding="utf-8").splitlines()
        assert sum(line == "$$" for line in lines) % 2 == 0, path


def test_examples_of_docstrings_are_code(site):
    text = (site / "reference" / "python.md").read_text(encoding="utf-8")
    assert "```pycon\n>>> " in text and ">>>" not in re.sub("```.*?```", "", text, flags=re.DOTALL)
