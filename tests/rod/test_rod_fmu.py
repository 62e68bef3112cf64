"""The rod's FMU beyond its stations: derivatives, root motion, energies, what it logs and refuses."""

import copy

import numpy as np
import pytest
from fmpy import extract

from nervure.errors import UnitError
from tests.conftest import output
from tests.slaves import FMU2Unpacked

H = 1e-3
STATIONS = 17


@pytest.fixture
def spatial(rod_only):
    """The same rod in space, pulled down along z."""
    rod_only = copy.deepcopy(rod_only)
    rod_only["name"] = "spatial-rod"
    rod_only["beam"]["root"]["at"] = {"position": [0.0, 0.0, 0.0], "direction": [1.0, 0.0, 0.0]}
    rod_only["rod"]["gravity"] = [0.0, 0.0, -2.0]
    return rod_only


@pytest.fixture
def rod(instantiate):
    """Function that makes the rod of a scene, initialised, with these inputs and outputs connected."""

    def make(scene, inputs=(), outputs=()):
        scene["time"]["end"] = 10.0
        unit = instantiate(scene)["rod"]
        unit.connect(list(inputs), list(outputs))
        unit.set()
        unit.start()
        unit.get()
        return unit

    return make


def run(unit, steps, h=H, start=0.0):
    for k in range(steps):
        unit.step(start + k * h, h)
    return start + steps * h


def references(unit, names):
    return [reference for name in names for reference in unit.variables[name].references]


def test_derivatives_are_neither_claimed_nor_given(rod_only, rod):
    unit = rod(rod_only)
    about = unit.description.coSimulation
    assert not about.providesDirectionalDerivative and about.maxOutputDerivativeOrder == 0
    run(unit, 1)
    tip, force = references(unit, ["tip.uy"]), references(unit, ["force_y"])[:1]
    with pytest.raises(Exception, match="fmi2GetDirectionalDerivative"):
        unit.fmu.getDirectionalDerivative(tip, force, [1.0])


def test_outputs_follow_what_is_set_in_initialization_mode(rod_only, instantiate):
    rod_only["rod"]["root_motion"] = "master"
    unit = instantiate(rod_only)["rod"]
    for offset in (0.0, 0.01, -0.02):
        start = np.array(unit.fmu.getReal(references(unit, ["x", "y"])))
        root = references(unit, ["root.y"])
        unit.fmu.setReal(root, [unit.fmu.getReal(root)[0] + offset])
        moved = np.array(unit.fmu.getReal(references(unit, ["x", "y"]))) - start
        assert moved == pytest.approx(np.repeat([0.0, offset], STATIONS), abs=1e-15)


def test_energy_moves_between_its_forms(rod_only, rod):
    unit = rod(rod_only)
    names = ["energy.elastic", "energy.kinetic", "energy.gravity"]
    sums, gravity = [], []
    for k in range(500):
        unit.step(k * H, H)
        values = [output(unit, name)[0] for name in names]
        sums.append(sum(values))
        gravity.append(values[2])
    assert max(map(abs, sums)) < 1e-3 * max(map(abs, gravity))
    assert min(gravity) < -0.1


def test_laws_of_the_scene_move_the_root(rod_only, rod):
    heave = {"sine": {"amplitude": 0.01, "frequency": 2.0, "ramp": 0.1}}
    pitch = {"sine": {"amplitude": 0.3, "frequency": 2.0, "ramp": 0.1}}
    rod_only["rod"]["root_motion"] = {"laws": {"y": heave, "rotations": [{"angle": pitch}]}}
    unit = rod(rod_only, outputs=["x", "y", "vx", "vy"])
    time = run(unit, 300)
    sin, cos = np.sin(4 * np.pi * time), np.cos(4 * np.pi * time)
    assert output(unit, "y")[0] == pytest.approx(0.01 * sin, abs=1e-9)
    assert output(unit, "vy")[0] == pytest.approx(0.04 * np.pi * cos, abs=1e-9)
    assert output(unit, "x")[0] == 0.0
    assert "root.y" not in unit.variables
    swing = output(unit, "y")[-1] - output(unit, "y")[0]
    assert abs(swing) > 0.005


