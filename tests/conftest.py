"""Scenes and units that several tests use."""

import copy
import hashlib
import io
import os
import subprocess
import sys
import zipfile
from collections.abc import Callable
from contextlib import ExitStack, chdir, redirect_stderr, redirect_stdout
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest

from nervure import coupling
from nervure.cli import main
from nervure.output.pictures import Pictures
from nervure.resources import ROOT
from nervure.scene import read, text, validate
from nervure.units import package
from nervure.units.describe import describe, unit_names
from nervure.units.fmu import Unit

FSI1, FSI3 = (ROOT / "scenes" / f"{name}.json" for name in ("fsi1-648x108", "fsi3-325x72"))
COUPLED = ("rod", "fluid")
"""Kinds of the units of the FSI3 scene; those of a wing have tests of their own."""

SCENES = sorted((ROOT / "scenes").glob("*.json"))

ROD_ONLY = {
    "name": "falling-rod",
    "time": {"end": 0.01, "communication_step": 1e-4},
    "beam": {
        "root": {"at": {"position": [0.0, 0.0], "direction": [1.0, 0.0]}},
        "length": 0.35,
        "thickness": 0.02,
        "segments": 16,
    },
    "rod": {
        "material": {"plane_strain": {"density": 1000.0, "youngs_modulus": 1.4e6, "poisson_ratio": 0.4}},
        "gravity": [0.0, -2.0],
    },
}
"""The bar of CSM3 (Turek & Hron 2006), let go at t = 0."""

FLUID_ONLY = {
    "name": "cylinder-in-a-stream",
    "time": {"end": 0.02, "communication_step": 1e-3},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 1e-2,
        "box": {"x": [-1.0, 1.0], "y": [-0.5, 0.5], "cells": [64, 32]},
        "initial_velocity": [1.0, 0.0],
        "inflow": {"x": [-1.0, -0.8], "profile": "uniform", "mean_velocity": {"constant": 1.0}, "c_eta": 1e-2},
        "cylinders": [{"center": [0.0, 0.0], "radius": 0.15}],
        "mask": {"cosine": {"c_eta": 1e-2, "half_width": 1.0}},
        "time_stepping": {"max_step": 1e-3, "max_cfl": 0.4},
    },
}
"""A cylinder in the middle of a uniform stream that starts at once."""


TWO_RODS = {
    "name": "two",
    "time": {"end": 0.3, "communication_step": 2e-3},
    "fluid": {
        "box": {"x": [0.0, 4.0], "y": [-1.0, 1.0], "cells": [128, 64]},
        "density": 1.0,
        "kinematic_viscosity": 5e-3,
        "initial_velocity": [1.0, 0.0],
        "mean_flow": {"x": {"constant": 1.0}},
        "mask": {"log_linear": {"c_eta": 1e-3}},
        "time_stepping": {"max_step": 2e-3, "max_cfl": 0.3},
    },
    "rods": [
        {
            "name": name,
            "beam": {
                "root": {"at": {"position": [1.0, side * 0.25], "direction": [1.0, side * 0.2]}},
                "length": 1.0,
                "thickness": 0.1,
                "segments": 16,
            },
            "rod": {
                "material": {"section": {"line_density": 0.3, "bending_stiffness": 2e-3, "axial_stiffness": 200.0}}
            },
        }
        for name, side in (("upper", 1), ("lower", -1))
    ],
}


draw = Pictures.finish


def pytest_runtest_setup(item):
    """Let only tests that look at pictures draw those of their runs: they take most of a short run."""
    Pictures.finish = draw if item.get_closest_marker("pictures") else lambda self, results: None


@pytest.fixture(scope="session")
def libraries():
    """The libraries, built from the sources as they are; those in `NERVURE_LIBRARIES` are taken as they are."""
    if "NERVURE_LIBRARIES" not in os.environ:
        subprocess.run(["cargo", "build", "--quiet", "--release", "--locked"], cwd=ROOT, check=True)


@pytest.fixture
def fsi3():
    """The shipped FSI3 scene, as JSON."""
    return read(FSI3)


