"""The scripts of the gallery do what they say, over a short time."""

import json
import re
import runpy
import sys
from pathlib import Path

import gallery
import make_pages
import pytest
from PIL import Image

from nervure.resources import ROOT

pytestmark = [pytest.mark.usefixtures("libraries"), pytest.mark.pictures]
GALLERY = ROOT / "scripts" / "gallery"

CASES = {
    "fsi3.py": ("0.05", "the run has 0 whole periods", ["curves.png", "vorticity.gif", "phases.png", "series.csv"]),
    "flag.py": ("0.4", "mass ratio 0.3: the tip", ["tip.png", "vorticity.png", "mass-0.15/summary.json"]),
    "flapping_vein.py": ("3.1", "efficiency", ["stiffness.png", "stiffness-32/flapping.png"]),
    "other_master.py": ("0.01", "largest difference of the tip", ["tip.csv", "tip.png"]),
    "own_solver.py": ("0.3", "largest difference of the tip's way: 0.", ["tip.png", "modal-beam/summary.json"]),
    "segments.py": ("0.1", "64 segments: ", ["sweep.csv", "sweep.png"]),
    "sphere.py": ("0.04", "drag coefficient", ["speed.png"]),
}
"""End of the run, what it prints, what it writes."""


@pytest.mark.parametrize("name", CASES)
def test_a_script_of_the_gallery_runs(name, tmp_path, monkeypatch, capsys):
    end, said, written = CASES[name]
    monkeypatch.setattr(sys, "argv", [name, "--end", end, "--output", str(tmp_path / "out")])
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(GALLERY / name))
    printed = capsys.readouterr().out
    assert said in printed, printed
    for file in written:
        assert (tmp_path / "out" / file).stat().st_size > 0, file


def test_every_script_of_the_gallery_is_tried():
    assert {path.name for path in GALLERY.glob("*.py")} == CASES.keys()


def test_the_site_tells_of_every_script_what_it_printed():
    text = (ROOT / "docs" / "guide" / "gallery.md").read_text(encoding="utf-8")
    assert sorted(gallery.MARK.findall(text)) == sorted(path.stem for path in GALLERY.glob("*.py"))
    page = make_pages.with_links(text, Path("docs/guide/gallery.md"), make_pages.documents())
    for name, kept in json.loads(gallery.KEPT.read_text(encoding="utf-8")).items():
        assert "\n".join(["```text", *kept["printed"], "```"]) in page, name
        assert f"`scripts/gallery/{name}.py` took {kept['cpu_s']} s" in page, name
        assert kept["digest"] == gallery.digest(name), f"`python site/gallery.py {name}` runs the script again"
    scenes = {own["id"] for own in json.loads((ROOT / "lab" / "scenes.json").read_text(encoding="utf-8"))}
    linked = set(re.findall(r"\(\.\./lab/index\.html#(\w+)\)", page))
    assert set(gallery.LAB.values()) <= linked <= scenes


@pytest.mark.parametrize("path", sorted((ROOT / "docs" / "pictures").glob("*.gif")), ids=lambda path: path.stem)
def test_a_moving_picture_of_the_documents_is_wide_and_small(path):
    with Image.open(path) as film:
        assert film.width >= 720 and film.n_frames > 10  # type: ignore[attr-defined]
    assert path.stat().st_size < 3e6
