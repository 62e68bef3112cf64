"""Shear factor and clamp compliance of a solid plate, the parameters of a rod that stands for it.

A plate in plane strain, clamped on a straight wall or on a cylinder, is bent by a moment and by a force at its far
end, by linear elasticity on nine-node quadrilaterals. Away from the ends its sections turn and move like those of
Timoshenko's beam,

    theta = M (x + d)/EI,    theta = P (l (x + d) - x²/2)/EI,    w' = theta + P/(k G h),

with the mean turning theta and the mean displacement w of a section; d is `clamp_compliance_length`, k `shear_factor`.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

LENGTH = 6.0
"""Length of the plate, in thicknesses."""
MIDDLE = (2.0, 4.5)
"""Ends of the part whose sections are read: two thicknesses off the wall, and nearly two off the loaded end."""
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(3)


def shapes(r: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the three quadratic polynomials on [-1, 1] and their slopes."""
    return np.array([r * (r - 1) / 2, 1 - r * r, r * (r + 1) / 2]), np.array([r - 0.5, -2 * r, r + 0.5])


def mesh(radius: float, along: int, across: int) -> tuple[np.ndarray, np.ndarray]:
    """Return coordinates of the nodes, `[2 along + 1, 2 across + 1]`, in thicknesses: finer at the wall and at both
    faces."""
    s = np.linspace(0.0, 1.0, along + 1)
    x = LENGTH * np.expm1(3 * s) / np.expm1(3)
    y = 0.5 * np.sin(np.linspace(-np.pi / 2, np.pi / 2, across + 1))
    x, y = (np.insert(v, range(1, len(v)), (v[1:] + v[:-1]) / 2) for v in (x, y))
    wall = np.sqrt(radius**2 - y**2) - radius if np.isfinite(radius) else 0 * y
    return x[:, None] + wall * np.clip(1 - x[:, None] / 1.5, 0, None), np.broadcast_to(y, (x.size, y.size))


def stiffness(x: np.ndarray, y: np.ndarray, poisson: float) -> np.ndarray:
    """Return the stiffness matrix for a Young's modulus of 1."""
    lame, shear = poisson / ((1 + poisson) * (1 - 2 * poisson)), 0.5 / (1 + poisson)
    law = np.array([[lame + 2 * shear, lame, 0], [lame, lame + 2 * shear, 0], [0, 0, shear]])
    numbers = np.arange(x.size).reshape(x.shape)
    matrix = np.zeros((2 * x.size, 2 * x.size))
    for i in range(0, x.shape[0] - 1, 2):
        for j in range(0, x.shape[1] - 1, 2):
            nodes = numbers[i : i + 3, j : j + 3].ravel()
            corners = np.stack([x.ravel()[nodes], y.ravel()[nodes]], 1)
            own = np.zeros((18, 18))
            for r, weight_r in zip(POINTS, WEIGHTS):
                for s, weight_s in zip(POINTS, WEIGHTS):
                    (of_r, slope_r), (of_s, slope_s) = shapes(r), shapes(s)
                    slopes = np.stack([np.outer(slope_r, of_s).ravel(), np.outer(of_r, slope_s).ravel()])
                    jacobian = slopes @ corners
                    dx, dy = np.linalg.solve(jacobian, slopes)
                    strain = np.zeros((3, 18))
                    strain[0, 0::2], strain[1, 1::2], strain[2, 0::2], strain[2, 1::2] = dx, dy, dy, dx
                    own += strain.T @ law @ strain * (np.linalg.det(jacobian) * weight_r * weight_s)
            places = np.stack([2 * nodes, 2 * nodes + 1], 1).ravel()
            matrix[np.ix_(places, places)] += own
    return matrix


def over_section(y: np.ndarray, weight: Callable[[float], float]) -> np.ndarray:
    """Return weights of the nodal values of a section in the integral of value times `weight(y)`."""
    result = np.zeros(y.size)
    for j in range(0, y.size - 1, 2):
        for s, weight_s in zip(POINTS, WEIGHTS):
            values, slopes = shapes(s)
            place, length = values @ y[j : j + 3], slopes @ y[j : j + 3]
            result[j : j + 3] += values * (weight(place) * length * weight_s)
    return result


def measure(radius: float, poisson: float, along: int, across: int) -> tuple[float, float, float]:
    """Return d by the moment, d by the force, and k; lengths in thicknesses."""
    x, y = mesh(radius, along, across)
    numbers = np.arange(x.size).reshape(x.shape)
    turning = over_section(y[0], lambda y: -12 * y)
    mean = over_section(y[0], lambda y: 1.0)
    loads = np.zeros((2 * x.size, 2))
    loads[2 * numbers[-1], 0] = turning
    loads[2 * numbers[-1] + 1, 1] = over_section(y[0], lambda y: 1.5 * (1 - 4 * y * y))
    free = np.arange(2 * x.shape[1], 2 * x.size)
    moved = np.zeros_like(loads)
    moved[free] = np.linalg.solve(stiffness(x, y, poisson)[np.ix_(free, free)], loads[free])
    moved = moved.reshape(*x.shape, 2, 2) / (12 * (1 - poisson**2))  # times EI; [along, across, component, load]

    at = x[:, x.shape[1] // 2]
    middle = (at > MIDDLE[0]) & (at < MIDDLE[1])
    theta = np.einsum("j,ijl->il", turning, moved[:, :, 0])[middle]
    w = np.einsum("j,ijl->il", mean, moved[:, :, 1])[middle]
    at = at[middle]
    by_moment = np.mean(theta[:, 0] - at)
    by_force = np.mean((theta[:, 1] + at**2 / 2) / LENGTH - at)
    bent = LENGTH * (at**2 / 2 + by_force * at) - at**3 / 6
    sheared = np.polyfit(at, w[:, 1] - bent, 1)[0]  # EI/(k G h)
    return by_moment, by_force, (1 + poisson) / (6 * (1 - poisson**2) * sheared)


def run(case: Any, folder: Path) -> dict[str, Any]:
    """Measure both walls with three of Poisson's ratios on two meshes."""
    rows = []
    for radius, wall in ((np.inf, "straight"), (2.5, "cylinder, R = 2.5 h")):
        for poisson in (0.0, 0.3, 0.4):
            for along, across in ((24, 6), (36, 8)):
                found = [round(float(number), 8) + 0.0 for number in measure(radius, poisson, along, across)]
                names = ("by_moment", "by_force", "shear_factor")
                rows.append(
                    {"wall": wall, "poisson": poisson, "elements": f"{along} x {across}"} | dict(zip(names, found))
                )
    return {"tables": {"clamp": rows}}
