"""The package as a Python program uses it: ten lines from a scene to a figure."""

import json
import signal

import numpy as np
import pytest
from rich.console import Console

import nervure
from nervure.scene import validate
from nervure.simulation import checkpoint
from nervure.units.fmu import Unit

pytestmark = pytest.mark.usefixtures("libraries")


@pytest.fixture
def falling(rod_only):
    return validate(rod_only)


def test_ten_lines_from_a_scene_to_a_figure(tmp_path):
    scene = nervure.load("csm3")
    scene.time.end = 0.02
    scene.rod.gravity = [0.0, -4.0]
    run = nervure.run(scene, tmp_path, quiet=True)
    assert run.summary.completed and run.summary.steps == run.series["time"].size - 1
    assert run.summary.quantities["tip_uy"].mean < 0 and run.units["tip_uy"] == "m"
    assert run.series["tip_uy"][-1] == pytest.approx(-0.5 * 4.0 * 0.02**2, rel=0.01)
    figure = run.plot("tip_uy", "tip_vy")
    assert [axis.get_ylabel() for axis in figure.axes] == ["tip, along y [mm]", "tip vy [m/s]"]
    figure.savefig(tmp_path / "tip.pdf")
    assert json.loads((tmp_path / "scene.json").read_text())["rod"]["gravity"] == [0.0, -4.0]


def test_a_run_is_read_as_it_was(falling, tmp_path):
    """In ten digits, as series.csv has them."""
    run = nervure.run(falling, tmp_path, quiet=True)
    again = nervure.read(tmp_path)
    assert (again.scene, again.summary, again.units) == (run.scene, run.summary, run.units)
    assert list(again.series) == list(run.series)
    for name, values in run.series.items():
        assert np.allclose(again.series[name], values, rtol=1e-9, atol=0.0), name


def test_summary_is_written_with_all_its_keys(falling, tmp_path):
    summary = nervure.run(falling, tmp_path, quiet=True).summary
    written = json.loads((tmp_path / "summary.json").read_text())
    assert written == summary.document() and [*written, "rods"] == list(vars(summary))
    assert written["coefficients"] is None and "reference" not in written["quantities"]["tip_uy"]
    assert written["series"]["tip_uy"] == "m"


def test_a_scene_is_run_by_its_name_with_overrides(tmp_path):
    run = nervure.run("csm3", tmp_path, overrides=["time.end=0.01", "beam.segments=8"], quiet=True)
    assert run.scene.beam.segments == 8 and run.summary.simulated_s == pytest.approx(0.01)


def test_a_scene_is_inspected_as_by_the_command(falling, capsys):
    nervure.inspect(falling)
    shown = capsys.readouterr().out
    assert "100 of 0.0001 s to 0.01 s" in shown and "wall time" in shown, shown


def test_what_cannot_be_used_is_refused(falling, tmp_path):
    falling.beam.thickness = -1.0
    with pytest.raises(nervure.InputError, match="beam.thickness"):
        nervure.run(falling, tmp_path, quiet=True)
    with pytest.raises(nervure.InputError, match="did you mean csm3"):
        nervure.load("csm4")
    with pytest.raises(nervure.InputError, match="holds no results"):
        nervure.read(tmp_path)
    with pytest.raises(nervure.InputError, match="changed by its attributes"):
        nervure.run(falling, tmp_path, overrides=["time.end=1"])
    with pytest.raises(AttributeError, match="`walk`"):
        nervure.walk  # noqa: B018


def test_a_quantity_that_was_not_recorded_is_said(falling, tmp_path):
    with pytest.raises(nervure.InputError, match="lift was not recorded: there are time, .*tip_uy"):
        nervure.run(falling, tmp_path, quiet=True).plot("lift")


def test_a_run_that_failed_gives_what_there_was_before(small_fsi3, tmp_path):
    scene = validate(small_fsi3)
    scene.coupling = {"load": "pressure_jump", "scheme": {"iterated": {"tolerance": 1e-15, "max_iterations": 2}}}  # type: ignore[assignment]
    with pytest.raises(nervure.RunError, match="did not converge in 2 iterations") as failed:
        nervure.run(scene, tmp_path, quiet=True)
    assert not failed.value.run.summary.completed
    assert nervure.read(tmp_path).summary.error == str(failed.value)


def test_an_interruption_writes_what_there_is_and_leaves_the_handlers(falling, tmp_path, monkeypatch):
    falling.time.end = 1e4
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    step = Unit.step

    def interrupted(self, t, h):
        step(self, t, h)
        if t > 0.01:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Unit, "step", interrupted)
    with pytest.raises(KeyboardInterrupt):
        nervure.run(falling, tmp_path, quiet=True)
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before
    assert nervure.read(tmp_path).summary.simulated_s == pytest.approx(0.0102)
    monkeypatch.undo()
    falling.time.end = 0.02
    with pytest.raises(nervure.InputError, match="holds the checkpoint of a run that was stopped"):
        nervure.run(falling, tmp_path, quiet=True)
    kept = checkpoint.read(tmp_path)
    assert kept.about["done"] == 102 and kept.about["scene"]["time"]["end"] == 1e4


def test_an_interrupted_run_goes_on(falling, tmp_path, monkeypatch):
    whole = nervure.run(falling, tmp_path / "whole", quiet=True)
    step = Unit.step

    def interrupted(self, t, h):
        step(self, t, h)
        if t > 0.005:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Unit, "step", interrupted)
    with pytest.raises(KeyboardInterrupt):
        nervure.run(falling, tmp_path / "parts", quiet=True)
    monkeypatch.undo()
    parts = nervure.resume(tmp_path / "parts", quiet=True)
    assert all((parts.series[name] == values).all() for name, values in whole.series.items())


def test_a_notebook_sees_one_line_that_moves(falling, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("nervure.output.console.TERMINAL_INTERVAL", 0.0)
    monkeypatch.setattr("nervure.output.console.Console", lambda **_: Console(force_jupyter=True))
    nervure.run(falling, tmp_path)
    shown = capsys.readouterr().out
    assert shown.count("\r") == 100 and "\rt 0.010 of 0.01 s" in shown and "tip_uy" in shown
