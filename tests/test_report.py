"""The committed report: documents show what results.json has, and a few of its values come out again."""

import dataclasses
import json
import subprocess
import sys

import pytest
from report import cases, convergence, documents, measure, render, store, topics

from nervure.files import rounded
from nervure.resources import ROOT

SMALLEST = (
    "rod-static/rod/n = 32",
    "rod-static/rod with shear/n = 8",
    "csm3/BDF2/n = 32, H = 0.008 s",
    "cylinder-2d1/wall target/300 x 60",
)
"""Cases that are measured anew: seconds each. test_fsi3.py runs FSI3."""


@pytest.fixture(scope="module")
def data():
    return store.load()


def test_documents_show_what_the_results_have(data):
    changed = render.everything(data, check=True)
    assert not changed, f"{changed}: `python scripts/report render` writes them anew"


def test_every_number_of_the_documents_is_marked():
    for path in documents.DOCUMENTS:
        assert documents.unmarked(path.read_text(encoding="utf-8")) == [], path


def test_a_number_without_a_mark_is_seen():
    assert documents.unmarked("within 2.2 % <!--n:a-->3.1<!----> of `1.5`, Python 3.11") == ["2.2 %"]


@pytest.mark.parametrize("text", ["2.2 %", "-1.5e-3", "4 mm", "1e-4", "12 times", "3.5"])
def test_every_kind_of_number_is_seen(text):
    assert documents.unmarked(f"of {text} in it") == [text]


def test_values_and_table_of_rows_agree_with_the_rows(data):
    """results.csv and `values` are made of the same rows as results.json."""
    values = {key: dataclasses.asdict(value) for key, value in topics.values(data["rows"]).items()}
    assert rounded(values) == data["values"]
    with open(store.DOCS / "results.csv", encoding="utf-8") as file:
        assert sum(1 for _ in file) == len(data["rows"]) + 1


def test_every_value_and_table_is_shown(data):
    numbers, tables = documents.used()
    assert set(data["values"]) == numbers and set(topics.tables(data["rows"])) == tables


@pytest.mark.parametrize("name", SMALLEST)
def test_a_committed_value_comes_out_again(libraries, data, name):
    case = next(case for case in cases.cases() if case.name == name)
    committed = {
        row.quantity: row
        for row in data["rows"]
        if (row.case, row.method, row.setting) == (case.case, case.method, case.setting)
    }
    command = [sys.executable, str(ROOT / "scripts" / "report" / "worker.py"), "0"]
    done = subprocess.run(command, input=json.dumps(case.scene()), capture_output=True, text=True, check=True)
    found = measure.values_of(case, json.loads(done.stdout))
    assert committed, f"{name} is not in results.json"
    for quantity, row in committed.items():
        assert found[quantity] == pytest.approx(row.value, rel=row.tolerance), quantity


def test_fsi3_of_the_report_is_the_one_that_is_recorded(data):
    settled = json.loads((ROOT / "tests" / "recorded.json").read_text())["settled"]
    rows = [
        row
        for row in data["rows"]
        if row.case == "fsi3" and row.setting == "325 x 72" and row.method == "momentum load"
    ]
    assert {row.quantity for row in rows} == set(cases.QUANTITIES["fsi3"])
    for row in rows:
        name, what = row.quantity.split(".")
        if what == "fit":
            continue
        assert row.value == pytest.approx(
            settled[name][what], abs=row.tolerance * settled[name]["amplitude"], rel=0.01
        ), row.quantity


def test_extrapolation_finds_a_limit_and_its_order():
    sizes = [10, 20, 40, 80]
    found = convergence.limit(sizes, [3.0 + 5.0 / n**2 for n in sizes])
    assert (found.order, found.value) == (pytest.approx(2.0, abs=1e-6), pytest.approx(3.0, rel=1e-9))


def test_extrapolation_refuses_what_is_not_asymptotic():
    assert "change sign" in convergence.limit([10, 20, 40], [1.0, 1.2, 1.1]).verdict
    assert "not settled" in convergence.limit([10, 20, 40, 80], [1.0, 1.3, 1.5, 1.55]).verdict


def test_the_front_keeps_what_nothing_beats():
    assert convergence.front([(1.0, 0.5), (2.0, 0.6), (3.0, 0.1), (0.5, 0.9)]) == [3, 0, 2]
