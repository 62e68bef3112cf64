"""Units from elsewhere that fail, lie or belong to another scene: each ends with a sentence that names it."""

import copy
import json
import os
import zipfile
from typing import Any

import pytest
from pythonfmu.builder import FmuBuilder

from nervure.resources import ROOT
from tests.conftest import nervure, run_scene

pytestmark = [
    pytest.mark.usefixtures("libraries"),
    pytest.mark.skipif(not FmuBuilder.has_binary(), reason="PythonFMU has no binary for this system"),
]

PAIR = {
    "name": "pair",
    "time": {"end": 0.04, "communication_step": 0.004},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 0.01,
        "box": {"x": [-1.0, 3.0], "y": [-1.0, 1.0], "cells": [64, 32]},
        "initial_velocity": [1.0, 0.0],
        "mean_flow": {"x": {"constant": 1.0}},
        "mask": {"log_linear": {"c_eta": 1e-3}},
        "time_stepping": {"max_step": 0.004, "max_cfl": 0.4},
    },
    "beam": {
        "root": {"at": {"position": [0.0, 0.0], "direction": [1.0, 0.3]}},
        "length": 1.0,
        "thickness": 0.2,
        "segments": 8,
    },
    "rod": {"material": {"plane_strain": {"density": 5.0, "youngs_modulus": 4e3, "poisson_ratio": 0.3}}},
    "coupling": {"load": "momentum", "scheme": "explicit"},
}

UNIT = '''
import os

import contract
import numpy as np
from contract import ContractUnit, root_of
from pythonfmu.enums import Fmi2Causality

contract.BASE_UNITS["Pa"] = {"kg": 1, "m": -1, "s": -2}


def asked(what):
    return os.environ.get("UNIT") == what


def perhaps_fail(name):
    if asked(name):
        raise RuntimeError(f"no licence for {name}")


class Rigid(ContractUnit):
    """A rigid beam that moves along y; the environment says where it fails."""

    STATE = ("y", "vy", "load", "spoiled")

    def __init__(self, **keywords):
        super().__init__(**keywords)
        beam = self.scene["beam"]
        root, tangent = root_of(self.scene)
        s = np.linspace(0.0, beam["length"], beam["segments"] + 1)
        self.x, self.y = root[:, None] + tangent[:, None] * s
        self.vx, self.vy, self.load, self.spoiled = (np.zeros_like(s) for _ in range(4))
        INPUTS
        for name, unit in (("x", "m"), ("y", "m"), ("vx", "m/s"), ("vy", "m/s")):
            self.register_array(name, unit, Fmi2Causality.output, getattr(self, name))

    def setup_experiment(self, *_):
        perhaps_fail("setup_experiment")

    def enter_initialization_mode(self):
        perhaps_fail("enter_initialization_mode")

    def exit_initialization_mode(self):
        perhaps_fail("exit_initialization_mode")
        if asked("nan at start"):
            self.x[2] = np.nan

    def do_step(self, current_time, step_size):
        if current_time > 0.01:
            perhaps_fail("do_step")
            for what, value in (("nan", np.nan), ("inf", np.inf), ("huge", 1e30), ("far", 50.0)):
                if asked(what):
                    self.x[-1] = value
            if asked("fast"):
                self.vy[3] = -1e13
        self.vy += step_size * (0.05 + 1e-3 * self.load.mean())
        self.y += step_size * self.vy
        if asked("half"):
            self.hidden = getattr(self, "hidden", 0) + 1
            self.y += 1e-6 * self.hidden
        return True

    def terminate(self):
        perhaps_fail("terminate")

    def _get_fmu_state(self):
        perhaps_fail("get_fmu_state")
        return {"nothing": 0.0} if asked("none") else super()._get_fmu_state()

    def _set_fmu_state(self, state):
        if not asked("none"):
            super()._set_fmu_state(state)
'''
INPUTS = {
    "momentum": """force = [np.zeros_like(s) for _ in range(3)]
        for name, unit, values in zip(("force_x", "force_y", "impedance"), ("N/m", "N/m", "kg/(m.s)"), force):
            self.register_array(name, unit, Fmi2Causality.input, values)""",
    "pressure_jump": 'self.register_array("pressure_jump", "Pa", Fmi2Causality.input, self.load)',
}


