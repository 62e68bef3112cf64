"""Random cases of rods and wings with bodies and walls: units of their own, between which the fluid finds contact.

The fluid is a ten-thousandth as dense as what moves, so energy is exchanged by contact alone.
"""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import numpy as np

from nervure.errors import UnitFailure
from nervure.scene import validate
from nervure.simulation.session import Session
from studies.engine import Case

STEPS, STEP = {"fall": 600, "meet": 300}, 1e-3
WALL, CELLS = 0.75, {2: 24, 3: 16}  # Of the channel from the middle, m, and of its box along an axis
RANGE = 0.06  # m
SKIN = 0.25 * RANGE  # Half the thickness of a wing for another part, m
KINDS = (
    ("rods and bodies, in the plane", 45, 2, ("rods", "rods"), "fall"),
    ("rods and bodies, in space", 45, 3, ("rods", "rods"), "fall"),
    ("wings and bodies", 10, 3, ("wings", "wings"), "fall"),
    ("a rod at a wing", 20, 3, ("rods", "wings"), "meet"),
    ("a wing at a wing", 10, 3, ("wings", "wings"), "meet"),
)
PULL, APART = 30.0, 0.3  # What pulls units that meet, m/s², each so far from the middle, m: they meet with 6 to 8 m/s
DENSITY = 1e-4  # kg/m³
SAMPLES = 5  # Points of a segment of a rod, and parts of an edge of a wing, at which depths are measured


def random_scene(seed: int, dimension: int, units: tuple[str, str], motion: str) -> dict[str, Any]:
    """Return a scene of two `units`, each of "rods" or "wings", at random places in a closed channel.

    They "fall" with two bodies, or "meet", pulled towards each other."""
    random = np.random.default_rng([seed, dimension, units == ("wings", "wings")])
    way = random.normal(size=dimension)
    way /= np.linalg.norm(way)
    meet = motion == "meet"
    axes = "xyz"[:dimension]
    places = random.permutation(list(itertools.product((-0.38, 0.38), repeat=dimension)))

    def between(low: float, high: float) -> float:
        return float(random.uniform(low, high))

    def gravity(k: int) -> list[float]:
        pull: list[float] = ((PULL * (1 - 2 * k) if meet else 9.81) * way).tolist()
        return pull

    def place(k: int) -> list[float]:
        if meet:
            places[k] = APART * (2 * k - 1) * way
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
            "name": f"part_{k}",
            "beam": {
                "root": {"at": {"position": root.tolist(), "direction": direction.tolist()}},
                "length": length,
                "thickness": thickness,
                "segments": 10,
                "surface": "line",
            },
            "rod": {"material": {"section": section}, "gravity": gravity(k), "root": {"free": {}}, "scheme": "bdf2"},
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
        own = {"mesh": mesh, "membrane": membrane, "gravity": gravity(k), "scheme": "bdf2", "relaxation_time": 1e-3}
        return {"name": f"part_{k}", "wing": own}

    def body(k: int) -> dict[str, Any]:
        radius, mass = between(0.1, 0.18), 10.0 ** between(-0.5, 0.5)
        shape = {"circle" if dimension == 2 else "sphere": {"radius": radius}}
        mount = {"mass": mass, "gravity": gravity(k)} | {axis: {} for axis in axes}
        return {"shape": shape, "position": place(k), "mount": mount}

    box = {axis: [-0.9, 0.9] for axis in axes} | {"cells": [CELLS[dimension]] * dimension}
    contact = {"range": RANGE} | ({"damping": between(0.0, 20.0)} if seed % 2 and not meet else {})
    bodies = [] if meet else [body(2), body(3)]
    both = [(rod if kind == "rods" else wing)(k) for k, kind in enumerate(units)]
    named = {units[0]: both}
    if units == ("rods", "wings"):
        named = {key: both[0][key] for key in ("beam", "rod")} | {"wing": both[1]["wing"]}
    return {
        "name": "mixed",
        "time": {"end": STEPS[motion] * STEP, "communication_step": STEP},
        "contact": contact,
        "coupling": {"guards": {"largest_imbalance": None}},
        "fluid": {
            "density": DENSITY,
            "kinematic_viscosity": 1e-2,
            "box": box,
            "channel": {axis: [-WALL, WALL] for axis in axes},
            "bodies": bodies,
            "mask": {"log_linear": {"c_eta": 1e-3}},
            "time_stepping": {"max_step": STEP, "max_cfl": 0.4},
        },
    } | named


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
        self.bodies, self.axes = scene["fluid"]["bodies"], "xyz"[: len(scene["fluid"]["box"]["cells"])]
        single = [scene | {"name": key} for key in ("rod", "wing") if key in scene]
        self.units = single or scene.get("rods") or scene["wings"]
        self.parts = [session.units[own["name"]] for own in self.units]
        energies = ["energy.elastic", "energy.kinetic", "energy.gravity", "energy.contact"]
        self.energies = [part.scalars_reader(energies) for part in self.parts]
        bodies = range(1, len(self.bodies) + 1)
        names = [f"body[{k}].{what}{axis}" for k in bodies for what in ("", "v") for axis in self.axes]
        self.motion = session.units["fluid"].scalars_reader(names) if names else lambda: np.zeros(0)
        kinds = [own["name"] if single else "rod" if "rod" in own else "wing" for own in self.units]
        self.is_wing = [kind == "wing" for kind in kinds]
        self.half = [
            SKIN if is_wing else 0.5 * own["beam"]["thickness"]
            for own, is_wing in zip(self.units, self.is_wing, strict=True)
        ]
        self.radii = [own["shape"].popitem()[1]["radius"] for own in json.loads(json.dumps(self.bodies))]

    def sample(self, k: int, x: np.ndarray) -> np.ndarray:
        """Return points of unit `k` with these nodes, m."""
        if not self.is_wing[k]:
            share = np.arange(SAMPLES)[:, None, None] / SAMPLES
            return np.concatenate(x[:-1] + share * (x[1:] - x[:-1]))
        corners = np.array(self.units[k]["wing"]["mesh"]["triangles"]["triangles"])
        steps = [(i, j, SAMPLES - i - j) for i in range(SAMPLES + 1) for j in range(SAMPLES + 1 - i)]
        points: np.ndarray = np.array(steps) / SAMPLES @ x[corners]
        return points.reshape(-1, 3)

    def look(self) -> tuple[float, float, float, bool]:
        """Return the energy and the kinetic energy of the units, J, the largest depth over that which no force reaches,
        negative of a gap, and whether anything is in the range of another part."""
        energies = np.array([own() for own in self.energies])
        energy, kinetic = energies.sum(), energies[:, 1].sum()
        motion = self.motion().reshape(-1, 2, len(self.axes))
        for own, (place, velocity) in zip(self.bodies, motion, strict=True):
            mount = own["mount"]
            energy += mount["mass"] * (0.5 * velocity @ velocity - np.dot(mount["gravity"], place))
        shapes = [np.array([part.read(axis) for axis in self.axes]).T for part in self.parts]
        points = [self.sample(k, shape) for k, shape in enumerate(shapes)]
        points += [place[None, :] for place, _ in motion]
        half = self.half + self.radii
        # A wing touches walls without thickness, to half the range.
        is_wing = self.is_wing + [False] * len(self.radii)
        walls = [(0.0, 0.5 * RANGE) if is_wing[k] else (own, own) for k, own in enumerate(half)]
        gaps = [(WALL - np.abs(at).max() - own, allowed) for at, (own, allowed) in zip(points, walls, strict=True)]
        for k, one in enumerate(points):
            for j, other in enumerate(points[:k]):
                apart = np.sqrt(((one[:, None] - other) ** 2).sum(axis=2).min())
                # Two units share half of both thicknesses.
                allowed = 0.5 * (half[k] + half[j]) if k < 2 else min(half[k], half[j])
                gaps.append((apart - half[k] - half[j], allowed))
        return energy, kinetic, max(-gap / own for gap, own in gaps), any(gap < RANGE for gap, _ in gaps)


