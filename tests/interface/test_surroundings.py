"""Consoles, notebooks, NumPy, files beside a scene, and other runs at the same time: what surrounds a run."""

import io
import os
import subprocess
import sys
from contextlib import redirect_stdout

import pytest

import nervure
from nervure import terminal
from nervure.output import console
from tests.conftest import TOOL

pytestmark = pytest.mark.usefixtures("libraries")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A short run of a rod."""
    return nervure.run("csm1", tmp_path_factory.mktemp("run"), overrides=["time.end=0.05"], quiet=True)


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp850", "cp932", "cp949", "cp1252"])
def test_results_are_shown_in_any_encoding(encoding, run):
    with redirect_stdout(io.TextIOWrapper(io.BytesIO(), encoding)) as out:
        console.text_console().print("from 1 – 2 ± 0.5, 東京", nervure.inspect(run.scene))
        out.flush()
    shown = out.buffer.getvalue().decode(encoding)
    assert "from 1 - 2 " in shown.replace("–", "-") and "steps" in shown and "?" in shown.replace("東京", "?"), shown


def test_a_command_runs_in_ascii_and_with_the_backend_of_a_notebook_that_is_elsewhere(tmp_path):
    strange = {"PYTHONIOENCODING": "ascii", "MPLBACKEND": "module://no_such_package.backend"}
    command = [*TOOL, "run", "csm1", "--end-time", "0.05", "--output", tmp_path / "run"]
    done = subprocess.run(command, env=os.environ | strange, capture_output=True, text=True)
    assert done.returncode == 0 and "0.033 - 0.050 s" in done.stdout, done.stderr
    script = "import nervure; nervure.read(r'{}').plot('tip_uy').savefig(r'{}')".format(
        tmp_path / "run", tmp_path / "tip.png"
    )
    done = subprocess.run([sys.executable, "-c", script], env=os.environ | strange, capture_output=True, text=True)
    assert done.returncode == 0 and (tmp_path / "tip.png").is_file(), done.stderr


def test_control_signs_of_a_scene_do_not_reach_the_terminal(rod_only, capsys):
    rod_only["description"] = "red \x1b[31mand\x07 more"
    nervure.inspect(nervure.scene.validate(rod_only))
    assert r"red \x1b[31mand\x07 more" in capsys.readouterr().out
    assert terminal.legible("a\tb\nc\x9b") == "a\tb\nc\\x9b"
