"""The FMUs of the shipped FSI3 scene as files: standard, contract, and what is committed of them."""

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from nervure import coupling
from nervure.errors import SceneError
from nervure.library import library
from nervure.resources import ROOT
from nervure.units import package
from nervure.units.describe import describe
from nervure.units.fmu import ELEMENT
from tests.conftest import COUPLED, output

pytestmark = pytest.mark.usefixtures("libraries")
both = pytest.mark.parametrize("kind", COUPLED)


@both
def test_fmpy_finds_no_fault(kind, fsi3, tmp_path):
    assert validate_fmu(str(package.pack(describe(kind, fsi3), tmp_path))) == []


@both
def test_model_description_follows_the_schema_of_fmi(kind, fsi3):
    schema = etree.XMLSchema(file=str(Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"))
    schema.assertValid(etree.fromstring(describe(kind, fsi3).xml.encode()))


@both
def test_fmu_holds_library_scene_and_description(kind, fsi3, tmp_path):
    with zipfile.ZipFile(package.pack(describe(kind, fsi3), tmp_path)) as archive:
        names = set(archive.namelist())
        description = etree.fromstring(archive.read("modelDescription.xml"))
    identifier = description.find("CoSimulation").get("modelIdentifier")
    binary = f"binaries/{fmpy.platform}/{identifier}{fmpy.sharedLibraryExtension}"
    assert {"modelDescription.xml", "resources/scene.json", binary} <= names


@both
def test_packing_twice_gives_the_same_bytes(kind, fsi3, tmp_path):
    first, second = (package.pack(describe(kind, fsi3), tmp_path / folder).read_bytes() for folder in "ab")
    assert first == second


LOADS = """
import _ctypes, ctypes, pathlib, sys
library, scene = sys.argv[1], pathlib.Path(sys.argv[2]).read_bytes()
buffer, needed = ctypes.create_string_buffer(1 << 20), ctypes.c_size_t()
def load(count):
    for _ in range(count):
        loaded = ctypes.CDLL(library)
        loaded.fmu_scene_check.argtypes = [ctypes.c_char_p] * 3 + [ctypes.c_size_t, ctypes.c_void_p]
        assert loaded.fmu_scene_check(scene, None, buffer, len(buffer), ctypes.addressof(needed)) == 0
        handle = loaded._handle
        _ctypes.dlclose(handle)
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1])
before = load(20)
print(load(100) - before)
"""


@both
@pytest.mark.skipif(sys.platform != "linux", reason="reads the memory of a process of Linux")
def test_loading_checking_and_unloading_leaks_nothing(kind):
    """100 loads grow by less than 500 pages of 4 kB: the loader keeps some 60, a schema in each would be 8000."""
    arguments = [sys.executable, "-c", LOADS, str(library(kind)), str(ROOT / "scenes" / "csm1.json")]
    done = subprocess.run(arguments, capture_output=True, text=True, check=True)
    assert int(done.stdout) < 500, done.stdout


SYSTEM = {"libc.so.6", "libm.so.6", "libgcc_s.so.1", "libpthread.so.0", "libdl.so.2", "ld-linux-x86-64.so.2"}
"""Libraries that every Linux has: those of glibc, and that of the C compiler for unwinding."""


@both
@pytest.mark.skipif(sys.platform != "linux", reason="reads the headers of ELF files")
def test_library_needs_nothing_but_the_system(kind):
    headers = subprocess.run(["objdump", "-p", library(kind)], capture_output=True, text=True, check=True).stdout
    needed = set(re.findall(r"NEEDED\s+(\S+)", headers))
    assert "libc.so.6" in needed and needed <= SYSTEM, needed
    assert re.findall(r"RUNPATH|RPATH", headers) == []


def test_fmus_of_several_systems_become_one(fsi3, tmp_path):
    own = package.pack(describe("rod", fsi3), tmp_path)
    other = tmp_path / "other.fmu"
    with zipfile.ZipFile(own) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    binary = next(name for name in files if name.startswith("binaries/"))
    foreign = {name: data for name, data in files.items() if name != binary} | {"binaries/other64/fmu_rod.so": b"..."}
    package.write_archive(other, foreign)
    with zipfile.ZipFile(package.merge([own, other], tmp_path / "both.fmu")) as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == files | foreign
        modes = {info.filename: info.external_attr >> 16 for info in archive.infolist()}
    assert [name for name, mode in modes.items() if mode == 0o755] == [binary, "binaries/other64/fmu_rod.so"]

    package.write_archive(other, foreign | {"resources/scene.json": b"{}"})
    with pytest.raises(SceneError, match=r"other\.fmu differs from .* in resources/scene\.json"):
        package.merge([own, other], tmp_path / "neither.fmu")
    assert not (tmp_path / "neither.fmu").exists()


@both
def test_committed_model_description_is_what_the_library_writes(kind, fsi3):
    committed = (ROOT / "modelDescription" / f"fmu_{kind}.xml").read_text(encoding="utf-8")
    assert committed == describe(kind, fsi3).xml, "`make descriptions` writes it anew"


def test_rod_and_fluid_fit_each_other(fsi3, instantiate):
    units = instantiate(fsi3)
    rod, fluid = units["rod"], units["fluid"]
    assert set(coupling.connections(fluid, rod)) == {"force_x", "force_y", "impedance"}
    assert set(coupling.connections(rod, fluid)) == {"x", "y", "vx", "vy"}
    assert {rod.variables[name].size for name in ("x", "y", "vx", "vy", "force_x", "force_y", "impedance")} == {43}


def test_pressure_jump_takes_the_place_of_the_momentum_load(fsi3, instantiate):
    fsi3["coupling"]["load"] = "pressure_jump"
    units = instantiate(fsi3)
    assert coupling.connections(units["fluid"], units["rod"]) == ["pressure_jump"]


def test_a_part_that_the_scene_lacks_has_no_variables(fluid_only):
    names = etree.fromstring(describe("fluid", fluid_only).xml.encode()).xpath("//ScalarVariable/@name")
    assert [name for name in names if ELEMENT.fullmatch(name)] == []
    assert [name for name in names if name.startswith(("beam.", "probe."))] == []
    assert {"drag", "lift", "cylinder[1].drag", "cylinder[1].lift", "cylinder[1].moment"} <= set(names)


def test_each_body_and_probe_has_its_outputs(small_fsi3, start_fluid):
    box, node = small_fsi3["fluid"]["box"], (60, 20)
    at_node = [low + k * (high - low) / n for (low, high), k, n in zip((box["x"], box["y"]), node, box["cells"])]
    small_fsi3["fluid"]["probes"] = [
        {"name": "node", "position": at_node},
        {"name": "inlet", "position": [-0.1, 0.205]},
    ]
    fluid = start_fluid(small_fsi3)
    value = {name: output(fluid, name)[0] for name in fluid.scalars("Real")}
    for name in ("drag", "lift"):
        assert value[name] == pytest.approx(value[f"cylinder[1].{name}"] + value[f"beam.{name}"], rel=1e-12)
    assert value["cylinder[1].drag"] > 0
    assert 0 < abs(value["beam.moment"]) < 0.35 * value["drag"]
    for name in ("u", "v", "p"):
        assert value[f"probe.node.{name}"] == pytest.approx(fluid.field(name)[node], rel=1e-9)
    assert value["probe.inlet.u"] == pytest.approx(1.5, rel=0.02)


@pytest.fixture
def start_fluid(instantiate):
    """The fluid of a scene after ten steps of 1 ms with its stations at rest."""

    def start(scene):
        fluid = instantiate(scene)["fluid"]
        fluid.connect([], [])
        fluid.start()
        for step in range(10):
            fluid.step(1e-3 * step, 1e-3)
        return fluid

    return start


def test_stations_start_on_the_undeformed_bar(fsi3, instantiate):
    rod = instantiate(fsi3)["rod"]
    rod.connect([], ["x", "y"])
    rod.get()
    assert output(rod, "x") == pytest.approx(np.linspace(0.25, 0.6, 43), abs=1e-12)
    assert output(rod, "y") == pytest.approx(np.full(43, 0.2), abs=1e-12)


def at_start(path, start, names, step=1e-3):
    """What fmpy records of an FMU before its first step, from `start` (s) on."""
    times = {"start_time": start, "stop_time": start + 2 * step, "step_size": step, "output_interval": step}
    return fmpy.simulate_fmu(str(path), output=names, validate=False, **times)[0]


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("start", [0.0, 0.25, -0.4, 3.1])
def test_bodies_and_roots_are_in_their_places_at_any_start_time(fluid_only, rod_only, packed, start, version):
    def law(amplitude, frequency):
        return {"sine": {"amplitude": amplitude, "frequency": frequency}}

    motion = {"x": law(0.1, 0.5), "y": law(0.2, 1.3), "angle": law(0.7, 0.6)}
    ellipse = {"shape": {"ellipse": {"length": 0.4, "thickness": 0.2}}, "position": [0.1, 0.0], "motion": motion}
    fluid_only["fluid"] |= {"initial_velocity": [0.0, 0.0], "inflow": None, "cylinders": [], "bodies": [ellipse]}
    where = at_start(packed("fluid", fluid_only, version), start, ["body[1].x", "body[1].y", "body[1].angle"])
    phases = 2 * np.pi * start * np.array([0.5, 1.3, 0.6])
    assert list(where)[1:] == pytest.approx([0.1, 0.0, 0.0] + np.array([0.1, 0.2, 0.7]) * np.sin(phases), abs=1e-12)

    rod_only["rod"]["root_motion"] = {"laws": {"x": law(0.1, 0.5), "y": law(0.2, 1.3)}}
    names = ["x[1]", "y[1]"] if version == 2 else ["x", "y"]
    place = [np.ravel(values)[0] for values in list(at_start(packed("rod", rod_only, version), start, names))[1:]]
    assert place == pytest.approx(np.array([0.1, 0.2]) * np.sin(phases[:2]), abs=1e-12)


def test_accuracy_of_the_rod_does_not_go_with_the_step_of_the_master(rod_only, packed):
    """Without `rod.max_step` the rod makes steps of the scene, 1e-4 s, whatever a master takes."""

    def tip(scene, step):
        found = fmpy.simulate_fmu(str(packed("rod", scene)), stop_time=0.2, step_size=step, output_interval=step)
        return found["tip.uy"][-1]

    rod_only["time"] |= {"end": 0.2, "communication_step": 1e-3}
    fine = tip(rod_only, 1e-3)
    assert abs(fine) > 0.01
    for step in (2e-3, 5e-3, 2e-2):
        assert tip(rod_only, step) == pytest.approx(fine, rel=1e-9)
    rod_only["rod"]["max_step"] = 2e-2
    assert abs(tip(rod_only, 2e-2) / fine - 1) > 1e-4