def throw(seed: int, dimension: int, units: tuple[str, str], motion: str) -> tuple[int, float, float, bool]:
    """Let the parts of a case fall or meet.

    Return the number of steps in contact, the largest gain of energy over what the bodies fall by, without any over the
    largest kinetic energy, the largest depth, and whether a unit failed before the end, as a wing that folds does."""
    scene = random_scene(seed, dimension, units, motion)
    falls = sum(own["mount"]["mass"] for own in scene["fluid"]["bodies"]) * 9.81 * WALL
    touched, gain, depth, fastest, failed = 0, 0.0, 0.0, 0.0, False
    with TemporaryDirectory() as folder, Session(validate(scene), Path(folder)) as session:
        session.start()
        gauge = Gauge(session, scene)
        start, *_ = gauge.look()
        for _ in range(session.grid.steps):
            try:
                session.step()
            except UnitFailure as error:
                print(f"case {seed}: {error}", flush=True)
                failed = True
                break
            energy, kinetic, deepest, touches = gauge.look()
            gain, depth, fastest = max(gain, energy - start), max(depth, deepest), max(fastest, kinetic)
            touched += int(touches)
    return touched, gain / (falls or fastest), depth, failed


def throw_all(_case: Case, _folder: Path) -> dict[str, Any]:
    """Throw all cases; return a row for each kind."""
    rows = []
    for kind, count, dimension, units, motion in KINDS:
        begin = process_time()
        outcomes = [throw(seed, dimension, units, motion) for seed in range(count)]
        touched, gains, depths, failed = np.array(outcomes).T
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
