"""The committed results: documents show them, README shows no stale one, and some come out again."""

import json
import subprocess
from dataclasses import replace

import pytest

from nervure.resources import ROOT, SCENES
from studies import catalogue, engine, rod, scenes, show, simulate, speed
from tests.simulation.record import RECORDED

SMALLEST = (
    "report/rod-static/rod/n = 32",
    "report/rod-static/rod with shear/n = 8",
    "report/csm3/BDF2/n = 32, H = 0.008 s",
    "fluid/grid/2D-1-curvature-300",
)
"""Cases that are measured again, in seconds each. test_fsi3.py runs FSI3."""


@pytest.fixture(scope="module")
def data():
    return catalogue.load()


def test_documents_show_what_the_results_have(data):
    changed = catalogue.render(data, check=True)
    assert not changed, f"{changed}: `make studies` writes them anew"


def test_the_full_report_has_every_study_without_a_command_of_its_own():
    listed = subprocess.run(
        ["make", "-pn", "report-full"], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout
    names = next(line for line in listed.splitlines() if line.startswith("STUDIES := ")).split()[2:]
    assert sorted(names) == sorted({study.name for study in catalogue.STUDIES} - {"lab", "reliability"})


def test_no_row_that_readme_shows_is_stale(data):
    shown = catalogue.shown(ROOT / "README.md")
    assert shown, "README shows no measured row"
    stale = sorted(name for name in shown if name not in data.records or data.records[name].stale)
    assert not stale, f"{stale}: `make shown-rows` runs them"


def test_every_scene_with_a_reference_is_compared_as_shipped(data):
    cases = [case for _, case in data.cases.values() if case.scene and case.about.keys() & {"published", "expected"}]
    run = {scenes.same(case.built()) for case in cases if case.about.get("published") or case.about.get("expected")}
    shipped = {path.stem: simulate.shipped(path.stem) for path in SCENES.glob("*.json")}
    compared = {name: scenes.same(scene) for name, scene in shipped.items() if scene.get("reference")}
    assert len(compared) > 20 and [name for name, scene in compared.items() if scene not in run] == []


def test_the_table_has_each_compared_run_once_and_the_largest_error_first(data):
    (study,) = (study for study in catalogue.STUDIES if study.name == "scenes")
    runs = "<br>".join(row["runs"] for row in study.tables["right"](data)).split("<br>")
    assert len(runs) == sum(len(records) for _, records in scenes.parts(data)) > 50
    worst = [abs(float(line.split()[-2])) for line in study.tables["worst"](data)]
    fair = [records[-1] for part, records in scenes.parts(data) if part["case"] != "FSI3, settings of the thesis"]
    errors = [100 * abs(error) for record in fair for error in record.errors().values()]
    assert worst == pytest.approx(sorted(errors, reverse=True)[: scenes.WORST], abs=0.06)


def test_nothing_is_faster_than_the_machine(data):
    """Bytes and operations are counted by hand: too high a count shows here."""
    for row in (row for row in speed.rooflines(data) + rod.rooflines(data) if "of peak" in row):
        assert row["of bandwidth"] < 1 and row["of peak"] < 1, row


def test_every_table_is_shown_in_a_document_or_on_the_site(data):
    shown = {key for path in show.documents() for key, _ in show.TABLE.findall(path.read_text(encoding="utf-8"))}
    assert set(show.SPECS) <= shown | {key for study in catalogue.STUDIES for key in study.tables}


def test_the_pages_of_the_site_have_every_result(data):
    pages = catalogue.table_pages(data)
    for record in data.records.values():
        page = pages[record.name.split("/")[0]]
        assert f"\n| {record['label']} | " in page, record.name


@pytest.mark.parametrize("name", SMALLEST)
def test_a_committed_value_comes_out_again(libraries, data, name, tmp_path):
    record = data[name]
    study, case = data.cases[name]
    engine.execute(replace(case, options=case.options | {"repeats": 0}), tmp_path)
    run = engine.Run(tmp_path, **json.loads((tmp_path / "run.json").read_text()))
    found = study.extract(case, run)["values"]
    for quantity in record.published:
        if record.get(quantity) is not None:
            assert found[quantity] == pytest.approx(record[quantity], rel=1e-4), quantity


def test_fsi3_of_the_report_is_the_one_that_is_recorded(data):
    settled = json.loads(RECORDED.read_text())["settled"]
    record = data["fsi3/grid/325x72"]
    for name, expected in settled.items():
        for what in ("mean", "amplitude", "frequency_hz"):
            found = record[f"{name}.{what}"]
            assert found == pytest.approx(expected[what], abs=0.02 * expected["amplitude"], rel=0.01), f"{name}.{what}"
