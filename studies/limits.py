"""Rods with a driven root and an exact result: scenes, computed and expected quantities, accepted errors.

The study of the vein records them, and tests/rod/test_flapping.py checks them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from nervure import coupling
from nervure.evaluate import flapping, statistics
from nervure.evaluate.statistics import Series, Window
from nervure.scene import validate
from nervure.scene.facts import Facts
from studies import simulate

Scene = dict[str, Any]

PITCHING = "vein-pitching-320x240"
FORCES = ("beam_drag", "beam_lift", "beam_moment")

STIFF = {"bending_stiffness": 1e5, "axial_stiffness": 1e8}
LAYER = 2286280459 / 1556755200  # Of a line, cells
FORCE_WIDTH = 0.02
"""Width of the box filter over compared forces, s: a fiftieth of the period. It removes the noise of the mask on the
grid, in which a rod that gives way by 1e-4 differs from a rigid one."""

CANTILEVER = np.array([1.87510407, 4.69409113, 7.85475744, 10.99554073])
"""First roots of 1 + cos b cosh b."""


@dataclass(frozen=True)
class Found:
    """A quantity and its expected value."""

    quantity: str
    value: float
    expected: float
    asked: float
    """Largest accepted `error`."""
    unit: str = ""

    @property
    def error(self) -> float:
        """Relative distance from the expected value, or the distance from 0."""
        return (self.value - self.expected) / (self.expected or 1.0)


Run = Callable[..., Series]
"""`record` without its folder: from a scene and the keyword `rigid` to the recorded series."""


def record(scene: Scene, folder: Path, drive: coupling.Drive | None = None, rigid: bool = False) -> Series:
    """Run a scene to its end and return the recorded series."""
    with simulate.session(scene, folder, rigid, drive) as session:
        status = session.run()
    assert status.error is None, status.error
    return session.recorder.series


def small_pitching() -> Scene:
    """Return the pitching vein on a coarse grid, thickened so that the grid resolves it."""
    scene = simulate.changed(PITCHING, {})
    scene["name"] = "small-pitching"
    scene["time"] = {"end": 3.05, "communication_step": 1e-3}
    scene["fluid"]["box"]["cells"] = [128, 96]
    scene["fluid"]["time_stepping"]["max_step"] = 1e-3
    scene["beam"] |= {"thickness": 0.06, "segments": 24}
    scene["rod"]["material"]["section"]["line_density"] = 0.06
    return scene


def filtered(time: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return a force under the box filter, without the ends that the filter does not fill."""
    end = round(FORCE_WIDTH / 2 / (time[1] - time[0]))
    return statistics.box_filter(time, force, FORCE_WIDTH)[end:-end]


def stiff_limit(run: Run) -> list[Found]:
    """A stiff vein exerts the forces of the prescribed motion: largest difference by the largest force. The fluid
    does not divide this step, which it would do otherwise for a rod than for a prescribed motion."""
    scene = small_pitching()
    scene["time"]["communication_step"] = scene["fluid"]["time_stepping"]["max_step"] = 4e-4
    scene["time"]["end"] = 2.0
    scene["rod"]["material"]["section"] |= STIFF
    both = run(scene), run(scene, rigid=True)
    found = []
    for name in FORCES:
        stiff, rigid = (filtered(series["time"], series[name]) for series in both)
        found.append(Found(name, np.abs(stiff - rigid).max() / np.abs(rigid).max(), 0.0, 0.01))
    return found


def energy(run: Run) -> list[Found]:
    """No energy is missing over a period, by the loads on the rod and by the forces of the fluid; under the momentum
    load these differ by the step."""
    scene = small_pitching()
    scene["time"]["communication_step"] = 4e-4
    facts = Facts(validate(scene))
    assert facts.scene.beam, "the scene has a beam"
    averages = flapping.evaluate(facts, facts.scales.get("beam"), run(scene), Window(2.0, 3.0, 1))
    assert averages, "the root is driven"
    balance: dict[str, Any] = averages.energy_balance
    by_fluid = (balance["root"] + balance["fluid"] - balance["gained"]) / balance["root"]
    return [Found("by the loads", balance["missing"], 0.0, 0.01), Found("by the fluid", by_fluid, 0.0, 0.01)]


