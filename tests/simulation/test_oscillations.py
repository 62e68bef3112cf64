"""Waves as short as the grid, in a flow that is written in Python."""

from typing import cast

import numpy as np
import pytest

from nervure.scene import validate
from nervure.simulation.loop import TimeGrid
from nervure.simulation.oscillations import CHECKS, LEFT, GridOscillationMonitor
from nervure.units.fmu import Unit

pytestmark = pytest.mark.usefixtures("libraries")

CELLS, SPEEDS = (64, 48), (0.5, 0.3)


class Waves:
    """A stream with waves of the vorticity along some axes in turn, from check to check."""

    def __init__(self, axes, speeds):
        self.axes, self.speeds = iter(axes), speeds

    def shown_field(self, name):
        if name in "uv":
            return np.full(CELLS, self.speeds["uv".index(name)])
        x, y = np.meshgrid(*(np.arange(n) for n in CELLS), indexing="ij")
        # Of two and a half cells and of eight.
        own = {axis: np.cos(0.8 * np.pi * at) for axis, at in (("x", x), ("y", y))}
        return sum((own[axis] for axis in next(self.axes)), 0.3 * np.cos(np.pi * (x + y) / 4))


def amplification(scheme, courant):
    """Return the growth in a step of a wave with this wave number times speed times step."""
    z = 1j * courant
    if scheme == "rk2":
        return abs(1 + z + z**2 / 2)
    return np.abs(np.roots([1.5, -2 - 2.5 * z, 0.5 + 2 * z, -0.5 * z])).max()


def longest_step(scheme, wave_number, speed, viscosity):
    """Return the step (s) in which viscosity takes from a wave what the scheme adds, by bisection."""
    low, high = 1e-6, 1.0
    for _ in range(60):
        step = np.sqrt(low * high)
        grows = amplification(scheme, wave_number * speed * step) - 1 > viscosity * wave_number**2 * step
        low, high = (low, step) if grows else (step, high)
    return low


def warnings(scene, axes, speeds=SPEEDS):
    """Return the warnings after each check of a run."""
    scene = validate(scene)
    grid = TimeGrid(CHECKS * scene.time.communication_step, scene.time.communication_step)
    monitor = GridOscillationMonitor(scene.fluid, cast(Unit, Waves(axes, speeds)), grid)
    return [monitor.check(step, 0.0, ()) for step in range(1, CHECKS + 1)]


@pytest.fixture
def stream(fluid_only):
    """A stream whose cells differ along x and y."""
    own = {"x": [-1.0, 1.0], "y": [-0.5, 0.7], "cells": list(CELLS)}
    fluid_only["fluid"] |= {"box": own, "kinematic_viscosity": 2e-6, "inflow": None, "cylinders": [], "channel": None}
    fluid_only["fluid"] |= {"initial_velocity": list(SPEEDS)}
    return fluid_only


@pytest.mark.parametrize("scheme", ["sbdf2", "rk2"])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_steps_in_which_the_scheme_lets_short_waves_grow_are_told(stream, scheme, axis):
    """Where the amplification by the scheme exceeds the decay by viscosity, to three parts in a hundred."""
    i = "xy".index(axis)
    cell = (2.0 / 64, 1.2 / 48)[i]
    longest = longest_step(scheme, LEFT * np.pi / cell, SPEEDS[i], 2e-6)
    along = tuple(speed if own == axis else 0.0 for own, speed in zip("xy", SPEEDS, strict=True))
    for factor in (0.97, 1.03):
        step = factor * longest
        stream["fluid"]["time_stepping"] = {"scheme": scheme, "max_step": step, "max_cfl": 0.4}
        stream["time"] |= {"communication_step": step}
        found = [text for texts in warnings(stream, [axis] * CHECKS, along) for text in texts]
        assert bool(found) == (factor > 1), (longest, found)
        assert all(text.startswith(f"short waves along {axis}") for text in found), found


def test_short_waves_are_told_of_where_two_checks_in_turn_find_them(stream):
    stream["fluid"]["time_stepping"] |= {"scheme": "rk2", "max_step": 0.02, "max_cfl": 0.4}
    stream["time"] |= {"communication_step": 0.02}
    found = warnings(stream, ["x", "", "x", "y", "", "y", "xy", "x"])
    assert [[text.partition(":")[0][-1] for text in texts] for texts in found] == [[], [], [], [], [], [], ["y"], ["x"]]
