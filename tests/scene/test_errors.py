"""Bad input: each is refused with a sentence that names what is wrong, and the process goes on."""

import json
import math
import zipfile

import pytest

from nervure.errors import SceneError, UnitError
from nervure.scene import load, override
from nervure.units import package
from nervure.units.describe import describe
from nervure.units.fmu import Unit
from tests.conftest import COUPLED, FSI3, run_scene

pytestmark = pytest.mark.usefixtures("libraries")
both = pytest.mark.parametrize("kind", COUPLED)


def rewrite(fmu, target, change):
    """Copy of `fmu` with `change(name, data)` in place of each file; None leaves the file out."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(target, "w") as copy:
        for name in source.namelist():
            data = change(name, source.read(name))
            if data is not None:
                copy.writestr(name, data)
    return target


@pytest.fixture
def steps_still(small_fsi3, instantiate):
    """Function that shows that a fresh unit still works in this process."""

    def check(kind):
        unit = instantiate(small_fsi3)[kind]
        unit.start()
        unit.step(0.0, 2e-4)

    return check


@both
def test_an_fmu_without_its_scene_names_the_file(kind, small_fsi3, tmp_path, steps_still):
    fmu = package.pack(describe(kind, small_fsi3), tmp_path)
    bare = rewrite(fmu, tmp_path / "bare.fmu", lambda name, data: None if name.startswith("resources") else data)
    with pytest.raises(UnitError, match=r"scene\.json"):
        Unit(bare, kind, 1.0)
    steps_still(kind)


@both
def test_an_fmu_without_a_library_for_this_platform_is_refused(kind, small_fsi3, tmp_path):
    fmu = package.pack(describe(kind, small_fsi3), tmp_path)
    bare = rewrite(fmu, tmp_path / "bare.fmu", lambda name, data: None if name.startswith("binaries") else data)
    with pytest.raises(UnitError, match="Cannot find shared library"):
        Unit(bare, kind, 1.0)


@both
def test_a_foreign_guid_is_refused(kind, small_fsi3, tmp_path, steps_still):
    fmu = package.pack(describe(kind, small_fsi3), tmp_path)
    guid = "{00000000-0000-0000-0000-000000000000}"

    def change(name, data):
        if name != "modelDescription.xml":
            return data
        begin = data.index(b'guid="') + 6
        return data[:begin] + guid.encode() + data[data.index(b'"', begin) :]

    with pytest.raises(UnitError, match="GUID .*0000-000000000000. belongs to another library"):
        Unit(rewrite(fmu, tmp_path / "foreign.fmu", change), kind, 1.0)
    steps_still(kind)


@both
def test_another_scene_under_the_same_description_is_refused(kind, small_fsi3, tmp_path):
    fmu = package.pack(describe(kind, small_fsi3), tmp_path)
    small_fsi3["beam"]["segments"] = 30

    def change(name, data):
        return json.dumps(small_fsi3) if name == "resources/scene.json" else data

    with pytest.raises(UnitError, match=r"GUID .* belongs to other resources: .*scene\.json"):
        Unit(rewrite(fmu, tmp_path / "other.fmu", change), kind, 1.0)


@both
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_an_input_that_is_not_finite_is_named(kind, value, small_fsi3, instantiate, steps_still):
    unit = instantiate(small_fsi3)[kind]
    name = {"rod": "force_y", "fluid": "y"}[kind]
    unit.connect([name], [])
    unit.start()
    unit.inputs[2] = value
    with pytest.raises(UnitError, match=rf"{name}\[3\] = .*finite"):
        unit.step(0.0, 2e-4)
    steps_still(kind)


@both
@pytest.mark.parametrize(
    ("t", "h", "named"),
    [
        (0.0, 0.0, "communicationStepSize = 0.000e0"),
        (0.0, -1e-4, "communicationStepSize = -1.000e-4"),
        (0.0, math.nan, "communicationStepSize = NaN"),
        (0.5, 1e-4, "currentCommunicationPoint = 5.000e-1"),
        (0.0, 9.0, "stopTime = 8.000e0"),
    ],
)
def test_an_impossible_step_names_value_and_limit(kind, t, h, named, small_fsi3, instantiate, steps_still):
    unit = instantiate(small_fsi3)[kind]
    unit.start()
    with pytest.raises(UnitError) as caught:
        unit.step(t, h)
    assert named in str(caught.value)
    steps_still(kind)


def test_stations_in_one_place_are_named(small_fsi3, instantiate):
    fluid = instantiate(small_fsi3)["fluid"]
    fluid.connect(["x", "y"], [])
    fluid.start()
    fluid.inputs[:] = 0.0
    with pytest.raises(UnitError, match="stations 1 and 2 of the beam coincide"):
        fluid.step(0.0, 2e-4)


def test_a_fast_station_is_named_with_its_limit(small_fsi3, instantiate):
    fluid = instantiate(small_fsi3)["fluid"]
    fluid.connect(["vy"], [])
    fluid.start()
    fluid.inputs[3] = 1e5
    with pytest.raises(UnitError, match=r"station 4 of the beam has the velocity \(0\.000e0, 1\.000e5\) m/s"):
        fluid.step(0.0, 2e-4)


def test_a_unit_that_failed_can_be_put_back(small_fsi3, instantiate):
    fluid = instantiate(small_fsi3)["fluid"]
    fluid.start()
    fluid.save()
    with pytest.raises(UnitError):
        fluid.step(0.0, -1.0)
    fluid.restore()
    fluid.step(0.0, 2e-4)


def test_a_file_that_is_no_fmu_is_named(tmp_path):
    text = tmp_path / "text.fmu"
    text.write_text("no zip file")
    with pytest.raises(UnitError, match="text.fmu cannot be read as an FMU"):
        Unit(text, "rod", 1.0)


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("fluid.density", "must be of the form key=value"),
        ("fluid.nothing.here=1", "names a key that the scene does not have"),
        ("fluid.cylinders.5.radius=1", "names a key that the scene does not have"),
        ("fluid.box.cells.2=8", "names a key that the scene does not have"),
    ],
)
def test_an_override_that_leads_nowhere_is_named(assignment, message, fsi3):
    with pytest.raises(SceneError, match=message):
        override(fsi3, assignment)


@pytest.mark.parametrize(("text", "message"), [("{", "column 2: not JSON"), ("[]", "a scene is an object")])
def test_a_file_that_is_no_scene_is_named(text, message, tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(text)
    with pytest.raises(SceneError, match=message):
        load(path)


def test_the_command_line_shows_the_units_words_and_exits_with_2(tmp_path):
    done = run_scene(FSI3, "--output", tmp_path, "--set", "fluid.density=-1")
    assert done.returncode == 2
    assert "`fluid.density` is out of range: -1 is not > 0 (from --set)" in done.stderr, done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
