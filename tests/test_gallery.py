"""The scripts of the gallery do what they say, over a short time."""

import subprocess
import sys

import pytest
from PIL import Image

from nervure.resources import ROOT

pytestmark = pytest.mark.usefixtures("libraries")
GALLERY = ROOT / "scripts" / "gallery"

CASES = {
    "fsi3.py": ("0.05", "the run has 0 whole periods", ["curves.png", "vorticity.gif", "phases.png", "series.csv"]),
    "flapping_vein.py": ("3.1", "efficiency", ["stiffness.png", "stiffness-32/flapping.png"]),
    "own_solver.py": ("0.3", "largest difference of the tip's way: 0.", ["tip.png", "modal-beam/summary.json"]),
}
"""End of the run, what it prints, what it writes."""


@pytest.mark.parametrize("name", CASES)
def test_a_script_of_the_gallery_runs(name, tmp_path):
    end, said, written = CASES[name]
    command = [sys.executable, GALLERY / name, "--end", end, "--output", tmp_path / "out"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and said in done.stdout, done.stdout + done.stderr
    for file in written:
        assert (tmp_path / "out" / file).stat().st_size > 0, file


def test_every_script_of_the_gallery_is_tried():
    assert {path.name for path in GALLERY.glob("*.py")} == CASES.keys()


@pytest.mark.parametrize("path", sorted((ROOT / "docs" / "pictures").glob("*.gif")), ids=lambda path: path.stem)
def test_a_moving_picture_of_the_documents_is_wide_and_small(path):
    with Image.open(path) as film:
        assert film.width >= 720 and film.n_frames > 10  # type: ignore[attr-defined]
    assert path.stat().st_size < 3e6
