"""A free body that carries wings and rods at driven hinges, without a fluid and with one."""

import copy
import json
import math
import runpy
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nervure
from nervure.coupling import CouplingError
from nervure.coupling.flight import Carried
from nervure.errors import InputError, SceneError, UnitFailure
from nervure.library import monitor
from nervure.output import animation
from nervure.resources import ROOT
from nervure.scene import validate
from nervure.scene.facts import Facts
from nervure.simulation.session import Session
from nervure.units.describe import describe

EXAMPLES = ROOT / "examples"

pytestmark = pytest.mark.usefixtures("libraries")

STROKE = {"sine": {"amplitude": 0.8, "frequency": 1.0, "ramp": 0.5}}
WING = {
    "mesh": {"rectangular": {"length": 0.2, "width": 0.1, "along": 3}},
    "membrane": {"areal_density": 50.0, "stretching_stiffness": 2500.0, "bending_stiffness": 0.09},
    "root": "root",
    "scheme": "bdf2",
    "relaxation_time": 1e-4,
}


def pair(mass: float = 1.0) -> dict:
    """A body with two wings on both sides, each of 1 kg; the right one is turned about y."""
    turn = {"axis": [0.0, 1.0, 0.0], "angle": math.pi}
    return {
        "name": "pair",
        "time": {"end": 0.25, "communication_step": 5e-3},
        "wings": [{"name": name, "wing": copy.deepcopy(WING)} for name in ("left", "right")],
        "flyer": {
            "mass": mass,
            "inertia": [0.01 * mass, 0.014 * mass, 0.019 * mass],
            "hinges": [
                {"carries": "left", "position": [0.05, 0.0, 0.0], "motion": {"stroke": STROKE}},
                {"carries": "right", "position": [-0.05, 0.0, 0.0], "turn": turn, "motion": {"stroke": STROKE}},
            ],
        },
    }


def outputs(session: Session, unit: str = "body") -> dict[str, float]:
    """Return the scalar outputs of a unit."""
    own = session.units[unit]
    return {name: own.outputs[own.slices[name]].item() for name in own.scalars("Real")}


def run(scene: dict, folder: Path, steps: int | None = None, **options) -> Session:
    """Return a session after some steps, or all."""
    session = Session(nervure.Scene.model_validate(scene), folder, **options)
    session.start()
    for _ in range(steps or session.grid.steps):
        session.step()
    return session


def test_two_wings_that_beat_alike_move_their_body_back_and_neither_aside_nor_round(tmp_path):
    with run(pair(), tmp_path) as session:
        found = outputs(session)
        nodes = session.units["left"].read("y")
    aside = [abs(found[name]) for name in ("x", "z", "angle_x", "angle_y", "angle_z")]
    assert found["y"] < -0.01 and nodes.max() > 0.01
    assert max(aside) < 1e-9 * abs(found["y"]), f"{found['y']} m back, {max(aside)} aside or round"


@pytest.mark.parametrize("mass", [1e-3, 1e-2, 1.0, 1e2])
def test_a_body_flies_at_every_ratio_of_masses(mass, tmp_path):
    """A light body follows the wings that beat, a heavy one stays."""
    with run(pair(mass), tmp_path) as session:
        back = outputs(session)["y"]
    # The centre of mass of all rests; that of the wings leaves the hinges by up to half their length.
    assert -0.1 < back * (mass + 2.0) / 2.0 < 0.0, f"{mass} kg: {back} m"
    assert (back < -0.03) == (mass < 0.1), f"{mass} kg: {back} m"


def test_a_rod_and_a_wing_hang_at_one_body_that_falls(tmp_path):
    """All fall alike: nothing bends."""
    scene, down = pair(), [0.0, 0.0, -9.81]
    del scene["wings"]
    scene["wing"] = WING | {"gravity": down}
    scene["beam"] = {
        "root": {"at": {"position": [0.0, 0.1, 0.0], "direction": [0.0, 1.0, 0.0]}},
        "length": 0.3,
        "thickness": 0.01,
        "segments": 6,
    }
    section = {"line_density": 0.3, "bending_stiffness": 0.1, "axial_stiffness": 200.0}
    scene["rod"] = {"material": {"section": section}, "scheme": "bdf2", "gravity": down}
    hinges = [{"carries": "wing", "position": [0.05, 0.0, 0.0]}, {"carries": "rod", "position": [0.0, 0.1, 0.0]}]
    scene["flyer"] |= {"gravity": down, "hinges": hinges, "velocity": [0.5, 0.0, 0.0]}
    with run(scene, tmp_path) as session:
        body, rod = outputs(session), outputs(session, "rod")
    assert body["x"] == pytest.approx(0.125, abs=1e-5)
    # The first step of the differences is of first order.
    assert body["z"] == pytest.approx(-0.5 * 9.81 * 0.25**2, rel=0.05)
    assert rod["tip.uz"] == pytest.approx(body["z"], abs=1e-6)


