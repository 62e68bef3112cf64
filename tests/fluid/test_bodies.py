"""Rigid bodies: what is said of them before and after a run, and the published cases."""

import numpy as np
import pytest

from nervure.errors import InputError
from nervure.evaluate import bodies, flapping as flapping_averages, statistics
from nervure.resources import ROOT
from nervure.scene import document, load, override, read, validate
from nervure.scene.facts import Facts
from nervure.scene.outline import body_outline
from nervure.simulation.session import Session
from nervure.simulation.summary import main_signal
from studies import flapping
from tests.simulation.test_runs import run

pytestmark = pytest.mark.usefixtures("libraries")

SQUARE = [[0.0, 0.0], [0.2, 0.0], [0.2, 0.2], [0.0, 0.2]]
PLATE = {"plate": {"length": 0.6}}


@pytest.fixture
def swinging(fluid_only):
    """A circle of 0.2 m that swings along a diagonal in still fluid, and a square that stands still."""
    sine = {"sine": {"amplitude": 0.1, "frequency": 2.0, "phase": 0.3}}
    fluid_only["fluid"] |= {"initial_velocity": [0.0, 0.0], "inflow": None, "cylinders": []}
    fluid_only["fluid"]["bodies"] = [
        {"shape": {"circle": {"radius": 0.1}}, "position": [0.0, 0.0], "motion": {"x": sine, "y": sine}},
        {"shape": {"polygon": {"corners": SQUARE}}, "position": [0.5, 0.2]},
    ]
    return fluid_only


def known_series():
    """Four periods of that motion, with a force by c_d = 2 and c_i = 1.5 along the diagonal and a constant across."""
    time = np.linspace(0, 2, 2001)
    omega, amplitude = 4 * np.pi, 0.1 * np.sqrt(2)
    phase = omega * time + 0.3
    velocity, rate = amplitude * omega * np.cos(phase), -amplitude * omega**2 * np.sin(phase)
    along = -2.0 * 0.2 * np.abs(velocity) * velocity / 2 - 1.5 * np.pi * 0.2**2 * rate / 4
    drag, lift = along / np.sqrt(2) - 0.01, along / np.sqrt(2) + 0.01
    way = 0.1 * np.sin(phase)
    columns = {"time": time, "drag": drag, "lift": lift}
    columns |= {"body_1_drag": drag, "body_1_lift": lift, "body_1_power": along * velocity}
    columns |= {"body_1_x": way, "body_1_y": way, "body_1_angle": 0 * time}
    return columns | {f"body_2_{name}": 0.02 + 0 * time for name in ("drag", "lift", "power", "x", "y", "angle")}


def test_coefficients_of_a_known_oscillation(swinging):
    scene, columns = validate(swinging), known_series()
    facts = Facts(scene)
    numbers = facts.numbers
    speed = 0.1 * np.sqrt(2) * 4 * np.pi
    assert numbers.reynolds == pytest.approx(speed * 0.2 / 1e-2)
    assert numbers.bodies["body_2"].length == pytest.approx(0.2 * np.sqrt(2))
    main = main_signal(columns)
    assert main.drive == pytest.approx(np.sqrt(2) * columns["body_1_x"])
    window = statistics.driven_window(columns["time"], main.values, main.drive)
    assert (window.periods, window.end) == (3, 2.0)
    found = bodies.evaluate(facts, columns, window, 0.0)
    moving, still = found["body_1"], found["body_2"]
    assert moving.kc == pytest.approx(2 * np.pi * 0.1 * np.sqrt(2) / 0.2)
    assert (moving.morison.cd, moving.morison.ci) == pytest.approx((2.0, 1.5), rel=1e-6)
    assert moving.morison.rest < 1e-6
    # The mean of |cos|³ is 4/(3 pi); the inertia gives nothing over a cycle.
    assert moving.cp == pytest.approx(2.0 * 4 / (3 * np.pi), rel=1e-4)
    # The mean of cos² is a half; one sample at each turn of the motion has the force of inertia with either sign.
    assert moving.cycles["cd_path"].mean == pytest.approx(2.0 / 2, rel=0.02)
    # Drag is along the path, and lift to its left.
    across = 0.01 * np.sqrt(2) * 2 / (speed**2 * 0.2)
    assert moving.cycles["cl"].mean == pytest.approx(across, rel=1e-3)
    assert moving.cycles["cd"].mean == pytest.approx(0.0, abs=1e-3 * across)
    assert moving.cycles["cp"].scatter < 1e-4
    assert (still.kc, still.morison, still.cp) == (None, None, None) and "cd_path" not in still.cycles


