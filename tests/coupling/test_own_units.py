"""Units from elsewhere, made with PythonFMU: the modal beam, the bar of finite elements and the analytic fluid of
examples/ in place of ours."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from pythonfmu.builder import FmuBuilder

import nervure
from nervure import coupling
from nervure.coupling.flight import Carried
from nervure.resources import ROOT
from nervure.scene import Scene
from nervure.simulation.loop import TimeGrid
from nervure.simulation.session import Session
from nervure.units.fmu import Unit
from tests.conftest import COUPLED, goes_back_and_on, output, run_scene
from tests.coupling import test_flyer

pytestmark = [
    pytest.mark.usefixtures("libraries"),
    pytest.mark.skipif(not FmuBuilder.has_binary(), reason="PythonFMU has no binary for this system"),
]

EXAMPLES = {"rod": "modal_beam.py", "solid": "solid_bar.py", "fluid": "strip_fluid.py", "wing": "own_wing.py"}
LENGTH, THICKNESS, FLUID_DENSITY = 0.35, 0.02, 1000.0
BENDING_STIFFNESS = 5.6e6 * THICKNESS**3 / 12 / (1 - 0.4**2)
FIRST_MODE = 1.8751040687
"""First root of cos b cosh b = -1."""

WEIGHT = 4.0
"""Of the beam in the fluid, N/m²: bends the tip by 0.5 % of its length."""

FREQUENCY_TOLERANCE = 1e-3
"""32 segments: the stations' masses take the place of an integral, by which the frequency is 5e-4 too low (modal beam)
or 9e-4 (our rod, whose stiffness is of second order as well)."""

DECAY_TOLERANCE = 1e-4
"""Of the angular frequency: what the second mode, 1 % of the first, leaves in a fit over four periods."""

CSM1, CSM_TOLERANCE = (-7.1877e-3, -66.1023e-3), 0.002
"""Turek & Hron (2006), m; the elements of the example leave 0.13 % of ux and 0.07 % of uy."""

STARTUP_TOLERANCE = 0.01
"""Of the largest deflection: 20 segments of the rod and the tension by the drag make 0.4 %."""


@pytest.fixture
def still():
    """The bar of FSI3 in a fluid at rest, let go under its weight; `density` (kg/m³) is its own, above 1000."""

    def scene(density: float) -> dict:
        return {
            "name": "still-fluid",
            "time": {"end": 7.4, "communication_step": 4e-3},
            "fluid": {
                "density": FLUID_DENSITY,
                "kinematic_viscosity": 1e-3,
                "box": {"x": [-0.1, 0.45], "y": [-0.2, 0.2], "cells": [32, 24]},
                "mask": {"cosine": {"c_eta": 1e-3, "half_width": 1.0}},
                "time_stepping": {"max_step": 4e-3, "max_cfl": 0.4},
            },
            "beam": {
                "root": {"at": {"position": [0.0, 0.0], "direction": [1.0, 0.0]}},
                "length": LENGTH,
                "thickness": THICKNESS,
                "segments": 32,
            },
            "rod": {
                "material": {"plane_strain": {"density": density, "youngs_modulus": 5.6e6, "poisson_ratio": 0.4}},
                "gravity": [0.0, -WEIGHT / ((density - FLUID_DENSITY) * THICKNESS)],
                "scheme": "bdf2",
            },
            "coupling": {"load": "momentum"},
        }

    return scene


@pytest.fixture
def own(tmp_path, packed):
    """Function that makes our own FMU of a scene, or that of examples/, and returns its path."""

    def make(kind: str, scene: dict, foreign: bool):
        if not foreign:
            return packed(kind, scene)
        path, fmu = tmp_path / "to-pack.json", tmp_path / f"{scene['name']}-foreign-{kind}.fmu"
        path.write_text(json.dumps(scene))
        command = [sys.executable, ROOT / "examples" / "pack.py", ROOT / "examples" / EXAMPLES[kind], path, fmu]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(done.stderr)
        return fmu

    return make


@pytest.fixture
def open_unit():
    """Function that opens an FMU, which is closed after the test."""
    units = []

    def make(path, kind: str) -> Unit:
        units.append(Unit(path, kind, 10.0))
        return units[-1]

    yield make
    for unit in units:
        unit.close()


def decaying_oscillation(t, values, omega, rate):
    """Angular frequency and decay rate of the a + exp(-rate t) (b cos omega t + c sin omega t) that fits best, by
    Gauss-Newton from the given ones."""
    for _ in range(20):
        cos, sin = np.cos(omega * t) * np.exp(-rate * t), np.sin(omega * t) * np.exp(-rate * t)
        linear = np.column_stack([np.ones_like(t), cos, sin])
        _, b, c = np.linalg.lstsq(linear, values, rcond=None)[0]
        slopes = np.column_stack([linear, t * (c * cos - b * sin), -t * (b * cos + c * sin)])
        *_, omega_update, rate_update = np.linalg.lstsq(slopes, values, rcond=None)[0]
        omega, rate = omega + omega_update, rate + rate_update
    return omega, rate


def results(folder):
    return np.genfromtxt(folder / "series.csv", delimiter=",", names=True)


@pytest.mark.parametrize(
    ("foreign_rod", "density", "linear_drag"),  # Each two of the values in one case
    [(False, 2000.0, 200.0), (False, 1001.0, 0.0), (True, 2000.0, 0.0), (True, 1001.0, 200.0)],
    ids=["our rod", "our light rod", "modal beam", "light modal beam"],
)
def test_frequency_and_decay_in_the_analytic_fluid(still, own, open_unit, foreign_rod, density, linear_drag):
    """With density 1001 kg/m³ a thousandth of the bar's mass is left to the rod."""
    scene = still(density)
    rod, fluid = open_unit(own("rod", scene, foreign_rod), "rod"), open_unit(own("fluid", scene, True), "fluid")
    fluid.fmu.setReal(fluid.variables["linear_drag"].references, [linear_drag])
    coupled = coupling.Explicit([rod], fluid)
    coupled.start()
    grid = TimeGrid(scene["time"]["end"], scene["time"]["communication_step"])
    times, tip = [], []
    for t, h in map(grid.step, range(grid.steps)):
        coupled.step(t, h)
        times.append(t + h)
        tip.append(output(rod, "tip.uy")[0])

    beam, added = density * THICKNESS, FLUID_DENSITY * math.pi * LENGTH / 4
    in_vacuo = FIRST_MODE**2 / LENGTH**2 * math.sqrt(BENDING_STIFFNESS / beam)
    in_fluid = in_vacuo * math.sqrt(beam / (beam + added))
    decay = linear_drag / (2 * (beam + added))
    omega, rate = decaying_oscillation(np.array(times), np.array(tip), in_fluid, decay)
    assert omega == pytest.approx(math.sqrt(in_fluid**2 - decay**2), rel=FREQUENCY_TOLERANCE)
    assert rate == pytest.approx(decay, abs=DECAY_TOLERANCE * in_fluid)
    assert min(tip) < -0.005 * LENGTH


