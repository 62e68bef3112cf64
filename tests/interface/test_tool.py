"""The command line as a whole: what each command shows or writes, and what it says when it cannot."""

import hashlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import zipfile
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from nervure import api
from nervure.errors import InputError
from nervure.library import library
from nervure.provenance import git_revision
from nervure.resources import ROOT
from nervure.scene import validate
from nervure.simulation import results
from nervure.units import delivery
from tests.conftest import FSI3, nervure, run_scene, stopped

pytestmark = pytest.mark.usefixtures("libraries")


LONG = "x" * 300
"""A name that no file may have."""


@pytest.fixture
def result(rod_only, tmp_path):
    """Function that runs the falling rod into a folder of `tmp_path`."""

    def make(name, *arguments):
        path = tmp_path / "scene.json"
        path.write_text(json.dumps(rod_only))
        done = run_scene(path, "--output", tmp_path / name, "--quiet", *arguments)
        assert done.returncode == 0, done.stderr
        return tmp_path / name

    return make


def test_nothing_heavy_is_loaded_before_it_is_needed():
    heavy = {"numpy", "pydantic", "fmpy", "matplotlib", "h5py", "PIL", "dask", "distributed"}
    code = f"import nervure.cli, sys; sys.exit(str({heavy} & set(sys.modules)) if {heavy} & set(sys.modules) else 0)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_build_packs_the_units_of_a_scene(tmp_path):
    done = nervure("build", FSI3, "--output", tmp_path)
    assert done.returncode == 0, done.stderr
    packed = [tmp_path / f"fsi3-325x72-{kind}.fmu" for kind in ("rod", "fluid")]
    assert done.stdout.split() == [str(path) for path in packed] and all(map(zipfile.is_zipfile, packed))


def test_build_writes_descriptions_alone(tmp_path):
    assert nervure("build", FSI3, "--descriptions", tmp_path).returncode == 0
    assert {path.name for path in tmp_path.iterdir()} == {"fmu_rod.xml", "fmu_fluid.xml"}
    assert (tmp_path / "fmu_rod.xml").read_bytes() == (ROOT / "modelDescription" / "fmu_rod.xml").read_bytes()


def test_inspect_shows_what_a_scene_will_do(small_fsi3, tmp_path):
    del small_fsi3["coupling"]
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(small_fsi3))
    shown = nervure("inspect", path, "--set", "time.end=4").stdout
    sizes = ("10000 of 0.0004 s to 4 s", "Re 100", "wall time", "160 x 36 cells", "20 segments, 21 stations")
    for part in ("rod and fluid", *sizes, "load ", "scheme ", " MB"):
        assert part in shown, shown


def test_inspect_shows_a_unit_by_arrays_and_a_run_as_it_printed_it(result):
    folder = result("falling")
    shown = nervure("inspect", folder / "falling-rod-rod.fmu").stdout
    for part in ("falling-rod.rod", "canGetAndSetFMUstate True", "force_x[1 … 17]", "N/m", "x[1 … 17]"):
        assert part in shown, shown
    (maker,) = (line.split() for line in shown.splitlines() if line.startswith(" made by"))
    assert maker[2] == "nervure-fmi-export" and len(maker) == 4, shown
    shown = nervure("inspect", folder).stdout
    for part in ("tip_uy amplitude", "100 steps to t = 0.01 s", "revision"):
        assert part in shown, shown


@pytest.mark.pictures
def test_plot_draws_the_same_from_the_table_as_the_run_did(result):
    folder = result("falling")
    first = (folder / "tip.png").read_bytes()
    (folder / "tip.png").unlink()
    done = nervure("plot", folder)
    assert done.returncode == 0, done.stderr
    assert (folder / "tip.png").read_bytes() == first


@pytest.mark.pictures
def test_plot_lays_several_runs_over_each_other(result, tmp_path):
    folders = result("falling"), result("floating", "--set", "rod.gravity=[0, 0]")
    none = nervure("plot", *folders)
    assert none.returncode == 2 and "--output" in none.stderr, none.stderr
    done = nervure("plot", *folders, "--output", tmp_path / "both")
    assert done.returncode == 0, done.stderr
    assert {path.name for path in (tmp_path / "both").iterdir()} == {"tip.png"}
    assert (tmp_path / "both" / "tip.png").read_bytes() != (folders[0] / "tip.png").read_bytes()


