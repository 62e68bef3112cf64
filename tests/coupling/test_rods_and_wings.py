"""Rods and wings, each a unit of its own, in one fluid."""

import copy

import numpy as np
import pytest
from lxml import etree

import nervure
from nervure.errors import SceneError
from nervure.output import animation, plots
from nervure.scene import validate
from nervure.scene.facts import Facts
from nervure.simulation.session import Session
from nervure.units import package, ssp
from nervure.units.describe import describe_all
from nervure.units.documentation import terminals
from tests.conftest import nervure as command

pytestmark = pytest.mark.usefixtures("libraries")

STEP = 0.02
WING = {
    "mesh": {"rectangular": {"length": 0.8, "width": 0.8, "along": 3}},
    "membrane": {"areal_density": 0.5, "stretching_stiffness": 200.0, "bending_stiffness": 0.5},
    "root": "root",
    "root_motion": {"z": {"sine": {"amplitude": 0.15, "frequency": 2.5, "ramp": 0.2}}},
}
SECTION = {"line_density": 0.02, "bending_stiffness": 1e-3, "axial_stiffness": 2.0}
ROD = {"material": {"section": SECTION}}


def beam(y: float = 0.0) -> dict:
    root = {"at": {"position": [1.1, y, 0.0], "direction": [1.0, 0.0, 0.0]}}
    return {"root": root, "length": 0.6, "thickness": 0.1, "segments": 6, "surface": "line"}


def behind(end: float = 0.8) -> dict:
    """A filament behind a wing that heaves in a stream."""
    return {
        "name": "behind",
        "time": {"end": end, "communication_step": STEP},
        "fluid": {
            "density": 1.0,
            "kinematic_viscosity": 0.02,
            "box": {"x": [-1.0, 2.0], "y": [-1.0, 1.0], "z": [-1.0, 1.0], "cells": [30, 20, 20]},
            "initial_velocity": [0.5, 0.0, 0.0],
            "mean_flow": {"x": {"constant": 0.5}},
            "mask": {"log_linear": {"c_eta": 1e-3}},
            "time_stepping": {"max_step": STEP, "max_cfl": 0.4},
        },
        "wing": copy.deepcopy(WING),
        "beam": beam(),
        "rod": copy.deepcopy(ROD),
    }


def listed() -> dict:
    """Two of each, side by side."""
    scene = behind(0.1)
    for key in ("wing", "beam", "rod"):
        del scene[key]
    scene["rods"] = [{"name": name, "beam": beam(y), "rod": ROD} for name, y in (("left", -0.3), ("right", 0.3))]
    scene["wings"] = [{"name": name, "wing": copy.deepcopy(WING)} for name in ("fore", "aft")]
    for own, x in zip(scene["wings"], (-0.5, 0.4), strict=True):
        own["wing"]["mesh"]["rectangular"]["length"] = 0.4
        own["wing"]["root_motion"]["x"] = {"constant": x}
    return scene


def carried() -> dict:
    """The wing on a flyer, in front of the rod."""
    scene = behind(0.1)
    del scene["wing"]["root_motion"]
    scene["wing"]["scheme"] = "bdf2"
    hinge = {"carries": "wing", "position": [0.0] * 3, "motion": {"deviation": WING["root_motion"]["z"]}}
    return scene | {"flyer": {"mass": 1.0, "inertia": [0.1, 0.1, 0.15], "hinges": [hinge]}}


@pytest.mark.parametrize(
    ("scene", "prefixes"),
    [
        (behind(0.1), {"rod": "", "wing": "wing."}),
        (listed(), {"left": "beam[1].", "right": "beam[2].", "fore": "wing[1].", "aft": "wing[2]."}),
        (carried(), {"rod": "", "wing": "wing."}),
        (behind(0.1) | {"wing": None, "wings": listed()["wings"]}, {"rod": "", "fore": "wing[1].", "aft": "wing[2]."}),
    ],
    ids=["one of each", "two of each", "a flyer's wing", "a rod and two wings"],
)
def test_each_rod_and_wing_meets_its_own_part_of_the_fluid(scene, prefixes, tmp_path):
    scene = {key: value for key, value in scene.items() if value is not None}
    with Session(validate(scene), tmp_path) as session:
        session.start()
        for _ in range(session.grid.steps):
            session.step()
        fluid = session.units["fluid"]
        assert [name for name in session.units if name != "body"] == [*prefixes, "fluid"]
        for name, prefix in prefixes.items():
            unit = session.units[name]
            for axis in "xyz":
                np.testing.assert_array_equal(fluid.read(prefix + axis), unit.read(axis), err_msg=name + axis)
            assert np.ptp(unit.read("z")) > 1e-9, f"{name} does not move"
        for prefix, link in zip(prefixes.values(), session.scheme.links, strict=True):
            loads = [fluid.read(f"{prefix}{name}") for name in ("force_x", "force_y", "force_z", "impedance")]
            np.testing.assert_array_equal(link.loads, np.concatenate(loads), err_msg=prefix)


