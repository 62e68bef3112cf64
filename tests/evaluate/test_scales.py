"""Lengths, areas, speeds and directions of coefficients: one rule for all bodies, which turns with them."""

import copy

import numpy as np
import pytest

from nervure.errors import SceneError
from nervure.evaluate import bodies, flapping
from nervure.evaluate.statistics import Window
from nervure.scene import validate
from nervure.scene.facts import Facts

EYE = np.eye(3)
TURNS = {
    "about x": np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "about y": np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
    "about z": np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]),
    "about x and y": np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]) @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]),
}
WINDOW = Window(0.0, 4.0, 4)
TIME = np.linspace(0.0, 4.0, 401)
FORCE = np.array([3.0 + 0.2 * np.sin(4 * np.pi * TIME), 1.0 + np.sin(2 * np.pi * TIME), 0.1 * np.cos(2 * np.pi * TIME)])


def scene(*bodies, stream=(1.0, 0.0, 0.0), **more):
    """A fluid in a cube, with bodies in a stream."""
    laws = {axis: {"constant": value} for axis, value in zip("xyz", np.round(stream, 12).tolist(), strict=True)}
    return {
        "name": "cube",
        "time": {"end": 4.0, "communication_step": 0.01},
        "fluid": {
            "density": 2.0,
            "kinematic_viscosity": 0.01,
            "box": {axis: [-2.0, 2.0] for axis in "xyz"} | {"cells": [32, 32, 32]},
            "initial_velocity": np.round(stream, 12).tolist(),
            "mean_flow": laws,
            "bodies": [{"position": [0.0, 0.0, 0.0], **body} for body in bodies],
            "mask": {"log_linear": {"c_eta": 1e-5}},
            "time_stepping": {"max_step": 0.01, "max_cfl": 0.4},
        },
        **more,
    }


def facts(*bodies, **more):
    return Facts(validate(scene(*bodies, **more)))


def axis_and_angle(rotation):
    """The `turn` of a rotation matrix."""
    angle = np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))
    values, vectors = np.linalg.eig(rotation)
    axis = np.real(vectors[:, np.argmin(abs(values - 1))])
    off = rotation - rotation.T
    if axis @ [off[2, 1], off[0, 2], off[1, 0]] < 0:
        axis = -axis
    return {"axis": axis.tolist(), "angle": float(angle)}


def about(axis, angle):
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def columns(name, force):
    return {"time": TIME, **{f"{name}_{end}": values for end, values in zip(flapping.FORCES, force, strict=True)}}


SHAPES = {
    "plate": {"plate": {"length": 1.0, "width": 2.0}},
    "cuboid": {"cuboid": {"lengths": [1.0, 0.25, 2.0]}},
    "ellipsoid": {"ellipsoid": {"lengths": [1.0, 0.5, 0.7]}},
    "disk": {"disk": {"radius": 0.5}},
    "cylinder": {"circular_cylinder": {"axis": "z", "radius": 0.25, "length": 1.5}},
}


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("shape", SHAPES)
def test_the_same_physics_turned_by_90_degrees_has_the_same_coefficients(shape, turn):
    """A body at 30° in a stream along x, and body, stream and forces turned."""
    rest, rotation = about([0, 0, -1], np.pi / 6), TURNS[turn]
    found = []
    for turned in (EYE, rotation):
        body = {"shape": SHAPES[shape], "turn": axis_and_angle(turned @ rest)}
        series = columns("body_1", turned @ FORCE)
        found.append(bodies.evaluate(facts(body, stream=turned @ [1.0, 0.0, 0.0]), series, WINDOW, 0.0)["body_1"])
    first, second = found
    for key in ("cd_mean", "cd_amplitude", "cl_mean", "cl_amplitude", "cs_mean", "cs_amplitude", "ct", "own_axes"):
        one, other = getattr(first, key), getattr(second, key)
        assert other == pytest.approx(one, rel=1e-9, abs=1e-9), (key, one, other)
    assert (first.reference.length, first.reference.area) == pytest.approx(
        (second.reference.length, second.reference.area)
    )
    assert first.ct < -1 and first.reference.drag == (1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("stream", "lengths"), [((0, 0, 1), [1, 1, 2]), ((0, 1, 0), [1, 2, 1]), ((1, 0, 0), [2, 1, 1])]
)
def test_thrust_is_against_the_stream_along_any_axis(stream, lengths):
    """309.6 N along the stream of 1 m/s, by 2 m² and 2 kg/m³."""
    force = 309.6 * np.outer(stream, np.ones_like(TIME))
    known = facts({"shape": {"cuboid": {"lengths": lengths}}}, stream=stream)
    found = bodies.evaluate(known, columns("body_1", force), WINDOW, 0.0)["body_1"]
    assert found.ct == pytest.approx(-309.6 / 2) and found.cd_mean == pytest.approx(309.6 / 2), found


