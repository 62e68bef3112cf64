"""Every shipped scene, and the references that go with them."""

import json

import jsonschema
import pytest
from conftest import SCENES
from nervure.evaluate import coefficients
from nervure.pack import package
from nervure.report import QUANTITIES
from nervure.resources import ROOT
from nervure.scene import REFERENCES, load, reference

every_scene = pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)


@every_scene
def test_scene_follows_the_committed_schema(path):
    schema = json.loads((ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(schema).validate(load(path))


@every_scene
def test_scene_is_named_like_its_file(path):
    assert load(path)["name"] == path.stem


@every_scene
def test_scene_packs(path, tmp_path, libraries):
    scene = load(path)
    for kind in package.kinds(scene):
        assert package.pack(kind, scene, tmp_path).is_file()


def test_a_scene_finds_the_reference_of_its_family():
    assert reference("fsi3-650x144") == reference("fsi3")
    assert reference("fsi30") is None


def test_references_are_about_quantities_that_are_evaluated():
    for name, family in json.loads(REFERENCES.read_text(encoding="utf-8")).items():
        for part in family.values():
            assert part["source"], name
            assert set(part.get("quantities", {})) <= set(QUANTITIES), name
            assert set(part.get("coefficients", {})) <= set(coefficients.NAMES), name


def test_primary_reference_lies_inside_the_published_spread():
    published = reference("fsi3")
    for name, spread in published["spread"]["quantities"].items():
        for what, (low, high) in spread.items():
            assert low <= published["primary"]["quantities"][name][what] <= high, (name, what)
