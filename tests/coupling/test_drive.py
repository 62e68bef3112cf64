"""A drive sets, step by step, what a scene leaves to the master."""

import math
import runpy
import sys

import numpy as np
import pytest

import nervure
from nervure.coupling import CouplingError, Driver
from nervure.errors import InputError
from nervure.resources import ROOT
from nervure.scene import load, validate
from nervure.simulation import checkpoint
from nervure.simulation.session import Session
from tests import conftest
from tests.coupling.test_master import Fake

EXAMPLES = ROOT / "examples"
PLATE = EXAMPLES / "steered-plate.json"
MOTION = {"sine": {"amplitude": 0.1, "frequency": 1.0, "ramp": 1.0}}


def heave(t, _values):
    """Return `MOTION` along y and its rate."""
    omega, part = 2 * math.pi, math.pi * min(t, 1.0)
    share, growth = (1 - math.cos(part)) / 2, math.pi * math.sin(part) / 2
    rate = share * omega * math.cos(omega * t) + growth * math.sin(omega * t)
    return {"root.y": 0.1 * share * math.sin(omega * t), "root.vy": 0.1 * rate}


def plate(end=1.0, **changes):
    return load(PLATE).copy({"time.end": end, **changes})


def tips(scene, drive=None):
    with Session(scene, drive=drive) as session:
        assert session.run().error is None, session.error
        return session.recorder.series["tip_uy"]


@pytest.mark.parametrize("given", [("root.y", "root.vy"), ("root.y",), ("root.vy",)])
def test_a_drive_moves_a_root_as_the_same_law_does_by_place_or_rate(given, libraries):
    by_law = tips(plate(**{"rod.root_motion": {"laws": {"y": MOTION}}}))
    found = tips(plate(), lambda t, _: {name: heave(t, _)[name] for name in given})
    apart = np.abs(found - by_law).max() / np.abs(by_law).max()
    assert apart < (1e-12 if len(given) == 2 else 0.004), f"{apart:.2e} of the largest displacement"


@pytest.fixture
def driver():
    """Function that makes the driver of a unit with a root, of which it returns values after some steps."""

    def made(drive, steps):
        rod = Fake("rod", ["root.y", "root.vy", "root.angle", "root.omega"], [])
        rod.connect(list(rod.variables), [])
        own, t = Driver({"rod": rod}, drive), 0.0
        for h in steps:
            own.move(t, h, {"time": t})
            t += h
        return own

    return made


def test_the_rate_of_a_place_is_exact_for_a_parabola_after_the_first_step(driver):
    own = driver(lambda t, _: {"root.y": 3 * t * t}, [0.1, 0.1, 0.04])
    assert own["root.vy"] == pytest.approx(6 * 0.24, rel=1e-12)


def test_the_place_of_a_rate_is_exact_for_a_linear_rate(driver):
    own = driver(lambda t, _: {"root.vy": 3 * t}, [0.1, 0.1, 0.04])
    assert own["root.y"] == pytest.approx(1.5 * 0.24**2, rel=1e-12)


def test_what_a_drive_leaves_out_stands_still_where_it_is(driver):
    own = driver(lambda t, _: {"root.y": t, "root.vy": 1.0} if t < 0.25 else {}, [0.1, 0.1, 0.1])
    assert (own["root.y"], own["root.vy"], own["root.angle"]) == (pytest.approx(0.2), 0.0, 0.0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"root.z": 0.1}, "sets 'root.z' for t = 0.1 s, but the scene leaves it root.y, root.vy, root.angle"),
        ({"root.y": math.nan}, "sets root.y to nan for t = 0.1 s, but must set a finite number, in m"),
        ({"root.y": True}, "sets root.y to True for t = 0.1 s, but must set a finite number, in m"),
        ({"root.y": np.False_}, "sets root.y to .*False.* for t = 0.1 s, but must set a finite number, in m"),
        ({"root.y": "up"}, "sets root.y to 'up' for t = 0.1 s, but must set a finite number"),
        ({"root.y": "1"}, "sets root.y to '1' for t = 0.1 s, but must set a finite number"),
        ({"root.y": 10**400}, "sets root.y to 1.*0 for t = 0.1 s, but must set a finite number"),
        ({"root.y": [0.1, 0.2]}, "sets root.y to .* but must set a finite number"),
        ([0.1], "returned .* for t = 0.1 s, but must return a dictionary"),
        (None, "returned None for t = 0.1 s"),
    ],
)
def test_what_a_drive_must_not_give_is_named_with_its_time(driver, given, words):
    with pytest.raises(CouplingError, match=words):
        driver(lambda _t, _values: given, [0.1])


