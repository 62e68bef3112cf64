"""The FMUs in `dist` on other systems and processors: Windows under wine, ARM under qemu. `make foreign-test`.

macOS can be run nowhere here: its libraries are only looked at.
"""

import os
import shutil
import struct
import subprocess
import zipfile
from pathlib import Path

import fmpy
import pytest

from nervure.resources import ROOT

STEP, STEPS = 4e-4, 20
AGREEMENT = 1e-12
"""Largest difference, in the largest value of its unit and at least the scale of the scene: a rod's velocity is a
difference of positions over a step, so that at the start, where all is small, its rounding is not small beside it."""

LENGTH, SPEED, DENSITY = 0.35, 2.0, 1000.0  # Of the bar, the inflow and the fluid, SI
PRESSURE = DENSITY * SPEED**2
SCALES = {"": 1.0, "1": 1.0, "m": LENGTH, "m/s": SPEED, "Pa": PRESSURE, "N/m": PRESSURE * LENGTH}
SCALES |= {"N.m/m": PRESSURE * LENGTH**2, "J/m": PRESSURE * LENGTH**2, "W/m": PRESSURE * LENGTH * SPEED}
SCALES |= {"kg/(m.s)": DENSITY * SPEED * LENGTH, "m2/s": LENGTH * SPEED, "m2/s2": SPEED**2}

BUILT, DIST = ROOT / "target" / "foreign", ROOT / "target" / "dist"
PROCESSORS = {0x01000007: "x86_64", 0x0100000C: "aarch64"}
"""Of a library for macOS, by their number in its file."""
SYSTEMS = {
    "linux64": ([], "x86_64-unknown-linux-gnu", ""),
    "win64": (["wine64", "/usr/lib/wine/wine64"], "x86_64-pc-windows-gnu", ".exe"),
    "aarch64-linux": (["qemu-aarch64", "qemu-aarch64-static"], "aarch64-unknown-linux-gnu", ""),
}
"""Command that runs a program of the system, its target, and how its programs end."""

EXPORTED = {"fmu_model_description", "fmu_model_description_3", "fmu_field"}
EXPORTED |= {"fmu_scene_check", "fmu_scene_facts", "fmu_scene_monitor"}


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    """The FMUs of `dist`, rod first."""
    folder = tmp_path_factory.mktemp("dist")
    paths = [next((ROOT / "dist").glob(f"*-{kind}.fmu")) for kind in ("rod", "fluid")]
    return [Path(fmpy.extract(str(path), str(folder / path.stem))) for path in paths]


def values(system: str, unpacked: list[Path], tmp_path: Path) -> dict[str, float]:
    """Real outputs of both units after some steps on a system."""
    commands, target, ending = SYSTEMS[system]
    command = [found for found in map(shutil.which, commands) if found][:1]
    if commands and not command:
        pytest.skip(f"needs {' or '.join(commands)}")
    if "qemu" in "".join(command):
        command += ["-L", "/usr/aarch64-linux-gnu"]
    program = BUILT / target / "release" / f"foreign-master{ending}"
    folder = tmp_path / "units"
    for kind, path in zip(("rod", "fluid"), unpacked):
        shutil.copytree(path, folder / kind)
    answer = subprocess.run(
        [*command, program, repr(STEP), str(STEPS), "rod", "fluid", system],
        cwd=folder,
        env=os.environ | {"WINEDEBUG": "-all"},
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr
    return {name: float(value) for name, value in map(str.split, answer.stdout.splitlines())}


@pytest.mark.parametrize("system", [name for name in SYSTEMS if name != "linux64"])
def test_another_system_agrees(system, unpacked, tmp_path):
    here, there = values("linux64", unpacked, tmp_path / "here"), values(system, unpacked, tmp_path / "there")
    assert here.keys() == there.keys() and len(here) > 300
    units = {
        f"{kind}.{variable.name}": variable.unit or ""
        for kind, folder in zip(("rod", "fluid"), unpacked)
        for variable in fmpy.read_model_description(str(folder)).modelVariables
    }
    scales = dict(SCALES)
    for name, value in here.items():
        scales[units[name]] = max(scales[units[name]], abs(value))
    for name, expected in here.items():
        difference, scale = abs(there[name] - expected), scales[units[name]]
        assert difference <= AGREEMENT * scale, f"{name} differs by {difference:.3e} at a scale of {scale:g}"


def test_the_libraries_of_macos_are_for_both_processors_and_export_the_functions(unpacked):
    """A Mach-O file for several processors (`mach-o/fat.h`), each part of which is the library made for it."""
    for folder in unpacked:
        path = next(folder.glob("binaries/darwin64/*.dylib"))
        data = path.read_bytes()
        magic, count = struct.unpack_from(">II", data)
        assert (magic, count) == (0xCAFEBABE, len(PROCESSORS))
        found = set()
        for part in range(count):
            processor, _, offset, size, _ = struct.unpack_from(">IIIII", data, 8 + 20 * part)
            header, own, _, kind = struct.unpack_from("<IIII", data, offset)
            assert (header, own, kind) == (0xFEEDFACF, processor, 6), "a dynamic library of 64 bits"
            made = DIST / f"{PROCESSORS[processor]}-apple-darwin" / "release" / f"lib{path.name}"
            assert data[offset : offset + size] == made.read_bytes(), f"{made} is not in {path.name}"
            found.add(processor)
        assert found == set(PROCESSORS)
        assert b"_fmi2DoStep\0" in data or b"fmi2DoStep" in data


def test_no_path_of_the_machine_is_in_a_library(unpacked):
    for folder in unpacked:
        for path in folder.glob("binaries/*/*"):
            data = path.read_bytes()
            for place in (str(ROOT), str(Path.home())):
                assert f"{place}/".encode() not in data, f"{place} is in {path.name} of {path.parent.name}"


def test_linux_libraries_export_what_is_documented_and_nothing_else(unpacked):
    for folder in unpacked:
        for path in folder.glob("binaries/*linux*/*.so"):
            listed = subprocess.run(["objdump", "-T", path], capture_output=True, text=True, check=False).stdout
            defined = [line.split() for line in listed.splitlines() if " g " in line and "*UND*" not in line]
            names = {words[-1] for words in defined}
            assert len(names) == 34 + 75 + len(EXPORTED) or "aarch64" in path.parent.name, names
            assert all(name.startswith(("fmi2", "fmi3")) or name in EXPORTED for name in names), names


def test_the_pair_is_small_and_carries_its_licences(unpacked):
    """22 MB for five processors: a fluid in the plane and in space, in two precisions."""
    size = sum(path.stat().st_size for path in (ROOT / "dist").glob("*.fmu"))
    assert size < 25e6, f"{size / 1e6:.1f} MB"
    for path in (ROOT / "dist").glob("*.fmu"):
        with zipfile.ZipFile(path) as archive:
            text = archive.read("documentation/licenses/third-party.txt").decode("utf-8")
        for crate in ("serde", "quick-xml"):
            assert f"\n{crate} " in text and "Apache License" in text, crate
