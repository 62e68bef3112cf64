"""Write a wing with curved and branched veins as a scene: a fly's, simplified.

python examples/venation.py > examples/wing-venation.json
nervure run examples/wing-venation.json

The plan of the veins is that of Drosophila (Houle, Mezey, Galpern, Carter 2003, BMC Evolutionary Biology 3:25): costa
along the leading edge, longitudinal veins L1 to L5, two cross-veins. Places were drawn by eye and not measured, and the
stiffnesses are estimates: veins of solid cuticle with 2 GPa, 20 µm thick at the root, and a film of 1 µm.
"""

import json
import re
import textwrap
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from matplotlib.path import Path
from matplotlib.tri import Triangulation

Array = npt.NDArray[np.float64]
Place = str | tuple[float, float]

LENGTH, EDGE = 2.4e-3, 0.045  # Length of the wing, m; edge of a triangle by it
# By the length, from the hinge towards the tip and forwards. Letters name places where veins meet.
PLACES = {
    "hc": (0.0, 0.035), "h1": (0.0, 0.01), "h3": (0.0, -0.015), "h4": (0.0, -0.04), "ha": (0.0, -0.07),
    "e1": (0.45, 0.182), "e2": (0.82, 0.128), "e3": (0.99, 0.0), "e4": (0.985, -0.075), "e5": (0.72, -0.275),
    "f2": (0.17, 0.02), "f5": (0.15, -0.045), "a3": (0.43, 0.035), "a4": (0.43, -0.062),
    "p4": (0.64, -0.085), "p5": (0.56, -0.2),
}  # fmt: skip
COSTA: list[Place] = ["hc", (0.15, 0.11), (0.3, 0.162), "e1", (0.62, 0.18), "e2", (0.93, 0.063), "e3", "e4"]
MARGIN: list[Place] = [
    "e4",
    (0.93, -0.16),
    (0.84, -0.225),
    "e5",
    (0.55, -0.305),
    (0.38, -0.285),
    (0.22, -0.215),
    (0.1, -0.14),
    "ha",
]
ROOT: list[Place] = ["hc", "h1", "h3", "h4", "ha"]
VEINS: dict[str, list[Place]] = {
    "costa": COSTA,
    "L3": ["h3", "f2", (0.3, 0.033), "a3", (0.7, 0.02), "e3"],
    "L4": ["h4", "f5", (0.3, -0.055), "a4", "p4", (0.82, -0.078), "e4"],
    "L1": ["h1", (0.15, 0.065), (0.3, 0.13), "e1"],
    "L2": ["f2", (0.4, 0.085), (0.62, 0.118), "e2"],
    "L5": ["f5", (0.35, -0.125), "p5", "e5"],
    "anterior": ["a3", "a4"],
    "posterior": ["p4", (0.62, -0.145), "p5"],
}


def curve(points: list[Place]) -> list[Array]:
    """Return a smooth curve through `points`, (pieces, 2) between named places, by splines of Catmull and Rom."""
    x = np.array([PLACES[p] if isinstance(p, str) else p for p in points])
    ends = np.vstack([2 * x[0] - x[1], x, 2 * x[-1] - x[-2]])
    s = np.linspace(0, 1, 20, endpoint=False)[:, None]
    pieces, piece = [], []
    for k, point in enumerate(points[1:]):
        a, b, c, d = ends[k : k + 4]
        piece.append(b + 0.5 * s * (c - a + s * (2 * a - 5 * b + 4 * c - d + s * (3 * b - a - 3 * c + d))))
        if isinstance(point, str):
            pieces.append(np.vstack([*piece, x[k + 1]]))
            piece = []
    return pieces


def resampled(piece: Array) -> Array:
    """Return places along a piece with distances of about EDGE."""
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(piece, axis=0).T))])
    at = np.linspace(0, s[-1], max(round(s[-1] / EDGE), 1) + 1)
    return np.column_stack([np.interp(at, s, axis) for axis in piece.T])


