"""The wheels of `make wheel`: one for each system, with the units of all systems, which need no compiler."""

import os
import re
import runpy
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from nervure import library as libraries
from nervure.errors import SceneError
from nervure.library import KINDS, library
from nervure.resources import ROOT
from nervure.units import delivery

NAMES = {"win64": "fmu_{}.dll", "darwin64": "libfmu_{}.dylib"}  # Of a library; on all others `libfmu_{}.so`

HAND_OUT = """
from pathlib import Path
from nervure.units import delivery
from nervure.scene import load
delivery.OLDEST_GLIBC = (99, 0)  # The libraries of this machine will do
delivery.write(load("csm1"), Path("handed-out"))
"""


def files(platforms) -> set[str]:
    return {f"{name}/{NAMES.get(name, 'libfmu_{}.so').format(kind)}" for name in platforms for kind in KINDS}


@pytest.fixture(scope="module")
def targets(tmp_path_factory, libraries):
    """This system's libraries and stand-ins for the others, laid out as by `make dist-libraries`."""
    folder = tmp_path_factory.mktemp("dist")
    for name, target in delivery.TARGETS[2].items():
        (folder / target / "release").mkdir(parents=True)
        for kind in KINDS:
            path = folder / target / "release" / NAMES.get(name, "libfmu_{}.so").format(kind)
            shutil.copy(library(kind), path) if name == "linux64" else path.write_bytes(name.encode())
    return folder


@pytest.fixture(scope="module")
def wheel(tmp_path_factory, targets):
    """The wheel for this system, as `make wheel` builds it."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "pip", "--quiet", "wheel", "--no-deps", "--no-build-isolation"]
    environment = {"NERVURE_LIBRARIES": str(targets / delivery.TARGETS[2]["linux64"] / "release")}
    done = subprocess.run(
        [*command, "--wheel-dir", folder, ROOT], env=os.environ | environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    return path


def test_it_has_the_examples_and_scripts_and_what_each_unit_packs(wheel):
    with zipfile.ZipFile(wheel) as archive:
        found = {name.removeprefix("nervure/data/") for name in archive.namelist()}
    there = {
        path.relative_to(ROOT).as_posix() for name in ("examples", "scripts") for path in (ROOT / name).rglob("*.py")
    }
    there |= {f"fmu-{kind}/{name}" for kind in KINDS for name in ("model.png", "documentation.html")}
    assert there <= found and "scripts/gallery/own_solver.py" in there


def test_its_tag_is_of_its_system_and_its_glibc(wheel, targets, tmp_path):
    major, minor = max(delivery.OLDEST_GLIBC, *(delivery.glibc(library(kind)) for kind in KINDS))
    assert wheel.name.endswith(f"-py3-none-manylinux_{major}_{minor}_x86_64.whl")
    hooks = runpy.run_path(str(ROOT / "hatch_build.py"))
    assert hooks["_delivered"](targets / delivery.TARGETS[2]["win64"] / "release", tmp_path)[1] == "win_amd64"


def test_it_has_the_libraries_and_licences_of_each_system_and_the_address_of_the_project(wheel):
    with zipfile.ZipFile(wheel) as archive:
        found = {name.partition("/data/binaries/")[2] for name in archive.namelist()} - {""}
        licences = archive.read("nervure/data/binaries/third-party-fluid.txt").decode("utf-8")
        (metadata,) = [archive.read(name) for name in archive.namelist() if name.endswith(".dist-info/METADATA")]
    assert found == files(delivery.TARGETS[2]) | {f"third-party-{kind}.txt" for kind in KINDS}
    address = re.search(r'^repository = "(.+?)"', (ROOT / "Cargo.toml").read_text(), re.MULTILINE)
    assert address and f"Project-URL: Repository, {address[1]}\n" in metadata.decode("utf-8")
    assert "\nrustfft " in licences and "Apache License" in licences


def test_it_runs_and_packs_for_all_systems_where_there_is_no_compiler(wheel, tmp_path):
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)

    def python(*arguments: str) -> None:
        environment = {"PYTHONPATH": str(site), "PATH": "", "HOME": str(tmp_path)}
        command = [sys.executable, *arguments]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr

    python("-m", "nervure", "run", "csm1", "--end-time", "0.1")
    assert (tmp_path / "results" / "csm1" / "tip.png").is_file()
    sphere = ("sphere-oscillating-64x64x64", "--set", "fluid.box.cells=[24, 24, 24]", "--end-time", "0.05")
    python("-m", "nervure", "run", *sphere)
    assert (tmp_path / "results" / sphere[0] / "vorticity.png").is_file()
    python("-m", "nervure", "examples", "tried")
    python("tried/scripts/gallery/fsi3.py", "--end", "0.02")
    python("-c", HAND_OUT)
    with zipfile.ZipFile(tmp_path / "handed-out" / "csm1-rod.fmu") as archive:
        found = {Path(name).parts[1] for name in archive.namelist() if name.startswith("binaries/")}
    assert found == set(delivery.TARGETS[2])


def test_a_system_that_the_wheel_has_no_units_for_is_told_what_helps(tmp_path, monkeypatch):
    (tmp_path / "linux64").mkdir()
    monkeypatch.delenv("NERVURE_LIBRARIES", raising=False)
    for name, value in {"SOURCE": None, "BINARIES": tmp_path, "PLATFORM": "riscv64-linux"}.items():
        monkeypatch.setattr(libraries, name, value)
    with pytest.raises(SceneError, match="riscv64-linux, but nervure was installed with units for linux64; `pip inst"):
        library("rod")