def test_a_drive_that_exits_has_failed(driver):
    """The run ended without a word and with the drive's own exit status."""
    with pytest.raises(CouplingError, match="the drive failed for t = 0.1 s: SystemExit: 3"):
        driver(lambda _t, _values: sys.exit(3), [0.1])


def test_an_exception_in_a_drive_ends_the_run_with_its_place_and_time(libraries, tmp_path):
    def drive(t, values):
        return {"root.y": 0.0 if t < 0.025 else values["tip_uz"]}

    with pytest.raises(nervure.RunError, match=r"for t = 0.03 s: KeyError: .*did you mean.*test_drive.py") as failed:
        nervure.run(plate(), tmp_path / "run", drive=drive, quiet=True)
    assert failed.value.run.summary.steps == 2


def test_a_drive_sees_the_last_row_of_the_series_also_where_it_is_not_recorded(libraries):
    def seen(**options):
        rows = []

        def drive(t, values):
            rows.append([t, values["time"], values["tip_uy"], values["lift"]])
            return heave(t, values)

        with Session(plate(0.1), drive=drive, **options) as session:
            session.run()
        return np.array(rows), session.recorder.series

    every, series = seen()
    some, _ = seen(series_every=0.05)
    assert (every == some).all()
    assert every[:, 0] == pytest.approx(series["time"][1:]) and every[:, 1] == pytest.approx(series["time"][:-1])
    assert (every[:, 2:] == np.stack([series[name] for name in ("tip_uy", "lift")], axis=1)[:-1]).all()


def pid():
    return runpy.run_path(str(EXAMPLES / "drive_pid.py"))["Pid"]()


def policy():
    return runpy.run_path(str(EXAMPLES / "drive_policy.py"))["drive"]


@pytest.mark.parametrize("make", [pid, policy])
def test_a_driven_run_goes_on_from_its_checkpoint_with_the_memory_of_its_drive(libraries, tmp_path, make):
    with Session(plate(0.2), drive=make()) as whole:
        whole.run()
    with Session(plate(0.2), tmp_path, drive=make()) as part:
        part.start()
        for _ in range(12):
            part.step()
        checkpoint.Checkpoint(part, dict.fromkeys(checkpoint.OPTIONS)).save()
    with Session(plate(0.2), drive=make()) as rest:
        checkpoint.restore(rest, checkpoint.read(tmp_path))
        rest.run()
    assert (rest.recorder.table[: rest.recorder.rows] == whole.recorder.table).all()


def test_the_memory_of_another_drive_is_refused(driver):
    """It was lost, or the checkpoint was called damaged."""

    class Own:
        def __call__(self, _t, _values):
            return {}

        def state(self):
            return {"sum": 1.0}

        def restore(self, state):
            self.sum = state["sum"]

    own, none = driver(Own(), []), driver(lambda _t, _values: {}, [])
    with pytest.raises(InputError, match="had a drive with a state, but this one has no `restore`"):
        none.remember(own.memory())
    with pytest.raises(InputError, match="cannot restore its state None: TypeError"):
        own.remember(none.memory())