def main() -> None:
    named: list[Array] = []

    def number(place: Array) -> int:
        for k, node in enumerate(named):
            if np.hypot(*(place - node)) < 1e-6:
                return k
        named.append(place)
        return len(named) - 1

    def chain(points: list[Place]) -> list[int]:
        found = [number(place) for piece in curve(points) for place in resampled(piece)]
        return [k for k, before in zip(found, [-1, *found], strict=False) if k != before]

    chains = {name: chain(points) for name, points in (VEINS | {"root": ROOT, "margin": MARGIN}).items()}
    rim = [*chains["costa"], *chains["margin"][1:], *chains["root"][-2:0:-1]]
    lines = np.array(named)
    outline = Path(lines[rim])
    # Rows of equilateral triangles inside, away from the veins.
    x, y = np.meshgrid(np.arange(0, 1, EDGE), np.arange(-0.35, 0.25, EDGE * 0.75**0.5))
    x[1::2] += EDGE / 2
    grid = np.column_stack([x.ravel(), y.ravel()])
    near = np.hypot(*(grid[:, None] - lines).T).min(0) < 0.72 * EDGE
    nodes = np.vstack([lines, grid[outline.contains_points(grid) & ~near]])
    triangles = Triangulation(*nodes.T).triangles
    triangles = triangles[outline.contains_points(nodes[triangles].mean(1))]
    edges = {frozenset(pair) for a, b, c in triangles.tolist() for pair in ((a, b), (b, c), (c, a))}
    missing = [(name, pair) for name, own in chains.items() for pair in pairwise(own) if frozenset(pair) not in edges]
    if missing:
        raise SystemExit(f"no edges of triangles: {missing}; another EDGE may help")
    places = [[round(float(LENGTH * v), 9) for v in node] + [0.0] for node in nodes]
    vein = {
        "line_density": 3.8e-7,
        "bending_stiffness": 1.6e-11,
        "torsional_stiffness": 1.2e-11,
        "axial_stiffness": 0.6,
    }
    tips = {"costa": 0.5, "anterior": 1.0, "posterior": 1.0}
    # Cross-veins and branches are thinner from the start.
    scales = {name: 1.0 if name in ("costa", "L3", "L4") else 0.7 for name in VEINS}
    powers = {"line_density": 2, "axial_stiffness": 2, "bending_stiffness": 4, "torsional_stiffness": 4}
    veins = [
        {"chain": name}
        | {key: float(f"{vein[key] * scale ** powers[key]:.3g}") for key in vein}
        | {"tip_diameter": tips.get(name, 0.6)}
        for name, scale in scales.items()
    ]
    sine = {"frequency": 200.0, "ramp": 0.0025}
    scene = {
        "$schema": "../modelDescription/scene.schema.json",
        "format": 2,
        "name": "wing-venation",
        "description": "A fly's wing with curved and branched veins beats in vacuum; its stiffness is an estimate.",
        "time": {"end": 0.005, "communication_step": 1e-5},
        "wing": {
            "mesh": {
                "triangles": {
                    "nodes": places,
                    "triangles": triangles.tolist(),
                    "chains": [{"name": name, "nodes": own} for name, own in chains.items()],
                }
            },
            "membrane": {
                "areal_density": 1.2e-3,
                "stretching_stiffness": 2000.0,
                "bending_stiffness": 1.8e-10,
                "poisson_ratio": 0.3,
            },
            "veins": veins,
            "root": "root",
            "root_motion": {
                "rotations": [
                    {"angle": {"sine": {"amplitude": 0.8, "phase": -np.pi / 2} | sine}, "axis": [1.0, 0.0, 0.0]},
                    {"angle": {"sine": {"amplitude": 1.22} | sine}, "axis": [0.0, 1.0, 0.0]},
                ]
            },
            "relaxation_time": 2e-5,
        },
    }
    # Lists of numbers go on one line, several triangles or nodes too.
    text = re.sub(r"\[[^][{}]*\]", lambda found: re.sub(r"\s+", " ", found[0]), json.dumps(scene, indent=1))
    rows = re.sub(r"\],\s+\[ ", "], [ ", text).replace("[ ", "[").replace(" ]", "]")
    for line in rows.splitlines():
        indent = " " * (len(line) - len(line.lstrip()))
        print(textwrap.fill(line, 100, subsequent_indent=indent) if "[" in line else line)


main()