@pytest.mark.parametrize(
    ("shape", "length", "area"),
    [
        ({"cuboid": {"lengths": [1.0, 1.0, 3.0]}}, 1.0, 3.0),
        ({"cuboid": {"lengths": [2.0, 0.5, 1.0]}}, 2.0, 2.0),
        ({"plate": {"length": 1.0, "width": 2.0}}, 1.0, 2.0),
        ({"sphere": {"radius": 0.5}}, 1.0, np.pi / 4),
        ({"ellipsoid": {"lengths": [1.0, 1.0, 2.0]}}, 1.0, np.pi / 2),
        ({"circular_cylinder": {"axis": "z", "radius": 0.25}}, 0.5, 2.0),
        ({"capsule": {"axis": "z", "radius": 0.25, "length": 1.5}}, 0.5, 0.5 + np.pi / 16),
        ({"disk": {"radius": 0.5}}, 1.0, np.pi / 4),
    ],
)
def test_length_is_the_chord_and_area_the_largest_projection(shape, length, area):
    own = facts({"shape": shape})
    found = own.scales["body_1"]
    assert (found.length, found.area) == pytest.approx((length, area)), found
    assert own.numbers.reynolds == pytest.approx(length / 0.01)


def test_a_closed_surface_has_the_area_of_the_solid_and_a_tilted_sheet_its_own():
    box = [[x, y, z] for x in (0.0, 1.0) for y in (0.0, 0.5) for z in (0.0, 2.0)]
    faces = [
        (0, 1, 3),
        (0, 3, 2),
        (4, 6, 7),
        (4, 7, 5),
        (0, 4, 5),
        (0, 5, 1),
        (2, 3, 7),
        (2, 7, 6),
        (0, 2, 6),
        (0, 6, 4),
    ]
    faces += [(1, 5, 7), (1, 7, 3)]
    closed = facts({"shape": {"triangulation": {"nodes": box, "triangles": faces}}}).scales["body_1"]
    tilt = about([0, 0, 1], 0.7)
    sheet = (np.array([(0, 0, 0), (1, 0, 0), (1, 0, 2), (0, 0, 2)]) @ tilt.T).tolist()
    tilted = facts({"shape": {"triangulation": {"nodes": sheet, "triangles": [(0, 1, 2), (0, 2, 3)]}}})
    assert (closed.length, closed.area) == pytest.approx((1.0, 2.0)), closed
    assert tilted.scales["body_1"].area == pytest.approx(2.0)


def test_reference_sets_length_area_speed_and_directions():
    reference = {"length": 0.4, "area": 0.5, "speed": 2.0, "drag": [0, 1, 0], "lift": [1, 1, 0]}
    own = facts({"shape": {"sphere": {"radius": 0.5}}, "reference": reference})
    found = bodies.evaluate(own, columns("body_1", FORCE), WINDOW, 0.0)["body_1"]
    assert own.numbers.reynolds == pytest.approx(2.0 * 0.4 / 0.01)
    assert found.reference.lift == (1.0, 0.0, 0.0)
    assert (found.cd_mean, found.cl_mean, found.ct) == pytest.approx((0.5, 1.5, -0.5), abs=1e-3), found


@pytest.mark.parametrize(
    ("reference", "said"),
    [({"lift": [1, 0, 0], "drag": [2, 0, 0]}, "across the drag"), ({"drag": [0, 0, 0]}, "length")],
)
def test_directions_that_are_none_are_refused(reference, said):
    with pytest.raises(SceneError, match=said):
        facts({"shape": {"sphere": {"radius": 0.5}}, "reference": reference}).numbers  # noqa: B018


def test_a_revolving_plate_has_the_speed_of_its_farthest_corner():
    """Turned at 3 rad/s about x at 2.5 m from the corner."""
    law = {"table": {"times": [0, 4], "values": [0, 12], "end_slopes": [3, 3]}}
    plate = {"shape": {"plate": {"length": 1.0, "width": 2.0}}, "pivot": [0, 0, -1.5], "motion": {"angle": law}}
    plate["motion"]["axis"] = [1, 0, 0]
    numbers = facts(plate, stream=(0.0, 0.0, 0.0)).numbers
    assert numbers.velocity == pytest.approx(3 * 2.5), numbers.velocity


def test_a_gust_is_no_stream():
    """It ends, so that the body's own motion or the stream it comes upon count."""
    gust = {"table": {"times": [0.0, 0.25, 0.5], "values": [0.0, 0.3, 0.0]}}
    heave = {"shape": {"sphere": {"radius": 0.5}}, "motion": {"y": {"sine": {"amplitude": 0.1, "frequency": 1.0}}}}
    still = scene(heave, stream=(0.0, 0.0, 0.0))
    still["fluid"]["mean_flow"]["z"] = gust
    streaming = scene({"shape": {"sphere": {"radius": 0.5}}})
    streaming["fluid"]["mean_flow"]["y"] = gust
    swinging = copy.deepcopy(streaming)
    swinging["fluid"]["mean_flow"]["x"] = {"sine": {"mean": 1.0, "amplitude": 0.2, "frequency": 1.0}}
    found = [Facts(validate(one)) for one in (still, streaming, swinging)]
    assert [own.numbers.velocity for own in found] == pytest.approx([0.2 * np.pi, 1.0, 1.0])
    assert found[0].stream is None and found[2].stream == pytest.approx([1.0, 0.0, 0.0])


