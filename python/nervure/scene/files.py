"""Scenes whose meshes and surfaces stand in files: the units get nodes and triangles in the place of a name."""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from nervure.errors import SceneError
from nervure.scene import meshes, reading, surfaces
from nervure.scene.keys import Document, assign

WING = "wing.mesh"  # End of the path of the mesh of a wing
MOST_BYTES = 4 << 20  # Largest scene file, as in crates/scene: a larger one is not even read
NODE_BYTES = 300  # Of a node with two triangles in the text of a scene


@dataclass(frozen=True)
class Files:
    """The folder of the files of a scene, and what stood where nodes and triangles are now, by dotted path.

    Scenes are equal wherever their files are.
    """

    folder: Path = field(default=Path(), compare=False)
    parts: Mapping[str, Document] = field(default_factory=dict, compare=False)

    def embed(self, scene: Document) -> "Files":
        """Read the files of `scene`, in its place, and return what stood there."""
        parts = {path: dict(part) for path, part in named(scene)}
        read = [key_of(path) for path, part in named(scene) if _read(path, part, self.folder)]
        if read and (size := len(json.dumps(scene, indent=2, ensure_ascii=False))) > MOST_BYTES:
            raise SceneError(
                f"the scene has {size / (1 << 20):.1f} MB with nodes and triangles of `{'`, `'.join(read)}`, but at "
                f"most {MOST_BYTES >> 20} MB are allowed, some {MOST_BYTES // NODE_BYTES:,} nodes: a coarser mesh helps"
            )
        return Files(self.folder, {**self.parts, **parts})

    def change(self, scene: Document, changes: Mapping[str, object]) -> "Files":
        """Change values of `scene`, in its place, by dotted keys, also of a file that was read."""
        for path, part in self.parts.items():
            if any(key.startswith(f"{path}.") for key in changes):
                assign(scene, path, part)
        for key, value in changes.items():
            assign(scene, key, value)
        return self.embed(scene)


class Read(dict[str, object]):
    """A scene as JSON has it, and its files."""

    files = Files()


def named(scene: Document) -> Iterator[tuple[str, Document]]:
    """Yield dotted path and content of each part of a scene, which may be unchecked, that names a file."""
    parts = []
    for i, body in enumerate(_list(_part(scene, "fluid"), "bodies")):
        surface = _part(_part(body, "shape"), "triangulation")
        parts.append((f"fluid.bodies.{i}.shape.triangulation", surface))
    parts.append((WING, _part(_part(scene, "wing"), "mesh")))
    for i, wing in enumerate(_list(scene, "wings")):
        parts.append((f"wings.{i}.{WING}", _part(_part(wing, "wing"), "mesh")))
    yield from ((path, part) for path, part in parts if isinstance(part, dict) and "file" in part)


def _part(whole: object, key: str) -> object:
    """Return the value of `key` in `whole`, or None where this is no object or has no such key."""
    return whole.get(key) if isinstance(whole, dict) else None


def _list(whole: object, key: str) -> list[object]:
    """Return the list under `key` in `whole`, or an empty one."""
    return found if isinstance(found := _part(whole, key), list) else []


def _read(path: str, part: Document, folder: Path) -> bool:
    """Put nodes (m) and triangles of a file, relative to `folder`, in the place of its name; return False where the
    units say what is wrong with it. Raise `SceneError` for a file that is no wing or surface."""
    unit = reading.unit(part)
    if unit is None or not isinstance(name := part["file"], str) or not part.keys() <= {"file", "unit"}:
        return False
    of_wing = path.endswith(WING)
    try:
        found = (meshes if of_wing else surfaces).read(folder / name, unit)
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise SceneError(f"`{key_of(path)}` is {name!r}, but {why}") from error
    part.clear()
    part |= {"triangles": found} if of_wing else found
    return True


def key_of(path: str) -> str:
    """Return the key of the file of the part at a dotted path, as messages show it."""
    return re.sub(r"\.(\d+)\b", r"[\1]", path) + ".file"
