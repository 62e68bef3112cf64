"""Scenes that cannot be meant are refused, and what may be a mistake is said, by name, place and time."""

import copy
import json
from typing import Any

import numpy as np
import pytest

from nervure.evaluate import benchmark
from nervure.library import check, facts
from nervure.scene import assign, read, text, validate
from nervure.simulation.session import Session
from tests.conftest import SCENES

CHANNEL: dict[str, Any] = {
    "name": "channel",
    "time": {"end": 1.0, "communication_step": 0.01},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 0.01,
        "box": {"x": [-2.0, 4.0], "y": [-1.5, 1.5], "cells": [120, 60]},
        "channel": {"y": [-1.0, 1.0]},
        "inflow": {"x": [-2.0, -1.5], "profile": "parabolic", "mean_velocity": {"constant": 1.0}, "c_eta": 1e-3},
        "mask": {"log_linear": {"c_eta": 1e-4}},
        "time_stepping": {"max_step": 0.01, "max_cfl": 0.4},
    },
}
"""A channel of 40 cells with an inflow, in a box whose cells are 0.05 m."""

STREAM: dict[str, Any] = {
    "name": "stream",
    "time": {"end": 60.0, "communication_step": 0.015},
    "fluid": {
        "density": 1.0,
        "kinematic_viscosity": 0.01,
        "box": {"x": [-6.0, 14.0], "y": [-6.0, 6.0], "cells": [320, 192]},
        "mean_flow": {"x": {"constant": 1.0}},
        "initial_velocity": [1.0, 0.0],
        "sponge": {"x": [11.0, 14.0], "mean_velocity": {"constant": 1.0}, "c_eta": 0.1},
        "mask": {"log_linear": {"c_eta": 1e-4}},
        "time_stepping": {"max_step": 0.015, "max_cfl": 0.4},
    },
}
"""A stream through a periodic box, with a sponge."""


def circle(x: float, y: float, radius: float, **more: Any) -> dict[str, Any]:
    """Return a circular body."""
    return {"shape": {"circle": {"radius": radius}}, "position": [x, y], **more}


def bar(x: float, y: float, length: float, thickness: float, **more: Any) -> dict[str, Any]:
    """Return a rectangular body."""
    return {"shape": {"rectangle": {"length": length, "thickness": thickness}}, "position": [x, y], **more}


def beam(x: float, y: float, direction: tuple[float, float], length: float = 1.0, **more: Any) -> dict[str, Any]:
    """Return a beam whose root is at a point."""
    root = {"at": {"position": [x, y], "direction": list(direction)}}
    return {"root": root, "length": length, "thickness": 0.1, "segments": 20, **more}


ROD: dict[str, Any] = {"material": {"section": {"line_density": 1.0, "bending_stiffness": 0.1, "axial_stiffness": 1e3}}}


def rods(*beams: dict[str, Any]) -> list[dict[str, Any]]:
    """Return rods with these beams."""
    return [{"name": f"r{i}", "beam": own, "rod": ROD} for i, own in enumerate(beams)]


