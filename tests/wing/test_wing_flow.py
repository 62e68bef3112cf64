"""A wing in a fluid of three dimensions: one exchange a step, its energies, and a run that is resumed."""

import numpy as np
import pytest
from rich.console import Console

import nervure
from nervure.coupling import Explicit
from nervure.errors import UnitError
from nervure.output.tables import print_table
from nervure.scene import validate
from nervure.simulation import checkpoint
from nervure.simulation.session import Session
from studies import simulate, wing as wing_study

pytestmark = pytest.mark.usefixtures("libraries")

STEP = 0.02
SCENE = {
    "name": "heaving-wing",
    "time": {"end": 0.8, "communication_step": STEP},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 0.02,
        "box": {"x": [-1.5, 2.5], "y": [-2.0, 2.0], "z": [-2.0, 2.0], "cells": [32, 32, 32]},
        "mask": {"log_linear": {"c_eta": 1e-3}},
        "time_stepping": {"max_step": STEP, "max_cfl": 0.4},
    },
    "wing": {
        "mesh": {"rectangular": {"length": 1.0, "width": 1.0, "along": 4}},
        "membrane": {"areal_density": 0.5, "stretching_stiffness": 200.0, "bending_stiffness": 0.5},
        "root": "root",
        "root_motion": {"z": {"sine": {"amplitude": 0.2, "frequency": 0.5, "ramp": 0.6}}},
    },
}


def scene(**wing):
    """The scene with other keys of the wing, as JSON."""
    return SCENE | {"wing": SCENE["wing"] | wing}


@pytest.fixture(scope="module")
def run(tmp_path_factory, libraries):
    return nervure.run(validate(SCENE), tmp_path_factory.mktemp("flow") / "run", quiet=True)


def test_the_scheme_is_explicit_with_the_momentum_load(libraries):
    with Session(validate(SCENE)) as session:
        assert type(session.scheme) is Explicit and list(session.units) == ["wing", "fluid"]
        assert session.scheme.choice.load == "momentum"
        assert session.scheme.guards[0].power_from_fluid > 0


def test_the_works_of_wing_and_fluid_are_one(run):
    """What the loads do to the wing is what the fluid did to its nodes, and the drive pays for it."""
    series, found = run.series, run.summary.interface
    print(found, series["root_work"][-1])
    assert run.summary.completed and found.exchanged > 0.05
    assert found.imbalance == pytest.approx(0.0, abs=0.03)
    held = series["energy_elastic"] + series["energy_kinetic"]
    given = series["root_work"][-1] + series["load_work"][-1]
    assert series["root_work"][-1] > 0.05 > -0.05 > series["load_work"][-1]
    assert held[-1] - held[0] == pytest.approx(given, abs=0.06 * series["root_work"][-1])
    assert run.summary.wing.load_power < 0.0
    assert run.summary.wing.root_power > 0.0


HANGING = {"gravity": [0.0, 0.0, -1.0], "root_motion": None}


@pytest.mark.parametrize("own", [{}, HANGING], ids=["driven", "hanging"])
def test_the_loads_hold_where_the_cfl_number_divides_the_step(own, tmp_path):
    """In four to twelve exchanges a step the works of wing and fluid are one, and the wing moves as ever."""
    whole = scene(**own)
    whole["wing"] = {key: value for key, value in whole["wing"].items() if value is not None}
    whole["time"] = SCENE["time"] | {"end": 0.4}
    ends = []
    for cfl in (0.4, 0.02):
        whole["fluid"] = SCENE["fluid"] | {"time_stepping": {"max_step": STEP, "max_cfl": cfl}}
        found = nervure.run(validate(whole), tmp_path, force=True, quiet=True)
        ends.append(found.series["tip_uz"][-1])
        works = [found.series[name][-1] for name in ("load_work", "wing_work")]
        assert works[0] == pytest.approx(works[1], rel=0.03), (cfl, works)
    assert found.series["iterations"].max() >= 4
    assert ends[1] == pytest.approx(ends[0], rel=0.05), ends


def test_a_fluid_in_space_refuses_a_step_in_which_its_loads_do_not_hold(libraries):
    """It says which step it takes, and takes that from the state before."""
    slow = SCENE["fluid"] | {"initial_velocity": [1.0, 0.0, 0.0]}
    slow |= {"time_stepping": {"max_step": STEP, "max_cfl": 0.1}}
    with Session(validate(SCENE | {"fluid": slow})) as session:
        session.start()
        fluid = session.units["fluid"]
        longest = fluid.read("longest_step").item()
        fluid.save()
        assert longest == pytest.approx(0.1 * 4.0 / 32, rel=0.2)
        with pytest.raises(
            UnitError, match="loads hold for one step.*make the communication step no longer than.*`lon"
        ):
            fluid.step(0.0, STEP)
        fluid.restore()
        fluid.step(0.0, longest)


def test_a_run_with_a_divided_step_resumes(tmp_path):
    whole = scene()
    whole["fluid"] = SCENE["fluid"] | {"time_stepping": {"max_step": STEP, "max_cfl": 0.05}}
    ends = []
    for halves in ((0.2,), (0.1, 0.2)):
        whole["time"] = SCENE["time"] | {"end": halves[0]}
        found = nervure.run(validate(whole), tmp_path, force=True, quiet=True, checkpoint_every=100.0)
        for end in halves[1:]:
            found = nervure.resume(tmp_path, end_time=end, quiet=True)
        ends.append(found.series)
    assert ends[0]["iterations"].max() > 1
    for name, column in ends[0].items():
        # The last step of the half is longer by rounding.
        assert np.allclose(column, ends[1][name], rtol=1e-6, atol=1e-9), (name, column, ends[1][name])


