"""The one way of a run: from the scene to its units, steps, observers and results."""

import h5py
import numpy as np
import pytest

import nervure
from nervure import library
from nervure.scene import validate
from nervure.simulation.loop import Observer
from nervure.simulation.session import Session
from tests.conftest import nervure as command

pytestmark = pytest.mark.usefixtures("libraries")


class Log(Observer):
    """Keeps what it sees of a run."""

    def __init__(self):
        self.steps, self.seen = [], []

    def step(self, loop):
        self.steps.append((loop.steps, loop.time))

    def end(self, status):
        self.seen.append(("end", status and status.completed))

    def finish(self, results):
        self.seen.append(("finish", (results.folder / "summary.json").exists()))


def test_steps_by_hand_give_the_bits_of_a_run(small_fsi3, tmp_path):
    small_fsi3["time"]["end"] = 0.01
    scene = validate(small_fsi3)
    run = nervure.run(scene, tmp_path / "run", quiet=True)
    with Session(scene, tmp_path / "session") as session:
        session.start()
        while session.steps < session.grid.steps:
            session.step()
        found = session.finish()
    assert found.summary.completed and found.summary.steps == run.summary.steps
    assert all(np.array_equal(found.series[name], values) for name, values in run.series.items())
    assert not list((tmp_path / "session").glob("*.fmu")), "the units were in a temporary folder"


def test_observers_see_the_start_each_step_the_end_and_the_results(rod_only, tmp_path):
    with Session(validate(rod_only), tmp_path) as session:
        log = Log()
        session.observers = [log]
        session.run()
        session.finish()
    assert log.steps[0] == (0, 0.0) and [steps for steps, _ in log.steps] == list(range(101))
    assert log.steps[-1][1] == pytest.approx(0.01)
    assert log.seen == [("end", True), ("finish", True)]


def test_observers_see_the_end_that_an_exception_makes(rod_only):
    def fail():
        raise RuntimeError

    with Session(validate(rod_only)) as session:
        log = Log()
        session.observers = [log]
        with pytest.raises(RuntimeError):
            session.run(stopping=fail)
    assert log.seen == [("end", None)]


def test_a_run_describes_each_unit_once(small_fsi3, tmp_path, monkeypatch):
    described, describe = [], library.describe

    def counted(kind, *arguments):
        described.append(kind)
        return describe(kind, *arguments)

    monkeypatch.setattr(library, "describe", counted)
    small_fsi3["time"]["end"] = 0.002
    for fmi in (2, 3):
        nervure.run(validate(small_fsi3), tmp_path / str(fmi), quiet=True, fmi=fmi)
        assert sorted(described) == ["fluid", "rod"], described
        described.clear()


def test_the_version_is_told_by_package_command_and_summary(rod_only, tmp_path):
    done = command("--version")
    assert done.returncode == 0 and done.stdout == f"nervure {nervure.__version__}\n"
    run = nervure.run(validate(rod_only), tmp_path, quiet=True)
    assert run.summary.versions["nervure"] == nervure.__version__


@pytest.mark.parametrize("every", [0.028, 0.029, 1.0, 1e308])
def test_rows_and_frames_farther_apart_than_the_run_is_long_are_those_of_its_start_and_end(two_rods, every, tmp_path):
    two_rods["time"]["end"] = 0.028
    run = nervure.run(validate(two_rods), tmp_path, series_every=every, fields_every=every, quiet=True)
    assert run.series["time"].tolist() == pytest.approx([0.0, 0.028])
    with h5py.File(tmp_path / "beam-upper.vtkhdf") as file:
        assert file["VTKHDF/Steps/Values"][:].tolist() == pytest.approx([0.0, 0.028])


@pytest.mark.parametrize("stride", [3, 4, 7])
def test_a_series_with_fewer_rows_has_the_values_of_their_times(two_rods, stride):
    two_rods["time"]["end"] = 0.028

    def series(every):
        with Session(validate(two_rods), series_every=every) as session:
            session.run()
            return session.recorder.series

    every, some = series(None), series(stride * 2e-3)
    for name, values in every.items():
        assert np.array_equal(some[name], values[::stride]), name
        assert values.size == 15, name
    assert all(np.ptp(every[name][1:]) > 0 for name in ("upper_tip_uy", "lower_load_power", "drag")), every
