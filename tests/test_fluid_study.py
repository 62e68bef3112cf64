"""The fluid's study: its list of cases, and a small one run to its tables and figures."""

import csv

import fluid
import pytest

from nervure.pack import package
from nervure.scene import reference

CASES = list(fluid.cases())

pytestmark = pytest.mark.usefixtures("libraries")


def test_cases_differ_and_belong_to_their_references():
    assert len({case.name for case in CASES}) == len(CASES)
    for case in CASES:
        expected = reference(fluid.SCENES[case.flow])
        assert reference(case.scene()["name"]) == expected, case.name


def test_the_unit_takes_a_case_of_every_group_mask_and_scheme():
    kinds = {(case.name.split("/")[0], case.mask, case.scheme, case.filter): case for case in reversed(CASES)}
    for case in kinds.values():
        package.describe("fluid", case.scene())


def test_an_offset_moves_the_grid_by_parts_of_a_cell():
    still, moved = (fluid.Case("x/y", "2D-2", 100, 1e-3, offset_x=x, offset_y=x).scene()["fluid"] for x in (0.0, 0.25))
    for axis, cells in (("x", 100), ("y", 20)):
        (low, high), (low_moved, high_moved) = still["box"][axis], moved["box"][axis]
        assert low_moved - low == pytest.approx(0.25 * (high - low) / cells)
        assert high_moved - low_moved == pytest.approx(high - low)
    assert moved["cylinders"] == still["cylinders"] and moved["channel"] == still["channel"]


@pytest.mark.parametrize(
    ("name", "cpu", "runs"),
    [("grid/a", 9.0, 5), ("thesis/a", 19.0, 3), ("grid/a", 21.0, 1), ("dt/a", 1.0, 1)],
)
def test_short_cases_that_are_drawn_over_time_run_several_times(name, cpu, runs):
    assert fluid.repeats(fluid.Case(name, "2D-2", 100, 1e-3), cpu) == runs


@pytest.fixture
def small(monkeypatch, tmp_path):
    """The study with two cases, of which one cannot run, in folders of its own; returns the list of what was run."""
    good = fluid.Case("grid/good", "2D-2", 100, 2e-3, end=0.1)
    bad = fluid.Case("grid/bad", "2D-2", 100, 2e-3, c_eta=-1.0, end=0.1)
    ran = []
    monkeypatch.setattr(fluid, "RESULTS", tmp_path / "results")
    monkeypatch.setattr(fluid, "DOCS", tmp_path / "docs")
    monkeypatch.setattr(fluid, "cases", lambda: iter([good, bad]))
    run = fluid.run
    monkeypatch.setattr(fluid, "run", lambda case: (ran.append(case.name), run(case))[1])
    return ran


def test_a_case_is_run_once_and_a_failed_one_keeps_its_reason(small, tmp_path, monkeypatch):
    fluid.main(only="*/good", jobs=1, listing=False)
    assert small == ["grid/good"]
    fluid.main(only="*", jobs=2, listing=False)
    assert small == ["grid/good", "grid/bad"]
    fluid.main(only="*", jobs=1, listing=False)
    assert small == ["grid/good", "grid/bad"], "nothing is left to run"
    with open(tmp_path / "results" / "results.csv", newline="") as file:
        rows = {row["case"]: row for row in csv.DictReader(file)}
    assert rows["grid/good"]["result"] == "ok" and float(rows["grid/good"]["cd_mean"]) > 0
    assert rows["grid/good"]["nx"] == "100" and float(rows["grid/good"]["flow_rate"]) > 0
    assert rows["grid/good"]["repeats"] == "5"
    for clock in ("wall", "cpu"):
        q1, median, q3 = (float(rows["grid/good"][f"{clock}_{name}"]) for name in ("q1", "s", "q3"))
        assert 0 < q1 <= median <= q3, clock
    assert "c_eta" in rows["grid/bad"]["result"] and rows["grid/bad"]["cd_mean"] == ""
    made = {path.name for path in (tmp_path / "docs").iterdir()}
    assert {"results.csv", "thesis_3_3.md", "thesis_3_4.md", "grid.md", "grid_2d2.png", "work_2d2.png"} <= made

    monkeypatch.setattr(fluid.package, "library", lambda _kind: tmp_path / "docs" / "grid.md")
    assert all(fluid.known()[case.name]["key"] != case.key for case in fluid.cases()), "another library, other results"