@pytest.fixture(scope="module")
def rigid(tmp_path_factory):
    """The FMUs of a rigid rod by load; the variable UNIT of the environment says what goes wrong in it."""
    folder, fmus = tmp_path_factory.mktemp("rigid"), {}
    (folder / "scene.json").write_text(json.dumps(PAIR))
    (folder / "contract.py").write_bytes((ROOT / "examples" / "contract.py").read_bytes())
    for load, inputs in INPUTS.items():
        unit = folder / f"rigid_{load}.py"
        unit.write_text(UNIT.replace("INPUTS", inputs))
        fmus[load] = folder / f"{load}.fmu"
        files = [folder / "contract.py", folder / "scene.json"]
        states = {"canGetAndSetFMUstate": True, "canSerializeFMUstate": True}
        FmuBuilder.build_FMU(unit, dest=fmus[load], project_files=files, **states)
    return fmus


@pytest.fixture
def run(tmp_path, rigid):
    """Function that runs the pair with a foreign rod under a load, in which something goes wrong."""

    def run(wrong, load="momentum", rod=None, scene=PAIR, fluid=None):
        path = tmp_path / "pair.json"
        scene = copy.deepcopy(scene)
        if load == "pressure_jump":
            scene["coupling"] = {"load": load}
        path.write_text(json.dumps(scene))
        fmus = ["--fluid-fmu", fluid] if fluid else ["--rod-fmu", rod or rigid[load]]
        options = ["--output", tmp_path / "results", "--quiet", "--force", *fmus]
        return run_scene(path, *options, env={**os.environ, "UNIT": wrong})

    return run


def test_the_unit_runs_where_nothing_goes_wrong(run, tmp_path):
    for load in INPUTS:
        done = run("", load)
        assert done.returncode == 0, done.stderr
        assert len((tmp_path / "results" / "series.csv").read_text().splitlines()) == 12


@pytest.mark.parametrize(
    "call", ["setup_experiment", "enter_initialization_mode", "exit_initialization_mode", "do_step", "terminate"]
)
def test_a_unit_that_fails_in_a_call_has_the_last_word(run, tmp_path, call):
    done = run(call)
    assert (done.returncode, done.stderr) == (1, f"error: rod: no licence for {call}\n") or (
        call == "do_step" and done.stderr.startswith("error: rod: no licence for do_step in the step from t = 0.012 s")
    )
    rows = (tmp_path / "results" / "series.csv").read_text().splitlines() if call in ("do_step", "terminate") else []
    assert len(rows) == {"do_step": 5, "terminate": 12}.get(call, 0)


@pytest.mark.parametrize("version", [2, 3])
def test_a_unit_that_cannot_be_instantiated_has_the_last_word(run, packed, tmp_path, version):
    """Its scene was edited, which the unit finds out when it is instantiated."""

    def edited(name, data):
        return data + b" " if name == "resources/scene.json" else data

    done = run("", rod=rewritten(packed("rod", PAIR, version), tmp_path / "edited.fmu", edited))
    assert done.returncode == 1 and "scene.json changed after the FMU was packed" in done.stderr, done.stderr
    assert done.stderr.startswith("error: rod: fmi") and done.stderr.count("\n") == 1, done.stderr


def test_a_unit_that_fails_to_save_its_state_has_the_last_word(run):
    done = run("get_fmu_state", "pressure_jump")
    assert (done.returncode, done.stderr) == (1, "error: rod: no licence for get_fmu_state\n")


