"""Consoles, notebooks, NumPy, files beside a scene, and other runs at the same time: what surrounds a run."""

import io
import json
import os
import re
import subprocess
import sys
import threading
import time
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nervure
from nervure import terminal
from nervure.files import LOCK
from nervure.library import library
from nervure.output import console
from nervure.resources import ROOT
from nervure.scene import validate
from nervure.simulation.session import Session
from nervure.units import package
from tests.conftest import FLUID_ONLY, TOOL

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
    nervure.inspect(validate(rod_only))
    assert r"red \x1b[31mand\x07 more" in capsys.readouterr().out
    assert terminal.legible("a\tb\nc\x9b") == "a\tb\nc\\x9b"


def test_numbers_and_booleans_of_numpy_are_those_of_python(rod_only, tmp_path):
    scene = validate(rod_only)
    scene.beam.segments = np.int64(8)
    scene = scene.copy({"time.end": np.float32(0.5), "rod.gravity": np.array([0, -2])})
    assert scene.document()["time"]["end"] == 0.5 and scene.rod.gravity == [0, -2]
    vary: Any = {"beam.segments": np.arange(8, 24, 8), "time.end": [np.float64(1e-3)]}
    rows = nervure.sweep(scene, vary, tmp_path / "sweep", workers=1, quiet=True)
    found = [(row["beam.segments"], row["status"]) for row in rows]
    assert found == [(8, "finished"), (16, "finished")], rows
    times: dict[str, Any] = {"checkpoint_every": np.int64(9), "series_every": np.float32(1e-3), "quiet": np.True_}
    run = nervure.run(scene.copy(time__end=1e-3), tmp_path / "run", **times)
    assert run.summary.completed


@pytest.mark.parametrize("answer", [True, np.True_, 1, np.array(True)], ids=repr)
def test_any_true_answer_to_a_step_ends_the_run(answer, tmp_path):
    scene = nervure.load("csm1", end_time=0.1)
    run = nervure.run(scene, tmp_path / "run", quiet=True, on_step=lambda t, _row: answer if t > 0.05 else 0)
    assert abs(run.series["time"][-1] - 0.055) < 1e-9, run.series["time"][-1]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda scene: setattr(scene.beam, "segments", "eight"), "`segments` is 'eight', but must be a whole number"),
        (lambda scene: setattr(scene.beam, "segmens", 8), "unknown key `segmens`: did you mean segments?"),
        (lambda scene: type(scene.beam)(length=1.0), "the key `root` is missing"),
        (lambda scene: scene.copy({"beam.segmens": 8}), "unknown key `beam.segmens`: did you mean segments?"),
        (lambda scene: scene.copy(rod=3), "`rod` is 3, but must be an object"),
        (
            lambda scene: scene.copy({"rod.root": {"torsion": {}}}),
            "unknown key `rod.root.torsion`: did you mean torsion_spring?",
        ),
        (
            lambda scene: scene.copy({"rod.root": {}}),
            "`rod.root` is empty, but must have exactly one of the keys torsion_spring, free",
        ),
        (
            lambda scene: scene.copy({"rod.root": {"free": {}, "torsion_spring": {"stiffness": 1}}}),
            "`rod.root` has free, torsion_spring, but must have exactly one of the keys free, torsion_spring",
        ),
    ],
)
def test_what_does_not_fit_a_key_is_said_in_a_sentence(change, said, rod_only):
    with pytest.raises(nervure.InputError) as refused:
        change(validate(rod_only))
    assert str(refused.value) == said


def test_a_new_scene_that_the_disk_does_not_take_leaves_nothing(tmp_path):
    (tmp_path / "long.json").write_text(json.dumps(FLUID_ONLY | {"description": "x" * 5000}))
    code = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)); from nervure.cli import main; "
    )
    command = [sys.executable, "-c", f"{code}sys.argv[1:] = ['new', 'mine', '--from', 'long.json']; main()"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2 and "cannot write mine.json: File too large" in done.stderr, done.stderr
    assert not (tmp_path / "mine.json").exists()


def test_two_runs_into_one_folder_at_once_are_one_and_a_refusal(rod_only, tmp_path):
    """Also by `resume` and with `force`; what killed its owner leaves the folder free."""
    folder, seen = tmp_path / "run", []

    def run_another(*_: object) -> bool:
        for another in (lambda: nervure.run(validate(rod_only), folder, force=True), lambda: nervure.resume(folder)):
            with pytest.raises(nervure.InputError, match="another run is writing into") as refused:
                another()
            seen.append(refused.value)
        return False

    folder.mkdir()
    (folder / LOCK).write_text("")
    nervure.run(validate(rod_only).copy(time__end=2e-4), folder, quiet=True, on_step=run_another)
    assert len(seen) == 6 and (folder / "summary.json").is_file() and not (folder / LOCK).exists()


def test_units_are_packed_into_a_relative_folder_while_fmpy_loads_them_from_another(rod_only, tmp_path, monkeypatch):
    move, pack, moved = os.chdir, package.pack, threading.Event()

    def move_slowly(folder):
        move(folder)
        moved.set()
        time.sleep(0.5)

    def pack_then(*arguments):
        assert moved.wait(30)
        return pack(*arguments)

    monkeypatch.setenv("NERVURE_LIBRARIES", os.path.relpath(library("rod").parent, tmp_path))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(os, "chdir", move_slowly)
    monkeypatch.setattr(package, "pack", pack_then)
    Session.packed(validate(rod_only), Path("results")).close()
    assert len(list((tmp_path / "results").glob("*.fmu"))) == 1


def test_a_time_outside_of_a_run_is_refused(tmp_path):
    pytest.importorskip("h5py")
    scene = validate(FLUID_ONLY).copy(time__end=2e-3)
    run = nervure.run(scene, tmp_path / "run", fields_every=1e-3, quiet=True)
    for moment in (-1.0, 3e-3, float("nan")):
        said = "goes from 0 to 0.002 s, but the time is|time is nan, but must be a finite number"
        with pytest.raises(nervure.InputError, match=said):
            run.plot_field("vorticity", moment)
    run.plot_field("vorticity", 2e-3)


def test_what_the_master_moves_names_the_page_whose_example_runs(rod_only, tmp_path, monkeypatch):
    rod_only["rod"]["root_motion"] = "master"
    with pytest.raises(nervure.InputError, match="`drive` of `nervure.run`, .* .docs/guide/drive.md.") as refused:
        nervure.run(validate(rod_only), tmp_path / "run", quiet=True)
    page = ROOT / re.findall(r"docs/\S+\.md", str(refused.value))[0]
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    (example,) = (block for block in blocks if "drive=" in block)
    monkeypatch.chdir(tmp_path)
    exec(example, {"nervure": nervure})
    found = nervure.read(tmp_path / "steered").series["tip_uy"][-1]
    assert 0 < found < 1e-3, f"{found} m: the tip begins to follow a root that has risen by 5e-4 m"