def test_a_state_that_no_checkpoint_holds_is_refused_before_the_run(driver):
    class Odd:
        def __call__(self, _t, _values):
            return {}

        def state(self):
            return {1, 2}

    with pytest.raises(InputError, match="has only one of `state` and `restore`"):
        driver(Odd(), [])
    Odd.restore = lambda _self, _state: None
    with pytest.raises(InputError, match="must hold numbers, texts, lists and dictionaries only"):
        driver(Odd(), [])
    Odd.state = lambda self: self.total
    with pytest.raises(InputError, match=r"cannot give its state: AttributeError: .*'total' \(test_drive.py, line"):
        driver(Odd(), [])


def test_a_drive_for_a_scene_that_leaves_nothing_open_is_refused(libraries, rod_only):
    with pytest.raises(InputError, match='leaves nothing to it: root_motion or .* must be "master"'):
        Session(validate(rod_only), drive=heave)


def test_a_wing_that_nothing_drives_is_refused_by_its_key(libraries):
    mesh = {"rectangular": {"length": 0.2, "width": 0.1, "along": 2}}
    membrane = {"areal_density": 1.0, "stretching_stiffness": 100.0, "bending_stiffness": 0.1}
    wing = {"mesh": mesh, "membrane": membrane, "root": "root", "root_motion": "master"}
    scene = {"name": "w", "time": {"end": 0.1, "communication_step": 0.01}, "wing": wing}
    with pytest.raises(InputError, match=r"leaves root.x, .* to the master \(root_motion\)"):
        Session(validate(scene))


def test_a_drive_that_turns_a_wing_hears_that_a_hinge_does(libraries):
    mesh = {"rectangular": {"length": 0.2, "width": 0.1, "along": 2}}
    membrane = {"areal_density": 1.0, "stretching_stiffness": 100.0, "bending_stiffness": 0.1}
    wing = {"mesh": mesh, "membrane": membrane, "root": "root", "root_motion": "master"}
    scene = {"name": "w", "time": {"end": 0.1, "communication_step": 0.01}, "wing": wing}
    with Session(validate(scene), drive=lambda t, _: {"root.angle": t}) as session:
        session.start()
        with pytest.raises(CouplingError, match="leaves it root.x.*; at a hinge of a `flyer` it turns a wing, too"):
            session.step()


CIRCLE = {
    "density": 1.0,
    "kinematic_viscosity": 0.05,
    "box": {"x": [-2.0, 2.0], "y": [-2.0, 2.0], "cells": [32, 32]},
    "initial_velocity": [1.0, 0.0],
    "bodies": [{"shape": {"circle": {"radius": 0.3}}, "position": [0.0, 0.0]}],
    "time_stepping": {"max_step": 0.01, "max_cfl": 0.4},
    "mask": {"log_linear": {"c_eta": 1e-3}},
}
STREAM = {
    "mean": {"mean_flow": {"x": {"constant": 1.0}}},
    "inflow": {"inflow": {"x": [-1.9, -1.5], "profile": "uniform", "mean_velocity": {"constant": 1.0}, "c_eta": 1e-3}},
    "fine box": {"mean_flow": {"x": {"constant": 1.0}}, "fine_box": {"x": [-1.25, 1.25], "y": [-1.25, 1.25]}},
}


@pytest.mark.parametrize("stream", STREAM)
def test_a_gust_by_a_drive_blows_as_the_same_law_of_the_stream(stream, libraries):
    """Under a gust the coarse grid takes fine steps, which changes the start of the flow."""
    fluid = CIRCLE | STREAM[stream]
    scene = {"name": "gust", "time": {"end": 0.5, "communication_step": 0.01}, "fluid": fluid}
    key = "fluid.inflow.mean_velocity" if stream == "inflow" else "fluid.mean_flow.x"
    drags = []
    for law in ({"sum": [{"constant": 1.0}, MOTION]}, {"constant": 1.0}):
        drive = None if "sum" in law else lambda t, _: {"gust.x": heave(t, _)["root.y"]}
        own = validate(scene).copy({key: law} | ({"fluid.gust": "master"} if drive else {}))
        with Session(own, drive=drive) as session:
            assert session.run().error is None, session.error
            drags.append(session.recorder.series["drag"])
    by_law, driven = drags
    assert np.ptp(by_law[20:]) > 0.1 * np.abs(by_law[20:]).mean()
    begin, most = (30, 5e-3) if stream == "fine box" else (0, 1e-9)
    apart = np.abs(driven - by_law)[begin:].max() / np.ptp(by_law[20:])
    assert apart < most, f"{apart:.1e} of the change of the drag"


