"""Random cases of rods or wings with bodies and walls: units of their own, between which the fluid finds contact.

The fluid is a ten-thousandth as dense as what moves, so energy is exchanged by contact alone.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np

from nervure.errors import UnitFailure
from nervure.scene import validate
from nervure.simulation.session import Session
from studies.engine import Case

STEPS, STEP = 600, 1e-3
WALL, CELLS = 0.75, {2: 24, 3: 16}  # Of the channel from the middle, m, and of its box along an axis
RANGE = 0.06  # m
SKIN = 0.25 * RANGE  # Half the thickness of a wing for another part, m
KINDS = (
    ("rods and bodies, in the plane", 45, 2, "rods"),
    ("rods and bodies, in space", 45, 3, "rods"),
    ("wings and bodies", 10, 3, "wings"),
)
DENSITY = 1e-4  # kg/m³
SAMPLES = 5  # Points of a segment of a rod, and parts of an edge of a wing, at which depths are measured


def random_scene(seed: int, dimension: int, units: str) -> dict[str, Any]:
    """Return a scene of two `units`, "rods" or "wings", and two bodies in a closed channel, at random places."""
    random = np.random.default_rng([seed, dimension, units == "wings"])
    way = random.normal(size=dimension)
    gravity = (9.81 * way / np.linalg.norm(way)).tolist()
    axes = "xyz"[:dimension]
    places = random.permutation(list(itertools.product((-0.38, 0.38), repeat=dimension)))

    def between(low: float, high: float) -> float:
        return float(random.uniform(low, high))

    def place(k: int) -> list[float]:
        found: list[float] = (places[k] + random.uniform(-0.08, 0.08, dimension)).tolist()
        return found

    def rod(k: int) -> dict[str, Any]:
        direction = random.normal(size=dimension)
        direction /= np.linalg.norm(direction)
        length, thickness, mass = between(0.35, 0.5), between(0.06, 0.1), between(0.5, 3.0)
        root = np.array(place(k)) - 0.5 * length * direction
        section = {
            "line_density": mass,
            "bending_stiffness": 10.0 ** between(-2.0, 0.5),
            "axial_stiffness": 2e4,
        }
        return {
            "name": f"rod_{k}",
            "beam": {
                "root": {"at": {"position": root.tolist(), "direction": direction.tolist()}},
                "length": length,
                "thickness": thickness,
                "segments": 10,
                "surface": "line",
            },
            "rod": {"material": {"section": section}, "gravity": gravity, "root": {"free": {}}, "scheme": "bdf2"},
        }

    def wing(k: int) -> dict[str, Any]:
        nodes, triangles = plate(between(0.3, 0.4), between(0.2, 0.3))
        turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
        nodes = nodes @ turn.T + place(k)
        membrane = {
            "areal_density": between(1.0, 3.0),
            "stretching_stiffness": 1e4,
            "bending_stiffness": 10.0 ** between(-2.0, 0.0),
            "poisson_ratio": 0.3,
        }
        mesh = {"triangles": {"nodes": nodes.tolist(), "triangles": triangles.tolist()}}
        own = {"mesh": mesh, "membrane": membrane, "gravity": gravity, "scheme": "bdf2", "relaxation_time": 1e-3}
        return {"name": f"wing_{k}", "wing": own}

    def body(k: int) -> dict[str, Any]:
        radius, mass = between(0.1, 0.18), 10.0 ** between(-0.5, 0.5)
        shape = {"circle" if dimension == 2 else "sphere": {"radius": radius}}
        mount = {"mass": mass, "gravity": gravity} | {axis: {} for axis in axes}
        return {"shape": shape, "position": place(k), "mount": mount}

    box = {axis: [-0.9, 0.9] for axis in axes} | {"cells": [CELLS[dimension]] * dimension}
    contact = {"range": RANGE} | ({"damping": between(0.0, 20.0)} if seed % 2 else {})
    return {
        "name": "mixed",
        "time": {"end": STEPS * STEP, "communication_step": STEP},
        "contact": contact,
        "coupling": {"guards": {"largest_imbalance": None}},
        "fluid": {
            "density": DENSITY,
            "kinematic_viscosity": 1e-2,
            "box": box,
            "channel": {axis: [-WALL, WALL] for axis in axes},
            "bodies": [body(2), body(3)],
            "mask": {"log_linear": {"c_eta": 1e-3}},
            "time_stepping": {"max_step": STEP, "max_cfl": 0.4},
        },
        units: [(rod if units == "rods" else wing)(k) for k in (0, 1)],
    }


def plate(length: float, width: float, along: int = 4, across: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes, m, and triangles of a flat rectangle about the origin."""
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, along + 1), np.linspace(-0.5, 0.5, across + 1))
    nodes = np.stack([length * x.ravel(), width * y.ravel(), np.zeros(x.size)], axis=1)
    first = (np.arange(across)[:, None] * (along + 1) + np.arange(along)).ravel()
    up = first + along + 1
    return nodes, np.concatenate([np.stack([first, first + 1, up + 1], 1), np.stack([first, up + 1, up], 1)])