@pytest.fixture(scope="module")
def run(tmp_path_factory, libraries):
    return nervure.run(validate(behind()), tmp_path_factory.mktemp("behind") / "run", quiet=True, fields_every=0.4)


def test_a_run_has_columns_and_results_of_rod_and_wing_by_their_units(run):
    series, summary = run.series, run.summary
    assert {"rod_tip_uz", "rod_load_work", "wing_tip_uz", "wing_root_power", "beam_drag", "wing_drag"} <= series.keys()
    assert {"wing_load_x", "fluid_wing_load_x", "beam_load_x", "drag"} <= series.keys()
    assert not {"tip_uz", "wing_wing_load_x"} & series.keys()
    assert {"rod_tip_uz", "wing_tip_uz", "wing_section_twist", "beam_drag", "wing_side"} <= summary.quantities.keys()
    assert summary.units.keys() == {"rod", "wing", "fluid"}
    assert (summary.flapping, summary.interface) == (None, None)
    assert summary.rods.keys() == {"rod"} and summary.wings.keys() == {"wing"}
    for own, part in ((summary.rods["rod"], "beam"), (summary.wings["wing"], "wing")):
        assert own.interface.work_by_fluid == series[f"{part}_work"][-1] != 0.0
    assert summary.rods["rod"].flapping is None and summary.wings["wing"].flapping.power_in > 0.0
    assert summary.bodies["wing"].cp > 0.0 and summary.bodies["beam"].cp is None
    # The wing's drive sets the period, not the rod that follows.
    begin, end = summary.window_s
    assert (end - begin) / summary.periods == pytest.approx(0.4, rel=0.02)
    np.testing.assert_allclose(series["drag"], series["beam_drag"] + series["wing_drag"], rtol=1e-9, atol=1e-12)


def test_the_works_of_rod_and_wing_are_those_of_the_fluid(run):
    for own in (run.summary.rods["rod"].interface, run.summary.wings["wing"].interface):
        assert own.exchanged > 1e-5 and abs(own.imbalance) < 0.1, own


def test_a_run_resumes_to_the_bit(run, tmp_path):
    """Half a run and its resumption are the run without a break."""
    first = nervure.run(validate(behind(0.4)), tmp_path, quiet=True, checkpoint_every=100.0)
    whole = nervure.resume(first.folder, end_time=0.8, quiet=True)
    assert whole.series.keys() == run.series.keys()
    for name, values in run.series.items():
        np.testing.assert_array_equal(whole.series[name], values, err_msg=name)


def test_tables_pictures_and_fields_have_rod_and_wing(run, tmp_path):
    names = {path.name for path in run.folder.iterdir()}
    assert names >= {"beam-rod.vtkhdf", "wing.vtkhdf", "fields.vtkhdf"}
    frames = animation.Frames(run.folder)
    (line, radius), (nodes, _) = frames.rods(2)[0], frames.membrane(2)
    assert line.shape == (7, 3) and radius == pytest.approx(0.05) and line[:, 0].min() > 1.0 > nodes[:, 0].max()
    assert len(frames.solids(2)) == 2, "the slice has not both"
    assert [path.name for path in plots.driven_roots(tmp_path, run, "svg")] == ["flapping-wing.svg"]
    shown = command("inspect", run.folder).stdout
    for words in ("interface: work on the rod ", "interface: work on the wing ", "beam: cD", "wing: cD"):
        assert words in shown, shown


def test_a_system_structure_connects_rod_and_wing_to_their_parts(tmp_path):
    scene = validate(behind())
    fmus = {name: package.pack(unit, tmp_path) for name, unit in describe_all(scene).items()}
    root = etree.fromstring(ssp.structure(scene.name, fmus, scene.time.end, 1))
    places = {
        (one.get("startElement"), one.get("startConnector"), one.get("endElement"), one.get("endConnector"))
        for one in root.iter("{*}Connection")
    }
    for one in (
        ("rod", "x[1]", "fluid", "x[1]"),
        ("wing", "x[1]", "fluid", "wing.x[1]"),
        ("fluid", "force_x[1]", "rod", "force_x[1]"),
        ("fluid", "wing.force_x[1]", "wing", "force_x[1]"),
    ):
        assert one in places, one
    joined = {(unit, name) for _, _, unit, name in places}
    inputs = [
        (unit.get("name"), one.get("name"))
        for unit in root.iter("{*}Component")
        for one in unit.iter("{*}Connector")
        if one.get("kind") == "input"
    ]
    assert {*inputs} == joined, "an input is not connected"


