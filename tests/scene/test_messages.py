"""Messages about bad input: they help, they are data, and the JSON Schema refuses the same."""

import copy
import csv
import json
import re

import jsonschema
import pytest

from nervure import library
from nervure.errors import SceneError
from nervure.resources import ROOT
from nervure.scene import load, read, text, validate
from nervure.scene.files import MOST_BYTES
from tests.conftest import COUPLED, SCENES
from tests.scene import bad_input

pytestmark = pytest.mark.usefixtures("libraries")

INNER_WORDS = re.compile(r"\b(f64|usize|u32|struct|enum|variant|newtype|unit|pydantic|NoneType|Traceback|panicked)\b")


ONLY_UNITS = {
    *("fluid.box.cells=[325.0, 72]", "format=2.0"),  # whole numbers in JSON Schema
    *("time.end=NaN", "time.end=Infinity", "time.end=1e999"),  # no JSON
    "fluid.channel={}",  # each of its keys is optional, but one is needed
}


@pytest.fixture(scope="module")
def rows(libraries):
    return list(bad_input.rows())


@pytest.fixture(scope="module")
def schema():
    text = (ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8")
    return jsonschema.Draft202012Validator(json.loads(text))


def test_messages_are_the_recorded_ones(rows):
    with (ROOT / "tests" / "scene" / "messages.csv").open(encoding="utf-8", newline="") as file:
        recorded = [bad_input.Row(*row) for row in csv.reader(file)][1:]
    assert rows == recorded, "`make messages` records them"


def test_every_bad_input_is_refused_in_words_of_people(rows):
    assert len(rows) >= 180
    for row in rows:
        assert row.status == "2" and row.message, row
        assert not INNER_WORDS.search(row.message), row


def test_every_fault_of_a_scene_has_its_key_in_the_sentence_and_as_data():
    """The key that was set, a part of it, or what it belongs to; contradictions may blame another."""
    for base, assignment in [*bad_input.TYPES, *bad_input.RELATIONS]:
        with pytest.raises(SceneError) as refused:
            load(base, [assignment])
        changed = re.sub(r"\.(\d+)", r"[\1]", assignment.partition("=")[0])
        assert refused.value.faults, assignment
        for fault in refused.value.faults:
            assert f"`{fault.key}`" in fault.text, fault
            if fault.kind != "conflict":
                assert fault.line is None and fault.key.startswith(changed), (assignment, fault)


@pytest.mark.parametrize(("cases", "seen"), [(bad_input.TYPES, True), (bad_input.RELATIONS, False)])
def test_schema_and_units_refuse_the_same(cases, seen, schema):
    """Both units use the same words, and only they see contradictions."""
    for base, assignment in cases:
        scene = bad_input.scene(base, assignment)
        said = set()
        for kind in COUPLED:
            with pytest.raises(SceneError) as refused:
                library.describe(kind, text(scene))
            said.add(str(refused.value))
        assert len(said) == 1, said
        expected = seen and assignment not in ONLY_UNITS
        assert schema.is_valid(json.loads(text(scene))) != expected, assignment


def numbers(document, place=()):
    """The path of every number of a scene."""
    parts = document.items() if isinstance(document, dict) else enumerate(document)
    for key, part in parts:
        if isinstance(part, dict | list):
            yield from numbers(part, (*place, key))
        elif isinstance(part, int | float):
            yield (*place, key)


def new_numbers():
    """Yield the shipped scenes with the paths of those numbers whose keys are in no scene before."""
    seen: set[tuple[str, ...]] = set()
    for path in SCENES:
        places = {tuple(key for key in place if isinstance(key, str)): place for place in numbers(read(path))}
        if new := [place for keys, place in places.items() if keys not in seen]:
            yield pytest.param(path, new, id=path.stem)
        seen.update(places)


@pytest.mark.parametrize(("path", "places"), list(new_numbers()))
@pytest.mark.parametrize("value", [-1, 0, 1e9])
def test_units_refuse_every_number_that_the_schema_refuses(path, places, value, schema):
    """Each number under each key of the shipped scenes in turn; the units name the key."""
    scene = read(path)
    for place in places:
        changed = copy.deepcopy(scene)
        part = changed
        for key in place[:-1]:
            part = part[key]
        part[place[-1]] = value
        if not schema.is_valid(changed):
            key = re.sub(r"\.(\d+)", r"[\1]", ".".join(map(str, place)))
            assert [fault.key for fault in library.check(text(changed))] == [key]


def test_a_fault_has_its_place_in_the_file_unless_the_value_was_overridden(tmp_path):
    path = tmp_path / "own.json"
    path.write_text(text(read("csm1")).replace('"length": 0.35', '"length": -0.35'), encoding="utf-8")
    line = next(i for i, line in enumerate(path.read_text().splitlines(), 1) if "length" in line)
    with pytest.raises(SceneError) as refused:
        load(path)
    assert [(fault.key, fault.line, fault.column) for fault in refused.value.faults] == [("beam.length", line, 5)]
    assert str(refused.value).startswith(f"{path}, line {line}, column 5: `beam.length` is out of range")
    with pytest.raises(SceneError, match=re.escape("`beam.length` is out of range: -2 is not > 0 (from --set)")):
        load(path, ["beam.length=-2"])
    with pytest.raises(SceneError, match=rf"line {line}, column 5: `beam.length` is out of range"):
        load(path, ["beam.segments=8"])
    with pytest.raises(SceneError, match=r"`time.end` is out of range: -1 is not > 0 \(from --end-time\)"):
        load("csm1", end_time=-1)
    load(path, ["beam.length=2"])


@pytest.mark.parametrize(("value", "shown"), [(float("nan"), "NaN"), (float("inf"), "Infinity")])
def test_a_number_that_json_lacks_is_refused_under_its_key(value, shown):
    scene = load("csm1")
    scene.beam.length = value
    (fault,) = library.check(text(scene))
    assert (fault.key, fault.value, fault.allowed) == ("beam.length", shown, "a number > 0")


def test_a_file_with_a_byte_order_mark_is_read(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(text(read("csm1")), encoding="utf-8-sig")
    assert load(path) == validate(read("csm1"))


def test_the_largest_file_is_the_same_for_python_and_the_units(tmp_path):
    head, tail = '{"name": "', '"}'
    path = tmp_path / "long.json"
    path.write_text(head + "x" * (MOST_BYTES - len(head) - len(tail)) + tail)
    assert {fault.kind for fault in library.check(path.read_text())} == {"missing"}
    assert [fault.kind for fault in library.check(path.read_text() + " ")] == ["syntax"]
    path.write_text(path.read_text() + " ")
    with pytest.raises(SceneError, match="is larger than 4 MB"):
        load(path)