def test_resume_takes_scene_and_options_from_a_folder_that_was_moved(fluid_only, tmp_path):
    """Nothing of the command is repeated; the scene's file is gone, and the folder has another name."""
    fluid_only["time"]["end"] = 100.0
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(fluid_only))
    first = tmp_path / "first"
    options = ["--set", "time.end=0.1", "--checkpoint-every", "0", "--fields-every", "0.05"]
    killed = stopped(signal.SIGKILL, 60, "run", path, "--output", first, *options)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    path.unlink()
    shown = nervure("inspect", first)
    assert "checkpoint after" in shown.stdout, shown.stderr
    moved = first.rename(tmp_path / "moved")
    done = nervure("resume", moved)
    assert done.returncode == 0, done.stderr
    assert json.loads((moved / "summary.json").read_text())["simulated_s"] == pytest.approx(0.1)
    assert (moved / "fields.vtkhdf").exists() and not (moved / "checkpoint.npz").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "scenes/fsi3-325x73.json"], ["scenes/fsi3-325x73.json", "did you mean fsi3-325x72?"]),
        (["run", "nowhere/qqq.json"], ["cannot read the scene file nowhere/qqq.json", "scenes"]),
        (["inspect", "nowhere/qqq.json"], ["cannot read the scene file"]),
        (["run", FSI3, "--output", "EMPTY", "--set", "fluid.colour=red"], ["unknown key `fluid.colour`"]),
        (["run", FSI3, "--output", "EMPTY", "--set", "fluid.density=heavy"], ["fluid.density", "heavy"]),
        (["run", FSI3, "--output", "EMPTY", "--end-time", "-1"], ["time.end", "-1"]),
        (["run", FSI3, "--output", "FILE"], ["cannot write into the result folder", "FILE"]),
        (["run", FSI3, "--rod-fmu", "nowhere.fmu"], ["--rod-fmu", "nowhere.fmu", "does not exist"]),
        (["run", FSI3, "--rod-fmu", "upper=FILE"], ["does not exist, and the one rod of the scene needs no NAME="]),
        (["run", FSI3, "--output", "EMPTY", "--rod-fmu", "FILE"], ["FILE cannot be read as an FMU"]),
        (["run", FSI3, "--output", ""], ["--output", "it is empty", "path of a"]),
        (["sweep", FSI3, "--output", ""], ["--output", "it is empty"]),
        (["resume", "EMPTY"], ["there is no checkpoint", "--checkpoint-every"]),
        (["plot", "EMPTY"], ["holds no results", "scene.json", "nervure run"]),
        (["inspect", "EMPTY"], ["holds no results"]),
        (["inspect", "nowhere.fmu"], ["nowhere.fmu cannot be read as an FMU"]),
        (["animate", "EMPTY"], ["--fields-every"]),
        (["build", FSI3, "--descriptions", "nowhere"], ["--descriptions", "nowhere", "does not exist"]),
        (["dist", "scenes/fsi3-325x73.json", "EMPTY/dist"], ["did you mean"]),
        (["fly"], ["No such command 'fly'"]),
        (["run", "csm1", "--output", "EMPTY", "--fields-every", "inf"], ["fields_every is inf", "finite"]),
        (["run", "csm1", "--output", "EMPTY", "--series-every", "nan"], ["series-every"]),
        (["run", "csm1", "--output", "EMPTY", "--checkpoint-every", "inf"], ["checkpoint_every is inf", "finite"]),
        (["run", "csm1", "--output", f"EMPTY/{LONG}"], [LONG, "File name too long"]),
        (["run", "csm1", "--output", "/proc/nervure"], ["/proc/nervure"]),
        (["run", "csm1", "--output", "FILE/inside"], ["FILE/inside", "Not a directory"]),
        (["build", "fsi3-325x72", "--output", f"EMPTY/{LONG}"], [LONG, "File name too long"]),
        (["dist", "csm1", f"EMPTY/{LONG}"], [LONG, "File name too long"]),
        (["dist", "csm1", "FILE"], ["holds a file", "did not write"]),
        (["dist", "csm1", "."], ["did not write"]),
        (["sweep", "csm1", "--output", f"EMPTY/{LONG}", "--vary", "rod.damping=0,1"], ["File name too long"]),
        (["sweep", "csm1", "--output", "EMPTY", "--vary", ""], ["the variation ``"]),
        (["sweep", "csm1", "--output", "EMPTY", "--vary", "rod.damping=[]"], ["rod.damping=[]"]),
        (["sweep", "csm1", "--output", "EMPTY", "--vary", "rod.damping="], ["rod.damping="]),
    ],
    ids=lambda value: " ".join(map(str, value[:2])).replace("/", "-") if isinstance(value, list) else None,
)
def test_what_cannot_be_used_is_said_with_what_to_do(arguments, said, tmp_path):
    empty, file = tmp_path / "EMPTY", tmp_path / "FILE"
    empty.mkdir()
    file.write_text("neither a folder nor an FMU")
    places = [str(a).replace("EMPTY", str(empty)).replace("FILE", str(file)) for a in arguments]
    done = nervure(*places, cwd=ROOT, env=os.environ | {"COLUMNS": "300"})
    assert done.returncode == 2, done.stderr
    for part in said:
        assert part.replace("FILE", str(file)) in done.stderr, done.stderr
    assert "Traceback" not in done.stderr
    assert not [path for path in empty.iterdir() if path.suffix != ".fmu"], "nothing was run"


