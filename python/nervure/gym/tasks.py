"""Small tasks on coarse grids, and a classical controller for each: what a trained one must beat.

An environment step takes one to three milliseconds of a core. The flows are those of coarse grids, not of nature.
"""

import math
from collections.abc import Callable

import numpy as np

from nervure.gym.env import Action, Env
from nervure.scene import load

FLAG, GUST = 0.2, 1.2  # Amplitude of the tip of the fluttering flag, m, and of its velocity, m/s
TURN = 0.3  # Largest angle of its root, rad
STROKE = 0.3  # Largest displacement of a heaving root, m
POWER = 0.2  # Thrust that a power is worth, N/W

Baseline = Callable[[np.ndarray, float], np.ndarray]
"""A controller: the action after an observation at a time, s."""


def swimmer(render_mode: str | None = None) -> Env:
    """Swim fast: a filament in still fluid whose leading end heaves and slides. Reward: the speed upstream, m/s."""
    scene = load("filament-swimming-144x48").copy({"rod.root_motion": "master"})
    seen = {"root_vx": 0.5, "tip_uy": STROKE, "tip_vy": 2.0, "root.y": STROKE, "root.vy": 2.0}
    action = Action("root.y", -STROKE, STROKE, lag=0.05)
    return Env(scene, [action], seen, lambda values, _: -values["root_vx"], render_mode=render_mode)


def swim(_seen: np.ndarray, time: float) -> np.ndarray:
    """Heave as a sine."""
    return np.array([STROKE * math.sin(2 * math.pi * time)])


def flag(render_mode: str | None = None) -> Env:
    """Still a flag that flutters in a stream, by turning its root. Reward: minus the squared displacement of the tip,
    1 at the amplitude without control. An episode begins in one of four phases of the flutter."""
    step = 0.01
    scene = load("flag-line-480x240").copy(
        {
            "time.communication_step": step,
            "fluid.time_stepping.max_step": step,
            "fluid.box.cells": [100, 50],
            "fluid.mask.log_linear.c_eta": 1e-3,
            "beam.segments": 16,
            "rod.root_motion": "master",
            "rod.material.section.line_density": 0.2,
            "rod.material.section.bending_stiffness": 1e-3,
        }
    )
    return Env(
        scene,
        [Action("root.angle", -TURN, TURN, lag=0.05)],
        {"tip_uy": FLAG, "tip_vy": GUST, "lift": 0.5, "root.angle": TURN},
        lambda values, _: -((values["tip_uy"] / FLAG) ** 2),
        steps=5,
        starts=(12.0, 12.25, 12.5, 12.75),
        failed=-10.0,
        render_mode=render_mode,
    )


def still(seen: np.ndarray, _time: float) -> np.ndarray:
    """Turn the root against the velocity of the tip."""
    return np.array([-0.4 * seen[1]])


def wake(render_mode: str | None = None) -> Env:
    """Swim in the wake of a cylinder: heave the leading end of a filament for thrust. Reward: thrust, N/m, less `POWER`
    times the power at the root. An episode begins in one of four phases of the vortex street."""
    step, place = 0.01, 2.5
    scene = load("filament-swimming-144x48").copy(
        {
            "time.communication_step": step,
            "fluid.time_stepping.max_step": step,
            "fluid.box": {"x": [-2.0, 7.0], "y": [-2.0, 2.0], "cells": [120, 54]},
            "fluid.kinematic_viscosity": 0.006,
            "fluid.mask.log_linear.c_eta": 1e-3,
            "fluid.initial_velocity": [1.0, 0.0],
            "fluid.mean_flow": {"x": {"constant": 1.0}},
            "fluid.sponge": {"x": [6.0, 7.0], "mean_velocity": {"constant": 1.0}, "c_eta": 0.05},
            "fluid.cylinders": [{"center": [0.0, 0.0], "radius": 0.3}],
            "fluid.disturbance": 0.5,
            "fluid.probes": [{"name": "ahead", "position": [place - 0.3, 0.0]}],
            "beam.root.at.position": [place, 0.0],
            "beam.segments": 10,
            "rod.root_motion": "master",
            "rod.slide": None,
            "rod.material.section.bending_stiffness": 0.3,
        }
    )
    return Env(
        scene,
        [Action("root.y", -STROKE, STROKE, lag=0.1)],
        {"probe_ahead_v": 1.0, "cylinder_1_lift": 0.3, "tip_uy": STROKE, "root.y": STROKE, "root.vy": 2.0},
        lambda values, _: -values["beam_drag"] - POWER * values["root_power"],
        starts=(30.0, 31.0, 32.0, 33.0),
        failed=-10.0,
        render_mode=render_mode,
    )


def slalom(seen: np.ndarray, _time: float) -> np.ndarray:
    """Move with the velocity across the stream ahead, from vortex to vortex."""
    return np.array([0.8 * seen[0]])


BASELINES: dict[str, Baseline] = {"nervure/Swimmer-v0": swim, "nervure/Flag-v0": still, "nervure/Wake-v0": slalom}
