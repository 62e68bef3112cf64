"""Situations that people reported of similar tools: the numbers that come out, and the words beside them."""

import copy
import math
import re
from typing import Any

import numpy as np
import pytest

import nervure
from nervure.scene import validate

SQUARE: dict[str, Any] = {
    "name": "square",
    "time": {"end": 60.0, "communication_step": 0.02},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 0.01,
        "box": {"x": [-4.0, 12.0], "y": [-5.0, 5.0], "cells": [192, 120]},
        "mean_flow": {"x": {"constant": 1.0}},
        "initial_velocity": [1.0, 0.0],
        "sponge": {"x": [9.5, 12.0], "mean_velocity": {"constant": 1.0}, "c_eta": 0.1},
        "bodies": [{"shape": {"rectangle": {"length": 1.0, "thickness": 1.0}}, "position": [0.0, 0.02]}],
        "mask": {"log_linear": {"c_eta": 1e-4}},
        "time_stepping": {"max_step": 0.02, "max_cfl": 0.4},
    },
}
"""A square in a stream at Re 100, which sheds vortices after some 30 s."""

CANTILEVER = {
    "name": "cantilever",
    "time": {"end": 20.0, "communication_step": 0.005},
    "beam": {"root": {"at": {}}, "length": 1.0, "thickness": 0.02, "segments": 24},
    "rod": {
        "material": {"section": {"line_density": 1.0, "bending_stiffness": 1.0, "axial_stiffness": 1e4}},
        "scheme": "trapezoid",
    },
}
"""A rod in space that gravity bends."""

DRIVEN = {
    "name": "driven",
    "time": {"end": 4.0, "communication_step": 0.002},
    "beam": {
        "root": {"at": {"position": [0.0, 0.0], "direction": [1.0, 0.0]}},
        "length": 1.0,
        "thickness": 0.05,
        "segments": 20,
    },
    "rod": {"material": {"section": {"line_density": 0.5, "bending_stiffness": 2.0, "axial_stiffness": 1e3}}},
}
"""A rod in vacuo whose root heaves."""


@pytest.fixture
def run(tmp_path, libraries):
    """Function that runs a scene and returns the run."""

    def run(scene):
        return nervure.run(validate(scene), tmp_path / scene["name"], quiet=True, force=True)

    return run


@pytest.mark.parametrize("shape", [{"circle": {"radius": 0.5}}, {"rectangle": {"length": 1.0, "thickness": 1.0}}])
def test_a_flow_that_stays_symmetric_has_a_lift_of_rounding(run, shape):
    """The faces of the square lie on lines of the grid, to rounding."""
    scene = copy.deepcopy(SQUARE)
    scene["fluid"]["bodies"] = [{"shape": shape, "position": [0.0, 0.0]}]
    scene["fluid"]["box"]["cells"] = [96, 60]
    scene["time"]["end"] = 3.0
    lift = run(scene).summary.quantities["lift"]
    assert (lift.state, lift.frequency_hz) == ("rounding", None), lift


@pytest.mark.parametrize("down", [(0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (0.0, -0.6, -0.8)])
def test_a_rod_in_space_has_the_same_frequency_in_every_direction(run, down):
    """0.56 Hz, by the first mode of a cantilever."""
    scene = copy.deepcopy(CANTILEVER)
    scene["beam"]["root"]["at"] = {"position": [0.0, 0.0, 0.0], "direction": [1.0, 0.0, 0.0]}
    scene["rod"]["gravity"] = [0.5 * g for g in down]
    summary = run(scene).summary
    assert summary.periods == 10
    assert summary.periods / (summary.window_s[1] - summary.window_s[0]) == pytest.approx(
        1.8751**2 / 2 / math.pi, rel=2e-3
    )


@pytest.mark.parametrize("points", [12, 20])
def test_a_table_of_a_sine_drives_as_the_sine_does(run, points):
    """Up to the first and the last interval, of which the ends are free."""

    def root_force(law):
        scene = copy.deepcopy(DRIVEN)
        scene["rod"]["root_motion"] = {"laws": {"y": law}}
        series = run(scene).series
        return series["root_force_y"][series["time"] > 1.0]

    sine = root_force({"sine": {"amplitude": 0.2, "frequency": 1.0}})
    phases = np.arange(points + 1) / points
    values = 0.2 * np.sin(2 * np.pi * phases)
    values[-1] = values[0]
    table = root_force({"table": {"times": phases.tolist(), "values": values.tolist(), "periodic": True}})
    apart = np.sqrt(np.mean((table - sine) ** 2) / np.mean(sine**2))
    assert apart < (0.06 if points == 12 else 0.02), apart
    series = root_force(
        {"sum": [{"fourier": {"frequency": 1.0, "sines": [0.3]}}, {"sine": {"amplitude": -0.1, "frequency": 1.0}}]}
    )
    assert series == pytest.approx(sine, abs=1e-6 * np.abs(sine).max())


def test_short_waves_of_the_flow_are_told_and_the_step_that_is_named_damps_them(run):
    """In the middle of a channel without bodies the fastest flow is a stream; elsewhere waves leave it."""
    scene = {
        "name": "channel",
        "time": {"end": 6.0},
        "fluid": {
            "density": 1.0,
            "kinematic_viscosity": 5e-5,
            "box": {"x": [-1.0, 3.0], "y": [-0.6, 0.6], "cells": [160, 48]},
            "channel": {"y": [-0.5, 0.5]},
            "inflow": {
                "x": [-1.0, -0.6],
                "profile": "parabolic",
                "mean_velocity": {"cosine_ramp": {"value": 1.0, "duration": 1.0}},
                "c_eta": 1e-2,
            },
            "disturbance": 0.01,
            "mask": {"log_linear": {"c_eta": 1e-2}},
            "time_stepping": {"scheme": "rk2", "max_cfl": 0.4},
        },
    }

    def told(step):
        scene["time"]["communication_step"] = scene["fluid"]["time_stepping"]["max_step"] = step
        return [text for text in run(scene).summary.warnings or [] if text.startswith("short waves along x")]

    (text,) = told(0.005)
    assert not told(float(re.search(r"`fluid\.time_stepping\.max_step` of (\S+) s damps", text)[1]))


def test_fluid_at_rest_has_no_waves_to_tell_of(run):
    scene = copy.deepcopy(SQUARE)
    scene["time"]["end"] = 0.1
    del scene["fluid"]["bodies"]
    for key in ("initial_velocity", "mean_flow", "sponge", "inflow"):
        scene["fluid"].pop(key, None)
    assert run(scene).summary.warnings is None