def changed(scene: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """Return the scene with other values of keys, in which `__` stands for a point."""
    scene = copy.deepcopy(scene)
    for key, value in changes.items():
        assign(scene, key.replace("__", "."), value)
    return scene


def bodies(*each: dict[str, Any]) -> dict[str, Any]:
    """Return the channel with these bodies."""
    return changed(CHANNEL, fluid__bodies=list(each))


def cylinder(x: float, y: float, radius: float) -> list[dict[str, Any]]:
    """Return a list of one cylinder."""
    return [{"center": [x, y], "radius": radius}]


TRIANGLE = {"shape": {"polygon": {"corners": [[2.2, 0.0], [3.0, 0.0], [3.0, 0.5]]}}, "position": [3.9, 0.0]}
"""A body whose position is in the box, and whose outline is not."""

ITERATED = {"load": "pressure_jump", "scheme": {"iterated": {"tolerance": 1.0}}}

REFUSED = {
    # in the inflow zone or a sponge
    "in-inflow": (bodies(circle(-1.7, 0.0, 0.3)), "fluid.bodies[0].position", "in the inflow zone, x [-2.0, -1.5]"),
    "square in the inflow": (bodies(bar(-1.75, 0.4, 0.4, 0.4)), "fluid.bodies[0].position", "in the inflow zone"),
    "cylinder in the inflow": (
        changed(CHANNEL, fluid__cylinders=cylinder(-1.75, 0.0, 0.1)),
        "fluid.cylinders[0].center",
        "in the inflow zone",
    ),
    "body that a law moves into the inflow at once": (
        bodies(circle(0.0, 0.0, 0.2, motion={"x": {"constant": -1.7}})),
        "fluid.bodies[0].position",
        "in the inflow zone",
    ),
    "in the sponge": (
        changed(STREAM, fluid__bodies=[circle(12.5, 0.0, 0.5)]),
        "fluid.bodies[0].position",
        "in the sponge, x [11.0, 14.0]",
    ),
    "beam in the inflow": (
        changed(CHANNEL, beam=beam(-1.9, 0.0, (1.0, 0.0), 0.3)),
        "beam.root.at.position",
        "most of the beam lies in the inflow zone",
    ),
    # walls of the channel
    "in a wall": (bodies(circle(1.0, 1.2, 0.15)), "fluid.bodies[0].position", "lies in a wall of the channel"),
    "in the lower wall": (bodies(bar(1.0, -1.3, 0.5, 0.3)), "fluid.bodies[0].position", "lies in a wall"),
    "cylinder beyond a wall": (
        changed(CHANNEL, fluid__cylinders=cylinder(1.0, 1.3, 0.1)),
        "fluid.cylinders[0].center",
        "lies in a wall",
    ),
    "beam through the upper wall": (
        changed(CHANNEL, beam=beam(0.0, 0.5, (0.0, 1.0), 0.8)),
        "beam.root.at.position",
        "passes through a wall of the channel at [0, 1.06]",
    ),
    "slanted beam through the lower wall": (
        changed(CHANNEL, beam=beam(0.0, 0.0, (1.0, -1.0), 1.8)),
        "beam.root.at.position",
        "passes through a wall",
    ),
    "beam from wall to wall": (
        changed(CHANNEL, beam=beam(0.0, -1.0, (0.0, 1.0), 2.2)),
        "beam.root.at.position",
        "passes through a wall",
    ),
    "beam in a wall": (changed(CHANNEL, beam=beam(0.0, 1.2, (1.0, 0.0))), "beam.root.at.position", "lies in a wall"),
    # outside the box
    "cylinder outside": (
        changed(STREAM, fluid__cylinders=cylinder(0.0, 9.0, 0.5)),
        "fluid.cylinders[0].center[1]",
        "[-6, 6]",
    ),
    "cylinder before the box": (
        changed(STREAM, fluid__cylinders=cylinder(-7.0, 0.0, 0.5)),
        "fluid.cylinders[0].center[0]",
        "[-6, 14]",
    ),
    "outline outside": (bodies(TRIANGLE), "fluid.bodies[0].position", "lies outside the box"),
    # bodies on bodies
    "twice": (bodies(circle(0.0, 0.0, 0.3), circle(0.0, 0.0, 0.3)), "fluid.bodies[1].position", "`fluid.bodies[0]`"),
    "one in another": (bodies(circle(0.0, 0.0, 0.5), bar(0.1, 0.0, 0.3, 0.2)), "fluid.bodies[1].position", "inside"),
    "larger around smaller": (bodies(bar(0.0, 0.0, 0.2, 0.2), circle(0.0, 0.0, 0.4)), "fluid.bodies[1].position", "in"),
    "cylinder and body": (
        changed(bodies(circle(0.0, 0.0, 0.3)), fluid__cylinders=cylinder(0.0, 0.0, 0.3)),
        "fluid.bodies[0].position",
        "`fluid.cylinders[0]`",
    ),
    # mounts
    "less inertia than the fluid": (
        bodies(bar(0.0, 0.0, 0.6, 0.3, pivot=[0.2, 0.0], mount={"mass": 1.0, "inertia": 1e-3, "angle": {}})),
        "fluid.bodies[0].mount.inertia",
        "at least the moment of inertia of the fluid it displaces, 0.013950",
    ),
    # no way around
    "blocked": (bodies(circle(0.0, 0.0, 1.2)), "fluid.bodies[0].position", "fills the channel from -1 to 1"),
    "plate across": (bodies(bar(0.0, 0.0, 0.1, 1.98)), "fluid.bodies[0].position", "fills the channel"),
    "slanted plate across": (bodies(bar(0.0, 0.0, 3.0, 0.1, angle=0.8)), "fluid.bodies[0].position", "fills the"),
    "plate across the box": (
        changed(STREAM, fluid__bodies=[bar(0.0, 0.0, 0.5, 12.0)]),
        "fluid.bodies[0].position",
        "fills the box from -6 to 6 and stops the stream along x",
    ),
    # beams and bodies
    "root in a cylinder": (
        changed(CHANNEL, fluid__cylinders=cylinder(0.0, 0.0, 0.3), beam=beam(0.0, 0.0, (1.0, 0.0))),
        "beam.root.at.position",
        "`on_cylinder` holds a beam at its surface",
    ),
    "root behind the surface of a cylinder": (
        changed(CHANNEL, fluid__cylinders=cylinder(0.0, 0.0, 0.3), beam=beam(-0.1, 0.1, (0.0, 1.0), 0.5)),
        "beam.root.at.position",
        "the root lies inside `fluid.cylinders[0]`",
    ),
    "beam through a body": (
        changed(bodies(bar(0.5, 0.0, 0.4, 0.4)), beam=beam(0.0, 0.0, (1.0, 0.0))),
        "beam.root.at.position",
        "passes through `fluid.bodies[0]`",
    ),
    "beam through another cylinder": (
        changed(
            CHANNEL,
            fluid__cylinders=cylinder(0.0, 0.0, 0.3) + cylinder(1.0, 0.0, 0.2),
            beam={"root": {"on_cylinder": {"cylinder": 0}}, "length": 1.0, "thickness": 0.1, "segments": 20},
        ),
        "beam.root.on_cylinder.angle",
        "passes through `fluid.cylinders[1]`",
    ),
    "beam in a body": (
        changed(bodies(circle(0.0, 0.0, 0.8)), beam=beam(-0.2, 0.0, (1.0, 0.0), 0.4)),
        "beam.root.at.position",
        "lies inside `fluid.bodies[0]`",
    ),
    # rods on rods
    "rods that cross": (
        changed(CHANNEL, rods=rods(beam(0.0, 0.0, (1.0, 0.0)), beam(0.5, -0.5, (0.0, 1.0)))),
        "rods[1].beam.root.at.position",
        "meets `rods[0].beam`",
    ),
    "rods half on each other": (
        changed(CHANNEL, rods=rods(beam(0.0, 0.0, (1.0, 0.0)), beam(0.5, 0.0, (1.0, 0.0)))),
        "rods[1].beam.root.at.position",
        "meets `rods[0].beam` at [0.5, 0]",
    ),
    "rods head to head": (
        changed(CHANNEL, rods=rods(beam(0.0, 0.0, (1.0, 0.0)), beam(1.0, 0.0, (-1.0, 0.0)))),
        "rods[1].beam.root.at.position",
        "meets `rods[0].beam`",
    ),
    "curved rods that cross": (
        changed(
            CHANNEL,
            rods=rods(
                beam(0.0, 0.0, (1.0, 0.0), rest_angles=[0.05 * i for i in range(20)]), beam(0.3, 0.5, (0.3, -1.0))
            ),
        ),
        "rods[1].beam.root.at.position",
        "meets `rods[0].beam`",
    ),
    # zones and the channel on the grid
    "narrow inflow": (changed(CHANNEL, fluid__inflow__x=[-2.0, -1.96]), "fluid.inflow.x", "at least a cell wide"),
    "narrow sponge": (changed(STREAM, fluid__sponge__x=[13.99, 14.0]), "fluid.sponge.x", "at least a cell wide"),
    "sponge over the box": (changed(STREAM, fluid__sponge__x=[-6.0, 14.0]), "fluid.sponge.x", "leave at least a cell"),
    "sponge wider than the box": (changed(STREAM, fluid__sponge__x=[-6.0, 15.0]), "fluid.sponge.x", "inside the box"),
    "zones over the box": (
        changed(CHANNEL, fluid__sponge={"x": [-1.5, 4.0], "mean_velocity": {"constant": 1.0}, "c_eta": 0.1}),
        "fluid.sponge.x",
        "leave at least a cell",
    ),
    "thin channel": (changed(CHANNEL, fluid__channel__y=[0.0, 0.01]), "fluid.channel.y", "at least a cell high"),
    # absurd numbers
    "clamp longer than the beam": (
        changed(CHANNEL, beam=beam(0.0, 0.0, (1.0, 0.0)), rod={**ROD, "clamp_compliance_length": 1.5}),
        "rod.clamp_compliance_length",
        "at most the length of the beam, 1",
    ),
    "layer as thick as the box": (
        changed(CHANNEL, fluid__mask={"cosine": {"c_eta": 1e-3, "half_width": 50.0}}),
        "fluid.mask.cosine.half_width",
        "must be <= 15",
    ),
    "decay over the box": (
        changed(CHANNEL, fluid__mask={"log_linear": {"c_eta": 1e-3, "decay_length_cells": 40.0}}),
        "fluid.mask.log_linear.decay_length_cells",
        "must be <= 15",
    ),
    "deep core": (
        changed(CHANNEL, fluid__mask={"log_linear": {"c_eta": 1e-3, "core_depth": 1e3}}),
        "fluid.mask.log_linear.core_depth",
        "must be <= 15",
    ),
    "tolerance of a whole step": (
        changed(CHANNEL, beam=beam(0.0, 0.0, (1.0, 0.0)), rod=ROD, coupling=ITERATED),
        "coupling.scheme.iterated.tolerance",
        "not > 0 and < 1",
    ),
}
"""Scene, key and a part of the sentence."""


@pytest.mark.parametrize("scene, key, words", REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_meant_is_refused_by_key(scene, key, words, libraries):
    faults = check(json.dumps(scene))
    assert [fault.key for fault in faults] == [key], faults
    assert words in faults[0].text and faults[0].allowed


STEP = bodies(bar(-1.0, -0.75, 2.0, 0.5))
"""A step that begins in the inflow zone, on the lower wall."""

MEANT = {
    "a step that begins in the inflow": STEP,
    "half a circle on the wall": bodies(circle(1.0, -1.0, 0.3)),
    "a cylinder with a plate behind it": bodies(circle(0.0, 0.0, 0.3), bar(0.6, 0.0, 0.8, 0.06)),
    "a piston in a channel without a stream": changed(bodies(bar(0.0, 0.0, 0.5, 2.0)), fluid__inflow=None),
    "a flap on the wall": changed(CHANNEL, beam=beam(0.0, -1.0, (0.0, 1.0), 0.8)),
    "a flap in the wall": changed(CHANNEL, beam=beam(0.0, -1.2, (0.0, 1.0), 0.8)),
    "two rods from one root": changed(CHANNEL, rods=rods(beam(0.0, 0.0, (1.0, 0.3)), beam(0.0, 0.0, (1.0, -0.3)))),
    "a rod at the tip of another": changed(CHANNEL, rods=rods(beam(0.0, 0.0, (1.0, 0.0)), beam(1.0, 0.0, (0.0, 0.9)))),
    "a rod on a body": changed(bodies(circle(0.0, 0.0, 0.3)), beam=beam(0.25, 0.0, (1.0, 0.0))),
    "a row of cylinders through the edge of the box": changed(STREAM, fluid__cylinders=cylinder(0.0, 6.0, 0.5)),
}


@pytest.mark.parametrize("scene", MEANT.values(), ids=MEANT)
def test_what_may_be_meant_is_not_refused(scene, libraries):
    assert check(json.dumps(scene)) == []


def test_advice_for_the_cfl_number_does_not_lead_back(libraries):
    """With `max_cfl` at its largest value no step is allowed: only a shorter communication step helps."""
    scene = changed(CHANNEL, fluid__inflow__mean_velocity__constant=1e6)
    for max_cfl in (1e-9, 0.4):
        scene["fluid"]["time_stepping"]["max_cfl"] = max_cfl
        (fault,) = check(json.dumps(scene))
        assert fault.key == "time.communication_step", fault
    scene["time"]["communication_step"] = float(fault.text.rsplit(" ", 1)[1])
    assert check(json.dumps(scene)) == []


def beat(amplitude: float, frequency: float = 0.5) -> dict[str, Any]:
    """Return a law of a sine."""
    return {"sine": {"amplitude": amplitude, "frequency": frequency}}


def driven_root(law: dict[str, Any]) -> dict[str, Any]:
    """Return a rod alone whose root a law moves."""
    own = {**ROD, "root_motion": {"laws": {"y": law}}}
    return {"name": "rod", "time": CHANNEL["time"], "beam": beam(0.0, 0.0, (1.0, 0.0)), "rod": own}


WEIGHT = {**ROD, "gravity": [0.0, -981.0]}
HEAVING = {**ROD, "root_motion": {"laws": {"y": beat(1.2)}}}
SPINNING = {**ROD, "root_motion": {"laws": {"rotations": [{"angle": beat(2.0)}]}}}
WARNED = {
    # motions
    "bodies-collide": (
        bodies(circle(-0.5, 0.0, 0.3, motion={"x": beat(1.0)}), circle(0.6, 0.0, 0.3)),
        "`fluid.bodies[1]` meets `fluid.bodies[0]`",
        (0.166, 0.175),
    ),
    "a cylinder driven through a body": (
        changed(
            bodies(bar(1.0, 0.0, 0.2, 0.2)),
            fluid__cylinders=[
                {"center": [0.0, 0.0], "radius": 0.2, "motion": {"x": {"constant": 0.0}, "y": beat(0.0)}}
            ],
            fluid__bodies__0__motion={"x": beat(-0.9)},
        ),
        "`fluid.bodies[0]` meets `fluid.cylinders[0]`",
        (0.28, 0.295),
    ),
    "a bar that turns into another": (
        bodies(
            bar(0.0, 0.0, 1.6, 0.1, motion={"angle": {"table": {"times": [0.0, 1.0], "values": [0.0, 1.571]}}}),
            circle(0.0, 0.6, 0.1),
        ),
        "`fluid.bodies[1]` meets `fluid.bodies[0]`",
        (0.85, 0.95),
    ),
    "a body driven through a wall": (
        bodies(circle(0.0, 0.5, 0.3, motion={"y": beat(0.5)})),
        "`fluid.bodies[0]` reaches 0.05",
        (0.16, 0.18),
    ),
    "a body driven into the inflow": (
        bodies(circle(-0.8, 0.0, 0.3, motion={"x": beat(-0.8)})),
        "into the inflow zone",
        (0.15, 0.25),
    ),
    "a body that leaves the box": (
        bodies(circle(3.0, 0.0, 0.3, motion={"x": beat(1.0)})),
        "over the edge of the box along x and comes in at the other side",
        (0.24, 0.26),
    ),
    "a fast sine in a long run": (
        changed(
            bodies(circle(3.0, 0.0, 0.3, motion={"x": beat(1.0, 40.0)})), time={"end": 1e3, "communication_step": 1e-3}
        ),
        "over the edge of the box",
        (0.003, 0.0035),
    ),
    "a bar that turns across the channel": (
        bodies(bar(0.0, 0.0, 2.1, 0.1, motion={"angle": beat(1.6)})),
        "fills the channel from -1 to 1 and stops the stream along x",
        (0.245, 0.26),
    ),
    "a rod driven through a wall": (
        changed(CHANNEL, beam=beam(0.0, 0.0, (1.0, 0.0)), rod=HEAVING),
        "`beam` (as a rigid beam) reaches",
        (0.3, 0.35),
    ),
    "a rod that turns into a body": (
        changed(bodies(circle(0.2, 0.7, 0.1)), beam=beam(0.0, 0.0, (1.0, 0.0), 0.9), rod=SPINNING),
        "`beam` (as a rigid beam) meets `fluid.bodies[0]`",
        (0.1, 0.3),
    ),
    "a rod driven through another": (
        changed(
            CHANNEL,
            rods=[
                rods(beam(0.0, 0.0, (1.0, 0.0)))[0],
                {
                    "name": "moved",
                    "beam": beam(0.2, 0.5, (1.0, 0.0)),
                    "rod": {**ROD, "root_motion": {"laws": {"y": beat(-0.6)}}},
                },
            ],
        ),
        "`rods[1].beam` (as a rigid beam) meets `rods[0].beam`",
        (0.2, 0.3),
    ),
    # places that may be meant
    "a body half in another": (
        bodies(circle(0.0, 0.0, 0.3), circle(0.4, 0.0, 0.3)),
        "`fluid.bodies[1]` overlaps `fluid.bodies[0]`",
        None,
    ),
    "half a circle on the wall": (bodies(circle(1.0, -1.0, 0.3)), "reaches 0.3 m into a wall of the channel", None),
    "a step that begins in the inflow": (STEP, "`fluid.bodies[0]` reaches 0.5 m into the inflow zone", None),
    "a body over the edge": (
        changed(STREAM, fluid__cylinders=cylinder(0.3, 5.8, 0.5)),
        "over the edge of the box along y",
        None,
    ),
    # streams
    "nosponge": (
        changed(STREAM, fluid__sponge=None, fluid__bodies=[circle(0.0, 0.02, 0.5)]),
        "is in its own wake",
        (20.0, 20.1),
    ),
    "a start without a sponge": (
        changed(STREAM, fluid__sponge=None, fluid__mean_flow=None, fluid__bodies=[circle(0.0, 0.02, 0.5)]),
        "is in its own wake",
        (20.0, 20.1),
    ),
    "a ramp and a beam without a sponge": (
        changed(
            STREAM,
            fluid__sponge=None,
            fluid__initial_velocity=[0.0, 0.0],
            fluid__mean_flow={"x": {"cosine_ramp": {"value": 2.0, "duration": 2.0}}},
            beam=beam(0.0, 0.02, (1.0, 0.0)),
        ),
        "`beam` is in its own wake",
        (10.9, 11.1),
    ),
    "a stream along y with a sponge across x": (
        changed(
            STREAM,
            fluid__mean_flow={"y": {"constant": 1.0}},
            fluid__initial_velocity=[0.0, 1.0],
            fluid__sponge__mean_velocity={"constant": 0.0},
            fluid__bodies=[circle(0.03, 0.0, 0.5)],
        ),
        "the stream along y passes the periodic box without a `sponge`: `fluid.bodies[0]` is in its own wake",
        (12.0, 12.1),
    ),
    "a sponge slower than the stream": (
        changed(STREAM, fluid__sponge__mean_velocity={"constant": 0.5}, fluid__bodies=[circle(0.0, 0.02, 0.5)]),
        "`fluid.sponge.mean_velocity` is 0.5 m/s and `fluid.mean_flow.x` 1 m/s",
        (0.0, 60.0),
    ),
    "a sponge that starts later than the inflow": (
        changed(
            CHANNEL,
            fluid__sponge={
                "x": [3.0, 4.0],
                "mean_velocity": {"cosine_ramp": {"value": 1.0, "duration": 0.5}},
                "c_eta": 0.1,
            },
        ),
        "`fluid.sponge.mean_velocity` is 0 m/s and `fluid.inflow.mean_velocity` 1 m/s at t = 0 s",
        (0.0, 0.0),
    ),
    # probes
    "a probe in a body": (
        changed(bodies(circle(0.0, 0.05, 0.3)), fluid__probes=[{"name": "p", "position": [0.0, 0.1]}]),
        "the probe `p` at [0, 0.1] lies in `fluid.bodies[0]`",
        None,
    ),
    "a probe in a wall": (
        changed(CHANNEL, fluid__probes=[{"name": "p", "position": [0.0, 1.2]}]),
        "the probe `p` at [0, 1.2] lies in a wall of the channel",
        None,
    ),
    # wakes that stay symmetric
    "sym-cylinder": (changed(STREAM, fluid__bodies=[circle(0.0, 0.0, 0.5)]), "mirror images at y = 0:", None),
    "a cylinder anywhere in a periodic box": (
        changed(STREAM, fluid__cylinders=cylinder(0.3, 1.0, 0.5)),
        "mirror images at y = 1:",
        None,
    ),
    "two bars side by side": (
        changed(STREAM, fluid__bodies=[bar(0.0, 1.0, 1.0, 0.5, angle=0.3), bar(0.0, -1.0, 1.0, 0.5, angle=-0.3)]),
        "mirror images at y = 0:",
        None,
    ),
    "a flag in the middle of a channel": (
        changed(CHANNEL, fluid__kinematic_viscosity=1e-3, beam=beam(0.0, 0.0, (1.0, 0.0)), rod=ROD),
        "mirror images at y = 0:",
        None,
    ),
    # laws
    "a table with a jump": (
        driven_root({"table": {"times": [0.0, 0.5, 0.501, 1.0], "values": [0.0, 0.0, 0.5, 0.5]}}),
        "although its values lie between 0 and 0.5",
        (0.2, 0.25),
    ),
    "a table that stops at once": (
        driven_root({"sum": [{"table": {"times": [0.0, 0.4], "values": [0.0, 0.4]}}, {"constant": 0.0}]}),
        "`rod.root_motion.laws.y.sum[0]` starts or stops at once at t = 0.4 s, where its table ends with the slope 1",
        (0.4, 0.4),
    ),
    "a table that begins later": (
        bodies(circle(0.0, 0.05, 0.2, motion={"x": {"table": {"times": [0.3, 1.3], "values": [0.0, 0.2]}}})),
        "`fluid.bodies[0].motion.x` starts or stops at once at t = 0.3 s",
        (0.3, 0.3),
    ),
    "a sine that the step does not follow": (
        driven_root(beat(1e-3, 40.0)),
        "a period has 2.50 communication steps: the run does not follow it; a step of 0.00125 s would",
        None,
    ),
    "a ramp within a step": (
        driven_root({"cosine_ramp": {"value": 0.1, "duration": 1e-3}}),
        "`rod.root_motion.laws.y` moves by 0.1 within 0.10 communication steps: the run does not follow it; a duration "
        "of 0.1 s would do",
        None,
    ),
    "a harmonic that the step does not follow": (
        driven_root({"fourier": {"frequency": 5.0, "sines": [0.1, 0.0, 1e-3]}}),
        "oscillates with 15 Hz, and a period has 6.67 communication steps",
        None,
    ),
    "a spring that the step does not follow": (
        bodies(circle(0.0, 0.05, 0.2, mount={"mass": 1.0, "y": {"stiffness": 1e6}})),
        "the spring of `fluid.bodies[0].mount.y.stiffness` oscillates with 159.15 Hz without the fluid",
        None,
    ),
    # drag of solids
    "a porous solid": (
        changed(bodies(circle(0.0, 0.05, 0.2)), fluid__mask__log_linear__c_eta=0.1),
        "a `c_eta` of 1e-1 s, at which the flow passes through solids: it should be at most 2.0e-2 s",
        None,
    ),
    "a drag that rounding drowns": (
        changed(bodies(circle(0.0, 0.05, 0.2)), fluid__mask__log_linear__c_eta=1e-20),
        "at which forces are the rounding of velocities: it should be at least 1.0e-14 s",
        None,
    ),
    "a drag that rounding drowns in single precision": (
        changed(bodies(circle(0.0, 0.05, 0.2)), fluid__mask__log_linear__c_eta=1e-9, fluid__precision="single"),
        "it should be at least 1.0e-8 s",
        None,
    ),
    # weights
    "gravity a hundred times too large": (
        {"name": "rod", "time": CHANNEL["time"], "beam": beam(0.0, 0.0, (1.0, 0.0)), "rod": WEIGHT},
        "981 m/s², its weight stretches it by 0.98 of its length",
        None,
    ),
    "a soft rod across gravity": (
        {
            "name": "rod",
            "time": CHANNEL["time"],
            "beam": beam(0.0, 0.0, (1.0, 0.0)),
            "rod": {**ROD, "gravity": [0.0, -60.0]},
        },
        "as a linear beam it would sink by 75 lengths",
        None,
    ),
    "a chain in a fluid": (
        changed(
            CHANNEL,
            beam=beam(0.0, 0.0, (1.0, 0.0)),
            rod={
                "material": {"section": {"line_density": 1.0, "bending_stiffness": 1e-3, "axial_stiffness": 1e5}},
                "gravity": [500.0, 0.0],
                "root": "pinned",
            },
        ),
        "its weight is 5.0e5 of its bending stiffness",
        None,
    ),
}
"""Scene, a part of the sentence, and an interval of the time, s; None where it holds from the start."""


@pytest.mark.parametrize("scene, words, time", WARNED.values(), ids=WARNED)
def test_what_may_be_a_mistake_is_said_with_its_time(scene, words, time, libraries):
    found = facts(json.dumps(scene))["warnings"]
    told = [warning for warning in found if words in warning["text"]]
    assert len(told) == 1, found
    assert told[0]["time"] is None if time is None else time[0] <= told[0]["time"] <= time[1], told


SOUND = {
    "a table of a step with rests": driven_root(
        {"table": {"times": [0.0, 0.2, 0.4, 0.6], "values": [0.0, 0.0, 0.1, 0.1], "end_slopes": [0.0, 0.0]}}
    ),
    "a table that goes on beyond the run": driven_root({"table": {"times": [-1.0, 9.0], "values": [-1.0, 9.0]}}),
    "a sine of ten steps": driven_root(beat(0.1, 10.0)),
    "a body beside the axis of the grid": changed(STREAM, fluid__bodies=[circle(0.0, 0.02, 0.5)]),
    "a stream at an angle with a sponge": changed(
        STREAM,
        fluid__mean_flow={"x": {"constant": 1.0}, "y": {"constant": 0.5}},
        fluid__initial_velocity=[1.0, 0.5],
        fluid__bodies=[circle(0.0, 0.02, 0.5)],
    ),
    "a probe beside a body": changed(
        bodies(circle(0.0, 0.05, 0.3)), fluid__probes=[{"name": "p", "position": [0.4, 0.1]}]
    ),
    "a start that is disturbed": changed(STREAM, fluid__bodies=[circle(0.0, 0.0, 0.5)], fluid__disturbance=0.01),
    "a Reynolds number without shedding": changed(
        STREAM, fluid__bodies=[circle(0.0, 0.0, 0.5)], fluid__kinematic_viscosity=0.03
    ),
    "a body that swings where there is place": bodies(
        circle(0.0, 0.05, 0.2, motion={"x": beat(0.5)}), circle(1.0, 0.0, 0.2)
    ),
    "a body that turns in a stream and back": changed(
        STREAM, fluid__sponge=None, fluid__mean_flow={"x": beat(1.0)}, fluid__initial_velocity=[0.0, 0.0],
        fluid__bodies=[circle(0.0, 0.02, 0.5)],
    ),
    "bodies that move together": bodies(
        circle(0.0, 0.05, 0.2, motion={"x": beat(0.5)}), circle(0.5, 0.05, 0.2, motion={"x": beat(0.5)})
    ),
    "a rod on its cylinder": changed(
        CHANNEL,
        fluid__cylinders=cylinder(0.0, 0.02, 0.2),
        beam={"root": {"on_cylinder": {"cylinder": 0}}, "length": 1.0, "thickness": 0.1, "segments": 20},
        rod={**ROD, "root_motion": {"laws": {"rotations": [{"angle": beat(0.3)}]}}},
    ),
}  # fmt: skip


@pytest.mark.parametrize("scene", SOUND.values(), ids=SOUND)
def test_a_sound_scene_is_not_warned_of(scene, libraries):
    assert facts(json.dumps(scene))["warnings"] == []


@pytest.mark.parametrize("name", [path.stem for path in SCENES])
def test_no_shipped_scene_is_warned_of(name, libraries):
    assert facts(text(read(name)))["warnings"] == []


def test_a_disturbance_starts_the_lift_of_a_symmetric_flow(libraries):
    """A hundredth of the stream; without the key the lift is rounding."""

    def lift(**more: Any) -> float:
        coarse = {"x": [-2.0, 4.0], "y": [-2.0, 2.0], "cells": [48, 32]}
        sponge = {"x": [3.0, 4.0], "mean_velocity": {"constant": 1.0}, "c_eta": 0.1}
        scene = changed(
            STREAM,
            fluid__bodies=[circle(0.0, 0.0, 0.5)],
            fluid__box=coarse,
            fluid__sponge=sponge,
            time={"end": 0.6, "communication_step": 0.015},
            **more,
        )
        with Session(validate(scene)) as session:
            assert session.run().error is None
            return float(np.abs(session.recorder.series["lift"][-20:]).max())

    still, disturbed, twice = lift(), lift(fluid__disturbance=0.01), lift(fluid__disturbance=0.02)
    assert still < 1e-12 < 1e-3 < disturbed, (still, disturbed, twice)
    assert twice == pytest.approx(2 * disturbed, rel=0.01)


@pytest.mark.parametrize(
    "name, key, value, said",
    [
        ("fsi3-650x144", "fluid.kinematic_viscosity", 2e-3, ["fluid.kinematic_viscosity"]),
        ("csm3", "rod.gravity", [0.0, -3.0], ["rod.gravity[1]"]),
        ("cylinder-2d2-800x144", "fluid.cylinders.0.radius", 0.06, ["fluid.cylinders[0].radius"]),
        ("fsi3-325x72", "fluid.inflow.mean_velocity", {"constant": 2.5}, ["fluid.inflow.mean_velocity.constant"]),
        ("fsi3-325x72", "fluid.inflow.mean_velocity", {"constant": 2.0}, []),
        ("fsi3-325x72", "fluid.box.cells", [650, 144], []),
        ("fsi3-325x72", "rod.damping", 0.0, []),
    ],
)
def test_a_changed_benchmark_is_known_by_its_key(name, key, value, said):
    document = read(name)
    assign(document, key, value)
    assert benchmark.changed(validate(document)) == said


def test_a_rod_that_stretches_is_told_of_during_the_run(libraries):
    soft = {"line_density": 1.0, "bending_stiffness": 0.01, "axial_stiffness": 0.5}
    rod = {"material": {"section": soft}, "damping": 2.0, "gravity": [9.81, 0.0]}
    scene = {
        "name": "stretchy",
        "time": {"end": 1.0, "communication_step": 0.01},
        "beam": beam(0.0, 0.0, (1.0, 0.0)),
        "rod": rod,
    }
    with Session(validate(scene)) as session:
        session.run()
    assert len(session.warnings) == 1 and "times as long as at rest" in session.warnings[0], session.warnings


SPACE: dict[str, Any] = changed(
    STREAM,
    time={"end": 2.0, "communication_step": 0.02},
    fluid__box={"x": [-2.0, 4.0], "y": [-1.5, 1.5], "z": [-1.0, 1.0], "cells": [48, 24, 16]},
    fluid__initial_velocity=[1.0, 0.0, 0.0],
    fluid__sponge__x=[3.0, 4.0],
)
"""A stream in space."""


def sphere(x: float, y: float, z: float, radius: float, **more: Any) -> dict[str, Any]:
    """Return a spherical body."""
    return {"shape": {"sphere": {"radius": radius}}, "position": [x, y, z], **more}


def cuboid(x: float, lengths: list[float], **more: Any) -> dict[str, Any]:
    """Return a cuboid in the middle of the section."""
    return {"shape": {"cuboid": {"lengths": lengths}}, "position": [x, 0.0, 0.0], **more}


def solids(*each: dict[str, Any], **more: Any) -> dict[str, Any]:
    """Return the stream in space with these bodies."""
    return changed(SPACE, fluid__bodies=list(each), **more)


def plate(x: float, length: float, width: float, **more: Any) -> dict[str, Any]:
    """Return a plate of no thickness in the middle of the section."""
    return {"shape": {"plate": {"length": length, "width": width}}, "position": [x, 0.0, 0.0], **more}


ACROSS = {"turn": {"axis": [0, 0, 1], "angle": 1.5707963267948966}}
WALLS = {"y": [-1.2, 1.2], "z": [-0.8, 0.8]}
TUBE = {"shape": {"circular_cylinder": {"radius": 0.3}}, "position": [0.0, 0.1, 0.7]}
QUARTER = {"angle": {"table": {"times": [0.0, 2.0], "values": [0.0, 1.5708]}}}
IN_SPACE = {
    "in the sponge": (solids(sphere(3.5, 0.0, 0.0, 0.3)), "position", "in the sponge, x [3.0, 4.0]"),
    "twice": (solids(sphere(0.0, 0.0, 0.0, 0.3), sphere(0.0, 0.0, 0.0, 0.3)), "position", "`fluid.bodies[0]` lies in"),
    "in another": (
        solids(cuboid(0.1, [0.2, 0.2, 0.2]), sphere(0.0, 0.0, 0.0, 0.5)),
        "position",
        "lies inside the other",
    ),
    "in a wall": (solids(sphere(0.0, 0.0, 0.9, 0.05), fluid__channel=WALLS), "position", "whose fluid is at z [-0.8"),
    "across the box": (solids(cuboid(0.0, [0.5, 3.0, 2.0])), "position", "fills the box from -1.5 to 1.5 and stops"),
    "a plate in the sponge": (solids(plate(3.5, 1.0, 1.0)), "position", "in the sponge, x [3.0, 4.0]"),
    "a plate across the box": (solids(plate(0.0, 3.0, 2.0, **ACROSS)), "position", "stops the stream"),
    "a plate in a ball": (
        solids(sphere(0.0, 0.0, 0.0, 0.5), plate(0.1, 0.3, 0.3)),
        "position",
        "lies inside the other",
    ),
    "on springs": (solids(sphere(0.0, 0.0, 0.0, 0.3, mount={"mass": 1.0, "y": {}})), "mount", "still or moves by laws"),
    "by the master": (solids(sphere(0.0, 0.0, 0.0, 0.3, motion="master")), "motion", "still or moves by laws"),
}


@pytest.mark.parametrize("scene, key, words", IN_SPACE.values(), ids=IN_SPACE)
def test_what_cannot_be_meant_in_space_is_refused_by_key(scene, key, words, libraries):
    (fault,) = check(json.dumps(scene))
    assert fault.key == f"fluid.bodies[{len(scene['fluid']['bodies']) - 1}].{key}" and words in fault.text, fault


def test_a_zone_or_channel_in_space_has_a_cell(libraries):
    for key, value in (("sponge.x", [3.99, 4.0]), ("sponge.x", [-2.0, 4.0]), ("channel", {**WALLS, "z": [0.0, 0.01]})):
        (fault,) = check(json.dumps(changed(SPACE, **{f"fluid__{key.replace('.', '__')}": value})))
        assert fault.key == f"fluid.{key}" + (".z" if key == "channel" else ""), fault


WARNED_IN_SPACE = {
    "one body meets another": (
        solids(sphere(0.0, 0.0, 0.0, 0.3), sphere(1.0, 0.0, 0.0, 0.3, motion={"x": beat(-0.8)})),
        "`fluid.bodies[1]` meets `fluid.bodies[0]` near [0.2",
        (0.166, 0.2),
    ),
    "a plate that turns into a ball": (
        solids(cuboid(0.0, [1.6, 0.1, 0.1], motion={**QUARTER, "axis": [0, 1, 0]}), sphere(0.0, 0.0, -0.6, 0.1)),
        "`fluid.bodies[1]` meets `fluid.bodies[0]`",
        (1.677, 1.72),
    ),
    "out of the box along z": (
        solids(sphere(0.0, 0.0, 0.0, 0.3, motion={"z": beat(1.0)})),
        "over the edge of the box along z",
        (0.24, 0.26),
    ),
    "into a wall": (
        solids(sphere(0.0, 0.0, 0.0, 0.3, motion={"y": beat(1.1)}), fluid__channel=WALLS),
        "m into a wall of the channel",
        (0.3, 0.42),
    ),
    "into the sponge": (solids(sphere(2.6, 0.0, 0.0, 0.3, motion={"x": beat(0.5)})), "m into the sponge", (0.05, 0.15)),
    "half in another": (solids(sphere(0.0, 0.0, 0.0, 0.3), sphere(0.4, 0.0, 0.0, 0.3)), "overlaps `fluid.bod", None),
    "a wake that returns": (
        solids(sphere(0.0, 0.1, 0.0, 0.3), fluid__sponge=None, time__end=8.0),
        "is in its own wake",
        (6.0, 6.1),
    ),
    "a plate without thickness that turns into a ball": (
        solids(plate(0.0, 1.6, 0.1, motion={**QUARTER, "axis": [0, 1, 0]}), sphere(0.0, 0.0, -0.6, 0.1)),
        "`fluid.bodies[1]` meets `fluid.bodies[0]`",
        (1.677, 1.76),
    ),
    "a disk that moves out of the box": (
        solids({"shape": {"disk": {"radius": 0.3}}, "position": [0.0, 0.0, 0.0], "motion": {"z": beat(1.0)}}),
        "over the edge of the box along z",
        (0.24, 0.26),
    ),
    "a long plate along the box": (solids(plate(0.0, 1.0, 2.0)), None, None),
    "a ball": (solids(sphere(0.0, 0.0, 0.0, 0.3)), None, None),
    "a plate that turns where there is place": (
        solids(cuboid(0.0, [1.6, 0.1, 0.1], motion={**QUARTER, "axis": [0, 1, 0]}), sphere(0.0, 0.6, 0.0, 0.1)),
        None,
        None,
    ),
    "a cylinder through the box": (solids(TUBE), None, None),
}
"""Scene, a part of the only sentence, none where nothing is said, and an interval of the time, s."""


STILL_SPACE = changed(SPACE, fluid__mean_flow=None, fluid__initial_velocity=[0.0, 0.0, 0.0], fluid__sponge=None)
STILL_SPACE["fluid"]["box"]["cells"] = [24, 12, 8]
STILL_SPACE["time"] = {"end": 0.2, "communication_step": 0.01}
"""Still fluid in space on a coarse grid."""


def hanging(at: list[float], gravity: float, direction: list[float] | None = None, **more: Any) -> dict[str, Any]:
    """Return a thin rod in space along x, or another direction, that gravity pulls along z."""
    root = {"at": {"position": at, "direction": direction or [1.0, 0.0, 0.0]}}
    own = {"root": root, "length": 1.0, "thickness": 0.06, "segments": 12, "surface": "line"}
    return {"beam": own, "rod": {**ROD, "gravity": [0.0, 0.0, gravity], **more}}


def in_space(*own: dict[str, Any], **fluid: Any) -> dict[str, Any]:
    """Return still fluid in space with rods or with one, or without."""
    parts = own[0] if len(own) == 1 else {"rods": [{"name": n, **rod} for n, rod in zip("ab", own, strict=False)]}
    return changed(STILL_SPACE, **{f"fluid__{key}": value for key, value in fluid.items()}, **(parts if own else {}))


def cloth(height: float, gravity: float) -> dict[str, Any]:
    """Return a wing that gravity pulls along z."""
    mesh = {"rectangular": {"length": 1.0, "width": 0.5, "along": 4}}
    skin = {"areal_density": 1.0, "stretching_stiffness": 100.0, "bending_stiffness": 0.01}
    motion = {"z": {"constant": height}}
    wing = {"mesh": mesh, "membrane": skin, "root": "root", "root_motion": motion, "gravity": [0.0, 0.0, gravity]}
    return {"wing": wing}


LEVEL = {"turn": {"axis": [1, 0, 0], "angle": 1.5707963267948966}, "position": [0.8, 0.0, -0.3]}
THIN = changed(STILL_SPACE, fluid__box__cells=[60, 30, 40], fluid__time_stepping__max_step=0.02)
"""Still fluid in space on a grid that sees a wall."""


def with_beams(*own: dict[str, Any], **fluid: Any) -> dict[str, Any]:
    """Return still fluid in space with beams on that grid."""
    return changed(in_space(*own, **fluid), fluid__box=THIN["fluid"]["box"])


def driven(**laws: Any) -> dict[str, Any]:
    """Return a rod in space along x whose root a law moves."""
    return hanging([0.0, 0.0, 0.0], 0.0, root_motion={"laws": laws})


STILL_BEAM, ALONG_Y = hanging([0.0, 0.0, 0.0], 0.0), [0.0, 1.0, 0.0]
FLOWING = changed(SPACE, fluid__time_stepping__max_step=0.02)
SHELL = {key: value for key, value in cloth(0.0, 0.0)["wing"].items() if key != "root_motion"}
BEAMS_IN_SPACE = {
    "through a wall": (
        with_beams(hanging([0.0, 0.0, -0.5], 0.0, [0.0, 0.0, 1.0]), channel={"y": [-1.2, 1.2], "z": [-0.6, 0.3]}),
        "beam.root.at.position",
        "passes through a wall of the channel at [0, 0, 0.41667], whose fluid is at z [-0.6, 0.3]",
    ),
    "in a wall": (with_beams(hanging([0.0, 0.0, 0.9], 0.0), channel=WALLS), "beam.root.at.position", "lies in a wall"),
    "in the sponge": (
        changed(FLOWING, fluid__sponge__x=[2.8, 4.0], **hanging([3.1, 0.0, 0.0], 0.0, ALONG_Y)),
        "beam.root.at.position",
        "most of the beam lies in the sponge",
    ),
    "through a ball": (
        with_beams(STILL_BEAM, bodies=[sphere(0.5, 0.0, 0.0, 0.3)]),
        "beam.root.at.position",
        "passes through `fluid.bodies[0]`",
    ),
    "in a ball": (
        with_beams(STILL_BEAM, bodies=[sphere(0.5, 0.0, 0.0, 0.7)]),
        "beam.root.at.position",
        "lies inside `fluid.bodies[0]`",
    ),
    "through a plate at a station": (
        with_beams(STILL_BEAM, bodies=[plate(0.5, 0.5, 0.5, **ACROSS)]),
        "beam.root.at.position",
        "meets `fluid.bodies[0]` at [0.5, 0, 0]",
    ),
    "through another": (
        with_beams(STILL_BEAM, hanging([0.5, -0.5, 0.0], 0.0, ALONG_Y)),
        "rods[1].beam.root.at.position",
        "meets `rods[0].beam` at [0.5, 0, 0]",
    ),
    "half on another": (
        with_beams(STILL_BEAM, hanging([0.5, 0.0, 0.0], 0.0)),
        "rods[1].beam.root.at.position",
        "meets `rods[0].beam` at [0.5, 0, 0]",
    ),
    "a wing in a wall": (with_beams(cloth(0.9, 0.0), channel=WALLS), "wing.mesh", "the wing lies in a wall"),
    "a wing in the sponge": (
        changed(FLOWING, fluid__sponge__x=[0.0, 4.0], wing=SHELL),
        "wing.mesh",
        "most of the wing lies in the sponge",
    ),
    "two plates in one place": (
        solids(plate(0.0, 1.0, 1.0), plate(0.0, 1.0, 1.0)),
        "fluid.bodies[1].position",
        "one of this body and `fluid.bodies[0]` lies inside the other",
    ),
    "two lines in one place": (
        bodies(*[{"shape": {"plate": {"length": 1.0}}, "position": [0.0, 0.05]}] * 2),
        "fluid.bodies[1].position",
        "one of this body and `fluid.bodies[0]` lies inside the other",
    ),
}


@pytest.mark.parametrize("scene, key, words", BEAMS_IN_SPACE.values(), ids=BEAMS_IN_SPACE)
def test_a_thin_part_that_cannot_be_meant_is_refused_by_key(scene, key, words, libraries):
    (fault,) = check(json.dumps(scene))
    assert fault.key == key and words in fault.text, fault


PILLAR = {"shape": {"circular_cylinder": {"radius": 0.3}}, "position": [0.0, 0.0, 0.3]}
THIN_WARNED = {
    "beams at less than their thickness": (
        with_beams(STILL_BEAM, hanging([0.5, -0.5, 0.05], 0.0, ALONG_Y)),
        "`rods[1].beam` overlaps `rods[0].beam` near [0.5, 0, 0.025]",
        None,
    ),
    "beams along each other in the plane": (
        changed(CHANNEL, rods=rods(beam(0.0, 0.0, (1.0, 0.0)), beam(0.0, 0.08, (1.0, 0.0)))),
        "`rods[1].beam` overlaps `rods[0].beam`",
        None,
    ),
    "a beam driven through a wall": (
        with_beams(driven(z=beat(0.9, 2.0)), channel=WALLS),
        "`beam` (as a rigid beam) reaches 0.05",
        (0.085, 0.095),
    ),
    "a beam driven over the edge": (
        with_beams(driven(z=beat(1.1, 2.0))),
        "over the edge of the box along z",
        (0.08, 0.09),
    ),
    "a beam that turns into a ball": (
        with_beams(
            driven(rotations=[{"angle": beat(1.0, 2.0), "axis": [0, 1, 0]}]), bodies=[sphere(0.7, 0.0, -0.5, 0.15)]
        ),
        "`beam` (as a rigid beam) meets `fluid.bodies[0]` near [0.7, 0, -0.39",
        (0.03, 0.04),
    ),
    "a beam driven onto a plate": (
        with_beams(driven(z=beat(-0.5, 2.0)), bodies=[plate(0.8, 0.4, 0.4, **LEVEL)]),
        "`beam` (as a rigid beam) meets `fluid.bodies[0]` near [0.8, 0, -0.3]",
        (0.045, 0.052),
    ),
    "a beam driven onto another": (
        with_beams(
            {**driven(z=beat(-0.5, 2.0)), "beam": hanging([0.0, 0.0, 0.2], 0.0)["beam"]},
            hanging([0.5, -0.5, 0.0], 0.0, ALONG_Y),
        ),
        "`rods[1].beam` meets `rods[0].beam` (as a rigid beam) near [0.5, 0, 0.02",
        (0.02, 0.03),
    ),
    "a ball that moves into a beam": (
        with_beams(STILL_BEAM, bodies=[sphere(0.8, 0.0, -0.4, 0.15, motion={"z": beat(0.5, 2.0)})]),
        "`beam` meets `fluid.bodies[0]` near [0.8, 0, -0.02",
        (0.035, 0.045),
    ),
    "a beam in its own wake": (
        changed(FLOWING, fluid__sponge=None, time__end=8.0, **hanging([0.0, 0.1, 0.03], 0.0)),
        "`beam` is in its own wake",
        (6.0, 6.1),
    ),
    "a wing in its own wake": (
        changed(FLOWING, fluid__sponge=None, time__end=8.0, **cloth(0.0, -1.0)),
        "`wing` (as a rigid wing) is in its own wake",
        (6.0, 6.1),
    ),
    "a wing driven over the edge": (
        changed(STILL_SPACE, wing={**SHELL, "root_motion": {"z": beat(1.2, 2.0)}}),
        "`wing` (as a rigid wing) reaches 0.0",
        (0.07, 0.09),
    ),
    "a wing driven onto a plate": (
        changed(
            in_space(bodies=[plate(0.8, 0.4, 0.4, **LEVEL)]), wing={**SHELL, "root_motion": {"z": beat(-0.6, 2.0)}}
        ),
        "`wing` (as a rigid wing) meets `fluid.bodies[0]` near [0.8, 0, -0.2",
        (0.03, 0.045),
    ),
    "plates that cross": (
        in_space(bodies=[plate(0.0, 1.0, 1.0), plate(0.0, 1.0, 1.0, **ACROSS)]),
        "`fluid.bodies[1]` overlaps `fluid.bodies[0]`",
        None,
    ),
    "plates that clap": (
        solids(
            plate(0.0, 1.0, 1.0, position=[0.0, 0.2, 0.0], motion={"y": beat(-0.3, 2.0)}),
            plate(0.0, 1.0, 1.0, position=[0.0, -0.2, 0.0], motion={"y": beat(0.3, 2.0)}),
        ),
        "`fluid.bodies[1]` meets `fluid.bodies[0]` near [0, 0, 0]",
        (0.04, 0.06),
    ),
    "a cylinder through the box": (
        changed(SPACE, fluid__bodies=[PILLAR], fluid__kinematic_viscosity=5e-3),
        "bodies and stream are mirror images at y = 0: the wake may never shed",
        None,
    ),
    "a ball in a fast stream": (
        solids(sphere(0.0, 0.0, 0.0, 0.3), fluid__kinematic_viscosity=2e-3),
        "mirror images at y = 0 and at z = 0",
        None,
    ),
    "a beam along a stream": (changed(FLOWING, **STILL_BEAM), "mirror images at y = 0 and at z = 0", None),
    "a wing along a stream": (
        changed(FLOWING, wing=SHELL),
        "mirror images at z = 0:",
        None,
    ),
    "a beam that hangs": (changed(FLOWING, **hanging([0.0, 0.0, 0.0], -1.0)), None, None),
    "beams of one root": (
        with_beams(
            hanging([0.0, 0.0, 0.0], 0.0, [1.0, 0.0, 0.3]), hanging([0.0, 0.0, 0.0], 0.0, [1.0, 0.0, -0.3])
        ),
        None,
        None,
    ),
    "a beam at the tip of another": (with_beams(STILL_BEAM, hanging([1.0, 0.0, 0.0], 0.0, ALONG_Y)), None, None),
    "a beam on a plate": (
        with_beams(hanging([0.5, 0.0, 0.0], 0.0), bodies=[plate(0.5, 0.5, 0.5, **ACROSS)]),
        None,
        None,
    ),
    "a beam that a ball holds": (with_beams(STILL_BEAM, bodies=[sphere(-0.1, 0.0, 0.0, 0.3)]), None, None),
    "a plate that stands on another": (
        solids(plate(0.0, 1.0, 1.0), plate(0.3, 0.6, 1.0, position=[0.0, 0.3, 0.0], **ACROSS)),
        None,
        None,
    ),
    "plates with one edge": (
        solids(plate(0.0, 1.0, 1.0), plate(0.0, 1.0, 1.0, position=[0.5, 0.5, 0.0], **ACROSS)),
        None,
        None,
    ),
}  # fmt: skip
WARNED_IN_SPACE |= THIN_WARNED


@pytest.mark.parametrize("scene, words, time", WARNED_IN_SPACE.values(), ids=WARNED_IN_SPACE)
def test_what_may_be_a_mistake_in_space_is_said_with_its_time(scene, words, time, libraries):
    found = facts(json.dumps(scene))["warnings"]
    assert len(found) == (words is not None), found
    if words:
        assert words in found[0]["text"], found
        assert found[0]["time"] is None if time is None else time[0] <= found[0]["time"] <= time[1], found


STILL = changed(STREAM, fluid__mean_flow=None, fluid__initial_velocity=[0.0, 0.0], fluid__sponge=None)
STILL["fluid"]["box"] = {"x": [-2.0, 4.0], "y": [-1.5, 1.5], "cells": [60, 30]}
STILL["time"] = {"end": 0.3, "communication_step": 0.01}
"""Still fluid on a coarse grid."""


def falling(own: dict[str, Any], gravity: tuple[float, float]) -> dict[str, Any]:
    """Return a beam with a rod in still fluid that gravity pulls."""
    return {"beam": own, "rod": {**ROD, "gravity": list(gravity)}}


def several(*own: dict[str, Any]) -> dict[str, Any]:
    """Return still fluid with rods."""
    return changed(STILL, rods=[{"name": name, **rod} for name, rod in zip("abc", own, strict=False)])


def sprung(at_x: float, at_y: float, **supports: Any) -> dict[str, Any]:
    """Return a circle on springs."""
    return circle(at_x, at_y, 0.2, mount={"mass": 0.5, **supports})


HELD = {"root": {"on_cylinder": {"cylinder": 0}}, "length": 1.5, "thickness": 0.05, "segments": 30}
LIMP = {"material": {"section": {"line_density": 1.0, "bending_stiffness": 1e-3, "axial_stiffness": 1e3}}}
UP, DOWN = (0.0, 20.0), (0.0, -20.0)
MET = {
    "rods": (
        several(falling(beam(0.0, 0.15, (1.0, 0.0)), DOWN), falling(beam(0.0, -0.15, (1.0, 0.0)), UP)),
        "the rod b meets the rod a near (0.93",
        (0.08, 0.13),
    ),
    "rods of one root": (
        several(falling(beam(0.0, 0.0, (1.0, 0.3)), DOWN), falling(beam(0.0, 0.0, (1.0, -0.3)), UP)),
        "the rod b meets the rod a near",
        (0.1, 0.14),
    ),
    "a rod and a body": (
        changed(STILL, fluid__bodies=[circle(0.8, -0.4, 0.2)], **falling(beam(0.0, 0.0, (1.0, 0.0)), DOWN)),
        "the rod meets body 1 near (0.82",
        (0.13, 0.17),
    ),
    "a rod and its own cylinder": (
        changed(
            STILL,
            fluid__cylinders=cylinder(0.0, 0.0, 0.3),
            beam=HELD,
            rod={**LIMP, "gravity": [-20.0, -20.0]},
        ),
        "the rod meets cylinder 1 near (0.2",
        (0.1, 0.3),
    ),
    "a rod that crosses itself": (
        {
            "name": "loop",
            "time": {"end": 0.4, "communication_step": 0.005},
            "beam": beam(0.0, 0.0, (1.0, 0.0), rest_angles=[0.1 * i for i in range(20)]),
            "rod": {
                **LIMP,
                "gravity": [0.0, -9.81],
                "root_motion": {"laws": {"rotations": [{"angle": beat(4.0, 1.0)}]}},
            },
        },
        "the rod meets itself near",
        (0.2, 0.4),
    ),
    "a body on springs and another": (
        changed(STILL, fluid__bodies=[circle(0.0, 0.0, 0.2), sprung(0.0, 0.6, y={"stiffness": 20.0, "rest": -0.6})]),
        "body 2 meets body 1 near (0.0",
        (0.13, 0.2),
    ),
    "bodies that the master moves": (
        changed(STILL, fluid__bodies=[circle(0.0, 0.6, 0.2, motion="master"), circle(0.0, -0.1, 0.25)]),
        "body 2 meets body 1 near (",
        (0.24, 0.28),
    ),
    "a body on springs and the edge": (
        changed(STILL, fluid__bodies=[sprung(0.0, 1.25, y={"stiffness": 20.0, "rest": 0.6})]),
        "body 1 reaches",
        (0.05, 0.15),
    ),
    "a body on springs and a wall": (
        changed(STILL, fluid__channel=CHANNEL["fluid"]["channel"], fluid__bodies=[
            sprung(0.0, 0.75, y={"stiffness": 20.0, "rest": 0.6})]),
        "m into a wall of the channel",
        (0.1, 0.2),
    ),
    "a body on springs and the sponge": (
        changed(
            STILL,
            fluid__sponge={"x": [3.0, 4.0], "mean_velocity": {"constant": 0.0}, "c_eta": 0.1},
            fluid__bodies=[sprung(2.7, 0.0, x={"stiffness": 60.0, "rest": 0.6})],
        ),
        "m into the sponge",
        (0.05, 0.25),
    ),
    "a rod and the sponge": (
        changed(
            STILL,
            fluid__sponge={"x": [3.0, 4.0], "mean_velocity": {"constant": 0.0}, "c_eta": 0.1},
            **falling(beam(2.7, 0.0, (0.0, 1.0)), (60.0, 0.0)),
        ),
        "the rod reaches",
        (0.1, 0.2),
    ),
}  # fmt: skip
"""Scene, the begin of the sentence, and an interval of its time, s."""


def told(scene: dict[str, Any]) -> list[str]:
    """Return what a run tells of places; the master lets bodies fall with 1 m/s."""
    driven = any(body.get("motion") == "master" for body in scene.get("fluid", {}).get("bodies", ()))
    drive = (lambda t: [0.0, -t, 0.0, 0.0, -1.0, 0.0]) if driven else None
    with Session(validate(scene), drive=drive) as session:
        assert session.run().error is None
        return [text for text in session.warnings if not text.startswith("short waves")]


MET_IN_SPACE = {
    "rods": (
        in_space(hanging([0.0, 0.0, 0.2], -20.0), hanging([0.8, -0.5, 0.0], 0.0, [0.0, 1.0, 0.0])),
        "the rod b meets the rod a near (0.8",
        (0.145, 0.155),
    ),
    "a rod and a ball": (
        in_space(hanging([0.0, 0.0, 0.0], -20.0), bodies=[sphere(0.8, 0.0, -0.3, 0.15)]),
        "the rod meets body 1 near (0.77",
        (0.1, 0.14),
    ),
    "a rod and a plate": (
        in_space(hanging([0.0, 0.0, 0.0], -20.0), bodies=[plate(0.8, 0.4, 0.4, **LEVEL)]),
        "the rod meets body 1 near (0.7",
        (0.16, 0.2),
    ),
    "a rod and a wall across z": (
        in_space(hanging([0.0, 0.0, -0.6], -20.0), channel=WALLS),
        "m into a wall of the channel",
        (0.14, 0.18),
    ),
    "a rod and the edge along z": (
        in_space(hanging([0.0, 0.0, -0.8], -20.0)),
        "over the edge of the box along z",
        (0.12, 0.16),
    ),
    "a wing and a ball": (
        in_space(cloth(0.0, -20.0), bodies=[sphere(0.8, 0.25, -0.3, 0.2)]),
        "the wing meets body 1 near (0.",
        (0.05, 0.2),
    ),
    "a wing and the edge": (in_space(cloth(-0.9, -20.0)), "the wing reaches 0.0", (0.05, 0.2)),
    "a rod alone that lies on itself": (
        {
            "name": "loop",
            "time": {"end": 0.5, "communication_step": 0.005},
            **hanging([0.0, 0.0, 0.0], -9.81, [0.1, 0.02, 1.0], **LIMP, damping=0.01),
        },
        "the rod meets itself near (0, 0, 0) m",
        (0.3, 0.4),
    ),
}  # fmt: skip
MET |= {f"in space {name}": case for name, case in MET_IN_SPACE.items()}


@pytest.mark.usefixtures("wing_library")
@pytest.mark.parametrize("scene, words, time", MET.values(), ids=MET)
def test_what_meets_during_a_run_is_told_of_with_place_and_time(scene, words, time, libraries):
    (found,) = told(scene)
    assert words in found, found
    assert time[0] <= float(found.rsplit(" ", 2)[1]) <= time[1], found


UNTOLD = {
    "rods of one root": several(falling(beam(0.0, 0.0, (1.0, 0.3)), UP), falling(beam(0.0, 0.0, (1.0, -0.3)), DOWN)),
    "a rod that is embedded in a body": changed(
        STILL, fluid__bodies=[circle(0.0, 0.0, 0.3)], **falling(beam(0.25, 0.0, (1.0, 0.0)), (0.0, -1.0))
    ),
    "a rod on its cylinder": changed(
        STILL, fluid__cylinders=cylinder(0.0, 0.0, 0.3), beam=HELD, rod={**LIMP, "gravity": [0.0, -1.0]}
    ),
    "rods in space that pass": in_space(
        hanging([0.0, 0.0, 0.08], 20.0), hanging([0.8, -0.5, 0.0], 0.0, [0.0, 1.0, 0.0])
    ),
    "rods in space of one root": in_space(
        hanging([0.0, 0.0, 0.0], 5.0, [1.0, 0.0, 0.3]), hanging([0.0, 0.0, 0.0], -5.0, [1.0, 0.0, -0.3])
    ),
    "a rod that a ball holds": in_space(hanging([0.0, 0.0, 0.0], -20.0), bodies=[sphere(-0.1, 0.0, 0.0, 0.2)]),
    "bodies side by side": changed(
        STILL, fluid__bodies=[circle(0.0, 0.0, 0.2), sprung(0.0, 0.6, y={"stiffness": 20.0, "rest": -0.1})]
    ),
}


@pytest.mark.parametrize("scene", UNTOLD.values(), ids=UNTOLD)
def test_what_touched_at_the_start_is_not_told_of(scene, libraries):
    assert told(scene) == []