def test_a_flyer_without_a_fluid_bounces_and_comes_to_rest_on_the_ground(tmp_path):
    """The wings weigh on the body, which carries them on the springs of the contact."""
    scene, down = pair(), [0.0, 0.0, -9.81]
    for own in scene["wings"]:
        own["wing"]["gravity"] = down
    ground = {"shape": {"cuboid": {"lengths": [2.0, 2.0, 0.2]}}, "position": [0.0, 0.0, -0.2], "pivot": [0.0] * 3}
    ball = {"shape": {"sphere": {"radius": 0.05}}, "position": [0.0] * 3, "pivot": [0.0] * 3}
    scene["flyer"] |= {"gravity": down, "solid": ball, "held": ["angle_x", "angle_y"]}
    scene["contact"] = {"range": 0.015, "damping": 100.0, "obstacles": [ground]}
    scene["time"]["end"] = 1.5
    for hinge in scene["flyer"]["hinges"]:
        del hinge["motion"]
    heights, speeds = [], []
    with Session(nervure.Scene.model_validate(scene), tmp_path) as session:
        session.start()
        for _ in range(300):
            session.step()
            found = outputs(session)
            heights.append(found["z"])
            speeds.append(found["vz"])
    # The surface of the ball meets the ground at z = -0.05 m, at z = -0.075 m to half its radius.
    assert min(heights) > -0.075 and min(speeds) < -0.6, f"down to {min(heights)} m, by {min(speeds)} m/s"
    assert max(speeds) > 0.05, "it does not bounce"
    # Its wings still swing.
    last = heights[-100:]
    assert min(last) > -0.06 and max(last) < -0.03, f"at last from {min(last)} m to {max(last)} m"


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"position": [0.0, 0.0, 1.0]}, "the flyer is at"),
        ({"motion": "master"}, "the flyer moves it"),
        ({"shape": {"ellipsoid": {"lengths": [0.1] * 3}}}, "what touches is a circle"),
    ],
)
def test_a_solid_that_a_flyer_cannot_have_is_refused(change, fault):
    scene = pair()
    ball = {"shape": {"sphere": {"radius": 0.05}}, "position": [0.0] * 3, "pivot": [0.0] * 3}
    scene["flyer"]["solid"] = ball | change
    scene["contact"] = {"range": 0.01}
    with pytest.raises(SceneError, match=fault):
        describe("body", scene)


def test_a_flight_goes_on_from_a_saved_state_with_the_same_bits(tmp_path):
    with run(pair(), tmp_path, 10) as session:
        for unit in session.units.values():
            unit.save()
        ends = []
        for _ in range(2):
            for unit in session.units.values():
                unit.restore()
                unit.get()
            session.steps = 10
            for unit in session.units.values():
                unit.fmu.currentTime = None
            for k in range(10, 15):
                session.scheme.step(k * 5e-3, 5e-3)
            ends.append(session.units["body"].outputs.copy())
    assert np.array_equal(*ends)


def test_the_master_moves_hinges(tmp_path):
    """A function gives the same flight as the law."""
    by_law = pair()
    for hinge in by_law["flyer"]["hinges"]:
        hinge["motion"] = {"stroke": {"cosine_ramp": {"value": 0.6, "duration": 0.5}}}
    driven = copy.deepcopy(by_law)
    for hinge in driven["flyer"]["hinges"]:
        hinge["motion"] = "master"

    def drive(t: float, _: Mapping[str, float]) -> dict[str, float]:
        angle, rate = 0.3 - 0.3 * math.cos(math.tau * t), 0.3 * math.tau * math.sin(math.tau * t)
        return {f"{name}.stroke": angle for name in ("left", "right")} | {
            f"{name}.stroke_rate": rate for name in ("left", "right")
        }

    with run(by_law, tmp_path, 20) as session:
        expected = outputs(session)["y"]
    with run(driven, tmp_path, 20, drive=drive) as session:
        assert outputs(session)["y"] == pytest.approx(expected, rel=1e-9)
    with pytest.raises(InputError, match=r"leaves .*left.stroke.* to the master \(flyer.hinges\[k\].motion\)"):
        run(driven, tmp_path)


def test_units_of_both_versions_of_fmi_describe_themselves():
    for unit in ("left", "body"):
        for version in (2, 3):
            xml = describe(unit, pair(), version).xml
            assert "left.root.reaction" in xml or "root.reaction" in xml


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"carries": "nobody"}, "the units of the scene are `left` and `right`"),
        ({"carries": "right"}, "another hinge carries it"),
    ],
)
def test_hinges_that_carry_nothing_of_their_own_are_refused(change, fault):
    scene = pair()
    scene["flyer"]["hinges"][0] |= change
    scene["flyer"]["hinges"].reverse()
    with pytest.raises(SceneError, match=fault):
        describe("body", scene)


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"scheme": "tr_bdf2"}, 'scheme` is "tr_bdf2", but .* must be bdf2'),
        ({"root": None}, "root"),
        ({"max_step": 1e-3}, "max_step"),
    ],
)
def test_a_wing_that_a_body_cannot_carry_is_refused(change, fault):
    scene = pair()
    scene["wings"][0]["wing"] |= change
    with pytest.raises(SceneError, match=fault):
        describe("body", scene)


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"inertia": [1.0, 0.0, 1.0]}, r"`flyer.inertia` is \[1.0, 0.0, 1.0\]"),
        ({"inertia": 1e200}, "`flyer.inertia` is 1e200, but .* product is from"),
        ({"products_of_inertia": [2.0, 0.0, 0.0]}, r"`flyer.products_of_inertia` is \[2.0, 0.0, 0.0\]"),
        ({"inertia": [1.0, 1.0, 2.00001]}, "`flyer.inertia` is .*, but each moment must be at most the sum of the"),
        ({"inertia": 2.0, "products_of_inertia": [0.0, 0.0, 1.01]}, "`flyer.products_of_inertia` .* each principal m"),
    ],
)
def test_a_body_with_an_impossible_inertia_is_refused_by_the_key_that_has_it(change, fault):
    scene = pair()
    scene["flyer"] |= {"inertia": [1.0, 1.0, 1.0]} | change
    with pytest.raises(SceneError, match=fault):
        describe("body", scene)