def test_missing_libraries_are_built_once(fluid_only, tmp_path, monkeypatch):
    (tmp_path / "scene.json").write_text(json.dumps(fluid_only))
    (tmp_path / "release").mkdir()
    there: dict[str, Path] = {kind: library(kind) for kind in ("rod", "fluid")}
    built: list[bool] = []

    def build():
        built.append(True)
        for path in there.values():
            (tmp_path / "release" / path.name).symlink_to(path)

    monkeypatch.setattr("nervure.library.build", build)
    monkeypatch.delenv("NERVURE_LIBRARIES", raising=False)
    monkeypatch.setenv("CARGO_TARGET_DIR", str(tmp_path))
    bad = nervure("run", "scene.json", "--set", "fluid.density=-1", cwd=tmp_path)
    assert bad.returncode == 2 and "`fluid.density` is out of range" in bad.stderr
    assert "building the libraries" in bad.stderr
    done = nervure("run", "scene.json", cwd=tmp_path)
    assert done.returncode == 0 and "building" not in done.stderr and built == [True]


def test_libraries_that_cannot_be_built_are_said(tmp_path, monkeypatch):
    monkeypatch.delenv("NERVURE_LIBRARIES", raising=False)
    missing = {"CARGO_TARGET_DIR": str(tmp_path), "PATH": str(tmp_path)}
    done = nervure("run", FSI3, "--output", tmp_path, env=os.environ | missing)
    assert done.returncode == 2 and "install Rust" in done.stderr, done.stderr


def test_build_without_cargo_takes_libraries_that_are_named_or_says_what_to_install(tmp_path, monkeypatch):
    named = {"PATH": str(tmp_path), "NERVURE_LIBRARIES": str(library("rod").parent)}
    done = nervure("build", "csm1", "--output", tmp_path, env=os.environ | named)
    assert done.returncode == 0 and (tmp_path / "csm1-rod.fmu").is_file(), done.stderr
    monkeypatch.delenv("NERVURE_LIBRARIES", raising=False)
    done = nervure("build", FSI3, "--output", tmp_path, env=os.environ | {"PATH": str(tmp_path)})
    assert done.returncode == 2 and "install Rust" in done.stderr, done.stderr