def test_forces_along_the_own_axes_follow_a_body_that_turns():
    """The force turns with the body: 1 along its own x, although its mean along x and y is 0."""
    turning = {"angle": {"table": {"times": [0, 4], "values": [0, 8 * np.pi], "end_slopes": [2 * np.pi] * 2}}}
    own = facts({"shape": {"sphere": {"radius": 0.5}}, "motion": turning})
    angle = 2 * np.pi * TIME
    series = columns("body_1", [np.cos(angle), np.sin(angle), 0 * angle]) | {"body_1_angle": angle}
    found = bodies.evaluate(own, series, WINDOW, 0.0)["body_1"].own_axes
    assert found == pytest.approx((4 / np.pi, 0.0, 0.0), abs=1e-6), found


@pytest.mark.parametrize(("lift", "st"), [(1e-5, 1.0), (1e-12, None)])
def test_a_lift_of_rounding_has_no_strouhal_number(lift, st):
    """Beside a drag of 1 N."""
    swing = np.sin(2 * np.pi * TIME)
    own = facts({"shape": {"cuboid": {"lengths": [1.0, 1.0, 3.0]}}})
    found = bodies.evaluate(own, columns("body_1", [swing, lift * swing, 0 * TIME]), WINDOW, 0.0)["body_1"]
    assert found.st == (st and pytest.approx(st)), found


@pytest.mark.parametrize("axes", ["x", "y", "z", "xz", "xyz"])
def test_an_oscillation_along_any_line_has_its_keulegan_carpenter_number(axes):
    """Of an amplitude of 0.1 m and a diameter of 1 m, 0.2 pi."""
    law = {"sine": {"amplitude": 0.1 / np.sqrt(len(axes)), "frequency": 2.0}}
    driven = facts({"shape": {"sphere": {"radius": 0.5}}, "motion": dict.fromkeys(axes, law)}, stream=(0, 0, 0))
    found = bodies.evaluate(driven, columns("body_1", FORCE), WINDOW, 0.0)["body_1"]
    assert found.kc == pytest.approx(0.2 * np.pi), found.kc
    assert found.reference.drag == pytest.approx([(axis in axes) / np.sqrt(len(axes)) for axis in "xyz"])


def test_two_oscillations_out_of_phase_have_no_keulegan_carpenter_number():
    laws = {axis: {"sine": {"amplitude": 0.1, "frequency": 2.0, "phase": at}} for axis, at in (("x", 0.0), ("z", 1.0))}
    driven = facts({"shape": {"sphere": {"radius": 0.5}}, "motion": laws})
    assert bodies.evaluate(driven, columns("body_1", FORCE), WINDOW, 0.0)["body_1"].kc is None


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_stream_that_swings_past_a_body_at_rest_sets_its_drag(axis):
    own = scene({"shape": {"sphere": {"radius": 0.5}}})
    own["fluid"]["mean_flow"] = {axis: {"sine": {"amplitude": 1.0, "frequency": 2.0, "ramp": 0.25}}}
    own["fluid"]["initial_velocity"] = [0.0, 0.0, 0.0]
    found = Facts(validate(own))
    assert found.stream is None and found.scales["body_1"].drag == tuple(float(a == axis) for a in "xyz")


def test_a_wing_has_re_reduced_frequency_mass_ratio_and_lift_along_its_normal():
    wing = {
        "mesh": {"rectangular": {"length": 0.5, "width": 1.0, "along": 4}},
        "membrane": {"areal_density": 0.5, "stretching_stiffness": 200.0, "bending_stiffness": 0.5},
        "veins": [{"chain": "tip", "line_density": 0.1, "bending_stiffness": 1.0, "axial_stiffness": 1.0}],
        "root": "root",
        "root_motion": {"z": {"sine": {"amplitude": 0.2, "frequency": 0.5}}},
    }
    own = Facts(validate(scene(wing=wing)))
    numbers, scales = own.numbers, own.scales["wing"]
    assert (scales.length, scales.area, *scales.lift) == pytest.approx((0.5, 0.5, 0.0, 0.0, 1.0))
    assert numbers.reynolds == pytest.approx(50.0)
    assert numbers.reduced_frequency == pytest.approx(np.pi * 0.5 * 0.5)
    assert numbers.mass_ratio == pytest.approx((0.5 + 0.1 / 0.5) / (2.0 * 0.5))
    hovers = {"rotations": [{"axis": [0, 1, 0], "angle": {"sine": {"amplitude": 1.0, "frequency": 0.5}}}]}
    hovering = Facts(validate(scene(stream=(0.0, 0.0, 0.0), wing=wing | {"root_motion": hovers})))
    assert hovering.numbers.velocity == pytest.approx(np.pi * 0.5, rel=0.01), hovering.numbers
    assert hovering.scales["wing"].lift == (0.0, 1.0, 0.0)
