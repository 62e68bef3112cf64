"""A rigid wing that a body carries, in place of ours; its body finds root.reaction and root.impedance by trial steps.

With the root at X, the turn R and the angular velocity omega, a node is at x = X + R r and moves with
v = X' + omega × R r. Of the masses m_k and the loads f_k - D_k (v_k(t + H) - v_k(t)), the body bears on the root

    F = Σ_k [m_k (v_k' - g) - f_k + D_k (v_k(t + H) - v_k(t))],   M = Σ_k (x_k - X) × …,

with two-step backward differences for v'. The mesh of the scene must be `triangles`.
"""

from functools import partial
from typing import Any

import numpy as np
from contract import ContractUnit, backward_differences
from pythonfmu.enums import Fmi2Causality

LAYER = 1.311
"""Cells of fluid that a wing carries, whose mass it leaves out of its own."""


class OwnWing(ContractUnit):
    """Its nodes are those of the scene's mesh."""

    description = "Rigid wing"
    STATE = ("v", "v_before", "h_before", "force", "impedance", "X", "V", "R", "omega", "on_root", "about_root")

    def __init__(self, **keywords: Any) -> None:
        super().__init__(**keywords)
        scene = self.scene
        named = {own["name"]: own["wing"] for own in scene.get("wings") or []}
        wing = named[scene["this_wing"]] if named else scene["wing"]
        mesh = wing["mesh"].get("triangles")
        if mesh is None:
            raise ValueError(f"the mesh of the wing is {', '.join(wing['mesh'])}, but must be `triangles`")
        nodes, triangles = np.array(mesh["nodes"], float).T, np.array(mesh["triangles"])
        a, b, c = (nodes[:, triangles[:, k]] for k in range(3))
        areas = np.linalg.norm(np.cross(b - a, c - a, axis=0), axis=0) / 2
        density = wing["membrane"]["areal_density"]
        if fluid := scene.get("fluid"):
            (low, high), cells = fluid["box"]["x"], fluid["box"]["cells"][0]
            ratio = (fluid.get("fine_box") or {}).get("ratio", 1)
            density = max(density - LAYER * fluid["density"] * (high - low) / cells / ratio, 0.0)
        n = nodes.shape[1]
        self.mass = density * np.bincount(triangles.ravel(), np.repeat(areas / 3, 3), n)
        self.gravity = np.array(wing.get("gravity") or [0.0] * 3)[:, None]
        self.X = np.array(wing.get("pivot") or [0.0] * 3)
        self.arms, self.R = nodes - self.X[:, None], np.eye(3).ravel()
        self.V, self.omega, self.on_root, self.about_root = (np.zeros(3) for _ in range(4))
        self.v, self.v_before, self.force = (np.zeros((3, n)) for _ in range(3))
        self.impedance, self.h_before = np.zeros(n), 0.0
        for d, axis in enumerate("xyz"):
            self.register_array(f"force_{axis}", "N", Fmi2Causality.input, self.force[d])
            motion = {axis: ("m", self.X), f"v{axis}": ("m/s", self.V), f"omega_{axis}": ("rad/s", self.omega)}
            for name, (unit, own) in motion.items():
                get, put = partial(own.item, d), partial(own.__setitem__, d)
                self.register(f"root.{name}", unit, Fmi2Causality.input, get, put)
            self.register(f"root.force_{axis}", "N", Fmi2Causality.output, partial(self.on_root.item, d))
            self.register(f"root.moment_{axis}", "N.m", Fmi2Causality.output, partial(self.about_root.item, d))
            for k in range(n):
                self.register(f"{axis}[{k + 1}]", "m", Fmi2Causality.output, partial(self.node, 0, d, k))
                self.register(f"v{axis}[{k + 1}]", "m/s", Fmi2Causality.output, partial(self.node, 1, d, k))
        self.register_array("impedance", "kg/s", Fmi2Causality.input, self.impedance)
        self.register_array("root.rotation", "1", Fmi2Causality.input, self.R)

    def place(self) -> tuple[np.ndarray, np.ndarray]:
        """Return positions and velocities of the nodes, `[3, nodes]`, by those of the root."""
        arms = self.R.reshape(3, 3) @ self.arms
        return self.X[:, None] + arms, self.V[:, None] + np.cross(self.omega, arms, axisb=0).T

    def node(self, which: int, d: int, k: int) -> float:
        """Return a component of the position (0) or the velocity (1) of node `k`."""
        return float(self.place()[which][d, k])

    def do_step(self, current_time: float, step_size: float) -> bool:
        c0, c1, c2 = backward_differences(step_size, self.h_before)
        x, v = self.place()
        rate = c0 * v - c1 * self.v + c2 * self.v_before
        borne = self.mass * (rate - self.gravity) - self.force + self.impedance * (v - self.v)
        self.on_root[:] = borne.sum(axis=1)
        self.about_root[:] = np.cross(x - self.X[:, None], borne, axis=0).sum(axis=1)
        self.v_before[:], self.v[:], self.h_before = self.v, v, step_size
        return True