@pytest.mark.pictures
def test_results_of_another_scene_are_replaced_only_by_force(result, rod_only, packed, tmp_path):
    folder = result("falling", "--set", "name=first", "--fields-every", "1e-3")
    (folder / "notes.txt").write_text("mine")
    before = contents(folder)
    command = ["run", tmp_path / "scene.json", "--output", folder]
    other = nervure(*command, "--set", "rod.gravity=[0, -3]", "--set", "name=first")
    assert other.returncode == 2 and "rod.gravity.1 is -2.0 there, but -3 here" in other.stderr, other.stderr
    rod_only["name"] = "own"
    unit = nervure(*command, "--set", "name=first", "--rod-fmu", packed("rod", rod_only))
    assert unit.returncode == 2 and "it is first.rod there, but own.rod here" in unit.stderr, unit.stderr
    assert contents(folder) == before

    same = nervure(*command, "--set", "name=first", "--set", "description=a remark")
    assert same.returncode == 0, same.stderr
    forced = nervure(*command, "--force")
    assert forced.returncode == 0, forced.stderr
    assert contents(folder).keys() == {"falling-rod-rod.fmu", "notes.txt", *results.FILES[:4]}


def test_a_file_that_is_no_result_is_not_replaced(rod_only, tmp_path):
    """The folder of one's scene, which has the name of a result, is no result folder."""
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(rod_only))
    done = run_scene(path, "--output", tmp_path)
    assert done.returncode == 2 and "scene.json, but no results that can be read" in done.stderr, done.stderr
    assert json.loads(path.read_text()) == rod_only


@pytest.mark.parametrize(
    ("name", "end", "damping", "said"),
    [
        ("csm1", 0.3, 100, "tip_ux still changes by"),
        ("csm3", 1.5, 0, "whole periods of the tip, and 4 is the least"),
        ("csm3", 8, 3, "the tip still drifts by -"),
    ],
)
def test_a_run_that_is_too_short_is_not_compared(name, end, damping, said, tmp_path):
    options = ["--end-time", end, "--set", "time.communication_step=5e-3", "--set", f"rod.damping={damping}"]
    short = nervure("run", name, "--output", tmp_path / "short", *options)
    assert said in short.stdout and "difference" not in short.stdout, short.stdout
    assert said in json.loads((tmp_path / "short" / "summary.json").read_text())["not_compared"]


def test_a_steady_run_that_is_long_enough_is_compared(tmp_path):
    done = nervure("run", "csm1", "--output", tmp_path / "long", "--set", "time.communication_step=8e-3")
    assert "difference" in done.stdout and "not compared" not in done.stdout, done.stdout