@pytest.mark.parametrize(("inertia", "products"), [([1.0, 1.0, 2.0], 0.0), (2.0, 1.0), ([1.0, 1e-12, 1.0], 0.0)])
def test_a_flat_body_is_allowed_also_one_that_lies_obliquely(inertia, products):
    """Principal moments of 1, 2 and 3, and those of a bar."""
    scene = pair()
    scene["flyer"] |= {"inertia": inertia, "products_of_inertia": [0.0, 0.0, products]}
    assert describe("body", scene).model == "pair.body"


def test_a_hinge_beyond_all_numbers_is_refused():
    scene = pair()
    scene["flyer"]["hinges"][0]["position"] = [0.0, 1e300, 0.0]
    with pytest.raises(SceneError, match=r"`flyer.hinges\[0\].position` is .* must be from -1e100 to 1e100 m"):
        describe("body", scene)


def test_a_wing_that_folds_on_its_body_is_named(tmp_path):
    scene = pair()
    for own in scene["wings"]:
        own["wing"]["membrane"] |= {"bending_stiffness": 1e-6}
    for hinge in scene["flyer"]["hinges"]:
        hinge["motion"] = {"stroke": {"sine": {"amplitude": 1.5, "frequency": 5.0}}}
    scene["time"] = {"end": 1.0, "communication_step": 1e-3}
    with Session(nervure.Scene.model_validate(scene), tmp_path) as session:
        found = session.run().error
    assert "the wing folds at nodes" in found and "stiffer bending helps" in found, found


def test_a_body_under_a_load_beyond_all_numbers_refuses_the_step(instantiate):
    scene = pair()
    unit = instantiate(scene)["body"]
    unit.connect(["left.root.reaction"], ["x"])
    unit.start()
    unit.inputs[:] = 1e300
    with pytest.raises(UnitFailure, match="energy of the body is no finite number"):
        unit.step(0.0, 5e-3)


def test_a_unit_that_announces_nothing_is_refused(tmp_path):
    with run(pair(), tmp_path, 1) as session:
        flight = session.scheme
        link = flight.links[0]
        del link.rod.variables["root.force_x"]
        with pytest.raises(CouplingError, match="which has no output `root.force_x`"):
            Carried("left", link, flight.body)


def box(cells: int = 20) -> dict:
    """A cube of fluid at rest that is held in the mean."""
    return {
        "density": 1.0,
        "kinematic_viscosity": 0.02,
        "box": {axis: [-1.0, 1.0] for axis in "xyz"} | {"cells": [cells] * 3},
        "mean_flow": {},
        "time_stepping": {"max_step": 0.01, "max_cfl": 0.4},
        "mask": {"log_linear": {"c_eta": 1e-3}},
    }


STREAM = {
    "mean_flow": {"x": {"constant": 1.0}},
    "initial_velocity": [1.0, 0.0, 0.0],
    "sponge": {"x": [0.3, 0.9], "mean_velocity": {"constant": 1.0}, "c_eta": 0.1},
}
WAY = [*"xyz", *(f"angle_{axis}" for axis in "xyz")]
FORCE = ["drag", "lift", "side"]
LIGHT_SPHERE: tuple[dict, dict, dict] = (
    {"shape": {"sphere": {"radius": 0.3}}},
    {"mass": 0.011, "inertia": 4e-4, "gravity": [0.3, 0.0, -1.0]},
    {},
)
TUMBLING_ELLIPSOID = (
    {"shape": {"ellipsoid": {"lengths": [0.6, 0.4, 0.8]}}, "pivot": [0.1, 0.05, 0.02]},
    {"mass": 0.2, "inertia": [0.01, 0.012, 0.008], "gravity": [0.3, -0.5, -1.0]},
    STREAM,
)


ON_TWO_GRIDS = {
    "box": {axis: [-1.6, 1.6] for axis in "xyz"} | {"cells": [24] * 3},
    "fine_box": {axis: [-1.333, 1.333] for axis in "xyz"} | {"ratio": 2, "follow": "body[1]"},
}
# It falls far enough for its box to move.
LIGHT_SPHERE_ON_TWO_GRIDS = (LIGHT_SPHERE[0], LIGHT_SPHERE[1] | {"gravity": [1.0, 0.0, -8.0]}, ON_TWO_GRIDS)
CEILING = {"shape": {"cuboid": {"lengths": [1.0, 1.0, 0.2]}}, "position": [0.0, 0.0, 0.415], "pivot": [0.0] * 3}


