"""The package as a Python program uses it: ten lines from a scene to a figure."""

import doctest
import json
import pydoc
import signal
import sys
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import nervure
from nervure.scene import validate
from nervure.scene.part import Part
from nervure.simulation import checkpoint
from nervure.units.fmu import Unit
from tests.conftest import FLUID_ONLY

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
    assert written == summary.document() and [*written, "warnings", "wing", "wings", "rods", "verified"] == list(
        vars(summary)
    )
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
    with pytest.raises(nervure.InputError, match="fields_every is True, but must be a finite number"):
        nervure.run("csm1", tmp_path, fields_every=True)
    with pytest.raises(nervure.InputError, match="series_every is 1.*0, but must be a finite number"):
        nervure.run("csm1", tmp_path, series_every=10**400)
    with pytest.raises(nervure.InputError, match="changed by its attributes"):
        nervure.run(falling, tmp_path, overrides=["time.end=1"])
    with pytest.raises(AttributeError, match="`walk`"):
        nervure.walk  # noqa: B018


def test_a_quantity_that_was_not_recorded_is_said(falling, tmp_path):
    with pytest.raises(nervure.InputError, match="lift was not recorded: there are time, .*tip_uy"):
        nervure.run(falling, tmp_path, quiet=True).plot("lift")
    with pytest.raises(nervure.InputError, match="there is no column to draw: there are time, .*tip_uy"):
        nervure.read(tmp_path).plot()
    assert nervure.compare(nervure.read(tmp_path), names="tip_uy").axes


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


class Display:
    """Stands for a notebook: keeps what is displayed, in the place of its handle."""

    def __init__(self):
        self.shown = []

    def display(self, content, **_):
        self.shown.append(content["text/plain"])
        return SimpleNamespace(update=lambda content, **_: self.shown.__setitem__(-1, content["text/plain"]))


def test_a_notebook_keeps_one_line_of_progress_and_plain_text(falling, tmp_path, capsys, monkeypatch):
    notebook = Display()
    modules = {"ipykernel": ModuleType("ipykernel"), "IPython": ModuleType("IPython"), "IPython.display": notebook}
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setenv("FORCE_COLOR", "1")  # A kernel sets it
    monkeypatch.setattr("nervure.output.console.TERMINAL_INTERVAL", 0.0)
    nervure.run(falling, tmp_path)
    assert len(notebook.shown) == 1 and notebook.shown[0].startswith("t 0.010 of 0.01 s"), notebook.shown
    printed = capsys.readouterr().out
    assert "\x1b" not in printed and "\r" not in printed and "tip_uy mean" in printed


def test_a_run_shows_itself_in_ten_lines(falling, tmp_path):
    lines = repr(nervure.run(falling, tmp_path, quiet=True)).splitlines()
    assert len(lines) <= 10 and lines[0] == "Run of falling-rod, 100 steps to t = 0.01 s"
    assert lines[1].startswith("  tip_ux: ") and f"  folder: {tmp_path}" in lines and len(max(lines, key=len)) < 120


def test_the_package_names_its_interface():
    names = [name for name in dir(nervure) if not name.startswith("_")]
    assert names == sorted(nervure.__all__) and "__version__" in dir(nervure)
    shown = pydoc.plain(pydoc.render_doc(nervure))
    for name in ("run(scene", "sweep(", "class Run(", "plot_field("):
        assert name in shown, name


@pytest.mark.parametrize(
    "thing",
    [nervure.load, nervure.run, nervure.read, nervure.sweep, nervure.verify, Part.copy],
    ids=lambda thing: thing.__qualname__,
)
def test_the_examples_of_a_docstring_hold(thing, tmp_path):
    found = doctest.DocTestFinder().find(thing, globs={"nervure": nervure, "folder": tmp_path})
    results = [doctest.DocTestRunner().run(one) for one in found]
    assert sum(result.attempted for result in results) >= 2 and not any(result.failed for result in results)


def test_a_copy_of_a_scene_is_changed_and_the_scene_stays(falling):
    changed = falling.copy({"rod.gravity": [0.0, -3.0]}, time__end=0.5, beam__segments=8)
    assert (changed.time.end, changed.beam.segments, changed.rod.gravity) == (0.5, 8, [0.0, -3.0])
    assert (falling.time.end, falling.beam.segments) == (0.01, 16)
    assert falling.rod.copy(damping=1.0).damping == 1.0
    with pytest.raises(nervure.InputError, match="did you mean time"):
        falling.copy({"tme.end": 1})
    with pytest.raises(nervure.InputError, match="but must be"):
        falling.copy(time__end="soon")


