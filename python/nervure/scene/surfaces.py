"""Surfaces of rigid bodies from STL, OBJ and PLY files, which trimesh reads."""

from collections.abc import Iterator
from pathlib import Path

from nervure.errors import InputError, SceneError
from nervure.extras import require
from nervure.scene.keys import Document

SUFFIXES = (".stl", ".obj", ".ply")
MOST_BYTES = 64 << 20  # Largest file


def embed(scene: Document, folder: Path) -> bool:
    """Put the nodes (m) and triangles of files into the surfaces of `scene`, and return whether there were files; paths
    are relative to `folder`. Raise `SceneError` for a file that is no surface."""
    found = False
    for key, surface in _surfaces(scene):
        name, unit = surface["file"], surface.get("unit") or 1.0
        if not isinstance(unit, (int, float)) or unit <= 0:
            continue  # The units say what is wrong
        try:
            nodes, triangles = _read(folder / name)
        except (OSError, ValueError, InputError) as error:
            why = error.strerror if isinstance(error, OSError) else error
            raise SceneError(f"`{key}.file` is {name!r}, but {why}") from error
        surface.clear()
        surface |= {"nodes": [[unit * x for x in node] for node in nodes], "triangles": triangles}
        found = True
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
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(f"it is larger than {MOST_BYTES >> 20} MB")
    trimesh = require("trimesh", "a surface from a file")
    try:
        mesh = trimesh.load_mesh(path)
        mesh.update_faces(mesh.nondegenerate_faces())
        nodes, triangles = mesh.vertices.tolist(), mesh.faces.tolist()
    except Exception as error:  # Whatever a reader trips over in a damaged file
        raise ValueError(f"trimesh cannot read it: {error}") from error
    if not triangles:
        raise ValueError("it has no triangles")
    return nodes, triangles