@pytest.mark.parametrize("dimension", [2, 3])
def test_master_that_drives_the_root_gets_what_the_laws_give(rod_only, spatial, rod, dimension):
    scene = rod_only if dimension == 2 else spatial
    law = {"sine": {"amplitude": 0.3, "frequency": 2.0, "ramp": 0.1}}
    scene["rod"]["root_motion"] = {"laws": {"y": law, "rotations": [{"angle": law}]}}
    by_law = rod(scene, outputs=["x", "y"])
    scene["rod"]["root_motion"] = "master"
    scene["name"] += "-driven"
    inputs = ["root.y", "root.vy"]
    inputs += (
        ["root.angle", "root.omega"]
        if dimension == 2
        else [f"root.{what}.{axis}" for what in ("direction", "direction_rate") for axis in "xy"]
    )
    driven = rod(scene, inputs, ["x", "y"])
    for k in range(200):
        t = (k + 1) * H
        share = 0.5 * (1 - np.cos(np.pi * min(t / 0.1, 1.0)))
        rate = 0.5 * np.pi / 0.1 * np.sin(np.pi * min(t / 0.1, 1.0))
        omega = 4 * np.pi
        value = 0.3 * share * np.sin(omega * t)
        speed = 0.3 * (share * omega * np.cos(omega * t) + rate * np.sin(omega * t))
        turn = (
            [value, speed]
            if dimension == 2
            else [np.cos(value), np.sin(value), -speed * np.sin(value), speed * np.cos(value)]
        )
        driven.inputs[:] = [value, speed, *turn]
        driven.step(k * H, H)
        by_law.step(k * H, H)
    assert driven.exchanged == pytest.approx(by_law.exchanged, abs=1e-9)
    assert abs(output(by_law, "y")[-1]) > 0.02


def test_state_of_a_moving_rod_comes_back_bit_by_bit(rod_only, rod):
    law = {"sine": {"amplitude": 0.3, "frequency": 2.0, "ramp": 0.1}}
    rod_only["rod"]["root_motion"] = {"laws": {"rotations": [{"angle": law}]}}
    unit = rod(rod_only, outputs=["x", "y"])
    time = run(unit, 50)
    unit.save()
    run(unit, 50, start=time)
    expected = unit.exchanged.copy()
    unit.restore()
    run(unit, 50, start=time)
    assert np.array_equal(unit.exchanged, expected)


def test_still_root_has_no_variables(rod_only, rod):
    assert not [name for name in rod(rod_only).variables if name.startswith("root.")]


def test_error_of_a_step_tells_the_time(rod_only, rod):
    unit = rod(rod_only, ["force_x"])
    time = run(unit, 3)
    unit.inputs[:] = 1e300
    with pytest.raises(UnitError, match=r"Newton's method stopped at a residual of .* in the step from t = 0\.003"):
        unit.step(time, H)


def test_thesis_bending_ends_with_its_singularity(spatial, rod):
    spatial["rod"]["bending"] = "projected"
    unit = rod(spatial, ["force_z"])
    unit.inputs[-1] = 100.0
    with pytest.raises(UnitError, match=r"plane xy is singular .* in the step from t = 0\.\d+ s"):
        run(unit, 2000)


def test_rescued_steps_are_counted_and_logged(rod_only, packed, tmp_path):
    """A blow that plain Newton cannot take in one step. The logger is without fmpy's proxy, of which there is one in
    the process: the unit's messages come formatted."""
    fmu = FMU2Unpacked(extract(str(packed("rod", rod_only)), str(tmp_path)))
    names = {variable.name: variable.valueReference for variable in fmu.variables}
    fmu.instantiate(callbacks=fmu.log)
    fmu.setDebugLogging(True, ["logEvents"])
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    tip = names[f"force_x[{STATIONS}]"]
    fmu.setReal([tip, names[f"force_y[{STATIONS}]"]], [-1e4, 100.0])
    for k in range(20):
        fmu.doStep(0.1 * k, 0.1)
        iterations, rescues = fmu.getInteger([names["newton.iterations"], names["newton.rescues"]])
        if rescues > 0:
            break
    fmu.freeInstance()
    assert rescues > 0 and iterations > 15
    assert [message for message in fmu.messages if "needed shift and line search" in message]


def test_a_solid_moved_by_a_law_pushes_the_rod_and_stays_outside(rod_only, rod):
    """A cylinder moves up by half a metre a second through the tip; without the key there is no contact and no variable
    of it."""
    rod_only["beam"] |= {"root": {"at": {"position": [0.0, 0.0], "direction": [1.0, 0.0]}}, "length": 1.0}
    section = {"line_density": 1.0, "bending_stiffness": 0.1, "axial_stiffness": 1e3}
    rod_only["rod"], rod_only["time"]["communication_step"] = {"material": {"section": section}}, H
    up = {"table": {"times": [0.0, 0.2], "values": [0.0, 0.1], "end_slopes": [0.5, 0.5]}}
    pushing = {"shape": {"circle": {"radius": 0.1}}, "position": [0.9, -0.14], "motion": {"y": up}}
    ends, names = [], []
    for contact in ({"contact": {"obstacles": [pushing]}}, {}):
        unit = rod(copy.deepcopy(rod_only) | contact, outputs=["x", "y"])
        run(unit, 200)
        unit.get()
        ends.append([output(unit, "x").copy(), output(unit, "y").copy()])
        names.append(set(unit.variables))
    x, y = ends[0]
    assert np.hypot(x - 0.9, y + 0.04).min() > 0.1 and y[-1] > 0.05
    assert (ends[1][1] == 0.0).all()
    assert names[0] - names[1] == {"energy.contact"}