def driven_by_gust(step: float, law: dict | None = None) -> nervure.Scene:
    """Return a stream past a circle whose fluid makes steps of 5 ms, with a law added or with a gust."""
    mean = {"sum": [{"constant": 1.0}, law]} if law else {"constant": 1.0}
    fluid = CIRCLE | {"mean_flow": {"x": mean}, "time_stepping": {"max_step": 0.005, "max_cfl": 0.4}}
    fluid |= {} if law else {"gust": "master"}
    return validate({"name": "gust", "time": {"end": 0.3, "communication_step": step}, "fluid": fluid})


def test_a_gust_is_linear_over_the_steps_of_the_fluid(libraries):
    """A gust that rises evenly blows as its law, however often the fluid divides a communication step."""
    ramp = {"table": {"times": [0.0, 10.0], "values": [0.0, 20.0]}}
    for step in (0.005, 0.02):
        drags = []
        for law in (ramp, None):
            drive = None if law else lambda t, _: {"gust.x": 2.0 * t}
            with Session(driven_by_gust(step, law), drive=drive) as session:
                assert session.run().error is None, session.error
                drags.append(session.recorder.series["drag"])
        assert np.abs(drags[1] - drags[0]).max() < 1e-9 * np.ptp(drags[0])


def test_a_fluid_under_a_gust_goes_back_and_on_in_another_instance(instantiate):
    first, second = (instantiate(driven_by_gust(0.02).document())["fluid"] for _ in range(2))

    def shown(unit, begin):
        for k in range(begin, begin + 3):
            unit.inputs[:] = 0.7 + 0.3 * k
            unit.step(k * 0.02, 0.02)
        unit.get()
        return unit.outputs.copy()

    for unit in (first, second):
        unit.connect(["gust.x"], ["drag", "kinetic_energy"])
        unit.start()
    conftest.goes_back_and_on(first, second, shown, 3)


def test_a_scene_is_inspected_with_what_it_leaves_open_at_rest(libraries):
    done = conftest.nervure("inspect", PLATE)
    assert done.returncode == 0 and "wall time" in done.stdout, done.stderr


@pytest.mark.parametrize("name", ["pid", "table", "policy"])
def test_the_example_of_a_drive_runs_as_its_text_says(libraries, tmp_path, name):
    file = EXAMPLES / f"drive_{name}.py"
    done = conftest.nervure("run", PLATE, "--drive", file, "--set", "time.end=0.5", "--output", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    assert f"nervure run examples/steered-plate.json --drive examples/drive_{name}.py" in file.read_text("utf-8")
    assert abs(nervure.read(tmp_path / "run").series["tip_uy"][-1]) > 1e-3


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "does not exist, but must be a Python file"),
        ("def law(t, values):\n    return {}\n", "has no function `drive(time, values)`, but law"),
        ("drive = 1.0\n", "own.py has no function `drive(time, values)`"),
        ("def drive(t, values)\n", "cannot be used: SyntaxError"),
        ("import sys\nsys.exit(3)\n", "cannot be used: SystemExit: 3"),
        ("import csv\nopen('absent.csv')\n", "cannot be used: FileNotFoundError"),
    ],
)
def test_a_file_that_is_no_drive_is_refused_with_the_reason(tmp_path, content, words):
    file = tmp_path / "own.py"
    if content is not None:
        file.write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as refused:
        nervure.coupling.read_drive(file)
    assert words in str(refused.value)
