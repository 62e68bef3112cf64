"""The units under FMI 3.0: standard, arrays, and the same bits as under FMI 2.0."""

import json
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from nervure import coupling, run
from nervure.errors import InputError, UnitError
from nervure.scene import validate
from nervure.units import delivery, package
from nervure.units.fmu import Unit, read_description, variables_of
from tests.conftest import COUPLED, nervure

pytestmark = pytest.mark.usefixtures("libraries")
both = pytest.mark.parametrize("kind", COUPLED)
SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"


@both
def test_fmpy_finds_no_fault(kind, fsi3, packed):
    assert validate_fmu(str(packed(kind, fsi3, 3))) == []


@both
def test_descriptions_follow_the_schemas_of_fmi(kind, fsi3, packed):
    with zipfile.ZipFile(packed(kind, fsi3, 3)) as archive:
        for name in ("modelDescription.xml", "terminalsAndIcons/terminalsAndIcons.xml"):
            schema = SCHEMAS / ("fmi3ModelDescription.xsd" if name[0] == "m" else "fmi3TerminalsAndIcons.xsd")
            etree.XMLSchema(file=str(schema)).assertValid(etree.fromstring(archive.read(name)))


@both
def test_variables_are_those_of_fmi_2_with_arrays_as_one(kind, fsi3, packed):
    two, three = (read_description(packed(kind, fsi3, version)) for version in (2, 3))
    assert len(three.modelVariables) < 60 < len(two.modelVariables)
    known, found = variables_of(two), variables_of(three)
    assert list(found) == list(known)
    for name, variable in found.items():
        other = known[name]
        assert (variable.kind, variable.causality, variable.unit) == (other.kind, other.causality, other.unit), name
        assert variable.references == other.references[:1], name
        assert variable.start == other.start, name
    assert {variable.shape for variable in three.modelVariables} == {(), (43,)}
    assert {unknown.variable.name for unknown in three.outputs} == {
        n for n, v in found.items() if v.causality == "output"
    }
    assert all(unknown.dependencies == [] for unknown in three.outputs), "outputs are made at the end of a step"


@both
def test_an_fmu_has_the_folders_of_fmi_3_and_explains_itself(kind, small_fsi3, packed):
    with zipfile.ZipFile(packed(kind, small_fsi3, 3)) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    assert f"binaries/{fmpy.platform_tuple}/fmu_{kind}{fmpy.sharedLibraryExtension}" in files
    page = files["documentation/index.html"].decode("utf-8")
    row = next(line for line in page.splitlines() if "<td>x[1] … x[21]<td>" in line)
    assert "<td>Float64<td>m<td>" in row and "An array has one value reference." in page
    assert "terminalsAndIcons/icon.png" in page and files["terminalsAndIcons/icon.png"].startswith(b"\x89PNG")
    assert "model.png" not in files, "FMI 3.0 has no such file"


def test_terminals_fit_each_other(fsi3, packed):
    terminals = {}
    for kind in COUPLED:
        with zipfile.ZipFile(packed(kind, fsi3, 3)) as archive:
            found = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml")).iter("Terminal")
        terminals[kind] = {terminal.get("name"): terminal.xpath("*/@memberName") for terminal in found}
    assert terminals["rod"] == {"load": ["force_x", "force_y", "impedance"], "stations": ["x", "y", "vx", "vy"]}
    assert terminals["fluid"] == terminals["rod"] | {"pressure_jump": ["pressure_jump"]}


def coupled(scene, instantiate, version):
    """Every output of both units after five steps; an iterated scheme puts both back into stored states meanwhile."""
    units = instantiate(scene, version)
    scheme = coupling.couple(units, validate(scene).coupling)
    scheme.start()
    h = scene["time"]["communication_step"]
    for i in range(5):
        scheme.step(i * h, h)
    return values(units)


def values(units):
    """Real outputs by `unit.name`."""
    return {
        f"{kind}.{name}": unit.read(name)
        for kind, unit in units.items()
        for name, variable in unit.variables.items()
        if variable.causality == "output" and variable.kind == "Real"
    }


MOMENTUM = {"load": "momentum", "scheme": "explicit"}
PRESSURE = {"load": "pressure_jump", "scheme": {"iterated": {"acceleration": "aitken"}}}


@pytest.mark.parametrize("how", [MOMENTUM, PRESSURE], ids=["explicit", "iterated"])
def test_the_bits_are_those_of_fmi_2(how, small_fsi3, instantiate):
    small_fsi3["coupling"] = how
    two, three = (coupled(small_fsi3, instantiate, version) for version in (2, 3))
    assert two.keys() == three.keys() and len(three) > 20
    assert [name for name in two if not np.array_equal(two[name], three[name])] == []