def test_two_foreign_units_run_from_the_command_line(still, own, tmp_path):
    scene = still(1001.0)
    fmus = {kind: own(kind, scene, True) for kind in COUPLED}
    path, folder = tmp_path / "scene.json", tmp_path / "results"
    path.write_text(json.dumps(scene))
    done = run_scene(path, "--output", folder, "--rod-fmu", fmus["rod"], "--fluid-fmu", fmus["fluid"])
    assert done.returncode == 0, done.stderr
    summary = json.loads((folder / "summary.json").read_text())
    assert {kind: unit["model"] for kind, unit in summary["units"].items()} == {
        "rod": "ModalBeam",
        "fluid": "StripFluid",
    }
    # Let go under its weight, a beam without damping falls to twice its static deflection.
    deflection = WEIGHT * LENGTH**4 / (8 * BENDING_STIFFNESS)
    assert results(folder)["tip_uy"].min() == pytest.approx(-2 * deflection, rel=0.03)


def test_a_foreign_unit_that_dies_ends_the_run_with_its_reason(still, own, tmp_path):
    """PythonFMU answers an exception with fmi2Fatal, after which no function of the unit may be called."""
    scene = still(2000.0)
    scene["rod"]["gravity"] = [0.0, -1000 * WEIGHT / (FLUID_DENSITY * THICKNESS)]
    path, folder = tmp_path / "scene.json", tmp_path / "results"
    path.write_text(json.dumps(scene))
    fmus = {kind: own(kind, scene, True) for kind in COUPLED}
    done = run_scene(path, "--output", folder, "--rod-fmu", fmus["rod"], "--fluid-fmu", fmus["fluid"], "--quiet")
    assert done.returncode == 1, done.stderr
    assert "but this beam is linear: 0.035 m at most" in done.stderr
    assert results(folder)["tip_uy"].size > 1


