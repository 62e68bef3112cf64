"""Scenes that cannot be meant are refused, and what may be a mistake is said, by name, place and time.

`geometry.json` has the cases: each is the scene that a JSON merge patch (RFC 7386) makes from a base.
"""

import copy
import json
import re
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import pytest

from nervure.evaluate import benchmark
from nervure.library import check, facts, monitor
from nervure.resources import ROOT
from nervure.scene import assign, read, text, validate
from nervure.scene.facts import Facts
from nervure.simulation.session import Session
from tests.conftest import SCENES

DATA = json.loads(Path(__file__).with_name("geometry.json").read_text())


def merged(base: Any, patch: Any) -> Any:
    """Return `base` after a merge patch."""
    if not isinstance(patch, dict):
        return patch
    changed = dict(base) if isinstance(base, dict) else {}
    for key, value in patch.items():
        if value is None:
            changed.pop(key, None)
        else:
            changed[key] = merged(changed.get(key), value)
    return changed


def scene_of(base: str, **patch: Any) -> dict[str, Any]:
    """Return the scene that a patch makes from a base."""
    scene: dict[str, Any] = merged(copy.deepcopy(DATA["bases"][base]), patch)
    return scene


def cases(name: str) -> Any:
    """Return the decorator that runs a test with each case of a list, as `case` with its `scene`."""
    each = [case | {"scene": scene_of(case["base"], **case["patch"])} for case in DATA[name]]
    return pytest.mark.parametrize("case", each, ids=[case["case"] for case in each])


@cases("refused")
def test_what_cannot_be_meant_is_refused_by_key(case, libraries):
    faults = check(json.dumps(case["scene"]))
    assert [fault.key for fault in faults] == [case["key"]], faults
    assert case["words"] in faults[0].text and faults[0].allowed


@cases("meant")
def test_what_may_be_meant_is_not_refused(case, libraries):
    assert check(json.dumps(case["scene"])) == []