def test_scatter_is_that_over_the_cycles():
    time = np.linspace(0, 3, 3001)
    found = bodies.cycle_mean(time, np.floor(time), statistics.Window(0.0, 3.0, 3))
    assert found.mean == pytest.approx(1.0, abs=2e-3) and found.scatter == pytest.approx(1.0, rel=2e-3)


@pytest.mark.parametrize(
    "change",
    [
        {"mean_flow": {"x": {"constant": 1.0}}},
        {"ramp": 10.0},
        {"angle": {"sine": {"amplitude": 0.1, "frequency": 2.0}}},
        {"y": {"sine": {"amplitude": 0.1, "frequency": 2.0, "phase": 1.0}}},
    ],
)
def test_no_morison_split_in_a_stream_or_of_another_motion(swinging, change):
    motion = swinging["fluid"]["bodies"][0]["motion"]
    if "mean_flow" in change:
        swinging["fluid"] |= change | {"initial_velocity": [1.0, 0.0]}
    elif "ramp" in change:
        motion["x"] = motion["y"] = {"sine": motion["x"]["sine"] | change}
    else:
        motion |= change
    scene, columns = validate(swinging), known_series()
    window = statistics.find_window(columns["time"], columns["body_1_x"])
    found = bodies.evaluate(Facts(scene), columns, window, 0.0)["body_1"]
    assert found.morison is None, found


@pytest.mark.parametrize("turn", [0.3, np.pi / 2, 2.0])
def test_the_main_signal_does_not_depend_on_the_orientation(turn):
    """The path of a tip, and the force on a body at rest, turned in the plane."""
    time = np.linspace(0, 4, 4001)
    along, across = np.sin(4 * np.pi * time), 0.2 * np.cos(8 * np.pi * time)
    x, y = np.cos(turn) * along - np.sin(turn) * across, np.sin(turn) * along + np.cos(turn) * across
    for names in (("tip_ux", "tip_uy"), ("drag", "lift")):
        straight, turned = (main_signal(dict(zip(names, path)) | {"time": time}) for path in ((along, across), (x, y)))
        assert straight.values == pytest.approx(along, abs=0.01), names
        assert np.abs(turned.values) == pytest.approx(np.abs(straight.values), abs=1e-12), names
        assert turned.drive is None


@pytest.mark.parametrize("angle", [0.0, 0.5, 2.0, -1.2])
def test_thrust_does_not_depend_on_the_direction_of_the_stream(swinging, angle):
    """A body at rest that the stream pushes with 0.3 N/m, and with 0.1 N/m to the left."""
    along, left = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    flow = {"mean_flow": {axis: {"constant": 2.0 * part} for axis, part in zip("xy", along.tolist(), strict=True)}}
    swinging["fluid"] |= flow | {"initial_velocity": (2.0 * along).tolist()}
    del swinging["fluid"]["bodies"][0]["motion"], swinging["fluid"]["bodies"][1]
    time = np.linspace(0, 2, 201)
    drag, lift = (part + 0 * time for part in 0.3 * along + 0.1 * left)
    columns = {"time": time, "drag": drag, "lift": lift, "body_1_drag": drag, "body_1_lift": lift}
    found = bodies.evaluate(Facts(validate(swinging)), columns, statistics.Window(1.0, 2.0, 0), 0.0)["body_1"]
    assert found.ct == pytest.approx(-0.3 / (swinging["fluid"]["density"] * 2.0**2 * 0.2 / 2)), found


@pytest.fixture
def carried(swinging):
    """A circle that the master moves, and one on springs along both axes, twice as heavy as the fluid."""
    mount = {"mass": 2 * np.pi * 0.01, "x": {}, "y": {"stiffness": 2 * np.pi * 0.01 * (4 * np.pi) ** 2, "rest": -0.02}}
    circle = {"shape": {"circle": {"radius": 0.1}}}
    swinging["fluid"] |= {
        "initial_velocity": [0.5, 0.0],
        "bodies": [
            circle | {"position": [0.0, 0.0], "motion": "master"},
            circle | {"position": [0.5, 0.2], "mount": mount},
        ],
    }
    return swinging