@pytest.mark.parametrize("kind", ["rod", "solid"])
def test_foreign_rod_starts_up_in_our_fluid_as_our_rod_does(fsi3, own, tmp_path, kind):
    """FSI3's own start-up on a coarse grid: the deflection is small, but the fluid is our own."""
    fsi3["fluid"]["box"]["cells"] = [160, 36]
    fsi3["beam"]["segments"] = 20
    if kind == "rod":
        del fsi3["rod"]["material"]["plane_strain"]["shear_factor"]  # which the modal beam does without
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(fsi3))
    tips = {}
    for name, foreign in (("ours", []), ("foreign", ["--rod-fmu", own(kind, fsi3, True)])):
        done = run_scene(path, "--output", tmp_path / name, "--end-time", "0.3", *foreign)
        assert done.returncode == 0, done.stderr
        tips[name] = results(tmp_path / name)["tip_uy"]
    largest = np.abs(tips["ours"]).max()
    assert 5e-5 < largest < 0.001 * LENGTH
    assert tips["foreign"] == pytest.approx(tips["ours"], abs=STARTUP_TOLERANCE * largest)


@pytest.fixture
def bar():
    """Function that makes the elements' bar of CSM1 and CSM3, whose root is the arc of the cylinder."""
    sys.path.insert(0, str(ROOT / "examples"))
    try:
        from solid_bar import Bar
    finally:
        sys.path.remove(str(ROOT / "examples"))
    return lambda: Bar(LENGTH, THICKNESS, 42, 1000.0, 1.4e6, 0.4, arc_radius=0.05)


NO_LOAD = (np.zeros((43, 2)), np.zeros(43))
"""On the stations, and its impedance."""


def test_bar_of_finite_elements_hangs_as_csm1_does(bar):
    """In steps so long that inertia is nothing, with gravity growing from one to the next."""
    hanging = bar()
    for part in np.linspace(0.1, 1.0, 10):
        hanging.step(1e6, *NO_LOAD, np.array([0.0, -2.0 * part]))
    assert tuple(hanging.sections(hanging.u)[-1]) == pytest.approx(CSM1, rel=CSM_TOLERANCE)


def test_bar_of_finite_elements_falls_as_our_rod_does(bar, rod_only, start):
    """CSM3 over a third of its period, to half of its swing. The two agree to 0.2 %."""
    rod_only["time"]["end"] = 1.0
    rod_only["beam"]["segments"] = 64
    rod_only["rod"]["material"]["plane_strain"]["shear_factor"] = 0.862
    rod_only["rod"]["clamp_compliance_length"] = 2.4e-4
    ours, falling = start(rod_only), bar()
    for i in range(100):
        ours.step(3e-3 * i, 3e-3)
        falling.step(3e-3, *NO_LOAD, np.array([0.0, -2.0]))
    found, expected = falling.sections(falling.u)[-1], [output(ours.unit, f"tip.{name}")[0] for name in ("ux", "uy")]
    assert expected[1] < -0.06
    assert found == pytest.approx(expected, rel=0.005)


def test_impedance_and_load_of_a_station_do_to_the_elements_what_they_say(bar):
    """A load with impedance does what f − D (v − v_before) does without it, v at the step's end."""
    random = np.random.default_rng(1)
    force, impedance = 0.1 * random.standard_normal((43, 2)), 500 * random.random(43)
    with_impedance, without = bar(), bar()
    for one in (with_impedance, without):
        one.step(1e-3, force, np.zeros(43), np.zeros(2))
    before = without.sections(without.v)
    with_impedance.step(1e-3, force, impedance, np.zeros(2))
    change = with_impedance.sections(with_impedance.v) - before
    without.step(1e-3, force - impedance[:, None] * change, np.zeros(43), np.zeros(2))
    assert np.abs(impedance[:, None] * change).max() > 0.01 * np.abs(force).max()
    assert without.v == pytest.approx(with_impedance.v, abs=1e-6 * np.abs(without.v).max())


@pytest.mark.parametrize(
    ("part", "change", "reason"),
    [
        ("coupling", {"load": "pressure_jump"}, "coupling.load of the scene must be `momentum`"),
        ("rod", {"damping": 1.0}, "knows no rod.damping"),
        ("rod", {"material": {"section": {}}}, "knows no rod.material but plane_strain"),
        ("fluid", {"density": 3000.0}, "at least as heavy as the fluid"),
    ],
)
def test_modal_beam_refuses_what_it_does_not_know(still, own, part, change, reason):
    scene = still(2000.0)
    scene[part] |= change
    with pytest.raises(RuntimeError, match=reason):
        own("rod", scene, True)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_state_of_a_foreign_unit_comes_back_bit_by_bit(still, own, open_unit, kind):
    path = own(kind, carried(1.0) | {"this_wing": "left"} if kind == "wing" else still(1001.0), True)
    assert validate_fmu(str(path)) == []
    unit, other = open_unit(path, kind), open_unit(path, kind)
    names = {causality: [v.name for v in unit.variables.values() if v.causality == causality and v.size > 1]
             for causality in ("input", "output")}  # fmt: skip
    for one in (unit, other):
        one.connect(names["input"], names["output"])
        one.start()

    def run(one, first):
        for step in range(first, first + 5):
            one.inputs[:] = np.sin(np.arange(one.inputs.size) + step)
            one.step(4e-3 * step, 4e-3)
        return one.outputs.copy()

    assert np.abs(goes_back_and_on(unit, other, run, 5)).max() > 0


