"""Write what the fuzz targets begin with: small scenes, states of both units, and a dictionary of the scene's words.

python fuzz/seeds.py        `make fuzz` does it; what the targets found before stays
"""

import json
import sys
import tempfile
from pathlib import Path

FUZZ = Path(__file__).resolve().parent
sys.path[:0] = [str(FUZZ.parent / "studies")]

from nervure.pack import package
from nervure.resources import ROOT
from nervure.scene import REFERENCES, load
from nervure.unit import Unit
from reliability.unit import SCENE, STEP

HEADER = 62
"""Bytes before the payload of a serialized state, which the target puts there itself (`crates/fmi2/src/snapshot.rs`)."""


def small(scene: dict) -> dict:
    """The scene on a grid and with a beam on which a step takes no time."""
    if scene.get("fluid"):
        scene["fluid"]["box"]["cells"] = [32, 16]
    if scene.get("beam"):
        scene["beam"]["segments"] = 6
    return scene


def write(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def words(schema: object) -> set[str]:
    """Keys and named values of a JSON schema."""
    found = set()
    if isinstance(schema, dict):
        found |= set(schema.get("properties", {})) | set(schema.get("enum", [])) | {schema.get("const")}
    for part in schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ():
        found |= words(part)
    return {word for word in found if isinstance(word, str)}


scenes = {path.stem: small(load(path)) for path in (ROOT / "scenes").glob("*.json") if path != REFERENCES} | {"flag": SCENE}
for name, scene in scenes.items():
    for kind in package.kinds(scene):
        write(FUZZ / "corpus" / f"{kind}_scene" / name, package.scene_text(scene).encode())
write(FUZZ / "target" / "flag" / "scene.json", package.scene_text(SCENE).encode())
for kind in package.KINDS:
    with tempfile.TemporaryDirectory() as folder:
        unit = Unit(package.pack(kind, SCENE, Path(folder)), kind, 1.0)
        unit.start()
        for step in range(4):
            write(FUZZ / "corpus" / f"{kind}_state" / f"steps-{step}", unit.serialize()[HEADER:])
            unit.step(step * STEP, STEP)
        unit.close()
schema = json.loads((ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8"))
dictionary = "".join(f'"\\"{word}\\""\n' for word in sorted(words(schema)))
write(FUZZ / "target" / "scene.dict", dictionary.encode())
