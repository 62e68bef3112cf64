"""What the tool says of input that it cannot use: every message helps, and the JSON Schema says the same beforehand."""

import copy
import json
import re

import jsonschema
import pytest

from nervure import library
from nervure.errors import SceneError
from nervure.resources import ROOT
from nervure.scene import load, read, text, validate
from tests import bad_input
from tests.conftest import SCENES

pytestmark = pytest.mark.usefixtures("libraries")

INNER_WORDS = re.compile(r"\b(f64|usize|u32|struct|enum|variant|newtype|unit|pydantic|NoneType|Traceback|panicked)\b")
FORM = re.compile(r"scene key `[^`]+` is .+, but .+")


@pytest.fixture(scope="module")
def messages(libraries):
    return bad_input.tables()


@pytest.fixture(scope="module")
def schema():
    text = (ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8")
    return jsonschema.Draft202012Validator(json.loads(text))


def test_page_of_messages_is_what_the_tool_says(messages):
    committed = (ROOT / "docs" / "messages.md").read_text(encoding="utf-8")
    assert committed == bad_input.page(messages), "`make messages` writes it anew"


def test_every_bad_input_is_refused_in_words_of_people(messages):
    assert sum(map(len, messages.values())) >= 120
    for heading, rows in messages.items():
        for given, status, said in rows:
            assert status == 2 and said, f"{given}: exit status {status}, {said}"
            assert not INNER_WORDS.search(said), f"{given}: {said}"
            if heading in ("Types and ranges", "Keys that do not go together"):
                assert FORM.search(said), f"{given}: {said}"


@pytest.mark.parametrize(("cases", "seen"), [(bad_input.TYPES, True), (bad_input.RELATIONS, False)])
def test_schema_and_units_refuse_the_same(cases, seen, schema):
    """And both units in the same words. What relates several keys only they see."""
    for base, assignment in cases:
        scene = bad_input.scene(base, assignment)
        said = set()
        for kind in library.KINDS:
            with pytest.raises(SceneError) as refused:
                library.describe(kind, text(scene))
            said.add(str(refused.value))
        assert len(said) == 1, said
        # A whole number may be written 8.0 in JSON Schema.
        expected = seen and assignment != "fluid.box.cells=[325.0, 72]"
        assert schema.is_valid(json.loads(text(scene))) != expected, assignment


def numbers(document, place=()):
    """The path of every number of a scene."""
    parts = document.items() if isinstance(document, dict) else enumerate(document)
    for key, part in parts:
        if isinstance(part, dict | list):
            yield from numbers(part, (*place, key))
        elif isinstance(part, int | float):
            yield (*place, key)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
@pytest.mark.parametrize("value", [-1, 0, 1e9])
def test_units_refuse_every_number_that_the_schema_refuses(path, value, schema):
    """And name it; each number of each shipped scene in turn."""
    scene = read(path)
    for place in numbers(scene):
        changed = copy.deepcopy(scene)
        part = changed
        for key in place[:-1]:
            part = part[key]
        part[place[-1]] = value
        if not schema.is_valid(changed):
            key = re.sub(r"\.(\d+)", r"[\1]", ".".join(map(str, place)))
            with pytest.raises(SceneError, match=re.escape(f"`{key}` is ")):
                library.check(text(changed))


def test_a_message_has_the_place_in_the_file_unless_the_key_was_overridden(tmp_path):
    path = tmp_path / "own.json"
    path.write_text(text(read("csm1")).replace('"length": 0.35', '"length": -0.35'), encoding="utf-8")
    line = next(i for i, line in enumerate(path.read_text().splitlines(), 1) if "length" in line)
    with pytest.raises(SceneError, match=rf"`beam.length` is -0.35, .*own\.json, line {line} column 5\)"):
        load(path)
    with pytest.raises(SceneError, match="`beam.length` is -2, ") as refused:
        load(path, ["beam.length=-2"])
    assert "line" not in str(refused.value)
    load(path, ["beam.length=2"])


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_number_that_json_lacks_is_refused_under_its_key(value):
    scene = load("csm1")
    scene.beam.length = value
    with pytest.raises(SceneError, match=rf"`beam.length` is \"{value}\", but it must be a number above 0"):
        library.check(text(scene))


def test_a_file_with_a_byte_order_mark_is_read(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text(text(read("csm1")), encoding="utf-8-sig")
    assert load(path) == validate(read("csm1"))