def test_motions_of_many_bodies_are_checked_in_seconds_and_what_meets_is_found(libraries):
    """At least 100 times of the run and of its beginning; before, 150 bodies took a minute."""
    scene = scene_of("still", time={"end": 10.0})
    body = {"shape": {"circle": {"radius": 0.1}}, "motion": {"y": {"sine": {"amplitude": 0.25, "frequency": 1.0}}}}
    scene["fluid"]["bodies"] = [body | {"position": [0.5 + k % 15, 0.5 + k // 15]} for k in range(150)]
    scene["fluid"]["box"] = {"x": [0, 16], "y": [0, 11], "cells": [320, 220]}
    scene["fluid"]["bodies"][77]["motion"] = {"y": {"sine": {"amplitude": 0.9, "frequency": 1.0, "phase": 3.14}}}
    start = perf_counter()
    found = [warning["text"] for warning in facts(json.dumps(scene))["warnings"]]
    seconds = perf_counter() - start
    assert any("`fluid.bodies[77]`" in text and "meets" in text for text in found), found
    assert seconds < 20, seconds


@pytest.mark.parametrize(("contact", "counts"), [({}, [0, 0, 0, 0, 0]), (None, [0, 0, 1, 0, 0])])
def test_two_wings_that_come_within_a_cell_of_each_other_without_contact_are_said_once(contact, counts, libraries):
    scene = read(ROOT / "examples" / "wings-clap.json") | {"contact": contact}
    mesh = Facts(validate(scene)).wing
    left = mesh.nodes[: len(mesh.nodes) // 2]
    cell = 9.6e-3 / 36
    watch, memory, said = monitor(json.dumps(scene)), None, []
    for step, gap in enumerate([1.5, 1.1, 0.9, 0.8, 0.7]):
        near = left + np.array([0.0, 0.0, gap * cell])
        answer = watch(
            {"time": step * 1e-5, "bodies": [], "beams": [], "wings": [left.tolist(), near.tolist()], "memory": memory}
        )
        memory = answer["memory"]
        said.append(answer["warnings"])
    assert [len(found) for found in said] == counts, said
    expected = (
        "the wing right comes within a cell of the wing left near .*, where their kernels overlap, at t = 0.00002 s"
    )
    assert all(re.match(expected, text) for text in said[2])


def test_advice_for_the_cfl_number_does_not_lead_back(libraries):
    """With `max_cfl` at its largest value no step is allowed: only a shorter communication step helps."""
    scene = scene_of("channel", fluid={"inflow": {"mean_velocity": {"constant": 1e6}}})
    for max_cfl in (1e-9, 0.4):
        scene["fluid"]["time_stepping"]["max_cfl"] = max_cfl
        (fault,) = check(json.dumps(scene))
        assert fault.key == "time.communication_step", fault
    scene["time"]["communication_step"] = float(fault.text.rsplit(" ", 1)[1])
    assert check(json.dumps(scene)) == []


def test_a_zone_or_channel_in_space_has_a_cell(libraries):
    walls = {"y": [-1.2, 1.2], "z": [0.0, 0.01]}
    for key, fluid in (
        ("sponge.x", {"sponge": {"x": [3.99, 4.0]}}),
        ("sponge.x", {"sponge": {"x": [-2.0, 4.0]}}),
        ("channel.z", {"channel": walls}),
    ):
        (fault,) = check(json.dumps(scene_of("space", fluid=fluid)))
        assert fault.key == f"fluid.{key}", fault


def in_time(time: float | None, expected: list[float] | None) -> bool:
    """Return whether a time lies in an interval, or both are absent."""
    return time is None if expected is None else time is not None and expected[0] <= time <= expected[1]


@cases("warned")
def test_what_may_be_a_mistake_is_said_with_its_time(case, libraries):
    found = facts(json.dumps(case["scene"]))["warnings"]
    (warning,) = [warning for warning in found if case["words"] in warning["text"]] or found
    assert case["words"] in warning["text"] and in_time(warning["time"], case["time"]), found


@cases("warned_alone")
def test_what_may_be_a_mistake_is_all_that_is_said(case, libraries):
    """But for the layers of motions, which these coarse grids do not resolve."""
    found = facts(json.dumps(case["scene"]))["warnings"]
    (warning,) = [warning for warning in found if "layer" not in warning["text"]]
    assert case["words"] in warning["text"] and in_time(warning["time"], case["time"]), warning


@cases("sound")
def test_a_sound_scene_is_not_warned_of(case, libraries):
    assert facts(json.dumps(case["scene"]))["warnings"] == []


@pytest.mark.parametrize("name", [path.stem for path in SCENES])
def test_no_shipped_scene_is_warned_of(name, libraries):
    assert facts(text(read(name)))["warnings"] == []


def test_a_disturbance_starts_the_lift_of_a_symmetric_flow(libraries):
    """A hundredth of the stream; without the key the lift is rounding."""

    def lift(disturbance: float | None = None) -> float:
        fluid = {
            "bodies": [{"shape": {"circle": {"radius": 0.5}}, "position": [0.0, 0.0]}],
            "box": {"x": [-2.0, 4.0], "y": [-2.0, 2.0], "cells": [48, 32]},
            "sponge": {"x": [3.0, 4.0]},
            "disturbance": disturbance,
        }
        scene = scene_of("stream", fluid=fluid, time={"end": 0.6})
        with Session(validate(scene)) as session:
            assert session.run().error is None
            return float(np.abs(session.recorder.series["lift"][-20:]).max())

    still, disturbed, twice = lift(), lift(0.01), lift(0.02)
    assert still < 1e-12 < 1e-3 < disturbed, (still, disturbed, twice)
    assert twice == pytest.approx(2 * disturbed, rel=0.01)


@pytest.mark.parametrize(
    "name, key, value, said",
    [
        ("fsi3-650x144", "fluid.kinematic_viscosity", 2e-3, ["fluid.kinematic_viscosity"]),
        ("csm3", "rod.gravity", [0.0, -3.0], ["rod.gravity[1]"]),
        ("cylinder-2d2-800x144", "fluid.cylinders.0.radius", 0.06, ["fluid.cylinders[0].radius"]),
        ("fsi3-325x72", "fluid.inflow.mean_velocity", {"constant": 2.5}, ["fluid.inflow.mean_velocity.constant"]),
        ("fsi3-325x72", "fluid.inflow.mean_velocity", {"constant": 2.0}, []),
        ("fsi3-325x72", "fluid.box.cells", [650, 144], []),
        ("fsi3-325x72", "rod.damping", 0.0, []),
    ],
)
def test_a_changed_benchmark_is_known_by_its_key(name, key, value, said):
    document = read(name)
    assign(document, key, value)
    assert benchmark.changed(validate(document)) == said


def test_a_rod_that_stretches_is_told_of_during_the_run(libraries):
    soft = {"line_density": 1.0, "bending_stiffness": 0.01, "axial_stiffness": 0.5}
    root = {"at": {"position": [0.0, 0.0], "direction": [1.0, 0.0]}}
    scene = {
        "name": "stretchy",
        "time": {"end": 1.0, "communication_step": 0.01},
        "beam": {"root": root, "length": 1.0, "thickness": 0.1, "segments": 20},
        "rod": {"material": {"section": soft}, "damping": 2.0, "gravity": [9.81, 0.0]},
    }
    with Session(validate(scene)) as session:
        session.run()
    assert len(session.warnings) == 1 and "times as long as at rest" in session.warnings[0], session.warnings


def warnings_of(scene: dict[str, Any]) -> list[str]:
    """Return the warnings of a run about places; the master lets bodies fall with 1 m/s."""
    bodies = scene.get("fluid", {}).get("bodies", ())
    names = [f"body[{k}].motion.y" for k, body in enumerate(bodies, 1) if body.get("motion") == "master"]
    drive = (lambda t, _: dict.fromkeys(names, -t)) if names else None
    with Session(validate(scene), drive=drive) as session:
        assert session.run().error is None
        return [text for text in session.warnings if not text.startswith("short waves")]


@pytest.mark.usefixtures("libraries")
@cases("met")
def test_what_meets_during_a_run_is_told_of_with_place_and_time(case, libraries):
    (found,) = warnings_of(case["scene"])
    assert case["words"] in found, found
    assert in_time(float(found.rsplit(" ", 2)[1]), case["time"]), found


@cases("untold")
def test_what_touched_at_the_start_is_not_told_of(case, libraries):
    assert warnings_of(case["scene"]) == []