def test_units_of_different_versions_go_together(small_fsi3, instantiate):
    pure, other = instantiate(small_fsi3, 2), instantiate(small_fsi3, 3)
    found = []
    for units in ({"rod": pure["rod"], "fluid": other["fluid"]}, {"rod": other["rod"], "fluid": pure["fluid"]}):
        scheme = coupling.couple(units, validate(small_fsi3).coupling)
        scheme.start()
        for i in range(3):
            scheme.step(i * 4e-4, 4e-4)
        found.append(values(units))
    assert [name for name in found[0] if not np.array_equal(found[0][name], found[1][name])] == []


@both
def test_serialized_bytes_lead_another_instance_on(kind, small_fsi3, instantiate):
    units, others = (instantiate(small_fsi3, 3) for _ in range(2))
    scheme = coupling.couple(units, validate(small_fsi3).coupling)
    scheme.start()
    scheme.step(0.0, 4e-4)
    unit, other = units[kind], others[kind]
    other.deserialize(unit.serialize())
    for each in (unit, other):
        each.connect([], [])
        each.step(4e-4, 4e-4)
    first, second = values({kind: unit}), values({kind: other})
    assert [name for name in first if not np.array_equal(first[name], second[name])] == []


def test_the_command_gives_the_same_series_in_both_versions(rod_only, tmp_path):
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps(rod_only), encoding="utf-8")
    for version in (2, 3):
        done = nervure("run", scene, "--fmi", version, "--output", tmp_path / f"{version}")
        assert done.returncode == 0, done.stderr
    two, three = ((tmp_path / f"{version}" / "series.csv").read_bytes() for version in (2, 3))
    assert two == three
    assert read_description(tmp_path / "3" / "falling-rod-rod.fmu").fmiVersion == "3.0"


def test_another_version_is_refused_with_those_that_are_there(tmp_path):
    done = nervure("run", "csm1", "--fmi", 4, "--output", tmp_path / "run")
    assert done.returncode == 2 and "'--fmi'" in done.stderr, done.stderr
    with pytest.raises(InputError, match="fmi is 1, but must be 2 or 3"):
        run("csm1", tmp_path / "run", fmi=1)
    assert not (tmp_path / "run").exists()


@both
def test_inspection_shows_arrays_flags_and_version(kind, fsi3, packed):
    done = nervure("inspect", packed(kind, fsi3, 3))
    assert done.returncode == 0, done.stderr
    shown = [" ".join(line.split()) for line in done.stdout.splitlines()]
    assert f"FMI 3.0, {fmpy.platform_tuple}" in shown and "hasEventMode False" in shown
    assert any(line.startswith("force_x[1 … 43]") for line in shown)
    assert not any("None" in line for line in shown)


def test_fields_are_shown_under_fmi_3_too(fluid_only, instantiate):
    two, three = (instantiate(fluid_only, version)["fluid"] for version in (2, 3))
    for fluid in (two, three):
        fluid.start()
        fluid.step(0.0, 1e-3)
    assert np.array_equal(two.field("vorticity"), three.field("vorticity"))


def test_a_unit_that_fails_says_why(small_fsi3, instantiate):
    fluid = instantiate(small_fsi3, 3)["fluid"]
    fluid.connect(["x"], [])
    fluid.inputs[:] = 0.3
    fluid.start()
    with pytest.raises(UnitError, match="fmi3DoStep: .*stations"):
        fluid.step(0.0, 1e-4)


def test_an_edited_scene_is_refused_by_name(rod_only, packed, tmp_path):
    with zipfile.ZipFile(packed("rod", rod_only, 3)) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    files["resources/scene.json"] += b" "
    path = package.write_archive(tmp_path / "edited.fmu", files)
    with pytest.raises(UnitError, match=r"fmi3InstantiateCoSimulation: .*scene\.json changed after the FMU was packed"):
        Unit(path, "rod", 1.0)


def test_fmpy_alone_simulates_a_unit(rod_only, packed):
    found = [
        fmpy.simulate_fmu(
            str(packed("rod", rod_only, version)), stop_time=0.01, output_interval=1e-3, output=["tip.uy"]
        )
        for version in (2, 3)
    ]
    assert found[1]["tip.uy"][-1] < -1e-6
    assert np.array_equal(found[0]["tip.uy"], found[1]["tip.uy"])


def test_a_delivery_of_fmi_3_has_no_ssp(rod_only, tmp_path, monkeypatch):
    monkeypatch.setattr(delivery, "OLDEST_GLIBC", (9, 9))
    delivery.write(validate(rod_only), tmp_path / "dist", 3)
    names = {path.name for path in (tmp_path / "dist").iterdir()}
    assert names == {"falling-rod-rod.fmu", "README.md", "manifest.json", "SHA256SUMS"}
    assert "FMI 3.0" in (tmp_path / "dist" / "README.md").read_text(encoding="utf-8")
