"""The master in `scripts/`, which knows fmpy alone, gives what the command gives."""

import csv
import subprocess
import sys

from nervure.resources import ROOT
from tests.conftest import FSI3, run_scene

END = 0.05
"""Simulated time, s."""


def columns(path, names):
    with open(path, encoding="utf-8", newline="") as file:
        return [[row[name] for name in names] for row in csv.DictReader(file)]


def test_the_script_alone_gives_the_digits_of_the_command(tmp_path, libraries):
    done = run_scene(FSI3, "--end-time", str(END), "--output", tmp_path, "--quiet")
    assert done.returncode == 0, done.stderr
    units = [tmp_path / f"fsi3-325x72-{kind}.fmu" for kind in ("rod", "fluid")]
    command = [sys.executable, ROOT / "scripts" / "fsi3.py", *units, tmp_path / "tip.csv", "--end", str(END)]
    subprocess.run(command, check=True)

    tip = ("ux", "uy", "vx", "vy")
    ours = columns(tmp_path / "series.csv", ["time", *(f"tip_{name}" for name in tip)])
    theirs = columns(tmp_path / "tip.csv", ["time", *(f"tip.{name}" for name in tip)])
    assert len(theirs) == round(END / 4e-4) + 1
    assert ours == theirs


def test_the_script_stays_short_and_on_its_own():
    text = (ROOT / "scripts" / "fsi3.py").read_text(encoding="utf-8")
    assert text.count("\n") < 80 and "import nervure" not in text and "from nervure" not in text
