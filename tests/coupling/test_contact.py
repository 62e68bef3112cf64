"""Rods and wings in a fluid that touch walls and each other: the scenes of `examples` on coarse grids."""

import numpy as np
import pytest

import nervure
from nervure.resources import ROOT
from nervure.scene import Scene
from nervure.simulation.session import Session

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
    print(min(low), touching.sum(), off, jumps.max())
    # Half the thickness is 0.01 m.
    assert min(low) > 0.01, f"the axis comes to {min(low)} m from the wall"
    assert touching.sum() > 400 and not touching[-30:].any(), "it does not touch, or does not leave"
    assert off < 1e-3, f"the powers differ by {off}"
    # The load reaches 400 N/m.
    assert jumps.max() < 20.0, f"the load jumps by {jumps.max()} N/m"
