"""Surfaces of rigid bodies from STL, OBJ and PLY files, which trimesh reads."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from nervure.errors import InputError, SceneError
from nervure.extras import require
from nervure.scene import reading
from nervure.scene.keys import Document

SUFFIXES = (".stl", ".obj", ".ply")


def embed(scene: Document, folder: Path) -> list[str]:
    """Put the nodes (m) and triangles of files into the surfaces of `scene`, and return the keys of the files. Paths
    are relative to `folder`. Raise `SceneError` for a file that is no surface."""
    found = []
    for key, surface in _surfaces(scene):
        unit = reading.unit(surface)
        if unit is None or not surface.keys() <= {"file", "unit"}:
            continue  # The units say what is wrong
        try:
            nodes, triangles = _read(folder / surface["file"])
        except (OSError, ValueError, InputError) as error:
            why = error.strerror if isinstance(error, OSError) else error
            raise SceneError(f"`{key}.file` is {surface['file']!r}, but {why}") from error
        surface.clear()
        surface |= {"nodes": [[unit * x for x in node] for node in nodes], "triangles": triangles}
        found.append(f"{key}.file")
    return found


def _surfaces(scene: Document) -> Iterator[tuple[str, Document]]:
    """Return key and document of each surface with a file."""
    fluid = scene.get("fluid")
    bodies = fluid.get("bodies") if isinstance(fluid, dict) else None
    for i, body in enumerate(bodies if isinstance(bodies, list) else ()):
        shape = body.get("shape") if isinstance(body, dict) else None
        surface = shape.get("triangulation") if isinstance(shape, dict) else None
        if isinstance(surface, dict) and isinstance(surface.get("file"), str):
            yield f"fluid.bodies[{i}].shape.triangulation", surface


def _read(path: Path) -> tuple[list[list[float]], list[list[int]]]:
    """Return nodes, in the unit of the file, and triangles with an area."""
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"triangles are in a file {', '.join(SUFFIXES)}")
    reading.check_size(path)
    trimesh = require("trimesh", "a surface from a file")
    try:
        if path.suffix.lower() == ".obj":
            _check_obj(path)
        mesh = trimesh.load_mesh(path, process=False)
        reading.check_nodes(mesh.faces, len(mesh.vertices))
        mesh.process()
        mesh.update_faces(mesh.nondegenerate_faces())
        nodes, triangles = mesh.vertices.tolist(), mesh.faces.tolist()
    except Exception as error:  # Whatever a reader trips over in a damaged file
        raise ValueError(f"trimesh cannot read it: {error}") from error
    if not triangles:
        raise ValueError("it has no triangles")
    return nodes, triangles


def _check_obj(path: Path) -> None:
    """Raise `ValueError` where a face of an OBJ file names a node that the file lacks: trimesh takes another."""
    lines = [line.split() for line in path.read_text(encoding="utf-8", errors="replace").splitlines()]
    faces = (line[1:] for line in lines if line[:1] == ["f"])
    corners = [int(corner.split("/")[0]) - 1 for face in faces for corner in face]
    reading.check_nodes(np.array(corners, int), sum(line[:1] == ["v"] for line in lines))
