"""Rods and wings that touch walls and each other, in a fluid and without one."""

import numpy as np
import pytest
from lxml import etree

import nervure
from nervure.errors import SceneError
from nervure.resources import ROOT
from nervure.scene import Scene, validate
from nervure.simulation.session import Session
from nervure.units import package, ssp
from nervure.units.describe import describe_all
from studies import mixed
from tests.coupling.test_rods_and_wings import dropped

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
        warned = [text for text in session.warnings if "sure to stop" in text]
    # The 3 cm of range between both skins stop 5.4 m/s.
    assert len(warned) == int(pull > 50.0), warned
    assert all(text.startswith("the wing upper and the wing lower meet with 5.") for text in warned), warned
    assert 0.0 < min(apart) < 0.03, f"they come to {min(apart)} m"
    assert apart[-1] > min(apart) + 0.005, "they do not part"


def meeting(kinds: tuple[str, str], ratio: float) -> dict:
    """Two units that meet in a fluid too light to matter, the second one so many times as heavy and stiff."""
    scene = mixed.random_scene(3, 3, kinds, "meet")
    scene["fluid"]["density"], scene["time"]["end"] = 1e-7, 0.2
    second = {"wing": scene["wing"]} if "wing" in scene else scene[kinds[1]][1]
    own = second["wing"]["membrane"] if "wing" in second else second["rod"]["material"]["section"]
    own |= {name: ratio * value for name, value in own.items() if name.endswith(("density", "stiffness"))}
    return scene


@pytest.mark.parametrize("kinds", [("rods", "rods"), ("rods", "wings"), ("wings", "wings")])
@pytest.mark.parametrize("ratio", [0.03, 1.0, 100.0])
def test_units_of_any_masses_exchange_equal_impulses_in_a_fluid(kinds, ratio, tmp_path):
    """Each load falls with its own velocity: unpaid, a light one takes some per cent less than a heavy one gives."""
    impulses = np.zeros((2, 3))
    with Session(validate(meeting(kinds, ratio)), tmp_path) as session:
        session.start()
        names = ("rod", "wing") if "wings" in kinds and "rods" in kinds else ("part_0", "part_1")
        loads = [session.units[name].scalars_reader([f"load.{axis}" for axis in "xyz"]) for name in names]
        for _ in range(session.grid.steps):
            session.step()
            impulses += [session.grid.communication_step * own().ravel() for own in loads]
    given = np.abs(impulses).max()
    assert given > 2e-3, "they do not touch"
    # The difference of the last step is still to be paid.
    assert np.abs(impulses.sum(axis=0)).max() < 1e-3 * given, f"{impulses} N s"


