"""Meshes of wings from files of other programs, which meshio reads."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from nervure.extras import require
from nervure.scene import reading
from nervure.scene.keys import Document

KEY = "wing.mesh.file"


def read(path: Path, unit: float = 1.0) -> Document:
    """Return `nodes` (m), `triangles`, `chains` and `groups` of a file that meshio reads: OBJ, STL, VTK, Gmsh, others;
    `unit` is the length of its unit, m.

    The line cells of each physical group of Gmsh, or of each value of an array of integers, make a chain of that name,
    and the triangles a group.
    Raises `ValueError` where the file has no triangles, other faces, lines that are no chain, or nodes that it lacks.
    """
    meshio = require("meshio", f"`{KEY}`")
    if not path.is_file():
        raise ValueError("there is no such file")
    reading.check_size(path)
    try:
        with warnings.catch_warnings(action="ignore"):
            mesh = meshio.read(path)
    except (Exception, SystemExit) as error:
        raise ValueError(f"meshio cannot read it: {error}") from error
    cells = [(block.type, np.asarray(block.data)) for block in mesh.cells]
    faces = {kind for kind, _ in cells} - {"line", "triangle", "vertex"}
    if faces:
        raise ValueError(f"it has cells {', '.join(sorted(faces))}, and a wing has triangles")
    for _, corners in cells:
        reading.check_nodes(corners, len(mesh.points))
    triangles = np.concatenate([np.empty((0, 3), int), *(corners for kind, corners in cells if kind == "triangle")])
    if not len(triangles):
        raise ValueError("it has no triangles")
    lines = {name: _chain(name, np.array(segments)) for name, segments in _groups(mesh).items()}
    # Gmsh writes points that belong to no cell, too.
    used = np.unique(np.concatenate([triangles.ravel(), *lines.values()]))
    places = np.zeros((len(used), 3))
    places[:, : mesh.points.shape[1]] = unit * mesh.points[used]
    return {
        "nodes": places.tolist(),
        "triangles": np.searchsorted(used, triangles).tolist(),
        "chains": [{"name": name, "nodes": np.searchsorted(used, nodes).tolist()} for name, nodes in lines.items()],
    } | _surfaces(mesh)


def _surfaces(mesh: Any) -> Document:
    """Return the `groups` of triangles, counted in the order of the file; nothing without numbers of cells."""
    found: dict[str, list[int]] = {}
    if (numbers := _numbers(mesh)) is None:
        return {}
    names = {int(tag): name for name, (tag, dimension) in mesh.field_data.items() if dimension == 2}
    tags = np.concatenate(
        [np.asarray(n).ravel() for n, c in zip(numbers, mesh.cells, strict=True) if c.type == "triangle"]
    )
    for i, tag in enumerate(tags):
        found.setdefault(names.get(int(tag), str(tag)), []).append(i)
    return {"groups": [{"name": name, "triangles": group} for name, group in found.items()]}


def _numbers(mesh: Any) -> list[np.ndarray] | None:
    """Return the first array of integers of the cells, by blocks of cells."""
    return next((d for d in mesh.cell_data.values() if all(np.asarray(b).dtype.kind in "iu" for b in d)), None)


def _groups(mesh: Any) -> dict[str, list[np.ndarray]]:
    """Return the line cells by the name of their group."""
    numbers = _numbers(mesh)
    names = {int(tag): name for name, (tag, dimension) in mesh.field_data.items() if dimension == 1}
    found: dict[str, list[np.ndarray]] = {}
    for i, block in enumerate(mesh.cells):
        if block.type == "line":
            tags = np.asarray(numbers[i]).ravel() if numbers else np.ones(len(block.data), int)
            for tag, segment in zip(tags, block.data, strict=True):
                found.setdefault(names.get(int(tag), str(tag)), []).append(segment)
    return found


def _chain(name: str, segments: np.ndarray) -> list[int]:
    """Return the nodes along segments, from the end that the file names first."""
    neighbours: dict[int, list[int]] = {}
    for a, b in segments.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    start = next((node for node, others in neighbours.items() if len(others) == 1), None)
    nodes = [] if start is None else [start]
    while nodes:
        ahead = [node for node in neighbours[nodes[-1]] if node not in nodes[-2:]]
        if len(ahead) != 1 or len(nodes) > len(segments):
            break
        nodes += ahead
    if len(nodes) != len(segments) + 1:
        raise ValueError(f"the lines of {name!r} must be one chain without branches or loops")
    return nodes