@pytest.mark.parametrize(("support", "solid", "count"), [("mount", True, 1), ("mount", False, 0), ("still", True, 0)])
def test_a_solid_of_a_flyer_that_no_fluid_knows_is_said_to_pass_through_a_free_body(support, solid, count):
    ball = {"shape": {"sphere": {"radius": 0.3}}, "pivot": [0.0] * 3}
    other = ball | {"position": [0.8, 0.0, 0.0]} | ({"mount": {"mass": 0.5, "x": {}}} if support == "mount" else {})
    scene = {"name": "met", "time": {"end": 1.0, "communication_step": 0.01}, "contact": {}}
    scene["fluid"] = box() | {"bodies": [ball | {"position": [0.0] * 3, "motion": "master"}, other]}
    scene["flyer"] = {"mass": 1.0, "inertia": 0.1, "hinges": []}
    scene["flyer"] |= {"solid": ball | {"position": [0.0] * 3}} if solid else {"shape": 0}
    found = [text for text in Facts(nervure.Scene.model_validate(scene)).warnings if "passes through" in text]
    assert len(found) == count, found


def meeting(other: str, ratio: float) -> dict:
    """A ball of a flyer that moves towards another body or a rod of so many times its mass, in a thin fluid."""
    ball, h = {"shape": {"sphere": {"radius": 0.15}}, "pivot": [0.0] * 3}, 2e-3
    scene: dict[str, Any] = {"name": "met", "time": {"end": 200 * h, "communication_step": h}}
    scene["contact"] = {"range": 0.06, "friction": 0.5}
    scene["flyer"] = {"mass": 1.0, "inertia": 9e-3, "shape": 0, "velocity": [0.5, 0.0, 0.0], "hinges": []}
    scene["fluid"] = {
        "density": 1e-4,
        "kinematic_viscosity": 1e-2,
        "box": {axis: [-0.9, 0.9] for axis in "xyz"} | {"cells": [16] * 3},
        "bodies": [ball | {"position": [0.0] * 3, "motion": "master"}],
        "mask": {"log_linear": {"c_eta": 1e-3}},
        "time_stepping": {"max_step": h, "max_cfl": 0.4},
    }
    if other == "body":
        mount: dict[str, Any] = {"mass": ratio, "inertia": 9e-3 * ratio} | {name: {} for name in WAY}
        scene["fluid"]["bodies"].append(ball | {"position": [0.45, 0.03, 0.0], "mount": mount})
        return scene
    section = {"line_density": 2.5 * ratio, "bending_stiffness": 1.0, "axial_stiffness": 2e4}
    root = {"at": {"position": [0.35, -0.17, 0.0], "direction": [0.0, 1.0, 0.0]}}
    scene["beam"] = {"root": root, "length": 0.4, "thickness": 0.06, "segments": 10, "surface": "line"}
    scene["rod"] = {"material": {"section": section}, "root": {"free": {}}, "scheme": "bdf2"}
    scene["coupling"] = {"guards": {"largest_imbalance": None}}
    return scene


@pytest.mark.parametrize(
    ("other", "ratio"), [("body", 0.1), ("body", 1.0), ("body", 100.0), ("rod", 0.3), ("rod", 30.0)]
)
def test_what_meets_the_body_of_a_flyer_pushes_it_back(other, ratio, tmp_path):
    """A flyer that felt nothing would keep its speed, and give a body of its own mass five times its energy."""
    names = [*WAY[:3], *(f"v{axis}" for axis in "xyz"), *(f"omega_{axis}" for axis in "xyz")]
    energies, gaps = [], []
    with Session(nervure.Scene.model_validate(meeting(other, ratio)), tmp_path) as session:
        session.start()
        units = session.units
        of_flyer = units["body"].scalars_reader(names)
        if other == "body":
            of_other = units["fluid"].scalars_reader([f"body[2].{name}" for name in names])
        else:
            of_other = units["rod"].scalars_reader(["energy.elastic", "energy.kinetic"])
        for _ in range(session.grid.steps):
            session.step()
            place, velocity, omega = of_flyer().reshape(3, 3)
            energy = 0.5 * velocity @ velocity + 4.5e-3 * omega @ omega
            if other == "body":
                its, v, turn = of_other().reshape(3, 3)
                gaps.append(np.linalg.norm(its - place) - 0.3)
                energy += ratio * (0.5 * v @ v + 4.5e-3 * turn @ turn)
                momentum = velocity + ratio * v
            else:
                line, rates = (np.array([units["rod"].read(f"{v}{axis}") for axis in "xyz"]).T for v in ("", "v"))
                gaps.append(np.linalg.norm(line - place, axis=1).min() - 0.18)
                energy += of_other().sum()
                momentum = velocity + ratio * (rates[1:] + rates[:-1]).mean(axis=0) / 2.0
            energies.append(energy)
    assert 0.0 < min(gaps) < 0.055 < gaps[-1], f"a gap of {min(gaps)} m, at the end of {gaps[-1]} m"
    assert max(energies) < 0.125 * 1.0005, f"{max(energies)} J of 0.125 J"
    assert np.abs(momentum - [0.5, 0.0, 0.0]).max() < 1e-3 * 0.5, f"{momentum} N s of 0.5 N s"


@pytest.mark.parametrize(("contact", "counts"), [(True, [0, 0]), (False, [0, 1])])
def test_a_rod_that_reaches_the_body_of_a_flyer_is_said_to_meet_it_without_contact_alone(contact, counts):
    scene = meeting("rod", 1.0)
    if not contact:
        del scene["contact"]
    watch, memory, said = monitor(json.dumps(scene)), None, []
    for step, x in enumerate([0.35, 0.1]):
        line = [[x, y, 0.0] for y in np.linspace(-0.17, 0.23, 11)]
        answer = watch({"time": step * 2e-3, "bodies": [[0.0] * 6], "beams": [line], "wings": [], "memory": memory})
        memory = answer["memory"]
        said.append(answer["warnings"])
    assert [len(found) for found in said] == counts, said


