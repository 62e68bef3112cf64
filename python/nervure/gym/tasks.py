"""Small tasks on coarse grids, and a classical controller for each: what a trained one must beat.

An environment step takes one to three milliseconds of a core, in space some thirty. The flows are those of coarse
grids, not of nature.
"""

import math
from pathlib import Path

import numpy as np

from nervure.gym.env import Action, Baseline, Env
from nervure.resources import ROOT
from nervure.scene import load

FLAG, GUST = 0.2, 1.2  # Amplitude of the tip of the fluttering flag, m, and of its velocity, m/s
TURN = 0.3  # Largest angle of its root, rad
STROKE = 0.3  # Largest displacement of a heaving root, m
POWER = 0.2  # Thrust that a power is worth, N/W
BEAT = 200.0  # Frequency of the flyer's wings, Hz
SWEEP, SWEEPS = 1.45, (0.9, 1.75)  # Stroke that bears it, and its limits, rad
PITCH, EARLY, SUDDEN = 0.7, 0.3, 2.5  # Turn of the chord from upright, rad; how early, rad; how sudden
REACH, CLIMB = 1e-3, 0.1  # Largest distance from the point, m, and scale of the climb, m/s
SERVO = 2.5e-4  # Lag of its hinges, and length of a step, s
LEAD = 2 * math.atan(math.tau * BEAT * SERVO) + math.pi * BEAT * SERVO  # Angle by which a hinge is late, rad
GAIN = 1 + (math.tau * BEAT * SERVO) ** 2  # Part by which it shrinks a sine
LIFT, DAMPING = 0.8, 0.3  # Changes of the stroke by a distance of `REACH` and a climb of `CLIMB`, rad
UPRIGHT = 2.5e-3  # Time in which the wings turn upright and the stroke begins, s
EPISODES = {"Swimmer": 200, "Flag": 200, "Wake": 150, "Hover": 200}  # Steps of an episode


def swimmer(render_mode: str | None = None) -> Env:
    """Swim fast: a filament in still fluid whose leading end heaves and slides. Reward: the speed upstream, m/s."""
    scene = load("filament-swimming-144x48").copy({"rod.root_motion": "master"})
    seen = {"root_vx": 0.5, "tip_uy": STROKE, "tip_vy": 2.0, "root.y": STROKE, "root.vy": 2.0}
    action = Action("root.y", -STROKE, STROKE, lag=0.05)
    return Env(scene, [action], seen, lambda values, _: -values["root_vx"], render_mode=render_mode)


def swim(_seen: np.ndarray, time: float) -> np.ndarray:
    """Heave as a sine."""
    return np.array([STROKE * math.sin(2 * math.pi * time)])


def flag(render_mode: str | None = None, cache: str | Path | None = None) -> Env:
    """Still a flag that flutters in a stream, by turning its root. Reward: minus the squared displacement of the tip,
    1 at the amplitude without control. An episode begins in one of four phases of the flutter."""
    step, steps, starts = 0.01, 5, (12.0, 12.25, 12.5, 12.75)
    scene = load("flag-line-480x240").copy(
        {
            "time.end": starts[-1] + EPISODES["Flag"] * steps * step,
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
        steps=steps,
        starts=starts,
        failed=-10.0,
        cache=cache,
        render_mode=render_mode,
    )


def still(seen: np.ndarray, _time: float) -> np.ndarray:
    """Turn the root against the velocity of the tip."""
    return np.array([-0.4 * seen[1]])


def wake(render_mode: str | None = None, cache: str | Path | None = None) -> Env:
    """Swim in the wake of a cylinder: heave the leading end of a filament for thrust. Reward: thrust, N/m, less `POWER`
    times the power at the root. An episode begins in one of four phases of the vortex street."""
    step, steps, starts, place = 0.01, 10, (30.0, 31.0, 32.0, 33.0), 2.5
    scene = load("filament-swimming-144x48").copy(
        {
            "time.end": starts[-1] + EPISODES["Wake"] * steps * step,
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
        steps=steps,
        starts=starts,
        failed=-10.0,
        cache=cache,
        render_mode=render_mode,
    )


def slalom(seen: np.ndarray, _time: float) -> np.ndarray:
    """Move with the velocity across the stream ahead, from vortex to vortex."""
    return np.array([0.8 * seen[0]])


def hover(render_mode: str | None = None, cache: str | Path | None = None) -> Env:
    """Hover at a point: flap two wings whose body may only rise and sink. Reward: 1 at the point, less the squared
    distance by `REACH`, where the episode ends. It begins in one of four phases of the stroke."""
    steps, starts, wing = 10, [(2 + i / 4) / BEAT for i in range(4)], "wings.{}.wing.mesh.insect.along"
    scene = load(ROOT / "examples" / "flyer-pid.json").copy(
        {
            "time.end": starts[-1] + EPISODES["Hover"] * SERVO,
            "time.communication_step": SERVO / steps,
            "fluid.time_stepping.max_step": SERVO / steps,
            "fluid.box.cells": [20, 16, 20],
            "flyer.held": ["x", "angle_y", "angle_z"],
            "flyer.velocity": [0.0, 0.0, 0.0],
            "flyer.angular_velocity": [0.0, 0.0, 0.0],
            **{wing.format(i): 4 for i in range(2)},
        }
    )
    pitches = {"left": (-0.5, math.pi + 0.5), "right": (-math.pi - 0.5, 0.5)}  # The right hinge is turned
    actions = [Action(f"{side}.stroke", -2.0, 2.0, SERVO) for side in pitches]
    actions += [Action(f"{side}.pitch", *ends, SERVO) for side, ends in pitches.items()]
    seen = {"body_z": REACH, "body_vz": CLIMB, "left.stroke": 1.0, "left.stroke_rate": math.tau * BEAT}
    seen |= {"right.stroke": 1.0, "right.stroke_rate": math.tau * BEAT, "left.pitch": 1.0, "right.pitch": 1.0}
    return Env(
        scene,
        actions,
        seen,
        lambda values, _: 1 - (values["body_z"] / REACH) ** 2,
        steps=steps,
        starts=starts,
        before=take_off,
        ends=lambda values: abs(values["body_z"]) > REACH,
        cache=cache,
        render_mode=render_mode,
    )


def flap(seen: np.ndarray, time: float) -> np.ndarray:
    """Flap with a stroke that is the larger, the lower the body is and the faster it sinks."""
    height, climb, *_ = seen
    sweep = min(max(SWEEP - LIFT * height - DAMPING * climb, SWEEPS[0]), SWEEPS[1])
    phase = math.tau * BEAT * time + LEAD
    turned = math.tanh(SUDDEN * math.cos(phase + EARLY)) / math.tanh(SUDDEN)
    sweep, pitch = GAIN * sweep * math.sin(phase), math.pi / 2 - PITCH * turned
    return np.array([sweep, sweep, pitch, -pitch])


def take_off(seen: np.ndarray, time: float) -> np.ndarray:
    """Flap more and more from rest."""
    begun = min(time / UPRIGHT, 1.0)
    return begun**2 * (3 - 2 * begun) * flap(seen, time)


BASELINES: dict[str, Baseline] = {
    "nervure/Swimmer-v0": swim,
    "nervure/Flag-v0": still,
    "nervure/Wake-v0": slalom,
    "nervure/Hover-v0": flap,
}
