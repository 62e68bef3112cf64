"""Scenes: read from a file or by the name of a shipped one, changed by dotted keys, and then objects with types.

What values a scene may have is decided by its units, not here. So a scene that does not fit the types is shown to them,
and they say what is wrong with it. A scene is written as it was given: its text has no defaults, which would otherwise
become part of every result and stay there when a later version has better ones.
"""

import json
import math
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from nervure.errors import SceneError
from nervure.library import KINDS, check, is_built
from nervure.resources import SCENES
from nervure.scene.part import Part
from nervure.scene.source import Source, parse
from nervure.scene.types import Beam, Rod, Scene

__all__ = [
    "Document",
    "Own",
    "Scene",
    "assign",
    "beams",
    "document",
    "kinds",
    "load",
    "override",
    "scene_of_unit",
    "unit_label",
]
__all__ += ["read", "text", "validate"]

Document = dict[str, Any]  # A scene as JSON has it, which no unit need have seen


def read(name: str | Path, overrides: Iterable[str] = (), end_time: float | None = None) -> Document:
    """The scene file at the path `name`, or else the shipped scene of that name, with `overrides` (key=value) and
    another end time, s; raises `SceneError` if it is not a JSON object."""
    return _changed(_open(name).document(), overrides, end_time)


def load(name: str | Path, overrides: Iterable[str] = (), end_time: float | None = None) -> Scene:
    """The same as an object with types; raises `SceneError` in the units' words where they refuse it, with the place in
    the file. Where the libraries are not built only the types are checked."""
    source, assignments = _open(name), list(overrides)
    scene = _changed(source.document(), assignments, end_time)
    try:
        if is_built("rod"):
            check(text(scene))
        return validate(scene)
    except SceneError as error:
        changed = [assignment.partition("=")[0] for assignment in assignments] + ["time.end"] * (end_time is not None)
        place = source.place_of(error.key, changed) if error.key else None
        raise SceneError(f"{error} ({place})" if place else str(error)) from error


def _open(name: str | Path) -> Source:
    path, shipped = Path(name), SCENES / f"{name}.json"
    if not path.exists() and shipped.is_file():
        path = shipped
    if path.is_dir():
        inside = path / "scene.json"
        hint = f"; `{inside}` is the scene of its run" if inside.is_file() else ""
        raise SceneError(f"{path} is a folder, but a scene is a file or the name of a shipped scene{hint}")
    try:
        return Source(path, path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        known = [found.stem for found in sorted(SCENES.glob("*.json"))]
        near = [name for name in known if name.startswith(path.stem)] or get_close_matches(path.stem, known, 1)
        hint = f"did you mean {' or '.join(near)}?" if near else f"the shipped scenes are {', '.join(known)}"
        raise SceneError(f"cannot read the scene file {path}: {error.strerror}; {hint}") from error
    except UnicodeDecodeError as error:
        raise SceneError(f"the scene file {path} is no text in UTF-8: byte {error.start + 1} is not") from error


def _changed(scene: Document, overrides: Iterable[str], end_time: float | None) -> Document:
    for assignment in overrides:
        override(scene, assignment)
    if end_time is not None:
        assign(scene, "time.end", end_time)
    return scene


def validate(scene: Document) -> Scene:
    """A scene as an object with types; raises `SceneError` in the units' words where they do not fit."""
    try:
        return Scene.model_validate(scene)
    except ValidationError as error:
        check(text(scene))
        raise SceneError(f"the scene does not have the types of its keys: {error}") from error


def document(scene: Scene | Document) -> Document:
    """A scene as JSON has it."""
    return scene.document() if isinstance(scene, Scene) else scene


def text(scene: Scene | Document) -> str:
    """A scene as the text of a scene file."""
    return json.dumps(_jsonable(document(scene)), indent=2, ensure_ascii=False) + "\n"


def _jsonable(value: Any) -> Any:
    """`value` with texts for the numbers that JSON does not have: the units refuse them under their keys."""
    if isinstance(value, dict):
        return {key: _jsonable(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_jsonable(part) for part in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def kinds(scene: Scene | Document) -> list[str]:
    """The units that a scene has, in the order in which they step: the rod or, by their names, several, and the fluid.
    A scene without any is for the fluid to refuse."""
    parts = vars(scene) if isinstance(scene, Scene) else scene
    return [*_names(parts), *(kind for kind in KINDS if parts.get(kind) is not None)] or ["fluid"]


def unit_label(kind: str) -> str:
    """What messages call a unit: `rod`, `fluid`, or `rod NAME`."""
    return kind if kind in KINDS else f"rod {kind}"


def _names(parts: dict[str, Any]) -> list[str]:
    """Names of several rods, as far as they have some: a unit may not have seen the scene yet."""
    rods = parts.get("rods")
    each = [vars(own) if isinstance(own, Part) else own for own in rods] if isinstance(rods, list) else []
    return [own["name"] for own in each if isinstance(own, dict) and isinstance(own.get("name"), str)]


def scene_of_unit(scene: Scene | Document, kind: str) -> str:
    """The text of the scene that a unit carries: that of one of several rods says which it is."""
    return text(scene if kind in KINDS else {**document(scene), "this_rod": kind})


@dataclass(frozen=True)
class Own:
    """A beam of a scene and its rod, and what its names begin with."""

    unit: str  # Of the rod: `rod`, or its name
    beam: Beam
    rod: Rod | None
    prefix: str  # Of the columns that the rod gives: none where it is the only one
    force: str  # Of the columns of the fluid's forces on it: `beam`, or `beam_1` and so on


def beams(scene: Scene) -> list[Own]:
    """The beams of a scene, in the order in which the fluid counts them."""
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
    """The value of a JSON text, or else the text itself."""
    try:
        return parse(value)
    except json.JSONDecodeError:
        return value
    except ValueError as error:
        raise SceneError(f"the value `{value[:60]}` cannot be used: {error}") from error


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