@pytest.mark.parametrize(
    ("body", "motion", "stream", "contact"),
    [
        (*LIGHT_SPHERE, None),
        (*TUMBLING_ELLIPSOID, None),
        (*LIGHT_SPHERE_ON_TWO_GRIDS, None),
        (*LIGHT_SPHERE, {"range": 0.01, "friction": 0.5, "obstacles": [CEILING]}),
    ],
    ids=["light", "tumbling", "two-grids", "in contact"],
)
def test_a_body_flies_as_the_same_one_on_a_mount(body, motion, stream, contact, tmp_path):
    """What is announced to the unit of the body is what the fluid then exerts.

    The sphere has a tenth of the mass of the fluid, the ellipsoid turns in a stream and reaches into a sponge.
    """
    ends = []
    for own in ("mount", "flyer"):
        placed = {"position": [0.0] * 3, "pivot": [0.0] * 3} | body
        placed |= {"mount": motion | {name: {} for name in WAY}} if own == "mount" else {"motion": "master"}
        scene = {"name": own, "time": {"end": 1.0, "communication_step": 0.01}}
        scene["fluid"] = box() | stream | {"bodies": [placed]}
        if own == "flyer":
            scene["flyer"] = motion | {"shape": 0, "hinges": []}
        if contact:
            scene["contact"] = contact
        with run(scene, tmp_path, 20) as session:
            found = outputs(session, "fluid")
            velocity = np.array([session.units["fluid"].field(name) for name in "uvw"])
        places = [np.array([found[f"body[1].{name}"] for name in names]) for names in (WAY[:3], WAY[3:], FORCE)]
        ends.append([*places, velocity])
    for part, mounted, flown in zip(("place", "angle", "force", "velocity of the flow"), *ends, strict=True):
        off, scale = np.abs(flown - mounted).max(), np.abs(mounted).max()
        # A mount adds the turn by contact to that of its step, a flyer finds both as one.
        assert off < (1e-7 if contact else 1e-9) * scale, f"{part}: {flown}, on a mount {mounted}"
    assert np.abs(ends[0][0]).max() > 0.01
    assert not contact or ends[0][0][2] < 0.02, "it is above the ceiling"


@pytest.mark.parametrize(("names", "wanted"), [((), "load_x"), (("wing_1", "wing_2"), "wing_1_load_x")])
def test_each_output_of_a_flyer_in_a_fluid_has_a_column(names, wanted, tmp_path):
    """A single wing has the columns of one without a body; names may be those of the fluid's own forces."""
    scene = pair()
    wings = scene.pop("wings")
    scene["flyer"]["hinges"] = [scene["flyer"]["hinges"][0] | {"carries": names[0] if names else "wing"}]
    scene |= {"wings": [wings[0] | {"name": name} for name in names]} if names else {"wing": wings[0]["wing"]}
    scene["fluid"] = box()
    with run(scene, tmp_path, 2) as session:
        series, unit = session.recorder.series, session.units[names[0] if names else "wing"]
        scalars = [name for own in session.units.values() for kind in ("Real", "Integer") for name in own.scalars(kind)]
        load = unit.outputs[unit.slices["load.x"]].item()
    assert len(series) == len(scalars) + 2
    assert series[wanted][-1] == load != 0.0
    assert series["body_y"].any()


def swimmer() -> dict:
    """A body in a fluid with two wings that are as light as the fluid."""
    scene = pair(0.2)
    for own in scene["wings"]:
        own["wing"]["membrane"] |= {"areal_density": 0.5, "bending_stiffness": 0.02}
    for hinge in scene["flyer"]["hinges"]:
        hinge["motion"] = {"stroke": {"sine": {"amplitude": 0.8, "frequency": 2.0}}}
        hinge["position"][0] *= 3.0
    # At a radius of 0.15 m rounding would decide whether points at the rim of the mask are in it.
    body = {"shape": {"sphere": {"radius": 0.16}}, "position": [0.0] * 3, "pivot": [0.0] * 3, "motion": "master"}
    scene["fluid"], scene["flyer"]["shape"] = box() | {"bodies": [body]}, 0
    return scene


TWO_GRIDS = {
    "box": {axis: [-2.0, 2.0] for axis in "xyz"} | {"cells": [20] * 3},
    "fine_box": {axis: [-1.6, 1.6] for axis in "xyz"} | {"ratio": 2, "follow": "nothing"},
}


ALL = ["x", "y", "z", "angle_x", "angle_y", "angle_z"]
ROOMY = {axis: [-1.8, 1.8] for axis in "xyz"}


@pytest.mark.parametrize(
    ("fine", "flyer", "followed"),
    [
        ({}, {}, "body[1]"),
        ({"follow": "nothing"}, {}, None),
        ({"follow": "master"}, {}, "master"),
        ({}, {"held": ["y", *ALL[3:]]}, "body[1]"),
        ({}, {"held": ["x", "y", "z"]}, None),  # It turns on the spot
        ({}, {"shape": None}, None),
    ],
)
def test_a_fine_box_follows_the_shape_of_a_flyer_that_may_leave_its_place(fine, flyer, followed):
    scene = swimmer()
    scene["fluid"] |= {"box": TWO_GRIDS["box"] | {"cells": [40] * 3}, "fine_box": ROOMY | {"ratio": 2} | fine}
    scene["flyer"] |= flyer
    if flyer.get("shape", 0) is None:
        del scene["fluid"]["bodies"]
    assert Facts(validate(scene)).followed == followed