def test_a_run_of_units_in_contact_in_a_fluid_resumes_to_the_bit(tmp_path):
    scene = validate(meeting(("rods", "wings"), 0.1))
    whole = nervure.run(scene, tmp_path / "whole", quiet=True)
    touched = np.abs(whole.series["rod_load_z"]) > 1e-2
    middle = float(whole.series["time"][touched.nonzero()[0][touched.sum() // 2]])
    first = nervure.run(scene.copy({"time.end": middle}), tmp_path / "parts", quiet=True, checkpoint_every=100.0)
    resumed = nervure.resume(first.folder, end_time=scene.time.end, quiet=True)
    for name, values in whole.series.items():
        np.testing.assert_array_equal(resumed.series[name], values, err_msg=name)


@pytest.mark.parametrize("seed", [5, 14])
def test_a_rod_that_meets_a_wing_stays_on_its_side_and_gains_no_energy(seed):
    """The slope of the force at the depth of the coming step let them pass, and pushed them off on the other side."""
    touched, gain, depth, _ = mixed.throw(seed, 3, ("rods", "wings"), "meet")
    assert touched > 50
    assert depth < 1.0, f"they are {depth} times as deep in each other as any force lets them"
    assert gain < 0.01, f"they gain {gain} of their kinetic energy"


def crossing(mass: float = 0.3, dimension: int = 3, **changes: object) -> dict:
    """Two free rods at rest that pull towards each other, crossing in space and one above the other in the plane."""

    def rod(name: str, place: list, way: list, pull: float, density: float) -> dict:
        section = {"line_density": density, "bending_stiffness": 5.0, "axial_stiffness": 2e4}
        root = {"at": {"position": place[-dimension:], "direction": way[-dimension:]}}
        beam = {"root": root, "length": 0.4, "thickness": 0.02, "segments": 8}
        own = {"material": {"section": section}, "gravity": [0.0, 0.0, pull][-dimension:], "root": {"free": {}}}
        return {"name": name, "beam": beam, "rod": own | {"scheme": "bdf2"}}

    lower = ([0.02, -0.2, -0.04], [0, 1, 0])
    upper = ([-0.2, 0.0, 0.04], [1, 0, 0]) if dimension == 3 else ([0.0, -0.2, 0.04], [0, 1, 0])
    return {
        "name": "crossing",
        "time": {"end": 0.2, "communication_step": 5e-4},
        "contact": {"friction": 0.2},
        "rods": [rod("upper", *upper, -9.81, 0.2), rod("lower", *lower, 9.81 * 0.2 / mass, mass)],
    } | changes


@pytest.mark.parametrize(("mass", "dimension"), [(0.3, 3), (5.0, 3), (0.2, 2)])
def test_rods_that_contact_alone_couples_exchange_momentum_and_gain_no_energy(mass, dimension, tmp_path):
    """Equal pulls leave the momentum of both at nothing, and contact takes as much from one as it gives the other."""
    axes = "xyz"[:dimension]
    energies = [f"energy.{kind}" for kind in ("elastic", "kinetic", "gravity")]
    momentum, impulse, given, energy, apart = [], np.zeros(dimension), 0.0, [], []
    with Session(validate(crossing(mass, dimension)), tmp_path) as session:
        session.start()
        contact, rods = session.units["contact"], [session.units[name] for name in ("upper", "lower")]
        loads = [contact.scalars_reader([f"beam[{k}].load_{axis}" for axis in axes]) for k in (1, 2)]
        read = [rod.scalars_reader(energies) for rod in rods]
        weights = np.r_[0.5, np.ones(7), 0.5] * 0.05
        for _ in range(session.grid.steps):
            session.step()
            one, other = (own().ravel().copy() for own in loads)
            impulse += (one + other) * session.grid.communication_step
            given += np.abs(one).max() * session.grid.communication_step
            energy.append(sum(own().sum() for own in read) + contact.read("energy")[0])
            speeds = [[weights @ rod.read(f"v{axis}") for axis in axes] for rod in rods]
            momentum.append(0.2 * np.array(speeds[0]) + mass * np.array(speeds[1]))
            apart.append(rods[0].read(axes[-1]).min() - rods[1].read(axes[-1]).max())
        left = contact.read("energy")[0]
    assert given > 0.02 and left == 0.0, "they do not touch, or are not apart again"
    assert np.abs(impulse).max() < 1e-12 * given, f"{impulse} N s of {given} N s are lost"
    assert np.abs(momentum[-1]).max() < 1e-9 * given, f"a momentum of {momentum[-1]} kg m/s"
    assert min(apart) > 0.01, f"the axes come to {min(apart)} m"
    assert max(energy) - energy[0] < 1e-3 * given, f"they gain {max(energy) - energy[0]} J"


def test_contact_alone_is_that_of_a_fluid_too_light_to_matter(tmp_path):
    """A rod falls across a wing: without a fluid contact pays the difference of what both sides took."""
    heights, loads = [], []
    for scene in (dropped(contact=True), {key: own for key, own in dropped(contact=True).items() if key != "fluid"}):
        with Session(validate(scene).copy({"time.end": 0.2}), tmp_path) as session:
            session.start()
            rod = session.units["rod"]
            for _ in range(session.grid.steps):
                session.step()
                heights.append(rod.read("z").mean())
                loads.append(rod.read("load.z")[0])
    (in_fluid, alone), (load, other) = np.array(heights).reshape(2, -1), np.array(loads).reshape(2, -1)
    assert load.max() > 5.0, "they do not touch"
    assert np.abs(alone - in_fluid).max() < 5e-4
    assert other.max() == pytest.approx(load.max(), rel=0.01) and other.sum() == pytest.approx(load.sum(), rel=0.01)


def test_a_run_of_rods_that_contact_couples_resumes_to_the_bit(tmp_path):
    scene = crossing(time={"end": 0.12, "communication_step": 5e-4})
    whole = nervure.run(validate(scene), tmp_path / "whole", quiet=True)
    touched = np.abs(whole.series["beam_1_power"]) > 0.0
    middle = float(whole.series["time"][touched.nonzero()[0][touched.sum() // 2]])
    part = validate(scene).copy({"time.end": middle})
    first = nervure.run(part, tmp_path / "parts", quiet=True, checkpoint_every=100.0)
    resumed = nervure.resume(first.folder, end_time=0.12, quiet=True)
    for name, values in whole.series.items():
        np.testing.assert_array_equal(resumed.series[name], values, err_msg=name)


def test_a_structure_of_contact_connects_all_inputs_of_both_versions_of_fmi(tmp_path):
    scene = validate(crossing())
    fmus = {name: package.pack(unit, tmp_path) for name, unit in describe_all(scene).items()}
    assert [*fmus] == ["upper", "lower", "contact"]
    root = etree.fromstring(ssp.structure(scene.name, fmus, scene.time.end))
    found = {one.get("endElement") + "." + one.get("endConnector") for one in root.iter("{*}Connection")}
    assert {"contact.beam[2].vz[9]", "upper.force_z[1]", "lower.impedance[9]"} <= found
    assert len(found) == 2 * 9 * (6 + 4)
    runs = [nervure.run(scene.copy({"time.end": 0.08}), tmp_path / str(fmi), fmi=fmi, quiet=True) for fmi in (2, 3)]
    assert np.array_equal(*(run.series["beam_2_work"] for run in runs)) and runs[0].series["beam_2_work"].any()


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (crossing(contact=None), "several rods need a fluid or a `contact` that couples them"),
        (crossing(coupling={"load": "pressure_jump"}), "contact without a fluid gives the load momentum"),
        (crossing(coupling={"scheme": {"iterated": {}}}), "the load momentum needs an explicit scheme"),
        (
            crossing(rods=[crossing()["rods"][0], crossing(dimension=2)["rods"][1]]),
            "what touches has as many dimensions: position and direction need 3 components",
        ),
        (
            crossing(rods=[own | {"name": name} for own, name in zip(crossing()["rods"], ("one", "Contact"))]),
            "names of other units",
        ),
    ],
)
def test_scenes_that_contact_cannot_couple_are_refused(scene, words):
    with pytest.raises(SceneError, match=words):
        describe_all({key: own for key, own in scene.items() if own is not None})
