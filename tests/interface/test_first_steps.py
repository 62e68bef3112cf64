"""What a newcomer types first: names that are slightly wrong, a scene of one's own, a package that is missing."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from nervure.catalogue import complete_key, shipped
from nervure.files import undone_on_error
from nervure.resources import ROOT, SCENES
from nervure.scene import load, read
from tests.conftest import FSI3, nervure

pytestmark = pytest.mark.usefixtures("libraries")


def test_scenes_are_listed_with_what_they_are():
    lines = nervure("scenes").stdout.splitlines()
    assert [line.split()[0] for line in lines] == sorted(path.stem for path in SCENES.glob("*.json"))
    assert all(len(line.split()) > 3 for line in lines), "each has a description"
    (flag,) = [one for one in json.loads(nervure("scenes", "--json").stdout) if one["name"] == "fsi3-325x72"]
    assert Path(flag["path"]) == FSI3 and "FSI3" in flag["description"]


@pytest.mark.parametrize("base", ["vein-3d", "fsi3-325x72", "filament-pair-192x128"])
def test_a_new_scene_is_the_old_one_in_its_own_words_under_another_name(base, tmp_path):
    done = nervure("new", "mine", "--from", base, cwd=tmp_path)
    assert done.returncode == 0 and "nervure run mine.json" in done.stdout, done.stderr
    written = (tmp_path / "mine.json").read_text()
    changed = [new for new, old in zip(written.splitlines(), (SCENES / f"{base}.json").read_text().splitlines())
               if new != old]  # fmt: skip
    assert len(changed) == 2, changed
    schema = read(tmp_path / "mine.json")["$schema"]
    assert Path(schema.removeprefix("file://")).is_file() and load(tmp_path / "mine.json").name == "mine"
    again = nervure("new", "mine.json", "--from", "csm1", cwd=tmp_path)
    assert again.returncode == 2 and "replaces no file" in again.stderr, again.stderr
    assert (tmp_path / "mine.json").read_text() == written


def test_a_scene_written_another_way_is_copied_too(rod_only, tmp_path):
    """The name stands in another place first, and escaped."""
    rod_only |= {"description": '"name": "falling-rod"', "$schema": "x"}
    (tmp_path / "scene.json").write_text(json.dumps(rod_only).replace('"name": "falling', '"name" : "\\u0066alling'))
    done = nervure("new", "mine", "--from", tmp_path / "scene.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    schema = {"$schema": read(tmp_path / "mine.json")["$schema"]}
    assert read(tmp_path / "mine.json") == rod_only | {"name": "mine"} | schema


@pytest.mark.parametrize(
    ("typed", "found"),
    [
        ("fluid.cha", ["fluid.channel", *(f"fluid.channel.{axis}" for axis in "yxz")]),
        ("fluid.box.c", ["fluid.box.cells"]),
        ("fluid.cylinders.0.r", ["fluid.cylinders.0.radius"]),
        ("rods.1.rod.dam", ["rods.1.rod.damping"]),
        ("rod.colour", []),
    ],
)
def test_keys_are_completed(typed, found):
    assert complete_key(typed) == found


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["sce"], ["scenes"]),
        (["run", "csm"], ["csm1", "csm2", "csm3"]),
        (["run", "my"], ["my-vein.json"]),
        (["new", "x", "--from", "csm1"], ["csm1"]),
        (["run", "csm1", "--set", "time.en"], ["time.end"]),
        (["sweep", "csm1", "--vary", "beam.se"], ["beam.segments"]),
        (["run", "csm1", "--set", "time.end="], []),
    ],
    ids=" ".join,
)
def test_a_shell_completes_what_is_typed(words, found, tmp_path):
    (tmp_path / "my-vein.json").write_text("{}")
    asked = {"COMP_WORDS": " ".join(["nervure", *words]), "COMP_CWORD": str(len(words))}
    environment = os.environ | asked | {"_NERVURE_COMPLETE": "complete_bash"}
    code = "import sys; sys.argv[0] = 'nervure'; from nervure.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.stdout.split() == found, done.stderr


def test_every_key_of_every_scene_can_be_completed():
    def paths(value, place=""):
        parts = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
        for key, part in parts:
            if isinstance(part, dict) or isinstance(value, dict):
                yield f"{place}{key}"
            yield from paths(part, f"{place}{key}.")

    free = ("reference.", "rod.material.section.calibration.")  # Names are the author's, not the schema's
    for one in shipped():
        missing = [
            path for path in paths(read(one.path)) if path not in complete_key(path) and not path[-1].isdecimal()
        ]
        assert [path for path in missing if not path.startswith(free)] == [], one.name


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["rnu", FSI3], ["Did you mean 'run'?"]),
        (["run", "my"], ["did you mean my-vein.json?"]),
        (["run", "csm9"], ["did you mean csm"]),
        (["run", FSI3, "--set", "tme.end=1", "--set", "rod.materal.density=2"], ["mean time?", "mean material?"]),
        (["run", FSI3, "--set", "rod.material.section.x=1"], ["there is no `rod.material.section`", "as a whole"]),
        (["run", FSI3, "--set", "fluid.cylinders.3.radius=1"], ["`fluid.cylinders` is a list of 1, counted from 0"]),
        (["run", FSI3, "--set", "fluid.density.x=1"], ["`fluid.density` has no parts"]),
        (["sweep", FSI3, "--vary", "beam.segmens=3,4"], ["unknown key `beam.segmens`: did you mean `segments`?"]),
        (["sweep", FSI3, "--vary", "beam.segments=[]"], ["must be of the form"]),
        (["sweep", FSI3, "--workers", "2", "--scheduler", "x"], ["--workers", "--scheduler"]),
        (["animate", "nowhere"], ["nowhere holds no fields", "--fields-every"]),
        (["new", "-x.y/", "--from", "csm1"], ["No such option"]),
        (["new", "x y", "--from", "csm1"], ['`name` is "x y"']),
        (["new", "x"], ["Missing option '--from'"]),
    ],
    ids=lambda value: " ".join(map(str, value[:3])).replace("/", "-")[-40:] if isinstance(value[0], str) else "",
)
def test_a_slip_is_answered_with_what_was_meant(arguments, said, tmp_path):
    (tmp_path / "my-vein.json").write_text("{}")
    done = nervure(*arguments, cwd=tmp_path, env=os.environ | {"COLUMNS": "300"})
    assert done.returncode == 2 and "Traceback" not in done.stderr, done.stderr
    for part in said:
        assert part in done.stderr, done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["my-vein.json"], "nothing was run"


def test_all_errors_of_a_file_are_said_at_once(rod_only, tmp_path):
    rod_only["beam"] |= {"length": -1, "segmens": 3}
    rod_only["time"]["end"] = "soon"
    (tmp_path / "scene.json").write_text(json.dumps(rod_only, indent=1))
    done = nervure("run", tmp_path / "scene.json")
    assert done.returncode == 2
    for part in ("`beam.length`", "did you mean `segments`?", "`time.end`"):
        assert f"{part}" in done.stderr and done.stderr.count("scene.json, line") == 3, done.stderr


@pytest.mark.parametrize(
    ("package", "arguments"),
    [
        ("h5py", ["run", "csm1", "--fields-every", "0.01"]),
        ("h5py", ["animate", "FIELDS"]),
        ("distributed", ["sweep", "csm1", "--vary", "beam.segments=3,4"]),
    ],
)
def test_a_package_that_is_missing_is_named_with_the_line_that_installs_it(package, arguments, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    done = nervure(*arguments, cwd=tmp_path)
    assert done.returncode == 2 and f"{sys.executable} -m pip install {package}" in done.stderr, done.stderr
    assert not list(tmp_path.iterdir()), "a refusal leaves nothing"


def test_a_package_that_is_missing_costs_no_checkpoint(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    (tmp_path / "checkpoint.npz").write_text("of an earlier run")
    done = nervure("run", "csm1", "--output", tmp_path, "--force", "--fields-every", "0.01")
    assert done.returncode == 2 and (tmp_path / "checkpoint.npz").exists(), done.stderr


@pytest.mark.parametrize("arguments", [["--rod-fmu", "FMU"], ["--fields-every", "-1"], ["--set", "name=nul/x"]])
def test_a_run_that_cannot_begin_leaves_nothing(arguments, rod_only, tmp_path):
    (tmp_path / "FMU").write_text("no FMU")
    (tmp_path / "scene.json").write_text(json.dumps(rod_only))
    before = set(tmp_path.iterdir())
    done = nervure("run", "scene.json", *arguments, cwd=tmp_path)
    assert done.returncode == 2 and set(tmp_path.iterdir()) == before, done.stderr


def test_only_what_is_new_is_undone(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("kept")
    for folder, started in (("mine", False), ("new/inner", False), ("half", True)):
        with pytest.raises(ValueError, match="planted"), undone_on_error(tmp_path / folder) as keep:
            (tmp_path / folder).mkdir(parents=True, exist_ok=True)
            (tmp_path / folder / "unit.fmu").write_text("")
            keep() if started else None
            raise ValueError("planted")
    assert {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*")} == {
        "mine", "mine/notes.txt", "half", "half/unit.fmu"
    }  # fmt: skip


def test_examples_are_copied_as_the_documents_name_them(tmp_path):
    done = nervure("examples", "tried", cwd=tmp_path)
    assert done.returncode == 0 and "scripts/fsi3.py: Couple a rod FMU and a fluid FMU" in done.stdout, done.stderr
    document = (ROOT / "docs" / "reference" / "own-solver.md").read_text()
    for path in re.findall(r"python (\S+\.py) (\S+\.py) (\S+/\S+\.json)?", document):
        assert all((tmp_path / "tried" / part).is_file() for part in path if part), path
    assert (tmp_path / "tried" / "scenes" / read(FSI3)["$schema"]).is_file()
    again = nervure("examples", "tried", cwd=tmp_path)
    assert again.returncode == 2 and "must be a new folder" in again.stderr


@pytest.mark.parametrize("script", ["examples/pack.py", "scripts/gallery/own_solver.py"])
def test_a_script_without_pythonfmu_names_the_line_that_installs_it(script, tmp_path):
    (tmp_path / "pythonfmu.py").write_text("raise ImportError")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(
        [sys.executable, ROOT / script], env=environment, cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 2 and f"`{sys.executable} -m pip install pythonfmu`" in done.stderr, done.stderr