def test_a_wing_in_the_rim_of_a_box_that_follows_is_told_what_it_follows():
    scene = swimmer()
    scene["fluid"] |= TWO_GRIDS | {"fine_box": {axis: [-1.6, 1.6] for axis in "xyz"} | {"ratio": 2}}
    with pytest.raises(SceneError, match=r"the rim of `fine_box`, which follows `body\[1\]`, leaves x \[-0.2, 0.2\]"):
        describe("body", scene)


@pytest.mark.parametrize(
    ("held", "gains"), [([], True), (ALL[3:], True), (["x", "y"], True), (["z"], False), (ALL, False)]
)
def test_a_flyer_whose_weight_no_support_bears_sets_a_periodic_box_in_motion(held, gains):
    scene = swimmer()
    del scene["fluid"]["mean_flow"]
    scene["flyer"] |= {"gravity": [0.0, 0.0, -9.81], "held": held}
    told = [text for text in Facts(validate(scene)).warnings if "gives its weight to the fluid" in text]
    assert len(told) == gains and all("`channel` or a `sponge`" in text for text in told)
    scene["fluid"]["channel"] = {"z": [-0.9, 0.9]}
    assert not any("gives its weight" in text for text in Facts(validate(scene)).warnings)


@pytest.mark.parametrize("grids", [{}, TWO_GRIDS], ids=["one grid", "two grids"])
def test_a_flyer_whose_step_has_four_of_its_fluid_moves_as_with_four_steps(grids, tmp_path):
    """By `max_step`; what a function sets at hinges lies between the steps, too."""

    def drive(t: float, _: Mapping[str, float]) -> dict[str, float]:
        angle, rate = 0.3 - 0.3 * math.cos(math.tau * t), 0.3 * math.tau * math.sin(math.tau * t)
        return {f"{name}.stroke": angle for name in ("left", "right")} | {
            f"{name}.stroke_rate": rate for name in ("left", "right")
        }

    ends = []
    for h, by_law in ((0.01, True), (0.04, True), (0.04, False)):
        scene = swimmer()
        scene["time"] = {"end": 0.16, "communication_step": h}
        scene["fluid"] |= grids
        for hinge in scene["flyer"]["hinges"]:
            law = {"stroke": {"cosine_ramp": {"value": 0.6, "duration": 0.5}}}
            hinge["motion"] = law if by_law else "master"
        with run(scene, tmp_path, drive=None if by_law else drive) as session:
            found = outputs(session)
            ends.append(np.array([found[name] for name in ("y", "vy")]))
    one, four, driven = ends
    assert four == pytest.approx(one, rel=1e-9) and driven == pytest.approx(one, rel=0.01), ends


def test_a_wing_repeats_a_step_from_a_state_saved_after_its_reaction_was_read(tmp_path):
    with run(pair(), tmp_path, 10) as session:
        carried, h = session.scheme.carried[0], 5e-3
        unit, t = carried.unit, 10 * h
        place = carried.inputs["root.vx"]
        begin = carried.root[place].copy()

        def ends(change: float) -> np.ndarray:
            carried.root[place] = begin + change
            unit.step(t, h)
            found = unit.outputs.copy()
            unit.restore()
            return found

        carried.respond(t, h)
        unit.save()
        first, again = ends(0.01), ends(0.01)
        read = []
        for times in (1, 2):
            carried.root[place] = begin
            for _ in range(times):
                carried.respond(t, h)
            read.append(ends(0.01))
    assert np.array_equal(first, again) and np.array_equal(*read)
    assert not np.array_equal(first, read[0]) and first == pytest.approx(read[0], rel=1e-6, abs=1e-9)


def test_a_flight_in_a_fluid_goes_on_from_a_saved_state_with_the_same_bits(tmp_path):
    scene = swimmer()
    scene["fluid"]["time_stepping"]["max_cfl"] = 0.005
    with run(scene, tmp_path, 4) as session:
        scheme, units = session.scheme, session.units.values()
        kept, buffers = scheme.memory(), [(own.inputs.copy(), own.outputs.copy()) for own in units]
        for unit in units:
            unit.save()
        ends = []
        for _ in range(2):
            for unit, (inputs, found) in zip(units, buffers, strict=True):
                unit.restore()
                unit.inputs[:], unit.outputs[:] = inputs, found
            scheme.remember(kept)
            exchanges = [scheme.step(k * 5e-3, 5e-3) for k in range(4, 7)]
            ends.append(session.units["body"].outputs.copy())
    assert max(exchanges) > 1 and np.array_equal(*ends), exchanges


def test_a_flyer_in_a_fluid_moves_alike_with_few_rows():
    scene = swimmer()
    scene["time"]["end"] = 12 * scene["time"]["communication_step"]

    def series(every: float | None) -> dict[str, np.ndarray]:
        with Session(validate(scene), series_every=every) as session:
            session.run()
            return session.recorder.series

    some = series(3 * scene["time"]["communication_step"])
    for name, values in series(None).items():
        assert np.array_equal(some[name], values[::3]), name