class Gauge:
    """Depths and energy of the parts of a running scene."""

    def __init__(self, session: Session, scene: dict[str, Any]):
        self.bodies, self.units = scene["fluid"]["bodies"], scene.get("rods") or scene["wings"]
        self.is_wing, self.axes = "wings" in scene, "xyz"[: len(self.bodies[0]["position"])]
        self.parts = [session.units[own["name"]] for own in self.units]
        energies = ["energy.elastic", "energy.kinetic", "energy.gravity", "energy.contact"]
        self.energies = [part.scalars_reader(energies) for part in self.parts]
        names = [f"body[{k}].{what}{axis}" for k in (1, 2) for what in ("", "v") for axis in self.axes]
        self.motion = session.units["fluid"].scalars_reader(names)
        if self.is_wing:
            self.half = [SKIN, SKIN]
            corners = np.array([own["wing"]["mesh"]["triangles"]["triangles"] for own in self.units])
            steps = [(i, j, SAMPLES - i - j) for i in range(SAMPLES + 1) for j in range(SAMPLES + 1 - i)]
            shares = np.array(steps) / SAMPLES
            self.sample: Callable[[int, np.ndarray], np.ndarray] = lambda k, x: (shares @ x[corners[k]]).reshape(-1, 3)
        else:
            self.half = [0.5 * own["beam"]["thickness"] for own in self.units]
            share = np.arange(SAMPLES)[:, None, None] / SAMPLES
            self.sample = lambda _, x: np.concatenate(x[:-1] + share * (x[1:] - x[:-1]))
        self.radii = [own["shape"].popitem()[1]["radius"] for own in json.loads(json.dumps(self.bodies))]

    def look(self) -> tuple[float, float, bool]:
        """Return the energy, J, the largest depth over half the thickness of the thinner part, which is negative of a
        gap, and whether anything is in the range of another part."""
        energy = sum(own().sum() for own in self.energies)
        motion = self.motion().reshape(2, 2, -1)
        for own, (place, velocity) in zip(self.bodies, motion, strict=True):
            mount = own["mount"]
            energy += mount["mass"] * (0.5 * velocity @ velocity - np.dot(mount["gravity"], place))
        shapes = [np.array([part.read(axis) for axis in self.axes]).T for part in self.parts]
        points = [self.sample(k, shape) for k, shape in enumerate(shapes)]
        points += [place[None, :] for place, _ in motion]
        half = self.half + self.radii
        # A wing touches walls without thickness, to half the range.
        walls = [0.0 if self.is_wing and k < 2 else half[k] for k in range(4)]
        allowed = [0.5 * RANGE if self.is_wing and k < 2 else half[k] for k in range(4)]
        gaps = [(WALL - np.abs(points[k]).max() - walls[k], allowed[k]) for k in range(4)]
        for k, one in enumerate(points):
            for j, other in enumerate(points[:k]):
                apart = np.sqrt(((one[:, None] - other) ** 2).sum(axis=2).min())
                gaps.append((apart - half[k] - half[j], min(half[k], half[j])))
        return energy, max(-gap / own for gap, own in gaps), any(gap < RANGE for gap, _ in gaps)


def throw(seed: int, dimension: int, units: str) -> tuple[int, float, float, bool]:
    """Let the parts of a case fall. Return the number of steps in contact, the largest gain of energy over what they
    fall by, the largest depth, and whether a unit failed before the end, as a wing that folds does."""
    scene = random_scene(seed, dimension, units)
    falls = sum(own["mount"]["mass"] for own in scene["fluid"]["bodies"]) * 9.81 * WALL
    touched, gain, depth = 0, 0.0, 0.0
    with TemporaryDirectory() as folder, Session(validate(scene), Path(folder)) as session:
        session.start()
        gauge = Gauge(session, scene)
        start, *_ = gauge.look()
        for _ in range(session.grid.steps):
            try:
                session.step()
            except UnitFailure as error:
                print(f"case {seed}: {error}", flush=True)
                return touched, gain, depth, True
            energy, deepest, touches = gauge.look()
            gain, depth = max(gain, (energy - start) / falls), max(depth, deepest)
            touched += int(touches)
    return touched, gain, depth, False


def throw_all(_case: Case, _folder: Path) -> dict[str, Any]:
    """Throw all cases; return a row for each kind."""
    rows = []
    for kind, count, dimension, units in KINDS:
        begin = process_time()
        touched, gains, depths, failed = np.array([throw(seed, dimension, units) for seed in range(count)]).T
        rows.append(
            {
                "kind": kind,
                "cases": float(count),
                "touching": float((touched > 0).sum()),
                "steps": float(touched.sum()),
                "gain": float(f"{gains.max():.3e}"),
                "depth": float(f"{depths.max():.3f}"),
                "failed": float(failed.sum()),
                "seconds": round(process_time() - begin, 1),
            }
        )
    return {"tables": {"random": rows}}
