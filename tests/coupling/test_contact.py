"""Rods and wings in a fluid that touch walls and each other: the scenes of `examples` on coarse grids."""

import numpy as np
import pytest

import nervure
from nervure.resources import ROOT
from nervure.scene import Scene, validate
from nervure.simulation.session import Session
from studies import mixed

pytestmark = pytest.mark.usefixtures("libraries")


def example(name: str, changes: dict) -> Scene:
    return nervure.load(ROOT / "examples" / f"{name}.json").copy(changes)


def test_a_flag_that_is_pressed_against_the_wall_stays_outside_and_leaves(tmp_path):
    """It is pressed for half a second, first by its middle and then by its tip."""
    flag = example("flag-wall", {"fluid.box.cells": [240, 54], "time.end": 0.9})
    low, energy, load, powers = [], [], [], []
    with Session(flag, tmp_path) as session:
        session.start()
        rod, fluid = session.units["rod"], session.units["fluid"]
        on_rod = rod.scalars_reader(["energy.contact", "load.y", "load.power"])
        from_fluid = fluid.scalars_reader(["beam.power"])
        for _ in range(session.grid.steps):
            session.step()
            low.append(rod.read("y").min())
            *numbers, power = on_rod()
            energy.append(numbers[0])
            load.append(numbers[1])
            powers.append([power, *from_fluid()])
    touching, on_rod_and_fluid = np.array(energy) > 0.0, np.array(powers)
    off = np.abs(np.diff(on_rod_and_fluid)).sum() / np.abs(on_rod_and_fluid).sum()
    jumps = np.abs(np.diff(load, 2))
    # Half the thickness is 0.01 m.
    assert min(low) > 0.01, f"the axis comes to {min(low)} m from the wall"
    assert touching.sum() > 400 and not touching[-30:].any(), "it does not touch, or does not leave"
    assert off < 1e-3, f"the powers differ by {off}"
    # The load reaches 400 N/m.
    assert jumps.max() < 20.0, f"the load jumps by {jumps.max()} N/m"


def test_two_wings_that_clap_and_fling_stay_apart_and_are_mirror_images(tmp_path):
    """Without contact they pass 0.08 mm through the plane between them, with it they stay 0.09 mm in front of it."""
    wings = example("wings-clap", {"time.end": 0.0032})
    mirror, closest, off, stored, loads, powers = np.array([[-1.0], [1.0], [1.0]]), [], 0.0, [], [], []
    energies = ["energy.elastic", "energy.kinetic", "energy.contact"]
    with Session(wings, tmp_path) as session:
        session.start()
        left, right, fluid = (session.units[name] for name in ("left", "right", "fluid"))
        read = left.scalars_reader(["root.work", "load.work", *energies])
        load_of = [wing.scalars_reader(["load.x", "load.y", "load.z"]) for wing in (left, right)]
        power_of = left.scalars_reader(["load.power"]), fluid.scalars_reader(["wing[1].power"])
        for _ in range(session.grid.steps):
            session.step()
            one, other = (np.array([wing.read(axis) for axis in "xyz"]) for wing in (left, right))
            closest.append(one[0].min())
            off = max(off, np.abs(mirror * one - other).max())
            root, load, *energy = read()
            stored.append(root + load - sum(energy))
            loads.append([own().copy() for own in load_of])
            powers.append([own().item() for own in power_of])
        assert not session.warnings
    both, power = np.array(loads), np.array(powers)
    largest = np.abs(both).max()
    uneven = np.abs(both[:, 0] * mirror[:, 0] - both[:, 1]).max() / largest
    differ = np.abs(np.diff(power)).sum() / np.abs(power).sum()
    jumps = np.abs(np.diff(both[:, 0, 0], 2)).max() / largest
    assert 5e-5 < min(closest) < 1.2e-4 and closest[-1] > 2.5e-4, f"{min(closest)} m, at the end {closest[-1]} m"
    assert off < 1e-9 * 2.5e-3 and uneven < 1e-9, f"the wings differ by {off} m, their loads by {uneven}"
    # Works of root and load pay for all energy: a wing stores up to 1e-8 J.
    assert min(stored) > -1e-12 and stored[-1] > 1e-9
    assert differ < 0.01 and jumps < 0.05, f"powers differ by {differ}, the load jumps by {jumps}"


@pytest.mark.parametrize(("pull", "end"), [(20.0, 0.1), (100.0, 0.06)])
def test_edges_of_two_wings_that_cross_between_their_points_stay_apart(pull, end, tmp_path):
    """They meet at right angles with 3 and 7 m/s, where both are farthest from the points by which they touch."""
    upper = [[x, 0.0, z] for z in (0.06, 0.16) for x in (-0.075, 0.075)]
    lower = [[0.0, y, z] for z in (-0.06, -0.16) for y in (-0.075, 0.075)]
    membrane = {"areal_density": 2.0, "stretching_stiffness": 1e4, "bending_stiffness": 1.0, "poisson_ratio": 0.3}

    def wing(nodes: list, sign: float) -> dict:
        mesh = {"triangles": {"nodes": nodes, "triangles": [[0, 1, 3], [0, 3, 2]]}}
        return {"mesh": mesh, "membrane": membrane, "gravity": [0.0, 0.0, sign * pull], "scheme": "bdf2"}

    scene = {
        "name": "edges",
        "time": {"end": end, "communication_step": 1e-3},
        "contact": {"range": 0.06},
        "fluid": {
            "density": 1e-4,
            "kinematic_viscosity": 1e-2,
            "box": {axis: [-0.6, 0.6] for axis in "xyz"} | {"cells": [8] * 3},
            "mask": {"log_linear": {"c_eta": 1e-3}},
            "time_stepping": {"max_step": 1e-3, "max_cfl": 0.4},
        },
        "wings": [{"name": "upper", "wing": wing(upper, -1.0)}, {"name": "lower", "wing": wing(lower, 1.0)}],
    }
    apart = []
    with Session(validate(scene), tmp_path) as session:
        session.start()
        for _ in range(session.grid.steps):
            session.step()
            apart.append(session.units["upper"].read("z").min() - session.units["lower"].read("z").max())
    assert 0.0 < min(apart) < 0.03, f"they come to {min(apart)} m"
    assert apart[-1] > min(apart) + 0.005, "they do not part"


@pytest.mark.parametrize("seed", [5, 14])
def test_a_rod_that_meets_a_wing_stays_on_its_side_and_gains_no_energy(seed):
    """The slope of the force at the depth of the coming step let them pass, and pushed them off on the other side."""
    touched, gain, depth, _ = mixed.throw(seed, 3, ("rods", "wings"), "meet")
    assert touched > 50
    assert depth < 1.0, f"they are {depth} times as deep in each other as any force lets them"
    assert gain < 0.01, f"they gain {gain} of their kinetic energy"
