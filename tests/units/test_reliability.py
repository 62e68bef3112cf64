"""The reliability checks with few cases, and how the units use what their host gives them."""

import os
import shutil
import threading
import time
from pathlib import Path

import fmpy
import pytest

from nervure.scene import Scene, load
from nervure.units import package
from nervure.units.describe import describe
from tests.conftest import COUPLED
from tests.reliability.checks import CHECKS, unpack
from tests.reliability.trials import inherited
from tests.reliability.unit import ERROR, OK, STEP, FMU2Unit, child, tried

pytestmark = pytest.mark.usefixtures("libraries")
both = pytest.mark.parametrize("kind", COUPLED)


@pytest.fixture(scope="module")
def folders(tmp_path_factory, libraries):
    """The unpacked FMUs of the small scene by kind."""
    return {kind: unpack(kind, tmp_path_factory.mktemp(kind), "flag") for kind in COUPLED}


@both
@pytest.mark.parametrize("name", CHECKS)
def test_check_finds_nothing(name, kind, tmp_path):
    check = CHECKS[name]
    folder = unpack(kind, tmp_path, check.scene)
    child("forkserver", 60.0, tried, check.function, kind, folder, check.few)


@pytest.mark.parametrize(
    ("planted", "after", "found"), [((os.abort,), 60.0, "crashed"), ((time.sleep, 60), 1.0, "hung")]
)
def test_a_crash_and_a_hang_are_found(planted, after, found):
    with pytest.raises(AssertionError, match=found):
        child("forkserver", after, *planted)


@both
def test_odd_folder_names_and_read_only_files_are_no_obstacle(kind, folders, tmp_path):
    folder = tmp_path / "a b%20ü#é 100 %"
    shutil.copytree(folders[kind], folder)
    for path in [*folder.rglob("*"), folder]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    assert "%25" in folder.as_uri()
    assert FMU2Unit(kind, folder).new().run(2) == FMU2Unit(kind, folders[kind]).new().run(2)
    for path in [folder, *folder.rglob("*")]:
        path.chmod(0o755)


@both
def test_without_a_resource_location_the_reason_is_logged(kind, folders):
    library = FMU2Unit(kind, folders[kind])
    for location in (None, b""):
        assert library.fmi2Instantiate(b"unit", 1, library.guid.encode(), location, library.log, 0, 0) is None
        assert "needs a resources folder with scene.json" in library.messages[-1]


@both
def test_a_good_run_is_silent_until_events_are_asked_for(kind, folders):
    library = FMU2Unit(kind, folders[kind])
    library.new().run(3)
    assert library.messages == []
    unit = library.new(start=False)
    unit.setDebugLogging(True, ["logEvents"])
    unit.enter()
    unit.exitInitializationMode()
    assert "stations, start at t = 0 s" in library.messages[-1]


@both
def test_without_a_logger_a_refusal_is_only_a_status(kind, folders):
    library = FMU2Unit(kind, folders[kind])
    library.log = type(library.log)()
    unit = library.new()
    assert unit.call("DoStep", 0.0, -1.0, 0) == ERROR
    assert unit.call("DoStep", 0.0, STEP, 0) == OK


def test_threads_of_a_step_end_with_it_and_a_fork_is_as_its_parent(libraries, tmp_path):
    """On two threads: the bits of one, a second thread while a step runs, none after it."""
    scene = load("fsi3-650x144")
    one, two = (FMU2Unit("fluid", folder) for folder in (unpacked(scene, tmp_path, 1), unpacked(scene, tmp_path, 2)))
    others, seen = set(tasks()), set()
    unit, is_over = two.new(), threading.Event()

    def watch():
        while not is_over.is_set():
            seen.update(tasks())

    watcher = threading.Thread(target=watch)
    watcher.start()
    answer = unit.run(5)
    is_over.set()
    watcher.join()
    assert answer == one.new().run(5)
    assert len(seen - others - {str(watcher.native_id)}) >= 1, "the step ran on one thread"
    assert set(tasks()) == others
    fresh = two.new().run(5)
    after = child("fork", 60.0, inherited, two, unit)
    assert after == (unit.run(5), fresh)


def unpacked(scene: Scene, folder: Path, threads: int) -> Path:
    """The unpacked FMU of the fluid on so many threads."""
    scene.fluid.threads, own = threads, folder / str(threads)
    return Path(fmpy.extract(str(package.pack(describe("fluid", scene), own)), str(own / "unpacked")))


def tasks() -> list[str]:
    """The threads of this process."""
    return os.listdir("/proc/self/task")