def test_a_stiffer_wing_follows_its_root_and_a_light_one_runs(run, tmp_path):
    """A membrane of a hundredth of the fluid that moves with it needs no shorter step and no iteration."""
    stiff, light = (
        nervure.run(validate(scene(membrane=SCENE["wing"]["membrane"] | changed)), tmp_path, force=True, quiet=True)
        for changed in ({"bending_stiffness": 50.0}, {"areal_density": 1.6e-3})
    )
    tips = [float(np.abs(own.series["tip_uz"] - stiff.series["tip_uz"]).max()) for own in (run, light)]
    print(tips)
    assert abs(stiff.series["tip_uz"]).max() < 0.22 and min(tips) > 0.1
    assert stiff.summary.interface.imbalance == pytest.approx(0.0, abs=0.002)
    assert light.summary.completed
    assert light.summary.interface.imbalance == pytest.approx(0.0, abs=0.03)


def test_a_resumed_run_has_the_bits_of_a_whole_one(run, tmp_path):
    half = nervure.run(validate(SCENE), tmp_path / "half", quiet=True, on_step=lambda time, _: time > 0.6)
    assert not half.summary.completed
    session, _ = checkpoint.resume(half.folder)
    with session:
        session.run()
        rest = session.finish()
    assert [name for name in run.series if not np.array_equal(run.series[name], rest.series[name])] == []


def test_a_wing_that_is_too_fast_for_the_step_exchanges_more_often(tmp_path):
    """The load holds for one step of the fluid, which divides a step in which the wing passes more than 0.4 cells."""
    laws = {"z": {"sine": {"amplitude": 1.0, "frequency": 0.5, "ramp": 0.5}}}
    with Session(validate(scene(root_motion=laws) | {"time": {"end": 1.0, "communication_step": STEP}})) as session:
        assert session.run().error is None and session.recorder.series["iterations"].max() > 1
        assert not [text for text in session.warnings if "power" in text], session.warnings


def test_the_forces_of_a_wing_approach_those_of_a_stiff_one(tmp_path):
    """The difference falls as the compliance, and is within 1 % where the wing bends little; the forces of the stiffest
    wing are those of a rigid body."""
    stiffest = wing_study.forces(wing_study.heaving(1e5, 32), "wing", tmp_path)
    rigid = wing_study.forces(wing_study.rigid(wing_study.heaving(1e5, 32)), "body_1", tmp_path)
    off, size = (float((forces**2).sum()) ** 0.5 for forces in (stiffest - rigid, rigid))
    assert off < 0.01 * size, f"{off} N beside {size} N"
    found = {d: wing_study.differences(wing_study.heaving(d, 32), tmp_path, stiffest)["mean"] for d in (500.0, 5000.0)}
    assert found[5000.0] < 0.01, found
    assert found[500.0] / found[5000.0] == pytest.approx(10.0, abs=3.0), found


def test_a_short_run_tells_of_lost_work(tmp_path):
    """In a step that the fluid divides by three, a film gets a fifth of the work that the fluid gives."""
    scene = wing_study.square("film", 1e-3, 0.05, stream=True)
    scene["time"]["end"] = 2.5
    with simulate.session(scene, tmp_path) as session:
        assert session.run().error is None
        assert any("the power on the wing and the power from the fluid differ" in said for said in session.warnings)


def test_a_driven_wing_has_the_table_of_a_flapping_rod(tmp_path):
    """Three periods, of which the ramp is left out."""
    heaves = scene(root_motion={"z": {"sine": {"amplitude": 0.1, "frequency": 2.5, "ramp": 0.4}}})
    heaves["time"] = {"end": 1.2, "communication_step": STEP}
    heaves["fluid"] = heaves["fluid"] | {"box": heaves["fluid"]["box"] | {"cells": [16, 16, 16]}}
    done = nervure.run(validate(heaves), tmp_path, quiet=True)
    found, body, numbers = done.summary.flapping, done.summary.bodies["wing"], done.summary.dimensionless
    assert done.summary.window_s == pytest.approx((0.4, 1.2)) and done.summary.periods == 2
    inside = done.series["time"] >= 0.4 - 1e-9
    mean = {
        name: np.trapezoid(values[inside], done.series["time"][inside]) / 0.8
        for name, values in done.series.items()
        if name in ("root_power", "wing_drag", "wing_lift", "wing_side")
    }
    expected = (mean["root_power"], -mean["wing_drag"], mean["wing_side"], -mean["wing_lift"])
    assert (found.power_in, found.thrust, found.lift, found.side) == pytest.approx(expected, rel=1e-9), found
    assert found.axis == "z" and found.thrust_by_power == pytest.approx(found.thrust / found.power_in)
    speed = 0.1 * 2 * np.pi * 2.5
    assert (numbers.velocity, numbers.reynolds) == pytest.approx((speed, speed / 0.02))
    assert numbers.reduced_frequency == pytest.approx(np.pi * 2.5 / speed)
    assert body.cp == pytest.approx(2 * found.power_in / speed**3), "of 1 m²"
    assert {"section_twist", "section_camber", "side"} <= done.summary.quantities.keys()
    with (console := Console(width=200)).capture() as shown:
        print_table(console, done.summary, done.scene)
    parts = "side mean [N]", "thrust, cycle mean [N]", "section_twist", "work on the wing"
    for part in (*parts, "A 1 m², drag along x, lift along z"):
        assert part in shown.get(), shown.get()