def test_the_terminals_of_each_wing_have_the_names_of_its_variables():
    found = etree.fromstring(terminals(describe_all(validate(listed()))["fluid"].xml).encode())
    members = {one.get("variableName"): one.get("memberName") for one in found.iter("TerminalMemberVariable")}
    for name in ("wing[2].x[1]", "beam[2].x[1]", "wing[1].force_z[3]"):
        assert members[name] == name.partition(".")[2], name


def dropped(contact: bool) -> dict:
    """A free rod falls across the middle of a plate whose edge is clamped, in a fluid too thin to matter."""
    scene = behind(0.3)
    scene["time"]["communication_step"] = step = 1e-3
    fluid = {"density": 1e-4, "kinematic_viscosity": 1e-2, "box": {axis: [-0.4, 0.4] for axis in "xyz"}}
    fluid["box"]["cells"] = [12, 12, 12]
    mask = {"log_linear": {"c_eta": 1e-3}}
    scene["fluid"] = fluid | {"mask": mask, "time_stepping": {"max_step": step, "max_cfl": 0.4}}
    membrane = {"areal_density": 2.0, "stretching_stiffness": 1e4, "bending_stiffness": 0.5, "poisson_ratio": 0.3}
    mesh = {"rectangular": {"length": 0.4, "width": 0.4, "along": 4}}
    scene["wing"] = {"mesh": mesh, "membrane": membrane, "root": "root", "scheme": "bdf2", "relaxation_time": 1e-3}
    root = {"at": {"position": [0.2, -0.1, 0.12], "direction": [0.0, 1.0, 0.0]}}
    scene["beam"] = beam() | {"root": root, "length": 0.2, "thickness": 0.04}
    section = {"line_density": 1.0, "bending_stiffness": 0.1, "axial_stiffness": 2e4}
    free = {"root": {"free": {}}, "scheme": "bdf2", "gravity": [0.0, 0.0, -9.81]}
    scene["rod"] = {"material": {"section": section}} | free
    scene["coupling"] = {"guards": {"largest_imbalance": None}}
    return scene | ({"contact": {"range": 0.04}} if contact else {})


@pytest.mark.parametrize("contact", [True, False])
def test_a_rod_that_falls_on_a_wing_bounces_and_gains_no_energy(contact, tmp_path):
    """Without contact it falls through."""
    names = ["energy.elastic", "energy.kinetic", "energy.gravity", "energy.contact"][: 4 if contact else 3]
    gaps, speeds, energies = [], [], []
    with Session(validate(dropped(contact)), tmp_path) as session:
        session.start()
        rod, wing = session.units["rod"], session.units["wing"]
        read = [unit.scalars_reader(names) for unit in (rod, wing)]
        energies.append(sum(own().sum() for own in read))
        for _ in range(session.grid.steps):
            session.step()
            x, y, z = (wing.read(axis) for axis in "xyz")
            under = np.hypot(x - rod.read("x").mean(), y - rod.read("y").mean()).argmin()
            gaps.append(rod.read("z").mean() - z[under])
            speeds.append(rod.read("vz").mean())
            energies.append(sum(own().sum() for own in read))
    falls = 0.2 * 9.81 * 0.1
    gain = (max(energies) - energies[0]) / falls
    if not contact:
        assert min(gaps) < -0.05
        return
    # Half its thickness is 0.02 m, and that of the wing for others a quarter of the range.
    assert 0.03 < min(gaps) < 0.06, f"the axis comes to {min(gaps)} m from the wing"
    assert speeds[-1] < 0.0 < max(speeds), "it does not bounce, or does not fall again"
    assert gain < 1e-2, f"it gains {gain} of the energy of its fall"


def test_the_mass_ratio_of_a_wing_beside_a_rod_is_of_its_own_length():
    numbers = Facts(validate(behind())).numbers
    assert (numbers.length, numbers.length_of) == (pytest.approx(0.6), "beam")
    assert numbers.mass_ratio == pytest.approx(0.5 / 0.8) and numbers.density_ratio < 3.0


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"fluid": None}, "`wing` is not allowed here: wings beside rods need a fluid, a flyer or a `contact`"),
        ({"rod": None}, "`beam` is not allowed here: beside a wing a beam needs a `rod`"),
    ],
)
def test_what_nothing_couples_is_refused(change, fault):
    scene = {key: value for key, value in (behind() | change).items() if value is not None}
    with pytest.raises(SceneError, match=fault):
        describe_all(scene)


def test_a_rod_with_the_name_of_the_wing_is_refused():
    scene = listed() | {"wing": WING}
    del scene["wings"]
    scene["rods"][0]["name"] = "Wing"
    with pytest.raises(SceneError, match=r'name` is "Wing", but `rod`, `wing`, `body`, `fluid` and `contact` are'):
        describe_all(scene)