def test_a_flyer_swims_with_wings_and_a_body_in_a_fluid(tmp_path):
    """Mirror images stay mirror images, and a light wing is stable in the fluid."""
    scene = swimmer()
    with run(scene, tmp_path, 30) as session:
        found, of_fluid = outputs(session), outputs(session, "fluid")
    assert abs(found["y"]) > 1e-5 and max(abs(found[axis]) for axis in "xz") < 1e-9 * abs(found["y"])
    assert of_fluid["wing[1].drag"] == pytest.approx(-of_fluid["wing[2].drag"], rel=1e-6)
    assert of_fluid["body[1].y"] == pytest.approx(found["y"], rel=1e-12)


def test_wings_take_in_the_sum_what_the_fluid_gives(tmp_path):
    """What an announced load lacks joins the next one."""
    taken, given = [], []
    with Session(nervure.Scene.model_validate(swimmer()), tmp_path) as session:
        session.start()
        for _ in range(30):
            session.step()
            of_wings, of_fluid = (outputs(session, name) for name in ("left", "fluid"))
            taken.append([of_wings[f"load.{axis}"] for axis in "xyz"])
            given.append([of_fluid[f"wing[1].load_{axis}"] for axis in "xyz"])
    # Of the first step, into the middle of the stroke, no loads are announced.
    lacking = np.sum(given[1:], axis=0) - np.sum(taken[1:], axis=0)
    size = np.abs(taken).sum(axis=0).max()
    assert np.abs(lacking).max() < 0.003 * size, f"{lacking / size} of the loads are lost"


def test_a_summary_has_the_means_of_each_wing_of_a_flyer_and_their_sums(tmp_path):
    scene = swimmer()
    scene["time"] = {"end": 1.5, "communication_step": 0.01}
    found = nervure.run(nervure.Scene.model_validate(scene), tmp_path, quiet=True).summary
    left, right = (found.wings[name].flapping for name in ("left", "right"))
    print(left, found.wing)
    assert found.periods >= 1 and left.power_in > 0.0
    assert left.power_in == pytest.approx(right.power_in, rel=1e-6)
    assert found.wing.root_power == pytest.approx(2 * left.power_in, rel=1e-6)
    assert left.tip_amplitude == pytest.approx(right.tip_amplitude, rel=1e-6)
    assert 0.5 < left.tip_by_rigid_tip < 2.0
    # Both meshes lie along x at rest; the hinge turns one.
    assert left.thrust == pytest.approx(-right.thrust, rel=1e-6) and found.wings["left"].interface.exchanged > 0.0


def test_a_flight_resumes(tmp_path):
    whole = nervure.run(nervure.Scene.model_validate(pair()), tmp_path / "whole", quiet=True)
    half = nervure.Scene.model_validate(pair()).copy({"time.end": 0.125})
    nervure.run(half, tmp_path / "half", quiet=True, checkpoint_every=100.0)
    resumed = nervure.resume(tmp_path / "half", end_time=0.25, quiet=True)
    # The last step of the half is longer by rounding.
    assert resumed.series["body_y"] == pytest.approx(whole.series["body_y"], abs=1e-12)


@pytest.mark.pictures
def test_pictures_and_file_of_a_flyer_show_all_its_wings_and_rods_where_its_hinges_hold_them(tmp_path, monkeypatch):
    scene = pair()
    scene["time"]["end"], scene["flyer"]["position"] = 0.02, [0.0, 0.0, 0.3]
    root = {"at": {"position": [0.0, 0.1, 0.3], "direction": [0.0, 1.0, 0.0]}}
    section = {"line_density": 0.3, "bending_stiffness": 0.1, "axial_stiffness": 200.0}
    scene["beam"] = {"root": root, "length": 0.3, "thickness": 0.01, "segments": 6}
    scene["rod"] = {"material": {"section": section}, "scheme": "bdf2"}
    scene["flyer"]["hinges"].append({"carries": "rod", "position": [0.0, 0.1, 0.0]})
    found = nervure.run(nervure.Scene.model_validate(scene), tmp_path, fields_every=0.01, quiet=True)
    mesh, (nodes, triangles) = found.facts.wing, animation.Frames(tmp_path).membrane(0)
    assert (tmp_path / "wing.png").exists() and len(mesh.roots) == len(mesh.tips) == len(mesh.edges()) == 2
    assert nodes == pytest.approx(mesh.nodes, abs=1e-7) and np.array_equal(triangles, mesh.triangles)
    print(mesh.nodes[mesh.tips])
    assert np.abs(mesh.nodes[mesh.tips, 0]) == pytest.approx(0.25)
    assert mesh.nodes[:, 2] == pytest.approx(0.3)
    drawn: list[Any] = []
    monkeypatch.setattr(animation.plots, "save", lambda figure, path: drawn.append(figure) or path)
    animation.write(tmp_path, None, None)
    assert (tmp_path / "motion.gif").exists()
    (figure,) = drawn
    shown = [np.array(line.get_data_3d()).T / 1e3 for line in figure.axes[0].lines]
    tail = animation.Frames(tmp_path).points(2)
    assert any(np.shape(line) == tail.shape and line == pytest.approx(tail) for line in shown), "the rod"


