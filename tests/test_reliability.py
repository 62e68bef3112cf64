"""The checks of docs/reliability.md with few cases, and what an FMU carries to be read."""

import ctypes
import os
import shutil
import time
import zipfile
from pathlib import Path

import fmpy
import pytest
from lxml import etree
from reliability.checks import CHECKS, guarded, unpack
from reliability.unit import ERROR, OK, STEP, Callbacks, Library, Unit

from nervure.pack import package

pytestmark = pytest.mark.usefixtures("libraries")
both = pytest.mark.parametrize("kind", package.KINDS)


@pytest.fixture(scope="module")
def folders(tmp_path_factory, libraries):
    """The unpacked FMUs by kind."""
    return {kind: unpack(kind, tmp_path_factory.mktemp(kind)) for kind in package.KINDS}


@both
@pytest.mark.parametrize("name", CHECKS)
def test_check_finds_nothing(name, kind, folders):
    check = CHECKS[name]
    well, result = guarded(name, kind, folders[kind], check.quick, 60.0)
    assert well, result


def crash(*arguments) -> None:
    os.abort()


def hang(*arguments) -> None:
    time.sleep(60)


@pytest.mark.parametrize(("planted", "found"), [(crash, "crashed"), (hang, "hung")])
def test_a_crash_and_a_hang_are_found(planted, found, folders):
    well, result = guarded("sequences", "rod", folders["rod"], 1, 8.0, planted)
    assert not well and found in result, result


@both
def test_odd_folder_names_and_read_only_files_are_no_obstacle(kind, folders, tmp_path):
    folder = tmp_path / "a b%20ü#é 100 %"
    shutil.copytree(folders[kind], folder)
    for path in [*folder.rglob("*"), folder]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    library = Library(kind, folder)
    assert "%25" in library.resources.decode()
    assert Unit(library).run(2) == Unit(Library(kind, folders[kind])).run(2)
    for path in [folder, *folder.rglob("*")]:
        path.chmod(0o755)


@both
def test_without_a_resource_location_the_reason_is_logged(kind, folders):
    library = Library(kind, folders[kind])
    callbacks = ctypes.byref(library.callbacks)
    for location in (None, b""):
        assert library.instantiate(b"unit", 1, library.guid, location, callbacks, 0, 0) is None
        assert "needs its resources folder with scene.json" in library.messages[-1]


@both
def test_a_good_run_is_silent_until_events_are_asked_for(kind, folders):
    library = Library(kind, folders[kind])
    Unit(library).run(3)
    assert library.messages == []
    unit = Unit(library, start=False)
    unit.do("SetDebugLogging", 1, 1, (ctypes.c_char_p * 1)(b"logEvents"))
    for name, arguments in (("SetupExperiment", (0, 0.0, 0.0, 0, 0.0)), ("EnterInitializationMode", ())):
        unit.do(name, *arguments)
    unit.do("ExitInitializationMode")
    assert "stations, start at t = 0 s" in library.messages[-1]


@both
def test_without_a_logger_a_refusal_is_only_a_status(kind, folders):
    library = Library(kind, folders[kind])
    library.callbacks = Callbacks()
    unit = Unit(library)
    assert library.DoStep(unit.component, 0.0, -1.0, 0) == ERROR
    assert library.DoStep(unit.component, 0.0, STEP, 0) == OK


@both
def test_fmu_explains_itself(kind, small_fsi3, tmp_path):
    with zipfile.ZipFile(package.pack(kind, small_fsi3, tmp_path)) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    names = etree.fromstring(files["modelDescription.xml"]).xpath("//ScalarVariable/@name")
    page = files["documentation/index.html"].decode("utf-8")
    assert [name for name in names if "[" not in name and f"<td>{name}<td>" not in page] == []
    assert "<td>x[1] … x[21]<td>" in page and "<h2>Equations</h2>" in page
    assert {"documentation/licenses/LICENSE-MIT", "documentation/licenses/LICENSE-APACHE"} <= files.keys()
    assert files["model.png"].startswith(b"\x89PNG")


@both
def test_each_array_is_one_terminal(kind, small_fsi3, tmp_path):
    with zipfile.ZipFile(package.pack(kind, small_fsi3, tmp_path)) as archive:
        terminals = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        variables = set(etree.fromstring(archive.read("modelDescription.xml")).xpath("//ScalarVariable/@name"))
    schema = Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"
    etree.XMLSchema(file=str(schema)).assertValid(terminals)
    sizes = {terminal.get("name"): len(terminal) for terminal in terminals.iter("Terminal")}
    exchanged = {"x", "y", "vx", "vy", "force_x", "force_y", "impedance"}
    assert sizes == dict.fromkeys(exchanged | ({"pressure_jump"} if kind == "fluid" else set()), 21)
    assert set(terminals.xpath("//@variableName")) <= variables