def transfer_function(run: Run) -> list[Found]:
    """Base excitation in vacuum, w(L)/w0 = (cos b + cosh b)/(1 + cos b cosh b), b^4 = mu omega^2 L^4/EI, by a scene
    alone."""
    b, mu, ei, periods = 1.4, 0.024, 0.0134, 40
    frequency = b**2 * np.sqrt(ei / mu) / (2 * np.pi)
    scene = simulate.changed(PITCHING, {})
    del scene["fluid"]
    scene["name"], scene["time"] = "vacuum", {"end": periods / frequency, "communication_step": 1 / (200 * frequency)}
    scene["rod"] |= {
        "scheme": "tr_bdf2",
        "root_motion": {"laws": {"y": {"sine": {"amplitude": 1e-4, "frequency": frequency, "ramp": 20 / frequency}}}},
    }
    series = run(scene)
    window = Window(30 / frequency, 40 / frequency, 10)
    tip, root = (flapping.harmonic(series["time"], series[name], window) for name in ("tip_uy", "rigid_tip_uy"))
    exact = (np.cos(b) + np.cosh(b)) / (1 + np.cos(b) * np.cosh(b))
    return [Found("tip by root", float((tip / root).real), float(exact), 5e-3)]


def frequency_of_the_wet_plate(ei: float, mu: float, area: float) -> float:
    """Return the first natural frequency, Hz, of a plate of chord 1 clamped at one edge in an ideal fluid of density 1
    that repeats in a square of `area`, without a mean pressure gradient.

    A thin plate that moves across itself at w(x), x = (1 - cos theta)/2, makes the jump sum a_n sin(n theta) of the
    potential with w = sum n a_n sin(n theta)/sin(theta), and carries pi/4 sum n a_n b_n between two such motions. The
    dipoles d of its images, per area, move the fluid at the plate at the velocity d/(2 area). The plate moves in the
    modes of a cantilever.
    """
    roots, n = CANTILEVER, np.arange(1, 60)
    theta = (np.arange(400) + 0.5) * np.pi / 400
    x, dx, sines = (1 - np.cos(theta)) / 2, np.sin(theta) * np.pi / 800, np.sin(np.outer(n, theta))
    b, s = roots[:, None] * x, (np.cosh(roots) + np.cos(roots)) / (np.sinh(roots) + np.sin(roots))
    modes = np.cosh(b) - np.cos(b) - s[:, None] * (np.sinh(b) - np.sin(b))
    jumps = 4 * (modes * dx) @ sines.T / np.pi / n
    dipoles, of_unit_velocity = np.pi / 4 * jumps[:, 0], np.pi / 4
    images = np.outer(dipoles, dipoles) / (2 * area + of_unit_velocity)
    mass = (modes * (mu * dx)) @ modes.T + np.pi / 4 * (jumps * n) @ jumps.T - images
    stiffness = np.diag(ei * roots**4 * ((modes * dx) * modes).sum(axis=1))
    return float(np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real.min()) / (2 * np.pi))


def free_vibration(run: Run, mu: float = 0.3, cells: int = 240, surface: str = "mask") -> list[Found]:
    """A plate in still fluid, nudged at its root, vibrates with its added mass; as a line it has at least the mass of
    the line's layer of fluid."""
    ei, side = 2.7121, 3.0
    layer = LAYER * side / cells if surface == "line" else 0.0
    scene = simulate.changed(PITCHING, {})
    scene["name"], scene["time"] = "free-vibration", {"end": 4.0, "communication_step": 5e-3}
    box = {"x": [-1.0, 2.0], "y": [-1.5, 1.5], "cells": [cells, cells]}
    scene["fluid"] |= {"box": box, "kinematic_viscosity": 1e-4}
    del scene["fluid"]["sponge"]
    scene["fluid"]["time_stepping"]["max_step"] = 5e-3
    scene["beam"] |= {"thickness": 0.03, "segments": 24, "surface": surface}
    scene["rod"]["material"]["section"] = {"line_density": mu, "bending_stiffness": ei, "axial_stiffness": 1e4}
    nudge = {"table": {"times": [0.0, 0.25, 0.5], "values": [0.0, 0.004, 0.0]}}
    scene["rod"]["root_motion"] = {"laws": {"rotations": [{"angle": nudge}]}}
    series = run(scene)
    later = series["time"] > 0.75
    time, uy = series["time"][later], series["tip_uy"][later]
    crossings = statistics.upward_crossings(time, uy, 0.0, uy.max())
    found = (crossings.size - 1) / (crossings[-1] - crossings[0])
    expected = frequency_of_the_wet_plate(ei, max(mu, layer), side**2)
    dry = CANTILEVER[0] ** 2 * np.sqrt(ei / mu) / (2 * np.pi)
    return [
        Found("frequency", float(found), expected, 0.05, "Hz"),
        Found("frequency by that in vacuum", float(found / dry), float(expected / dry), 0.05),
    ]


LIMITS: dict[str, Callable[[Run], list[Found]]] = {
    "stiff limit": stiff_limit,
    "transfer function": transfer_function,
    "free vibration": free_vibration,
    "free vibration, line": partial(free_vibration, cells=120, surface="line"),
    "free vibration, light line": partial(free_vibration, mu=1e-6, cells=120, surface="line"),
    "energy": energy,
}