@pytest.fixture
def small_fsi3(fsi3):
    """FSI3 on a grid that is good enough for questions about the interface; the channel runs from the start."""
    fsi3["name"] = "small-fsi3"
    fsi3["fluid"]["box"]["cells"] = [160, 36]
    fsi3["fluid"]["inflow"]["mean_velocity"] = {"constant": 1.0}
    fsi3["beam"]["segments"] = 20
    return fsi3


@pytest.fixture
def rod_only():
    return copy.deepcopy(ROD_ONLY)


@pytest.fixture
def fluid_only():
    return copy.deepcopy(FLUID_ONLY)


@pytest.fixture
def two_rods():
    """Two equal rods in a stream, mirror images at y = 0, where the grid has a row."""
    return copy.deepcopy(TWO_RODS)


@pytest.fixture(scope="session", autouse=True)
def packing_is_quick():
    """FMUs of the tests are not compressed, which would take longer than most runs."""
    package.COMPRESSION = zipfile.ZIP_STORED


@pytest.fixture(scope="session")
def packed(tmp_path_factory, libraries):
    """Function that packs a unit of a scene, each only once: that takes longer than most tests."""
    folder = tmp_path_factory.mktemp("packed")

    def pack(kind: str, scene: dict, version: int = 2) -> Path:
        digest = hashlib.sha256(f"{version} {text(scene)}".encode()).hexdigest()[:16]
        path = folder / digest / f"{scene['name']}-{kind}.fmu"
        return path if path.exists() else package.pack(describe(kind, scene, version), path.parent)

    return pack


@pytest.fixture
def instantiate(packed):
    """Function that packs a scene and returns its units by kind, which are closed after the test."""
    with ExitStack() as stack:

        def make(scene: dict, version: int = 2) -> dict[str, Unit]:
            units = {}
            for kind in unit_names(scene):
                units[kind] = Unit(packed(kind, scene, version), kind, scene["time"]["end"])
                stack.callback(units[kind].close)
            return units

        yield make


@pytest.fixture
def start(instantiate):
    """Function that makes the coupling of a scene, with both units ready for their first step."""

    def make(scene: dict):
        scheme = coupling.couple(instantiate(scene), validate(scene).coupling)
        scheme.start()
        return scheme

    return make


def output(unit: Unit, name: str) -> np.ndarray:
    """View of one of a unit's outputs."""
    return unit.outputs[unit.slices[name]]


TOOL = [sys.executable, "-m", "nervure"]
"""The command in a process of its own."""


def stopped(number: int, steps: int, *arguments) -> subprocess.CompletedProcess:
    """Run the command in a process of its own that gets a signal after so many steps: see `stopped.py`."""
    command = [sys.executable, ROOT / "tests" / "stopped.py", str(int(number)), str(steps), *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300)


def goes_back_and_on(unit: Unit, other: Unit, run: Callable[[Unit, int], np.ndarray], steps: int) -> np.ndarray:
    """Check that a started unit repeats `steps` steps from its saved state bit by bit, and that `other` makes them from
    the serialized state; `run` makes that many steps after the first ones and returns what they give, as this does."""
    run(unit, 0)
    unit.save()
    state = unit.serialize()
    expected = run(unit, steps)
    unit.restore()
    assert np.array_equal(run(unit, steps), expected)
    other.deserialize(state)
    assert np.array_equal(run(other, steps), expected)
    return expected


def nervure(*arguments, cwd=".", env=os.environ) -> subprocess.CompletedProcess:
    """Run the command in this process, which spares its start; `TOOL` is for what needs one of its own."""
    argv, environment = ["nervure", *map(str, arguments)], dict(env)
    with (
        chdir(cwd),
        patch.dict(os.environ, environment, clear=True),
        patch.object(sys, "argv", argv),
        redirect_stdout(io.StringIO()) as out,
        redirect_stderr(io.StringIO()) as errors,
        pytest.raises(SystemExit) as ended,
    ):
        main()
        sys.exit(0)
    return subprocess.CompletedProcess(argv, int(ended.value.code or 0), out.getvalue(), errors.getvalue())


def run_scene(scene: Path, *arguments, **keywords) -> subprocess.CompletedProcess:
    return nervure("run", scene, *arguments, **keywords)
