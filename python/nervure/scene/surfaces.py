"""Surfaces of rigid bodies from STL, OBJ and PLY files, which trimesh reads."""

from pathlib import Path

import numpy as np

from nervure.errors import InputError
from nervure.extras import require
from nervure.scene import reading
from nervure.scene.keys import Document

SUFFIXES = (".stl", ".obj", ".ply")


def read(path: Path, unit: float) -> Document:
    """Return `nodes` (m) and the `triangles` with an area of a file in `unit` (m). Raise `ValueError` where it
    cannot be read or has none."""
    if path.suffix.lower() not in SUFFIXES:
        raise ValueError(f"triangles are in a file {', '.join(SUFFIXES)}")
    reading.check_size(path)
    try:
        trimesh = require("trimesh", "a surface from a file")
    except InputError as error:
        raise ValueError(str(error)) from error
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
    return {"nodes": [[unit * x for x in node] for node in nodes], "triangles": triangles}


def _check_obj(path: Path) -> None:
    """Raise `ValueError` where a face of an OBJ file names a node that the file lacks: trimesh takes another."""
    lines = [line.split() for line in path.read_text(encoding="utf-8", errors="replace").splitlines()]
    faces = (line[1:] for line in lines if line[:1] == ["f"])
    corners = [int(corner.split("/")[0]) - 1 for face in faces for corner in face]
    reading.check_nodes(np.array(corners, int), sum(line[:1] == ["v"] for line in lines))
