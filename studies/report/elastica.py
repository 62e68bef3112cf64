"""A cantilever under its own weight by Reissner's beam (1972), to rounding: what rods with these stiffnesses
converge to."""

import math

STEPS = 2000


def tip(length: float, weight: float, bending: float, axial: float, shear: float = math.inf) -> tuple[float, float]:
    """Displacement of the tip (m) of a horizontal beam that weighs `weight` (N/m) downwards; stiffnesses EI (N m²),
    EA, GA_s (N).

    The force in the section is known, −weight (L − s) upwards; theta' = M/EI and
    M' = −(r' × N) are integrated from the root by
    Runge and Kutta's rule, and M(0) is found by Newton's method such that M(L) = 0.
    """

    def slope(s: float, state):
        x, y, theta, moment = state
        force = -weight * (length - s)
        cos, sin = math.cos(theta), math.sin(theta)
        stretch, slide = 1 + force * sin / axial, force * cos / shear
        dx, dy = stretch * cos - slide * sin, stretch * sin + slide * cos
        return dx, dy, moment / bending, -dx * force

    def shot(moment: float):
        state, h = (0.0, 0.0, 0.0, moment), length / STEPS
        for i in range(STEPS):
            s = i * h
            k1 = slope(s, state)
            k2 = slope(s + h / 2, [a + h / 2 * b for a, b in zip(state, k1)])
            k3 = slope(s + h / 2, [a + h / 2 * b for a, b in zip(state, k2)])
            k4 = slope(s + h, [a + h * b for a, b in zip(state, k3)])
            state = [a + h / 6 * (b + 2 * c + 2 * d + e) for a, b, c, d, e in zip(state, k1, k2, k3, k4)]
        return state

    small = -weight * length**2 / 2
    guess, end = small, shot(small)[3]
    other = 0.9 * small
    for _ in range(40):
        other_end = shot(other)[3]
        if abs(other_end) < 1e-13 * abs(small) or other_end == end:
            break
        guess, end, other = other, other_end, other - other_end * (other - guess) / (other_end - end)
    x, y, _, _ = shot(other)
    return x - length, y