def test_a_body_on_springs_has_its_numbers_and_its_response(carried, tmp_path):
    del carried["fluid"]["bodies"][0]
    mount = Facts(validate(carried)).numbers.mounts["body_1"]
    assert mount.mass_ratio == pytest.approx(2.0)
    along, across = mount.supports["x"], mount.supports["y"]
    assert (along.natural_frequency, along.damping_ratio, along.reduced_velocity) == (0.0, None, None)
    assert across.natural_frequency == pytest.approx(2.0) and across.damping_ratio == 0.0
    assert across.reduced_velocity == pytest.approx(0.5 / (2.0 * 0.2))
    del carried["fluid"]["bodies"][0]["mount"]["x"]
    carried["time"]["end"] = 1.5
    carried["fluid"]["kinematic_viscosity"] = 2e-3
    series, summary = run(tmp_path, carried)
    t, y = series["time"], series["body_1_y"] - 0.2
    assert np.diff(y) / np.diff(t) == pytest.approx((series["body_1_vy"][1:] + series["body_1_vy"][:-1]) / 2, abs=0.02)
    assert (series["body_1_x"] == 0.5).all() and not series["body_1_angle"].any()
    # The fluid adds about its displaced mass: 2 Hz √(2/3).
    crossings = t[1:][np.diff(np.sign(y + 0.02)) != 0]
    assert 1 / (crossings[2] - crossings[0]) == pytest.approx(1.6, rel=0.1)
    assert [*summary["quantities"]] == ["body_1_y", "drag", "lift"]
    main = main_signal({name: series[name] for name in series.dtype.names})
    assert (main.name, main.drive) == ("displacement", None) and np.abs(main.values) == pytest.approx(np.abs(y + 0.2))


def test_walls_across_x_are_walls_across_y_turned(carried):
    """A circle beside the middle of a channel falls or rises alike along the channel."""
    places = []
    for along, across in ("xy", "yx"):
        order = [0, 1] if along == "x" else [1, 0]
        mount = {"mass": 0.05, along: {}, across: {}, "gravity": [[3.0, 0.0][axis] for axis in order]}
        place = [[0.0, 0.05][axis] for axis in order]
        carried["fluid"] |= {
            "box": {"x": [-0.5, 0.5], "y": [-0.5, 0.5], "cells": [40, 40]},
            "channel": {across: [-0.4, 0.4]},
            "initial_velocity": [0.0, 0.0],
            "bodies": [{"shape": {"circle": {"radius": 0.1}}, "position": place, "mount": mount}],
        }
        with Session(validate(carried | {"time": carried["time"] | {"end": 0.1}})) as session:
            session.run()
            series = session.recorder.series
        places.append([series[f"body_1_{axis}"] for axis in (along, across)])
    assert places[0][0][-1] > 2e-3 and abs(places[0][1][-1] - 0.05) < 2e-3
    assert np.array(places[1]) == pytest.approx(np.array(places[0]), abs=1e-9)


def test_a_cylinder_on_a_spring_locks_in():
    """The shipped scene on ten cells a diameter, in a third of the box: there the amplitude is 0.536 at 0.194 Hz. The
    spring has 0.2 Hz, a cylinder at rest would shed at 0.18 to 0.19 Hz. Without damping no power is left over."""
    scene = document(load("viv-384x256"))
    fluid = scene["fluid"]
    scene["time"] = {"end": 60.0, "communication_step": 0.05}
    fluid["box"] = {"x": [-5.0, 11.0], "y": [-4.0, 4.0], "cells": [160, 80]}
    fluid["sponge"]["x"], fluid["disturbance"], fluid["time_stepping"]["max_step"] = [8.0, 11.0], 0.1, 0.05
    with Session(validate(scene)) as session:
        session.run()
        series = session.recorder.series
    time, main = series["time"], main_signal(series)
    window = statistics.find_window(time, main.values)
    found = statistics.evaluate(time, main.values, window)
    assert main.name == "displacement" and window.periods >= 4
    assert found.amplitude == pytest.approx(0.536, rel=0.06) and found.frequency_hz == pytest.approx(0.194, rel=0.06)
    power = flapping_averages.average(time, series["body_1_power"], window)
    in_the_spring = fluid["bodies"][0]["mount"]["y"]["stiffness"] * found.amplitude**2 / 2
    assert abs(power) < 0.005 * in_the_spring * 2 * np.pi * found.frequency_hz