def test_a_function_sees_every_row_and_may_end_the_run(falling, tmp_path):
    seen = []

    def see(time, values):
        seen.append((time, values["tip_uy"]))
        return time > 0.00495

    run = nervure.run(falling, tmp_path, quiet=True, on_step=see)
    assert len(seen) == 51 == len(run.series["time"]) and seen[-1][1] == run.series["tip_uy"][-1]
    assert not run.summary.completed and nervure.resume(tmp_path, quiet=True).summary.completed


def test_an_exception_in_a_function_that_sees_rows_loses_no_results(falling, tmp_path):
    def slip(time, values):
        return values["tip"] if time > 0.00495 else None

    with pytest.raises(KeyError, match="tip"):
        nervure.run(falling, tmp_path, quiet=True, on_step=slip)
    assert nervure.read(tmp_path).summary.steps == 50
    assert nervure.resume(tmp_path, quiet=True).summary.completed


def test_every_column_is_drawn_and_every_run_compared(falling, tmp_path):
    """Also counts, which have no unit, and runs whose folders have one name."""
    made = [nervure.run(falling, tmp_path / name / "falling", quiet=True) for name in "ab"]
    for run in (made[0], nervure.read(made[0].folder)):
        assert run.units.keys() == run.series.keys() and run.plot("iterations").axes
    figure = nervure.compare(*made, names=["tip_uy"])
    assert len(figure.axes[0].lines) == 2


@pytest.fixture(scope="module")
def with_fields(tmp_path_factory, libraries):
    folder = tmp_path_factory.mktemp("fields")
    return nervure.run(validate(FLUID_ONLY), folder, fields_every=5e-3, quiet=True)


@pytest.mark.parametrize("name", ["vorticity", "pressure", "speed", "u"])
def test_a_field_is_drawn_at_a_time(name, with_fields):
    figure = with_fields.plot_field(name, 0.011)
    assert figure.axes[0].get_title(loc="right") == "t = 0.010 s"
    assert figure.axes[1].get_ylabel().startswith(f"{name} [")


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda run: run.plot_field("vortcity"), "did you mean vorticity"),
        (lambda run: run.plot("drg"), "did you mean drag"),
        (lambda run: nervure.sweep("csm1", {("beam.segments", "time.end"): [1]}), "must be tuples of 2"),
        (lambda run: nervure.sweep("csm1", {"beam.segmens": [1]}), "did you mean `segments`"),
        (lambda run: nervure.sweep("csm1", {}, workers=1, scheduler="x"), "workers"),
        (lambda run: nervure.sweep([], {}), "there is no scene"),
        (lambda run: nervure.sweep("csm1", {"beam.segments": []}), "there are no values of beam.segments"),
        (lambda run: nervure.sweep(run.scene.document(), {}), r"is a dict, but must be .*Scene\(\*\*dictionary\)"),
        (lambda run: nervure.load(json.dumps(run.scene.document())), "is JSON text, but must be a path"),
        (lambda run: nervure.load("a" * 300), "File name too long"),
        (lambda run: nervure.load("a\0b"), "null byte"),
        (lambda run: nervure.load("csm1", "time.end=a"), "`time.end` must be a number"),
        (lambda run: nervure.compare(), "there is no run"),
        (lambda run: nervure.run("csm1", run.folder / "x", on_step=1), "on_step is 1, but"),  # type: ignore[arg-type]
        (lambda run: nervure.run("csm1", run.folder / "x", drive="my.py"), "drive is 'my.py'"),  # type: ignore[arg-type]
    ],
)  # fmt: skip
def test_a_slip_in_python_is_answered_with_what_was_meant(ask, said, with_fields):
    with pytest.raises(nervure.InputError, match=said):
        ask(with_fields)


