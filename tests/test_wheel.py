"""The wheel of `make wheel`: the units of all systems in it, and none of its tools needed where it is installed."""

import os
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
def wheel(tmp_path_factory, libraries):
    """It, with this system's libraries and stand-ins for the others, as `make dist-libraries` lays them out."""
    folder = tmp_path_factory.mktemp("dist")
    for name, target in delivery.TARGETS[2].items():
        (folder / target / "release").mkdir(parents=True)
        for kind in KINDS:
            path = folder / target / "release" / NAMES.get(name, "libfmu_{}.so").format(kind)
            shutil.copy(library(kind), path) if name == "linux64" else path.write_bytes(name.encode())
    command = [sys.executable, "-m", "pip", "--quiet", "wheel", "--no-deps", "--no-build-isolation"]
    environment = {"NERVURE_LIBRARIES": str(folder / delivery.TARGETS[2]["linux64"] / "release")}
    done = subprocess.run(
        [*command, "--wheel-dir", folder, ROOT], env=os.environ | environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    (path,) = folder.glob("*.whl")
    return path


def test_it_is_for_any_system_and_has_the_libraries_and_licences_of_each(wheel):
    assert wheel.name.endswith("-py3-none-any.whl")
    with zipfile.ZipFile(wheel) as archive:
        found = {name.partition("/data/binaries/")[2] for name in archive.namelist()} - {""}
        licences = archive.read("nervure/data/binaries/third-party-fluid.txt").decode("utf-8")
    assert found == files(delivery.TARGETS[2]) | {f"third-party-{kind}.txt" for kind in KINDS}
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
