"""The checks of docs/reliability.md with few cases, and how the units use what their host gives them."""

import ctypes
import os
import shutil
import time

import pytest
from nervure.pack import package

from studies.reliability.__main__ import CHECKS, unpack
from studies.reliability.unit import ERROR, OK, STEP, Library, Unit, child, tried

pytestmark = pytest.mark.usefixtures("libraries")
both = pytest.mark.parametrize("kind", package.KINDS)


@pytest.fixture(scope="module")
def folders(tmp_path_factory, libraries):
    """The unpacked FMUs by kind."""
    return {kind: unpack(kind, tmp_path_factory.mktemp(kind)) for kind in package.KINDS}


@both
@pytest.mark.parametrize("name", CHECKS)
def test_check_finds_nothing(name, kind, folders):
    function, _, few = CHECKS[name]
    child("spawn", 60.0, tried, function, kind, folders[kind], few)


@pytest.mark.parametrize(("planted", "found"), [((os.abort,), "crashed"), ((time.sleep, 60), "hung")])
def test_a_crash_and_a_hang_are_found(planted, found):
    with pytest.raises(AssertionError, match=found):
        child("spawn", 8.0, *planted)


@both
def test_odd_folder_names_and_read_only_files_are_no_obstacle(kind, folders, tmp_path):
    folder = tmp_path / "a b%20ü#é 100 %"
    shutil.copytree(folders[kind], folder)
    for path in [*folder.rglob("*"), folder]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    library = Library(kind, folder)
    assert b"%25" in library.resources
    assert Unit(library).run(2) == Unit(Library(kind, folders[kind])).run(2)
    for path in [folder, *folder.rglob("*")]:
        path.chmod(0o755)


@both
def test_without_a_resource_location_the_reason_is_logged(kind, folders):
    library = Library(kind, folders[kind])
    for library.resources in (None, b""):
        assert library.instantiate() is None
        assert "needs its resources folder with scene.json" in library.messages[-1]


@both
def test_a_good_run_is_silent_until_events_are_asked_for(kind, folders):
    library = Library(kind, folders[kind])
    Unit(library).run(3)
    assert library.messages == []
    unit = Unit(library, start=False)
    unit.do("SetDebugLogging", 1, 1, (ctypes.c_char_p * 1)(b"logEvents"))
    unit.start()
    assert "stations, start at t = 0 s" in library.messages[-1]


@both
def test_without_a_logger_a_refusal_is_only_a_status(kind, folders):
    library = Library(kind, folders[kind])
    library.callbacks = type(library.callbacks)()
    unit = Unit(library)
    assert unit.call("DoStep", 0.0, -1.0, 0) == ERROR
    assert unit.call("DoStep", 0.0, STEP, 0) == OK
