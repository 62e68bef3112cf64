"""An Euler–Bernoulli beam by its first eigenmodes, in place of the rod.

The deflection w(s, t) = Σ q_j(t) phi_j(s) of a cantilever, |w| << L, in the modes that it has in vacuo

    phi_j(s) = cosh z - cos z - sigma_j (sinh z - sin z) + 2 b_j (d/L) sinh z,   z = b_j s/L,
    1 + cos b_j cosh b_j + b_j (d/L) (cos b_j sinh b_j - sin b_j cosh b_j) = 0

(Rao, Vibration of Continuous Systems, ch. 11), the clamp being set back by d: a spring EI/d. Along itself the beam is
rigid, and it has no shear: a scene's `shear_factor` has no effect. With the net line density mu = (rho_s - rho_f) h
under the momentum load, and of station k the normal force f_k, the impedance D_k and the normal velocity v_k,

    m_j q_j'' + EI (b_j/L)^4 (m_j/mu) q_j = Σ_k phi_j(s_k) [f_k - D_k (v_k(t + H) - v_k(t))] + mu g_n ∫ phi_j ds,

    m_j = mu ∫ phi_j² ds,

by two-step backward differences, everything at the end of the step.
"""

import math
from typing import Any

import numpy as np
from contract import ContractUnit, backward_differences, root_of
from pythonfmu.enums import Fmi2Causality

MODES = 6
"""A uniform load bends the tip by 6e-6 less than with all of them."""

QUADRATURE = 40
"""Points of the integrals over the beam: more than enough for the squares of six modes."""

LARGEST_DEFLECTION = 0.1
"""Of the tip, in lengths: beyond it the linear beam is more than 0.5 % too long."""


class ModalBeam(ContractUnit):
    """Its stations are the points of the scene's beam, so that the fluid sees what it would of the rod."""

    description = "Euler-Bernoulli cantilever by its first modes"
    STATE = ("q", "v", "q_before", "v_before", "h_before", "x", "y", "vx", "vy", "force_x", "force_y", "impedance")

    def __init__(self, **keywords: Any) -> None:
        super().__init__(**keywords)
        beam, rod = self.scene["beam"], self.scene["rod"]
        unknown = [f"rod.{key}" for key in ("damping", "root_motion") if rod.get(key)]
        unknown += ["beam.rest_angles"] if beam.get("rest_angles") else []
        if unknown or "plane_strain" not in rod["material"]:
            raise ValueError(f"the modal beam knows no {', '.join(unknown) or 'rod.material but plane_strain'}")
        material = rod["material"]["plane_strain"]
        length, h = beam["length"], beam["thickness"]
        stiffness = material["youngs_modulus"] * h**3 / 12 / (1 - material["poisson_ratio"] ** 2)
        line_density = (material["density"] - self.scene["fluid"]["density"]) * h
        if line_density < 0.0:
            raise ValueError("the beam must be at least as heavy as the fluid that it displaces")

        root, tangent = root_of(self.scene)
        self.normal = np.array([-tangent[1], tangent[0]])
        self.s = np.linspace(0.0, length, beam["segments"] + 1)
        self.rest = root[:, None] + tangent[:, None] * self.s
        setback = rod.get("clamp_compliance_length", 0.0) / length
        b = np.array([_wavenumber(j, setback) for j in range(1, MODES + 1)])
        sigma = (np.cosh(b) + np.cos(b) + 2 * b * setback * np.sinh(b)) / (np.sinh(b) + np.sin(b))

        def modes(s: np.ndarray) -> np.ndarray:
            z = np.outer(s / length, b)
            shapes: np.ndarray = (
                np.cosh(z) - np.cos(z) - sigma * (np.sinh(z) - np.sin(z)) + 2 * b * setback * np.sinh(z)
            )
            return shapes

        self.phi = modes(self.s)  # [stations, modes]
        points, weights = np.polynomial.legendre.leggauss(QUADRATURE)
        points, weights = length * (points + 1) / 2, length * weights / 2
        square = weights @ modes(points) ** 2  # ∫ phi_j² ds
        self.mass = line_density * square
        self.stiffness = stiffness * (b / length) ** 4 * square
        gravity = np.array(rod.get("gravity") or [0.0, 0.0]) @ self.normal
        self.weight = line_density * gravity * (weights @ modes(points))

        self.q, self.v, self.q_before, self.v_before = (np.zeros(MODES) for _ in range(4))
        self.h_before = 0.0
        self.x, self.y = self.rest.copy()
        self.vx, self.vy, self.force_x, self.force_y, self.impedance = (np.zeros_like(self.s) for _ in range(5))
        for name, unit in (("force_x", "N/m"), ("force_y", "N/m"), ("impedance", "kg/(m.s)")):
            self.register_array(name, unit, Fmi2Causality.input, getattr(self, name))
        for name, unit in (("x", "m"), ("y", "m"), ("vx", "m/s"), ("vy", "m/s")):
            self.register_array(name, unit, Fmi2Causality.output, getattr(self, name))
        tip_x, tip_y = self.rest[:, -1]
        for name, unit, read in (
            ("tip.ux", "m", lambda: self.x[-1] - tip_x),
            ("tip.uy", "m", lambda: self.y[-1] - tip_y),
            ("tip.vx", "m/s", lambda: self.vx[-1]),
            ("tip.vy", "m/s", lambda: self.vy[-1]),
        ):
            self.register(name, unit, Fmi2Causality.output, read)

    def do_step(self, current_time: float, step_size: float) -> bool:
        c0, c1, c2 = backward_differences(step_size, self.h_before)
        known_rate = c2 * self.q_before - c1 * self.q  # q' = c0 q(t + H) + known_rate
        force = self.normal @ (self.force_x, self.force_y)
        damper = self.phi.T @ (self.impedance[:, None] * self.phi)
        matrix = np.diag(c0**2 * self.mass + self.stiffness) + c0 * damper
        right = (
            self.phi.T @ force
            + self.weight
            + damper @ (self.v - known_rate)
            - self.mass * (c0 * known_rate + c2 * self.v_before - c1 * self.v)
        )
        self.q_before[:], self.v_before[:] = self.q, self.v
        self.q[:] = np.linalg.solve(matrix, right)
        self.v[:] = c0 * self.q + known_rate
        self.h_before = step_size
        self.x[:], self.y[:] = self.rest + self.normal[:, None] * (self.phi @ self.q)
        self.vx[:], self.vy[:] = self.normal[:, None] * (self.phi @ self.v)
        deflection = abs(self.phi[-1] @ self.q)
        if not deflection < LARGEST_DEFLECTION * self.s[-1]:
            limit = LARGEST_DEFLECTION * self.s[-1]
            raise ValueError(f"the tip is {deflection:g} m off, but this beam is linear: {limit:g} m at most")
        return True


def _wavenumber(j: int, setback: float) -> float:
    """The j-th root b of the frequency equation, from 1; `setback` in lengths of the beam."""
    b = (j - 0.5) * math.pi
    for _ in range(20):
        cosine, sine, tangent, secant = math.cos(b), math.sin(b), math.tanh(b), 1 / math.cosh(b)
        value = cosine + secant + b * setback * (cosine * tangent - sine)
        slope = -sine - tangent * secant + setback * (cosine * tangent - sine)
        b -= value / (slope + b * setback * (cosine * secant**2 - sine * tangent - cosine))
    return b