@pytest.mark.pictures
def test_a_film_of_a_flyer_with_rods_alone_shows_them_all(tmp_path):
    scene = pair()
    del scene["wings"]
    scene["time"]["end"] = 0.02
    section = {"line_density": 0.3, "bending_stiffness": 0.1, "axial_stiffness": 200.0}
    rod = {"material": {"section": section}, "scheme": "bdf2"}
    beam = {"length": 0.3, "thickness": 0.01, "segments": 6}
    sides = {"left": 0.05, "right": -0.05}
    roots = {name: {"at": {"position": [x, 0.0, 0.0], "direction": [20 * x, 0.0, 0.0]}} for name, x in sides.items()}
    scene["rods"] = [{"name": name, "beam": beam | {"root": root}, "rod": rod} for name, root in roots.items()]
    hinges = [{"carries": name, "position": [x, 0.0, 0.0], "motion": {"stroke": STROKE}} for name, x in sides.items()]
    scene["flyer"]["hinges"] = hinges
    nervure.run(nervure.Scene.model_validate(scene), tmp_path, fields_every=0.005, quiet=True)
    frames = animation.Frames(tmp_path)
    times, paths = frames.tips
    assert len(times) == 5 and [path[0, 0] for path in paths] == pytest.approx([0.35, -0.35])
    for path, shapes in zip(paths, frames.shapes, strict=True):
        assert path == pytest.approx(shapes[:, -1], abs=1e-7) and np.ptp(path[:, 1]) > 0
    assert {"motion.png", "motion.gif"} <= {path.name for path in animation.write(tmp_path, None, None)}


def test_a_controller_holds_the_height_and_all_angles_that_a_constant_stroke_loses(tmp_path):
    """On coarse cells and with a small stroke, which lift less than half of the example's mass, after a push."""
    scene = json.loads((EXAMPLES / "flyer-pid.json").read_text())
    scene["time"] = {"end": 0.0125, "communication_step": 2e-5}
    scene["fluid"]["box"]["cells"], scene["flyer"]["mass"] = [32, 24, 32], 5.5e-7
    scene["fluid"]["time_stepping"]["max_step"] = 2e-5
    scene["flyer"]["angular_velocity"] = [0.0, 60.0, 40.0]
    ends = []
    for seen in (1.0, 0.0):
        pid = runpy.run_path(str(EXAMPLES / "flyer_pid.py"))["Pid"]
        pid.__call__.__globals__.update(AMPLITUDE=0.9, KP=5600.0, KD=38.0)  # Twice as fast as the example
        own = pid()

        def drive(t: float, values: Mapping[str, float], own=own, seen=seen) -> dict[str, float]:
            return own(t, {name: value if name == "time" else seen * value for name, value in values.items()})

        with run(scene, tmp_path, drive=drive) as session:
            found = outputs(session)
            ends.append([found[name] for name in ("z", "angle_x", "angle_y", "angle_z")])
    print(ends)
    (held, *upright), (lost, *leaning) = ends
    assert lost < -1e-4 and abs(held) < 0.5 * abs(lost), f"{held} m under control, {lost} m without"
    for axis, under, without in zip("xyz", upright, leaning, strict=True):
        assert abs(without) > 0.05 and abs(under) < 0.5 * abs(without), f"{under} about {axis}, {without} without"


def test_the_laws_of_hinges_set_speed_length_and_cfl_number(libraries):
    """The tip of a wing of 0.2 m turns about z at most by 2 π f times the amplitude."""
    scene = swimmer()
    scene["time"]["end"] = 2.0
    numbers = Facts(nervure.Scene.model_validate(scene)).numbers
    speed = 0.8 * 2 * math.pi * 2.0 * math.hypot(0.2, 0.05)
    assert numbers.velocity == pytest.approx(speed, rel=1e-3) and numbers.velocity_of == "hinge of left"
    assert numbers.length == pytest.approx(0.1) and numbers.length_of == "wing_1"
    assert numbers.reynolds == pytest.approx(speed * 0.1 / 0.02, rel=1e-3)
    assert numbers.cfl == pytest.approx(speed * 5e-3 / 0.1, rel=1.0)
    scene["flyer"]["hinges"][0]["motion"] = scene["flyer"]["hinges"][1]["motion"] = "master"
    assert Facts(nervure.Scene.model_validate(scene)).numbers.velocity is None


@pytest.mark.parametrize("contact", [True, False])
def test_wings_of_a_flyer_without_a_fluid_that_clap_stay_apart_by_contact(contact, tmp_path):
    scene = pair()
    scene["time"] = {"end": 0.24, "communication_step": 3e-3}
    for hinge in scene["flyer"]["hinges"]:
        stroke = {"sine": {"amplitude": 1.75, "frequency": 1.0}}
        hinge["motion"] = {"stroke": stroke, "pitch": {"constant": math.pi / 2}}
    scene |= {"contact": {"range": 0.03}} if contact else {}
    apart = []
    with Session(nervure.Scene.model_validate(scene), tmp_path) as session:
        session.start()
        for _ in range(session.grid.steps):
            session.step()
            left, right = (session.units[name].read("x") for name in ("left", "right"))
            apart.append(left.min() - right.max())
        found = outputs(session)
    assert min(apart) > 0.0 if contact else min(apart) < -0.05, f"they come to {min(apart)} m"
    assert found["y"] > 0.1 and max(abs(found[name]) for name in ("x", "z", "angle_z")) < 1e-9 * found["y"]