@pytest.mark.parametrize("load", INPUTS)
@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("nan", "its output x[9] is nan m at t = 0.016 s"),
        ("inf", "its output x[9] is inf m at t = 0.016 s"),
        ("huge", "its output x[9] is 1e+30 m at t = 0.016 s"),
        ("fast", "its output vy[4] is -1e+13 m/s at t = 0.016 s"),
        ("far", "its station 9 is at (50, 0.287"),
        ("nan at start", "its output x[3] is nan m at t = 0.004 s"),
    ],
)
def test_an_output_that_cannot_be_is_laid_to_its_unit(run, load, wrong, said):
    done = run(wrong, load)
    assert done.returncode == 1 and done.stderr.startswith(f"error: rod: {said}"), done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("wrong", ["half", "none"])
def test_a_unit_that_does_not_roll_back_is_refused_where_it_must(run, wrong):
    done = run(wrong, "pressure_jump")
    assert done.returncode == 1, done.stderr
    assert "the rod does not come back to the state that it saved" in done.stderr
    assert run(wrong).returncode == 0, "an explicit scheme repeats nothing"


def changed(*path, value):
    """The pair with another value of a key."""
    scene: dict[str, Any] = copy.deepcopy(PAIR) | {"name": "other"}
    part = scene
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = value
    return scene


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        (changed("beam", "length", value=0.5), "its station 9 is at (0.478"),
        (changed("beam", "root", "at", "position", value=[0.01, 0.0]), "m at the start, but at ("),
        (changed("beam", "root", "at", "direction", value=[1.0, 0.31]), "its station 9 is at (0.955"),
        (changed("beam", "thickness", value=0.15), "its `displaced_line_density` is 0.15 kg/m2, but 0.2 kg/m2 in the"),
        (changed("fluid", "density", value=4.0), "its `displaced_line_density` is 0.8 kg/m2, but 0.2 kg/m2 in the"),
    ],
)
def test_a_rod_of_another_scene_is_refused_by_name(run, packed, tmp_path, scene, said):
    done = run("", rod=packed("rod", scene))
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("error: the FMU of the rod, other.rod, is of another scene than pair: "), done.stderr
    assert said in done.stderr


@pytest.mark.parametrize(
    ("scene", "said"),
    [
        (changed("beam", "root", "at", "position", value=[0.5, 0.0]), "its station "),
        (changed("fluid", "density", value=4.0), "its `density` is 4 kg/m3, but 1 kg/m3 in the scene"),
    ],
)
def test_a_fluid_of_another_scene_is_refused_by_name(run, packed, scene, said):
    done = run("", fluid=packed("fluid", scene))
    assert done.returncode == 2, done.stderr
    assert f"the FMU of the fluid, other.fluid, is of another scene than pair: {said}" in done.stderr


@pytest.mark.parametrize("version", [2, 3])
def test_a_rod_of_another_material_is_a_rod_of_the_scene(run, packed, version):
    softer = changed("rod", "material", "plane_strain", "youngs_modulus", value=2e3)
    done = run("", rod=packed("rod", softer, version))
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("root", [None, "fluid"])
def test_a_root_that_nobody_moves_is_refused(run_scene_of, root):
    scene = copy.deepcopy(PAIR)
    scene["rod"]["root_motion"] = "master"
    if root is None:
        del scene["fluid"], scene["coupling"]
    done = run_scene_of(scene)
    assert done.returncode == 2 and "to the master (root_motion)" in done.stderr, done.stderr


@pytest.fixture
def run_scene_of(tmp_path):
    """Function that runs a scene that is given as a dict."""

    def run(scene, *arguments):
        path = tmp_path / "scene.json"
        path.write_text(json.dumps(scene))
        return run_scene(path, "--output", tmp_path / "results", "--quiet", *arguments)

    return run


@pytest.mark.parametrize("option", ["--rod-fmu", "--fluid-fmu"])
def test_an_fmu_without_a_unit_to_replace_is_refused(run_scene_of, packed, fluid_only, rod_only, option):
    scene, other = (fluid_only, rod_only) if option == "--rod-fmu" else (rod_only, fluid_only)
    done = run_scene_of(scene, option, packed("rod" if option == "--rod-fmu" else "fluid", other))
    assert done.returncode == 2 and f"the scene has no {option[2:-4]}" in done.stderr, done.stderr