def test_the_master_moves_a_body_and_a_state_has_all_of_it(carried):
    def drive(t, _):
        motion = {"x": 0.1 * np.sin(3 * t), "vx": 0.3 * np.cos(3 * t), "angle": t, "omega": 1.0}
        return {f"body[1].motion.{part}": value for part, value in motion.items()}

    with Session(validate(carried), drive=drive) as session:
        unit = session.units["fluid"]
        assert [name for name in unit.variables if ".motion." in name] == [
            f"body[1].motion.{part}" for part in ("x", "y", "angle", "vx", "vy", "omega")
        ]
        session.start()
        for _ in range(5):
            session.step()
        x, y, angle = (unit.scalars("Real").index(f"body[1].{part}") for part in ("x", "y", "angle"))
        assert unit.reals[[x, y, angle]] == pytest.approx([0.1 * np.sin(3 * session.time), 0.0, session.time])
        unit.save()
        h = session.time / 5
        first = []
        for _ in range(2):
            session.scheme.step(session.time, h)
            first.append(unit.reals.copy())
            unit.restore()
        assert (first[0] == first[1]).all() and first[0].any()
    with pytest.raises(InputError, match=r"leaves body\[1\].motion.x, .* to the master .*, but nothing drives it"):
        Session(validate(carried))


def test_outlines_are_where_the_bodies_are(swinging):
    square = validate(swinging).fluid.bodies[1]
    turned = body_outline(square, 0.5, 0.2, np.pi / 2)
    assert turned == pytest.approx(np.array([[0.5, 0.2], [0.5, 0.4], [0.3, 0.4], [0.3, 0.2]]))
    swinging["fluid"]["bodies"] = [
        {"shape": {"rectangle": {"length": 0.4, "thickness": 0.1, "ends": ends}}, "position": [0, 0], "pivot": [0.1, 0]}
        for ends in ("square", "round")
    ]
    for body in validate(swinging).fluid.bodies:
        corners = body_outline(body, 0.0, 0.0, 0.0)
        assert [*corners.min(0), *corners.max(0)] == pytest.approx([-0.3, -0.05, 0.1, 0.05], abs=1e-3), body


@pytest.mark.pictures
def test_bodies_have_their_force_motion_and_power(swinging, tmp_path):
    swinging["fluid"]["bodies"][0]["motion"]["angle"] = {"sine": {"amplitude": 0.5, "frequency": 1.0}}
    series, summary = run(tmp_path, swinging)
    t = series["time"]
    assert series["body_1_y"] == pytest.approx(0.1 * np.sin(4 * np.pi * t + 0.3), abs=1e-6)
    assert series["body_1_angle"] == pytest.approx(0.5 * np.sin(2 * np.pi * t), abs=1e-6)
    assert series["drag"] == pytest.approx(series["body_1_drag"] + series["body_2_drag"], abs=1e-6)
    velocity, omega = 0.4 * np.pi * np.cos(4 * np.pi * t + 0.3), np.pi * np.cos(2 * np.pi * t)
    power = (series["body_1_drag"] + series["body_1_lift"]) * velocity + series["body_1_moment"] * omega
    assert series["body_1_power"][1:] == pytest.approx(power[1:], rel=1e-5)
    assert (tmp_path / "results" / "vorticity.png").exists() and summary["bodies"]["body_2"]["cp"] is None


def test_an_oscillating_cylinder_has_the_published_coefficients(tmp_path):
    """Dütsch et al. 1998: c_d 2.09, c_i 1.45. With 15 points a diameter the third period has 2.11 and 1.46 here; the
    place of the grid alone moves c_d by 1.7 %."""
    scene = read(flapping.KC5, ["fluid.box.cells=[300, 180]", "time.end=15.0", "time.communication_step=0.01"])
    override(scene, "fluid.time_stepping.max_step=0.01")
    series, summary = run(tmp_path, scene)
    found = flapping.oscillating(series)
    assert found["cd"] == pytest.approx(2.09, rel=0.03), found
    assert found["ci"] == pytest.approx(1.45, rel=0.03), found
    assert np.abs(series["lift"]).max() < 1e-9, "the flow is symmetric"
    # The window of the summary ends a quarter of a period earlier, while the wake is still settling.
    morison = summary["bodies"]["body_1"]["morison"]
    assert (morison["cd"], morison["ci"]) == pytest.approx((found["cd"], found["ci"]), rel=0.05)
    assert summary["bodies"]["body_1"]["kc"] == pytest.approx(5.0)


