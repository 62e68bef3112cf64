"""A cantilever under its own weight as Reissner's beam (1972), exact to rounding."""

import numpy as np

STEPS = 2000


def tip(length: float, weight: float, bending: float, axial: float, shear: float = np.inf) -> tuple[float, float]:
    """Displacement of the tip (m) of a horizontal beam that weighs `weight` (N/m) downwards; stiffnesses EI (N m²), EA,
    GA_s (N).

    The force in the section is known, −weight (L − s) upwards; theta' = M/EI and M' = −(r' × N) are integrated from the
    root by Runge and Kutta's rule, and M(0) is found by the secant method such that M(L) = 0.
    """

    def slope(s: float, state: np.ndarray) -> np.ndarray:
        force, cos, sin = -weight * (length - s), np.cos(state[2]), np.sin(state[2])
        stretch, slide = 1 + force * sin / axial, force * cos / shear
        dx, dy = stretch * cos - slide * sin, stretch * sin + slide * cos
        return np.array([dx, dy, state[3] / bending, -dx * force])

    def shot(moment: float) -> np.ndarray:
        state, h = np.array([0.0, 0.0, 0.0, moment]), length / STEPS
        for s in np.arange(STEPS) * h:
            k1 = slope(s, state)
            k2 = slope(s + h / 2, state + h / 2 * k1)
            k3 = slope(s + h / 2, state + h / 2 * k2)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(s + h, state + h * k3))
        return state

    other = 0.9 * (guess := -weight * length**2 / 2)
    end = shot(guess)[3]
    while True:
        state = shot(other)
        if abs(state[3]) < 1e-12 * weight * length**2 or state[3] == end:
            return float(state[0] - length), float(state[1])
        guess, end, other = other, state[3], other - state[3] * (other - guess) / (state[3] - end)