def rewritten(fmu, target, change):
    """A copy of an FMU with `change(name, data)` in place of each file."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(target, "w") as copied:
        for name in source.namelist():
            copied.writestr(name, change(name, source.read(name)))
    return target


def in_description(old, new):
    """A change of the model description."""
    return lambda name, data: data.replace(old, new) if name == "modelDescription.xml" else data


@pytest.mark.parametrize(
    "change",
    [
        in_description(b'start="', b'start="one '),
        in_description(b"</fmiModelDescription>", b""),
        in_description(b'valueReference="5"', b'valueReference="-5"'),
        in_description(b'valueReference="5"', b'valueReference="five"'),
        in_description(b'name="x[', b'nome="x['),
        in_description(b"modelIdentifier=", b"identifier="),
        in_description(b'fmiVersion="2.0"', b""),
        in_description(b'causality="output"', b'causality="exit"'),
        in_description(b'unit="m"', b'unit="mm"'),
        in_description(b"<CoSimulation", b"<ModelExchange"),
        lambda name, data: b"no library" if name.startswith("binaries") else data,
        lambda name, data: b"" if name == "modelDescription.xml" else data,
    ],
)
def test_a_description_or_library_that_cannot_be_used_is_refused(run, packed, tmp_path, change):
    rod = packed("rod", PAIR)
    done = run("", rod=rewritten(rod, tmp_path / "bad.fmu", change))
    assert done.returncode == 2 and "Traceback" not in done.stderr, done.stderr
    assert done.stderr.startswith("error: "), done.stderr


@pytest.mark.parametrize("name", ["../outside", "binaries/../../outside", "/tmp/outside", "..\\outside", "C:\\outside"])
def test_an_entry_outside_of_an_fmu_is_refused(run, packed, tmp_path, name):
    bad = rewritten(packed("rod", PAIR), tmp_path / "bad.fmu", lambda _, data: data)
    with zipfile.ZipFile(bad, "a") as archive:
        archive.writestr(name, "text")
    done = run("", rod=bad)
    assert done.returncode == 2 and "lies outside of it" in done.stderr, done.stderr


@pytest.mark.parametrize("entry", ["resources/zeros", "modelDescription.xml"])
def test_an_fmu_that_unpacks_to_too_much_is_refused(run, packed, tmp_path, entry):
    """The archive says so in its list of entries, which the reader of zip files holds it to."""
    bad = tmp_path / "bomb.fmu"
    with zipfile.ZipFile(bad, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("resources/zeros", b"0")
        archive.writestr("modelDescription.xml", b"0")
        archive.getinfo(entry).file_size = 3 << 30
    done = run("", rod=bad)
    assert done.returncode == 2 and " MB, but at most" in done.stderr, done.stderr


def test_a_damaged_or_encrypted_entry_is_refused(run, packed, tmp_path):
    whole = packed("rod", PAIR).read_bytes()
    bad = tmp_path / "bad.fmu"
    for at in (len(whole) // 2, len(whole) // 3):
        bad.write_bytes(whole[:at] + bytes([whole[at] ^ 255]) + whole[at + 1 :])
        done = run("", rod=bad)
        assert done.returncode == 2 and "Bad CRC-32" in done.stderr, done.stderr


@pytest.mark.parametrize("kind", ["inspect", "merge"])
def test_other_commands_refuse_a_bad_fmu_too(packed, tmp_path, kind):
    bad = rewritten(packed("rod", PAIR), tmp_path / "bad.fmu", in_description(b'start="', b'start="one '))
    arguments = {"inspect": [bad], "merge": [bad, packed("rod", PAIR), "--output", tmp_path / "merged.fmu"]}[kind]
    done = nervure(kind, *arguments)
    assert done.returncode == 2 and "Traceback" not in done.stderr, done.stderr