def carried(mass: float) -> dict:
    """A body in a fluid with two stiff wings of three nodes along and across each."""
    nodes = [[0.1 * i, 0.05 * (j - 1), 0.0] for j in range(3) for i in range(3)]
    squares = [3 * j + i for j in range(2) for i in range(2)]
    triangles = [list(own) for k in squares for own in ((k, k + 1, k + 4), (k, k + 4, k + 3))]
    chains = [{"name": "root", "nodes": [0, 3, 6]}]
    membrane = {"areal_density": 50.0, "stretching_stiffness": 2.5e6, "bending_stiffness": 1e3}
    scene = test_flyer.swimmer()
    for own in scene["wings"]:
        own["wing"] |= {"membrane": membrane, "root": "root"}
        own["wing"]["mesh"] = {"triangles": {"nodes": nodes, "triangles": triangles, "chains": chains}}
    for hinge in scene["flyer"]["hinges"]:
        hinge["motion"] = {"stroke": {"cosine_ramp": {"value": 0.6, "duration": 0.5}}}
    scene["flyer"] |= {"mass": mass, "inertia": [0.01 * mass, 0.014 * mass, 0.019 * mass]}
    scene["time"] = {"end": 0.2, "communication_step": 0.01}
    return scene


@pytest.mark.usefixtures("libraries")
@pytest.mark.parametrize("mass", [0.01, 1.0])
def test_an_own_wing_flies_on_a_body_as_a_stiff_one_of_ours(mass, own, tmp_path):
    """It has no root.reaction, and is heavier than its body or as heavy."""
    scene = carried(mass)
    fmus = {name: own("wing", scene | {"this_wing": name, "name": name}, True) for name in ("left", "right")}
    ends = []
    for foreign in ({}, fmus):
        path = tmp_path / "flyer.json"
        path.write_text(json.dumps(scene))
        options = [text for name, fmu in foreign.items() for text in ("--rod-fmu", f"{name}={fmu}")]
        done = run_scene(path, "--output", tmp_path / "run", "--force", *options)
        assert done.returncode == 0, done.stderr
        series = nervure.read(tmp_path / "run").series
        ends.append([series[f"body_{name}"][-1] for name in ("y", "vy", "x", "angle_z")])
    ours, theirs = ends
    assert theirs[:2] == pytest.approx(ours[:2], rel=0.01) and max(map(abs, theirs[2:])) < 1e-6, ends


@pytest.mark.usefixtures("libraries")
@pytest.mark.parametrize(
    ("kind", "change", "words"),
    [
        ("wing", ["wings", 0, "wing", "mesh"], "the mesh of the wing is insect, but must be `triangles`"),
        ("wing", ["this_wing"], "the scene .*to-pack.json lacks 'this_wing', which .*own_wing.py needs"),
        ("rod", [], "the scene .*to-pack.json lacks 'beam', which .*modal_beam.py needs"),
    ],
)
def test_a_scene_that_lacks_what_an_own_unit_needs_is_refused_by_the_missing_key(kind, change, words, own):
    scene = test_flyer.pair() | {"this_wing": "left"}
    if change == ["this_wing"]:
        del scene["this_wing"]
    elif change:
        scene["wings"][0]["wing"]["mesh"] = {"insect": {"span": 0.1, "chord": 0.04, "along": 4}}
    with pytest.raises(RuntimeError, match="^error: " + words):
        own(kind, scene, foreign=True)


def test_an_own_wing_that_cannot_save_its_state_is_refused_by_a_body(own, tmp_path):
    scene = carried(1.0)
    fmu = own("wing", scene | {"this_wing": "left", "name": "left"}, True)
    with Session.packed(Scene.model_validate(scene), tmp_path / "run", {"left": fmu}) as session:
        flight = session.scheme
        left = session.units["left"]
        left.can_roll_back = False
        with pytest.raises(
            coupling.CouplingError, match="no output `root.reaction`: it must try its steps, but cannot"
        ):
            Carried("left", flight.links[0], flight.body)
