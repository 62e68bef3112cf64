"""The shipped FSI3 scene from start to end, against recorded and published numbers."""

import json

import pytest

from nervure.scene import load
from nervure.simulation.results import FILES
from tests.conftest import FSI3
from tests.simulation.record import EARLY_QUANTITIES, EARLY_TIMES, RECORDED, run

pytestmark = pytest.mark.pictures

EARLY_TOLERANCE = 1e-6
"""Relative to the largest recorded value: another machine's libm differs in the last bit, and before the wake sways
such differences hardly grow."""

SETTLED_TOLERANCE = 0.01
"""Relative to the amplitude, or to the frequency: the wake forgets in which rounding it began, but the moment at which
it starts to sway, and with it the window, does not."""

COARSE_GRID = {
    "tip_uy": {"amplitude": 0.10, "frequency_hz": 0.03},
    "drag": {"mean": 0.13},
    "lift": {"amplitude": 0.14},
}
"""Largest relative distance from the published values on this grid, whose cells are 8 mm against a bar of 20 mm: it has
8.6, 2.1, 12 and 12 %. Other places of the grid differ by some per cent."""


@pytest.fixture(scope="module")
def fsi3_run(libraries, tmp_path_factory):
    """Folder and numbers of the run."""
    folder = tmp_path_factory.mktemp("fsi3")
    return folder, run(folder)


def test_every_result_is_there(fsi3_run):
    folder, _ = fsi3_run
    name = load(FSI3).name
    assert {path.name for path in folder.iterdir()} == {*FILES, "series.h5", f"{name}-rod.fmu", f"{name}-fluid.fmu"}


def test_summary_tells_what_was_run_and_what_it_cost(fsi3_run):
    folder, _ = fsi3_run
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["completed"] and summary["error"] is None
    assert summary["simulated_s"] == pytest.approx(8.0, rel=1e-12)
    assert summary["steps"] == round(8.0 / load(FSI3).time.communication_step)
    assert summary["periods"] >= 5
    assert summary["wall_s"] == pytest.approx(sum(summary["phases_s"].values()))
    assert summary["method"]["coupling"]["load"] == "momentum" and summary["method"]["coupling"]["scheme"] == "explicit"
    assert abs(summary["interface"]["imbalance"]) < 0.05, summary["interface"]
    for quantity in summary["quantities"].values():
        assert quantity["reference"]["source"]


def test_extremes_and_harmonic_fit_tell_the_same(fsi3_run):
    folder, _ = fsi3_run
    tip = json.loads((folder / "summary.json").read_text())["quantities"]["tip_uy"]
    assert tip["fit"]["amplitude"] == pytest.approx(tip["amplitude"], rel=0.03)
    assert tip["fit"]["frequency_hz"] == pytest.approx(tip["frequency_hz"], rel=0.005)


@pytest.mark.parametrize("quantity", EARLY_QUANTITIES)
def test_early_flow_is_as_recorded(fsi3_run, quantity):
    recorded = json.loads(RECORDED.read_text())["early"]
    alike = ("tip_ux", "tip_uy") if quantity.startswith("tip") else ("drag", "lift")
    scale = max(abs(value) for name in alike for value in recorded[name])
    for t, found, expected in zip(EARLY_TIMES, fsi3_run[1]["early"][quantity], recorded[quantity]):
        assert found == pytest.approx(expected, abs=EARLY_TOLERANCE * scale), f"{quantity} at t = {t} s"


@pytest.mark.parametrize("quantity", EARLY_QUANTITIES)
def test_settled_motion_is_as_recorded(fsi3_run, quantity):
    found, recorded = fsi3_run[1]["settled"][quantity], json.loads(RECORDED.read_text())["settled"][quantity]
    for what in ("mean", "amplitude"):
        assert found[what] == pytest.approx(recorded[what], abs=SETTLED_TOLERANCE * recorded["amplitude"]), what
    assert found["frequency_hz"] == pytest.approx(recorded["frequency_hz"], rel=SETTLED_TOLERANCE)


@pytest.mark.parametrize("quantity", COARSE_GRID)
def test_settled_motion_is_near_the_published_one(fsi3_run, quantity):
    found, published = fsi3_run[1]["settled"][quantity], load(FSI3).reference.quantities[quantity]
    for what, tolerance in COARSE_GRID[quantity].items():
        assert found[what] == pytest.approx(getattr(published, what), rel=tolerance), what