def test_a_hovering_ellipse_has_the_published_lift(tmp_path):
    """Eldredge 2007: mean lift 0.483 in the fourth period. A box of 10 chords with 24 points a chord gives 0.448 here,
    and the curve 6.0 % of its peak off what was digitised; the rest of the limits is for other places of the grid."""
    scene = read(flapping.HOVER, ["fluid.box.cells=[240, 240]", "fluid.box.x=[-5.0, 5.0]", "fluid.box.y=[-5.0, 5.0]"])
    series, summary = run(tmp_path, scene)
    found = flapping.fourth_period(series)
    assert found["lift"] == pytest.approx(0.483, rel=0.1), found
    assert found["lift_rms"] < 0.08, found
    cycles = summary["bodies"]["body_1"]["cycles"]
    mean = cycles["cl"]["mean"] / flapping.LIFT
    assert mean == pytest.approx(found["lift"], rel=0.1) and cycles["cl"]["scatter"] < 0.1 * cycles["cl"]["mean"]


def test_of_two_disks_that_fall_the_upper_one_drafts_kisses_and_tumbles(tmp_path):
    """The example on half the cells: the lower one is caught, then passed."""
    steps = [f"{key}=4e-4" for key in ("time.communication_step", "fluid.time_stepping.max_step")]
    scene = read(ROOT / "examples" / "drafting-disks.json", ["fluid.box.cells=[52,148]", *steps])
    series, _ = run(tmp_path, document(scene))
    lower, upper = (np.array([series[f"body_{k}_{axis}"] for axis in "xy"]) for k in (1, 2))
    way = upper - lower
    apart = np.linalg.norm(way, axis=0)
    print(apart[0], apart.min(), way[:, -1])
    # The range of contact keeps them a tenth of a diameter apart.
    assert apart[0] > 4.9e-3 and 2.5e-3 < apart.min() < 2.8e-3
    assert abs(way[0, 0]) < 2e-5 and abs(way[0, -1]) > 5e-4


@pytest.mark.parametrize("shape", ["circle", "plate"])
def test_close_bodies_fall_the_same_in_any_order(shape, tmp_path):
    """Their masks share cells, or their markers points, so each is dragged by what the other one moves."""
    shapes = {"circle": [{"circle": {"radius": 0.2}}, {"circle": {"radius": 0.25}}], "plate": [PLATE, PLATE]}[shape]
    places = {"circle": [[0.02, 0.25], [0.0, -0.22]], "plate": [[0.0, 0.06], [0.1, -0.06]]}[shape]

    def fall(order):
        mounts = [
            {"mass": mass, "inertia": 3.0, "gravity": [0.0, -9.81], "x": {}, "y": {}, "angle": {}}
            for mass in (150.0, 250.0)
        ]
        bodies = [{"shape": shapes[k], "position": places[k], "mount": mounts[k]} for k in order]
        series, _ = run(tmp_path, {
            "name": "close",
            "time": {"end": 0.1, "communication_step": 0.01},
            "fluid": {
                "density": 1000.0,
                "kinematic_viscosity": 0.1,
                "box": {"x": [-1.0, 1.0], "y": [-1.0, 1.0], "cells": [32, 32]},
                "mean_flow": {},
                "bodies": bodies,
                "mask": {"log_linear": {"c_eta": 1e-3}},
                "time_stepping": {"max_step": 0.01, "max_cfl": 0.4},
            },
        })  # fmt: skip
        columns = [f"body_{{}}_{name}" for name in ("lift", "moment", "vy", "omega")]
        return np.array([[series[name.format(order.index(k) + 1)] for name in columns] for k in (0, 1)])

    one, other = fall([0, 1]), fall([1, 0])
    off = np.abs(one - other).max(axis=2) / np.abs(one).max(axis=2)
    assert off.max() < 1e-4, off