@contextmanager
def no_file_beyond(size):
    """A limit on the size of files stands for a disk that gets full."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_results_that_cannot_be_written_leave_the_former_ones(result, rod_only, monkeypatch):
    folder = result("falling")
    before = contents(folder)
    write = results.write

    def when_full(*arguments):
        disk.enter_context(no_file_beyond(2000))  # scene.json has room, series.csv not
        write(*arguments)

    monkeypatch.setattr(results, "write", when_full)
    with (
        ExitStack() as disk,
        pytest.raises(InputError, match=f"results cannot be written into {folder}: File too large"),
    ):
        api.run(validate(rod_only), folder, quiet=True)
    assert contents(folder) == before


def test_units_that_cannot_be_packed_or_unpacked_are_said(result, tmp_path):
    folder = result("falling")
    before = contents(folder)
    command = ["run", tmp_path / "scene.json", "--output", folder]
    with no_file_beyond(2000):
        packing = nervure(*command)
        unpacking = nervure(*command, "--rod-fmu", folder / "falling-rod-rod.fmu")
    assert packing.returncode == unpacking.returncode == 2
    assert f"cannot write into the result folder {folder}: File too large" in packing.stderr, packing.stderr
    assert "falling-rod-rod.fmu cannot be unpacked into" in unpacking.stderr, unpacking.stderr
    assert contents(folder) == before


def test_results_that_are_damaged_are_said(result):
    folder = result("falling")
    sound = (folder / "series.csv").read_text()
    header, start, *_ = sound.splitlines()
    for lines, words in (
        (["time,tip_uy", "0.0,zero"], "could not convert"),
        (["time,tip_uy", "0.0,0.0"], "lacks the column"),
        ([header, ""], "has no rows"),
        ([header, start], "ends at t = 0 s, before the window"),
        ([header, start, "0.1"], "row 2 of series.csv has 1 values for"),
    ):
        (folder / "series.csv").write_text("\n".join(lines))
        with pytest.raises(InputError, match=f"are damaged: .*{words}"):
            results.read(folder)
    done = nervure("plot", folder)
    assert done.returncode == 2 and "are damaged" in done.stderr, done.stderr
    (folder / "series.csv").write_text(sound)
    for name, content, words in (
        ("summary.json", "[]", "summary.json: it is \\[\\], but must be"),
        ("summary.json", "[" * 5000, "nested too deep"),
        ("scene.json", "{}", "scene.json: missing required key"),
    ):
        (folder / name).write_text(content)
        with pytest.raises(InputError, match=f"are damaged.*{words}"):
            results.read(folder)


@pytest.mark.parametrize(
    ("version", "names"),
    [
        (2, {"linux64": "so", "win64": "dll", "darwin64": "dylib"}),
        (3, {"x86_64-linux": "so", "x86_64-windows": "dll", "x86_64-darwin": "dylib", "aarch64-darwin": "dylib"}),
    ],
)
def test_a_delivery_has_the_libraries_of_all_systems(version, names, tmp_path, monkeypatch, rod_only):
    monkeypatch.setattr(delivery, "OLDEST_GLIBC", (99, 0))
    own = library("rod")
    for target in set(delivery.TARGETS[version].values()):
        (tmp_path / target / "release").mkdir(parents=True)
    shutil.copy(own, tmp_path / "x86_64-unknown-linux-gnu" / "release")
    for path in ("x86_64-pc-windows-gnu/release/fmu_rod.dll", "universal2-apple-darwin/release/libfmu_rod.dylib"):
        (tmp_path / path).write_bytes(path.encode())
    monkeypatch.setenv("NERVURE_LIBRARIES", str(tmp_path / "x86_64-unknown-linux-gnu" / "release"))
    delivery.write(validate(rod_only), tmp_path / "dist", version)
    with zipfile.ZipFile(tmp_path / "dist" / "falling-rod-rod.fmu") as archive:
        binaries = {name for name in archive.namelist() if name.startswith("binaries/")}
        notices = archive.read("documentation/licenses/third-party.txt").decode("utf-8")
    assert binaries == {f"binaries/{name}/fmu_rod.{ending}" for name, ending in names.items()}
    assert "\nserde " in notices and "Apache License" in notices and "\nnervure" not in notices
    readme = (tmp_path / "dist" / "README.md").read_text()
    assert f"FMI {version}.0" in readme and ", ".join(sorted(names)) in readme and "{" not in readme


def test_a_delivery_is_what_its_checksums_and_manifest_say(fsi3, tmp_path, monkeypatch):
    monkeypatch.setattr(delivery, "OLDEST_GLIBC", (99, 0))  # the libraries of this machine will do
    folder = tmp_path / "dist"
    delivery.write(validate(fsi3), folder)
    sums = dict(line.split("  ")[::-1] for line in (folder / "SHA256SUMS").read_text().splitlines())
    assert sums == {
        p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir() if p.name != "SHA256SUMS"
    }
    manifest = json.loads((folder / "manifest.json").read_text())
    assert manifest["files"].keys() | {"manifest.json"} == sums.keys()
    git = git_revision()
    assert manifest["source_revision"].startswith(git.revision) and git.dirty == (
        "-dirty" in manifest["source_revision"]
    )


@pytest.mark.parametrize("own", ["notes.txt", "README.md", "manifest.json", "folder/notes.txt"])
def test_a_delivery_replaces_only_what_a_delivery_left(rod_only, tmp_path, monkeypatch, own):
    """A folder of somebody else, and one of an earlier delivery to which somebody added or in which changed a file."""
    monkeypatch.setattr(delivery, "OLDEST_GLIBC", (99, 0))
    scene, folder = validate(rod_only), tmp_path / "dist"
    for delivered in (False, True):
        if delivered:
            shutil.rmtree(folder)
            delivery.write(scene, folder)
            delivery.write(scene, folder)
        (folder / own).parent.mkdir(parents=True, exist_ok=True)
        (folder / own).write_text("mine")
        with pytest.raises(InputError, match=f"holds {own.split('/')[0]}, which `nervure dist` did not write"):
            delivery.write(scene, folder)
        assert (folder / own).read_text() == "mine"
    shutil.rmtree(folder)
    folder.mkdir()
    delivery.write(scene, folder)
    assert {path.name for path in tmp_path.iterdir()} == {"dist"}
