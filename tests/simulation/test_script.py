"""The masters in `scripts/`, which know fmpy alone, give what the command gives."""

import csv
import subprocess
import sys

import numpy as np
import pytest

import nervure
from nervure.resources import ROOT
from tests.conftest import FSI3, run_scene
from tests.coupling.test_flyer import pair

END = 0.05
"""Simulated time, s."""


def columns(path, names):
    with open(path, encoding="utf-8", newline="") as file:
        return [[row[name] for name in names] for row in csv.DictReader(file)]


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_the_script_alone_gives_the_digits_of_the_command(fmi, tmp_path, libraries):
    done = run_scene(FSI3, "--end-time", str(END), "--output", tmp_path, "--quiet", "--fmi", fmi)
    assert done.returncode == 0, done.stderr
    units = [tmp_path / f"fsi3-325x72-{kind}.fmu" for kind in ("rod", "fluid")]
    command = [sys.executable, ROOT / "scripts" / "fsi3.py", *units, tmp_path / "tip.csv", "--end", str(END)]
    subprocess.run(command, check=True)

    tip = ("ux", "uy", "vx", "vy")
    ours = columns(tmp_path / "series.csv", ["time", *(f"tip_{name}" for name in tip)])
    theirs = columns(tmp_path / "tip.csv", ["time", *(f"tip.{name}" for name in tip)])
    assert len(theirs) == round(END / 4e-4) + 1
    assert ours == theirs


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_flyer_flies_alike_in_the_script(fmi, tmp_path, libraries):
    scene = pair() | {"time": {"end": 0.05, "communication_step": 5e-3}}
    run = nervure.run(nervure.Scene.model_validate(scene), tmp_path, quiet=True, fmi=fmi)
    units = [str(tmp_path / "pair-"), tmp_path / "way.csv", "0.05", "left", "right"]
    subprocess.run([sys.executable, ROOT / "scripts" / "flyer.py", *units], check=True)
    way = np.array(columns(tmp_path / "way.csv", ["time", "y", "vy"]), float).T
    assert way == pytest.approx(np.array([run.series[name] for name in ("time", "body_y", "body_vy")]), rel=1e-9)
    assert way[1, -1] < 0


@pytest.mark.parametrize(("name", "lines"), [("fsi3.py", 90), ("flyer.py", 100)])
def test_a_script_stays_short_and_on_its_own(name, lines):
    text = (ROOT / "scripts" / name).read_text(encoding="utf-8")
    assert text.count("\n") <= lines and "import nervure" not in text and "from nervure" not in text
