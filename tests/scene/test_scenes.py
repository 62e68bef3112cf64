"""Every shipped scene, and the references that go with them."""

import json

import jsonschema
import numpy as np
import pytest
import scene_types

from nervure.errors import SceneError
from nervure.evaluate import coefficients
from nervure.resources import ROOT
from nervure.scene import document, load, read, text, types
from nervure.scene.facts import Facts
from nervure.simulation.summary import quantities
from nervure.units import package
from nervure.units.describe import describe, unit_names
from tests.conftest import SCENES

every_scene = pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)


@every_scene
def test_scene_follows_the_committed_schema(path):
    schema = json.loads((ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(schema).validate(read(path))


@every_scene
def test_scene_is_named_like_its_file(path):
    assert load(path).name == path.stem


@every_scene
def test_scene_packs(path, tmp_path, libraries):
    scene = load(path)
    for kind in unit_names(scene):
        assert package.pack(describe(kind, scene), tmp_path).is_file()


@every_scene
def test_scene_is_written_as_it_was_read(path):
    """Its values stay as they are, and no default is added."""
    assert document(load(path)) == read(path)
    assert json.loads(text(load(path))) == read(path)


@every_scene
def test_reference_is_about_quantities_that_are_evaluated(path):
    reference = load(path).reference
    if reference is not None:
        assert reference.quantities.keys() <= set(quantities(Facts(load(path))))
        assert (coefficients.published(reference) or reference.quantities) and reference.source


def test_published_value_lies_inside_the_published_spread():
    published = load("fsi3-325x72").reference
    for name, spread in published.spread.quantities.items():
        for what in ("mean", "amplitude", "frequency_hz"):
            if (bounds := getattr(spread, what)) is not None:
                assert bounds[0] <= getattr(published.quantities[name], what) <= bounds[1], (name, what)


def test_classes_of_a_scene_are_those_of_the_schema():
    schema = json.loads((ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8"))
    written = (ROOT / "python" / "nervure" / "scene" / "types.py").read_text(encoding="utf-8")
    assert written == scene_types.generate(schema), "make writes them anew"


def test_defaults_are_those_of_the_schema():
    fluid = load("fsi3-325x72").fluid
    assert (fluid.threads, fluid.initial_velocity, fluid.probes, fluid.sponge) == (1, (0.0, 0.0), [], None)
    assert types.RootLaws().x == types.TimeLawConstant(constant=0.0)
    assert types.Guards().window_steps == 500


def test_a_default_that_is_changed_is_written():
    """Also where a list or a part is changed in its place, which pydantic itself does not notice."""
    scene = load("vein-pitching-320x240")
    scene.fluid.probes.append(types.Probe(name="wake", position=(1.0, 0.0)))
    scene.rod.root_motion.laws.y.constant = 0.5
    written = document(scene)
    assert written["fluid"]["probes"] == [{"name": "wake", "position": [1.0, 0.0]}]
    assert written["rod"]["root_motion"]["laws"]["y"] == {"constant": 0.5}


@pytest.mark.parametrize("value", [8, np.int64(8), np.float64(8), np.float32(8)])
def test_numbers_of_numpy_are_numbers(value):
    scene = load("csm3")
    scene.time.end = value
    assert json.loads(text(scene))["time"]["end"] == 8


@pytest.mark.parametrize(
    ("assignment", "named"),
    [
        ("fluid.colour=1", ["colour"]),
        ("fluid.density=heavy", ["fluid.density", "heavy"]),
        ("beam.segments=8.5", ["beam.segments", "8.5"]),
        ("beam.segments=true", ["beam.segments"]),
        ('beam.segments="8"', ["beam.segments"]),
        ("fluid.time_stepping.scheme=euler", ["fluid.time_stepping.scheme", "euler", "sbdf2"]),
        ("fluid.box=3", ["fluid.box"]),
        ("time=null", ["time"]),
    ],
)
def test_a_scene_that_does_not_fit_the_types_is_refused_in_the_units_words(assignment, named, libraries):
    with pytest.raises(SceneError) as refused:
        load("fsi3-325x72", [assignment])
    assert all(part in str(refused.value) for part in named), refused.value
    assert "pydantic" not in str(refused.value)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda scene: setattr(scene.fluid, "densty", 1.0), "densty"),
        (lambda scene: setattr(scene.fluid, "density", "heavy"), "must be a number"),
        (lambda scene: setattr(scene.beam, "segments", 8.5), "must be a whole number"),
        (lambda scene: setattr(scene.fluid, "filter", "sharp"), "'smooth', 'two_thirds' or 'none'"),
    ],
)
def test_an_attribute_that_cannot_be_is_refused_at_once(change, named):
    with pytest.raises(ValueError, match=named):
        change(load("fsi3-325x72"))
