"""Scenes whose meshes and surfaces stand in files: the units get nodes and triangles in the place of a name."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from nervure.errors import SceneError
from nervure.scene import meshes, surfaces
from nervure.scene.keys import Document, assign

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
        parts = dict(named(scene))
        read = surfaces.embed(scene, self.folder) + meshes.embed(scene, self.folder)
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
    """Yield dotted path and content of each part of a scene that names a file."""
    wing, fluid = scene.get("wing"), scene.get("fluid")
    parts = [("wing.mesh", wing.get("mesh") if isinstance(wing, dict) else None)]
    bodies = fluid.get("bodies") if isinstance(fluid, dict) else None
    for i, body in enumerate(bodies if isinstance(bodies, list) else ()):
        shape = body.get("shape") if isinstance(body, dict) else None
        surface = shape.get("triangulation") if isinstance(shape, dict) else None
        parts.append((f"fluid.bodies.{i}.shape.triangulation", surface))
    yield from ((path, dict(part)) for path, part in parts if isinstance(part, dict) and "file" in part)
