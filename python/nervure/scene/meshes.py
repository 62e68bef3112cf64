"""Meshes of wings from files of other programs, which meshio reads."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from nervure.errors import SceneError
from nervure.extras import require
from nervure.scene.keys import Document

KEY = "wing.mesh.file"


def embed(scene: Document, folder: Path) -> bool:
    """Put nodes (m), triangles and chains of a file, relative to `folder`, into the wing of `scene`, and return whether
    there was a file. Raise `SceneError` for a file that is no wing."""
    wing = scene.get("wing")
    mesh = wing.get("mesh") if isinstance(wing, dict) else None
    if not isinstance(mesh, dict) or len(mesh) != 1 or not isinstance(mesh.get("file"), str):
        return False
    mesh["triangles"] = read(folder / mesh.pop("file"))
    return True


def read(path: Path) -> Document:
    """Return `nodes` (m), `triangles`, `chains` and `groups` of a file that meshio reads: OBJ, STL, VTK, Gmsh, others.

    The line cells of each physical group of Gmsh, or of each value of an array of integers, make a chain of that name,
    and the triangles a group.
    Raises `SceneError` where the file has no triangles, other faces, or lines that are no chain.
    """
    meshio = require("meshio", f"`{KEY}`")
    if not path.is_file():
        raise SceneError(f"`{KEY}` is {str(path)!r}, but there is no such file")
    try:
        with warnings.catch_warnings(action="ignore"):
            mesh = meshio.read(path)
    except (Exception, SystemExit) as error:
        raise SceneError(f"`{KEY}` is {str(path)!r}, which meshio cannot read: {error}") from error
    faces = {block.type for block in mesh.cells} - {"line", "triangle", "vertex"}
    if faces:
        raise SceneError(f"`{KEY}` is {str(path)!r} with cells {', '.join(sorted(faces))}, but a wing has triangles")
    triangles = np.concatenate([np.empty((0, 3), int), *(c.data for c in mesh.cells if c.type == "triangle")])
    if not len(triangles):
        raise SceneError(f"`{KEY}` is {str(path)!r}, but it has no triangles")
    lines = {name: _chain(name, np.array(segments), path) for name, segments in _groups(mesh).items()}
    # Gmsh writes points that belong to no cell, too.
    used = np.unique(np.concatenate([triangles.ravel(), *lines.values()]))
    places = np.zeros((len(used), 3))
    places[:, : mesh.points.shape[1]] = mesh.points[used]
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


def _chain(name: str, segments: np.ndarray, path: Path) -> list[int]:
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
        raise SceneError(f"`{KEY}` is {str(path)!r}: the lines of {name!r} must be one chain without branches or loops")
    return nodes
