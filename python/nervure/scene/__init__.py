"""Scenes: read by path or by the name of a shipped scene, changed by dotted keys, turned into objects with types.

The units' libraries alone decide which values a scene may have (`crates/scene`). A scene is written as it was given:
the text has no defaults, which would otherwise become part of every result and outlast a later version's better ones.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from nervure.errors import Fault, SceneError
from nervure.library import check, is_built
from nervure.resources import SCENES
from nervure.scene.types import Beam, Rod, Scene

__all__ = ["Document", "Own", "Scene", "assign", "beams", "document", "load", "override", "read", "text", "validate"]

Document = dict[str, Any]  # A scene as JSON has it, not necessarily checked

MOST_BYTES = 4 << 20  # Largest scene file, as in crates/scene: a larger one is not even read


def read(name: str | Path, overrides: Iterable[str] = (), end_time: float | None = None) -> Document:
    """Return the scene file at the path `name`, or else the shipped scene of that name, with `overrides` (key=value)
    and another end time, s; raises `SceneError` if it is not a JSON object."""
    path, source = _open(name)
    return _changed(_parse(path, source)[0], overrides, end_time)


def load(name: str | Path, overrides: Iterable[str] = (), end_time: float | None = None) -> Scene:
    """Return the scene as an object with types; raises `SceneError` with all faults that the units find.

    Where the libraries are not built only the types are checked.
    """
    (path, source), assignments = _open(name), list(overrides)
    scene, faults = _parse(path, source)
    if assignments or end_time is not None:
        scene = _changed(scene, assignments, end_time)
        faults = check(text(scene), source) if is_built("rod") else []
    if faults:
        raise SceneError("\n".join(_line(fault, path, end_time is not None) for fault in faults), faults)
    return validate(scene)


def _line(fault: Fault, path: Path, with_end_time: bool) -> str:
    """Return the sentence of a fault with its place: in the file at `path`, or the option that changed the value."""
    if fault.line:
        return f"{path}, line {fault.line}, column {fault.column}: {fault.text}"
    option = "--end-time" if with_end_time and fault.key == "time.end" else "--set"
    return f"{fault.text} (from {option})"


def _open(name: str | Path) -> tuple[Path, str]:
    """Return path and text of a scene file."""
    path, shipped = Path(name), SCENES / f"{name}.json"
    if not path.exists() and shipped.is_file():
        path = shipped
    if path.is_dir():
        inside = path / "scene.json"
        hint = f"; `{inside}` is the scene of its run" if inside.is_file() else ""
        raise SceneError(f"{path} is a folder, but a scene is a file or the name of a shipped scene{hint}")
    try:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
    except OSError as error:
        known = [found.stem for found in sorted(SCENES.glob("*.json"))]
        near = [name for name in known if name.startswith(path.stem)] or get_close_matches(path.stem, known, 1)
        hint = f"did you mean {' or '.join(near)}?" if near else f"the shipped scenes are {', '.join(known)}"
        raise SceneError(f"cannot read the scene file {path}: {error.strerror}; {hint}") from error
    if len(content) > MOST_BYTES:
        raise SceneError(f"the scene file {path} is larger than {MOST_BYTES >> 20} MB")
    try:
        return path, content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"the scene file {path} is not UTF-8 text: byte {error.start + 1} is invalid") from error


def _parse(path: Path, source: str) -> tuple[Document, list[Fault]]:
    """Return the document of a scene file and its faults; raises `SceneError` where it is not JSON."""
    faults = check(source) if is_built("rod") else []
    broken = [fault for fault in faults if fault.kind in ("syntax", "duplicate")]
    if broken:
        raise SceneError("\n".join(_line(fault, path, False) for fault in broken), broken)
    try:
        scene = json.loads(source)
    except (ValueError, RecursionError) as error:
        said = "\n".join(_line(fault, path, False) for fault in faults)
        raise SceneError(said or f"{path} is not JSON: {error}", faults) from error
    if not isinstance(scene, dict):
        raise SceneError(f"{path} is not a JSON object")
    return scene, faults


def _changed(scene: Document, overrides: Iterable[str], end_time: float | None) -> Document:
    for assignment in overrides:
        override(scene, assignment)
    if end_time is not None:
        assign(scene, "time.end", end_time)
    return scene


def validate(scene: Document) -> Scene:
    """Return a scene as an object with types; raises `SceneError` with its faults where the types do not fit."""
    try:
        return Scene.model_validate(scene)
    except ValidationError as error:
        faults = check(text(scene)) if is_built("rod") else []
        said = "\n".join(fault.text for fault in faults)
        raise SceneError(said or f"the scene does not have the types of its keys: {error}", faults) from error


def document(scene: Scene | Document) -> Document:
    """Return a scene as JSON has it."""
    return scene.document() if isinstance(scene, Scene) else scene


def text(scene: Scene | Document) -> str:
    """Return a scene as the text of a scene file."""
    return json.dumps(document(scene), indent=2, ensure_ascii=False) + "\n"


@dataclass(frozen=True)
class Own:
    """A beam of a scene with its rod, and the beginnings of the names of its columns."""

    unit: str  # Unit of the rod: `rod`, or its name
    beam: Beam
    rod: Rod | None
    prefix: str  # Of the columns of the rod's outputs; empty for the only rod
    force: str  # Name of the fluid's force on the beam: `beam`, or `beam_1` and so on


def beams(scene: Scene) -> list[Own]:
    """Return the beams of a scene in the order in which the fluid counts them."""
    if scene.beam:
        return [Own("rod", scene.beam, scene.rod, "", "beam")]
    return [Own(own.name, own.beam, own.rod, f"{own.name}_", f"beam_{i}") for i, own in enumerate(scene.rods, 1)]


def override(scene: Document, assignment: str) -> None:
    """Set one value of `scene` from `key=value`, e.g. `fluid.box.cells.0=650`; the value is JSON, or else a string."""
    key, equals, value = assignment.partition("=")
    if not (key and equals):
        raise SceneError(f"the override `{assignment}` must be of the form key=value")
    assign(scene, key, json_or_text(value))


def json_or_text(value: str) -> Any:
    """Return the value of a JSON text, or else the text itself."""
    try:
        return json.loads(value, object_pairs_hook=_without_duplicates)
    except (ValueError, RecursionError):
        return value


def _without_duplicates(members: list[tuple[str, Any]]) -> Document:
    found = dict(members)
    if len(found) < len(members):
        names = [name for name, _ in members]
        twice = next(name for name in names if names.count(name) > 1)
        raise SceneError(f"duplicate key `{twice}` in the value of an override")
    return found


def assign(scene: Document, key: str, value: Any) -> None:
    """Set one value of `scene` by its dotted path, in which a number is an index into a list. A last key that does not
    exist is added: whether it is allowed is for the units to say."""
    path: list[Any] = [int(part) if part.isdecimal() else part for part in key.split(".")]
    *parents, last = path
    target: Any = scene
    try:
        for part in parents:
            target = target[part]
        if isinstance(target, list):
            target[last]  # an index beyond the end is an error, not an addition
        target[last] = value
    except (KeyError, IndexError, TypeError) as error:
        raise SceneError(f"the override of `{key}` names a key that the scene does not have") from error