loose: Any = nervure
"""The package without its types."""


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda run: run.scene.copy({5: 6}), "a key is 5, but must be a text such as `time.end`"),
        (lambda run: run.scene.copy({"\ud800": 6}), "a key is .*, but must be a text"),
        (lambda run: run.scene.copy({"é": 6}), "unknown key `é`"),
        (lambda run: run.scene.copy([5]), r"changes are \[5\], but must be a dictionary"),
        (lambda run: loose.sweep("csm1", {5: [1]}), "vary has the key 5, but it must be a scene key"),
        (lambda run: loose.sweep("csm1", ["time.end"]), r"vary is \['time.end'\], but must be a dictionary"),
        (lambda run: loose.sweep("csm1", {"time.end": b"12"}), "are b'12', but must be a list"),
        (lambda run: loose.sweep(run.scene, {}, overrides=["time.end=1"]), "is changed by its attributes"),
        (lambda run: loose.sweep(5, {}), "the scene is a int"),
        (lambda run: loose.sweep("csm1", {}, workers=0), "workers is 0, but must be a whole number of at least 1"),
        (lambda run: loose.verify(run.scene, overrides=["time.end=1"]), "is changed by its attributes"),
        (lambda run: loose.verify("csm1", quantities=[5]), r"quantities is \[5\], but must be a text or a list"),
        (lambda run: loose.verify("csm1", budget=float("inf")), "budget is inf, but must be a finite number above 0"),
        (lambda run: loose.load("csm1", 5), "overrides is 5, but must be a text or a list of texts"),
        (lambda run: loose.load("csm1", end_time="2"), "end_time is '2', but must be a finite number"),
        (lambda run: loose.read(["x"]), r"folder is \['x'\], but must be a path"),
        (lambda run: loose.resume("a\0b"), "folder is .*, but must be a path"),
        (lambda run: loose.run("csm1", ""), "output is '', but must be a path"),
        (lambda run: loose.run("csm1", run.folder / "x", force="no"), "force is 'no', but must be True or False"),
        (lambda run: loose.run("csm1", run.folder / "x", rod_fmu=5), "rod_fmu is 5, but must be a path"),
        (lambda run: loose.run("csm1", run.folder / "x", fmi=[2]), r"fmi is \[2\], but must be 2 or 3"),
        (lambda run: loose.compare("results"), "a run is 'results', but must be what `nervure.run`"),
        (lambda run: loose.compare(run, names=5), "names is 5, but must be a text or a list of texts"),
        (lambda run: run.plot(5), r"names is \(5,\), but must be a text"),
        (lambda run: run.fields("0"), "begin is '0', but must be a finite number"),
        (lambda run: run.plot_field("u", time="0"), "time is '0', but must be a finite number"),
        (lambda run: run.plot_field("u", crop="all"), "crop is 'all', but must be a list of finite numbers"),
        (lambda run: run.plot_field(at=float("nan")), "at is nan, but must be a finite number"),
        (lambda run: run.animate(across=5), "across is 5, but must be x, y or z"),
        (lambda run: run.animate(q="1"), "q is '1', but must be a finite number above 0"),
        (lambda run: run.animate(background=5), "background is 5, but must be a text"),
    ],
)
def test_a_wrong_key_or_value_is_refused_by_the_name_of_its_argument(ask: Any, said: str, with_fields):
    with pytest.raises(nervure.InputError, match=said):
        ask(with_fields)


@pytest.mark.parametrize(("package", "ask"), [("pandas", "to_pandas"), ("xarray", "to_xarray"), ("xarray", "fields")])
def test_a_table_needs_its_package(package, ask, with_fields, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(nervure.InputError, match=f"-m pip install {package}`"):
        getattr(with_fields, ask)()


def test_series_become_tables_with_units(with_fields):
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    table, dataset = with_fields.to_pandas(), with_fields.to_xarray()
    assert table.index.name == "time" and table.attrs["units"]["drag"] == "N/m" == dataset.drag.attrs["units"]
    assert (table["drag"].to_numpy() == with_fields.series["drag"]).all()
    assert dataset.time.attrs["units"] == "s" and (dataset.drag.values == with_fields.series["drag"]).all()


def test_fields_become_a_dataset_with_places(with_fields):
    pytest.importorskip("xarray")
    found = with_fields.fields(0.004, 0.011)
    assert found.vorticity.dims == ("time", "y", "x") and found.time.values == pytest.approx([0.005, 0.01])
    assert found.u.attrs["units"] == "m/s" and found.x.attrs["units"] == "m"
    waves = {axis: 2j * np.pi * np.fft.fftfreq(found.sizes[axis], found[axis].diff(axis).values[0]) for axis in "xy"}
    curl = np.fft.ifft(waves["x"] * np.fft.fft(found.v.values, axis=2), axis=2)
    curl -= np.fft.ifft(waves["y"][:, None] * np.fft.fft(found.u.values, axis=1), axis=1)
    assert np.abs(curl.real - found.vorticity.values).max() < 1e-3 * np.abs(curl).max()
    with pytest.raises(nervure.InputError, match="no frames in that time, but 5 elsewhere"):
        with_fields.fields(5)
