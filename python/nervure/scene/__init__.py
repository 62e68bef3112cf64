"""Scenes: read by path or by the name of a shipped scene, changed by dotted keys, turned into objects with types.

The units' libraries alone decide which values a scene may have (`crates/scene`). A scene is written as it was given:
the text has no defaults, which would otherwise become part of every result and outlast a later version's better ones.
"""

import copy
import json
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from nervure import arguments
from nervure.catalogue import hint
from nervure.errors import Fault, SceneError
from nervure.library import check
from nervure.resources import ROOT, SCENES
from nervure.scene.files import MOST_BYTES, Files, Read, key_of, named
from nervure.scene.keys import Document, assign, json_or_text, override, plain
from nervure.scene.part import refusal
from nervure.scene.types import Beam, Rod, Scene, Wing

__all__ = [
    "Document", "Own", "Scene", "assign", "beams", "column_names", "document", "files_of", "json_or_text", "load",
    "override", "plain", "read", "text", "validate", "wings", "with_files", "write_copy",
]  # fmt: skip


def read(name: str | Path, overrides: Iterable[str] = (), end_time: float | None = None) -> Document:
    """Return the scene file at the path `name`, or else the shipped scene of that name, with `overrides` (key=value)
    and another end time, s, and with the nodes and triangles of its files; raises `SceneError` if it is not a JSON
    object."""
    path, source = _open(name)
    scene = Read(_changed(_parse(path, source)[0], overrides, end_time))
    scene.files = Files(path.parent).embed(scene)
    return scene


def load(name: str | Path, overrides: Iterable[str] = (), end_time: float | None = None) -> Scene:
    """Return the scene as an object with types; raises `SceneError` with all faults that the units find.

    >>> scene = nervure.load("csm3", ["beam.segments=12"], end_time=0.5)
    >>> scene.beam.segments, scene.time.end
    (12, 0.5)
    """
    (path, source), assignments = _open(name), arguments.texts("overrides", overrides)
    if not isinstance(end_time, int | float | None):  # What number it may be, the check of the scene knows
        end_time = arguments.if_given("end_time", end_time)
    scene, faults = _parse(path, source)
    if assignments or end_time is not None:
        scene = _changed(scene, assignments, end_time)
    files = Files(path.parent).embed(scene)
    if files.parts or assignments or end_time is not None:
        faults = check(text(scene), source)
    if faults:
        raise SceneError("\n".join(_line(fault, path, end_time is not None, files.parts) for fault in faults), faults)
    made = validate(scene)
    made._files = files
    return made


def with_files(scene: Scene) -> Scene:
    """Return a scene with what the files hold that its attributes name; the same where they name none."""
    return scene.copy() if any(named(scene.document())) else scene


def files_of(scene: Scene | Document) -> Files:
    """Return where the files of a scene are, by default in the working folder."""
    return scene._files if isinstance(scene, Scene) else getattr(scene, "files", Files())


def _line(fault: Fault, path: Path, with_end_time: bool, files: Iterable[str] = ()) -> str:
    """Return the sentence of a fault with its place: in the file at `path`, one of the `files` beside it, or the option
    that changed the value."""
    if fault.line:
        return f"{path}, line {fault.line}, column {fault.column}: {fault.text}"
    for part in files:
        key = key_of(part)
        if fault.key.startswith(key.removesuffix(".file")):
            return f"{fault.text} (from `{key}`)"
    option = "--end-time" if with_end_time and fault.key == "time.end" else "--set"
    return f"{fault.text} (from {option})"


def _open(name: str | Path) -> tuple[Path, str]:
    """Return path and text of a scene file."""
    is_text = isinstance(name, str) and name.lstrip().startswith("{")
    if is_text or not isinstance(name, str | Path):
        given, made = ("JSON text", "json.loads(text)") if is_text else (f"a {type(name).__name__}", "dictionary")
        raise SceneError(
            f"the scene is {given}, but must be a path, the name of a shipped scene or `nervure.Scene(**{made})`"
        )
    path, shipped = Path(name), SCENES / f"{name}.json"
    if not os.path.exists(path) and os.path.isfile(shipped):
        path = shipped
    if os.path.isdir(path):
        inside = path / "scene.json"
        instead = f"; `{inside}` is the scene of its run" if inside.is_file() else ""
        raise SceneError(f"{path} is a folder, but a scene is a file or the name of a shipped scene{instead}")
    try:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        known = [found.stem for found in sorted(SCENES.glob("*.json"))]
        mine = [str(found) for found in sorted(path.parent.glob("*.json")) if str(found).startswith(str(path))]
        meant = f"did you mean {' or '.join(mine)}?" if mine else hint(path.stem, known, "the shipped scenes are")
        why = error.strerror if isinstance(error, OSError) else error
        raise SceneError(f"cannot read the scene file {path}: {why}; {meant}") from error
    if len(content) > MOST_BYTES:
        raise SceneError(f"the scene file {path} is larger than {MOST_BYTES >> 20} MB")
    try:
        return path, content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SceneError(f"the scene file {path} is not UTF-8 text: byte {error.start + 1} is invalid") from error


def _parse(path: Path, source: str) -> tuple[Document, list[Fault]]:
    """Return the document of a scene file and its faults; raises `SceneError` where it is not JSON."""
    faults = check(source)
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
    refused: list[str] = []
    for assignment in overrides:
        try:
            override(scene, assignment)
        except SceneError as error:
            refused.append(str(error))
    if refused:
        raise SceneError("\n".join(refused))
    if end_time is not None:
        assign(scene, "time.end", end_time)
    return scene


def validate(scene: Document) -> Scene:
    """Return a scene as an object with types; raises `SceneError` with its faults where the types do not fit."""
    try:
        return Scene.model_validate(scene)
    except ValidationError as error:
        faults = check(text(scene))
        said = "\n".join(fault.text for fault in faults)
        raise SceneError(said or str(refusal(error)), faults) from None


def document(scene: Scene | Document) -> Document:
    """Return a scene as JSON has it."""
    return scene.document() if isinstance(scene, Scene) else scene


def text(scene: Scene | Document) -> str:
    """Return a scene as the text of a scene file."""
    return json.dumps(document(scene), indent=2, ensure_ascii=False) + "\n"


def write_copy(name: str, base: str | Path) -> Path:
    """Write a copy of the scene `base` under another name, as its author set it, and return the path `name`.json. Raise
    `SceneError` where the file exists, or a scene cannot have the name."""
    target = Path(name if name.endswith(".json") else f"{name}.json")
    path, source = _open(base)
    scene, faults = _parse(path, source)
    if Files(path.parent).embed(whole := copy.deepcopy(scene)).parts:
        faults = check(text(whole), source)
    if faults:
        raise SceneError("\n".join(_line(fault, path, False) for fault in faults), faults)
    changes = {"name": target.stem}
    if "$schema" in scene:
        changes["$schema"] = (ROOT / "modelDescription" / "scene.schema.json").resolve().as_uri()
    changes |= {f"{key}.file": _moved(part["file"], path.parent, target.parent) for key, part in named(scene)}
    changed, copied = copy.deepcopy(scene), source
    for key, value in changes.items():
        there, here = (json.dumps(one, ensure_ascii=False) for one in (_value(scene, key), value))
        found = re.search(rf'"{re.escape(key.rpartition(".")[2])}"\s*:\s*({re.escape(there)})', copied)
        copied = copied[: found.start(1)] + here + copied[found.end(1) :] if found else copied
        assign(changed, key, value)
    if json.loads(copied) != changed:  # The words of the file are not those that were sought
        copied = text(changed)
    Files(target.parent).embed(changed)
    if faults := check(text(changed)):
        raise SceneError("\n".join(fault.text for fault in faults), faults)
    try:
        with target.open("x", encoding="utf-8") as file:
            file.write(copied)
    except FileExistsError:
        raise SceneError(f"{target} exists, and `nervure new` replaces no file") from None
    except OSError as error:
        target.unlink(missing_ok=True)
        raise SceneError(f"cannot write {target}: {error.strerror}") from error
    return target


def _value(scene: Document, key: str) -> Any:
    """Return the value at a dotted key of a document that has it."""
    return reduce(lambda part, name: part[int(name) if isinstance(part, list) else name], key.split("."), scene)


def _moved(file: str, before: Path, after: Path) -> str:
    """Return the path of a file beside `before` as a scene in the folder `after` names it."""
    if before.resolve() == after.resolve() or os.path.isabs(file):
        return file
    return Path(os.path.relpath(before.resolve() / file, after.resolve())).as_posix()


@dataclass(frozen=True)
class Own:
    """A beam of a scene with its rod, and the beginnings of the names of its columns."""

    unit: str  # Unit of the rod: `rod`, or its name
    beam: Beam
    rod: Rod | None
    prefix: str  # Of the columns of the rod's outputs; empty for a rod without another rod or a wing
    force: str  # Name of the fluid's force on the beam: `beam`, or `beam_1` and so on


def beams(scene: Scene) -> list[Own]:
    """Return the beams of a scene in the order in which the fluid counts them."""
    names = column_names(scene)
    if scene.beam:
        return [Own("rod", scene.beam, scene.rod, *names["rod"])]
    return [Own(own.name, own.beam, own.rod, *names[own.name]) for own in scene.rods]


def wings(scene: Scene) -> dict[str, Wing]:
    """Return the wings of a scene by the names of their units, in the order in which the fluid counts them."""
    return {"wing": scene.wing} if scene.wing else {own.name: own.wing for own in scene.wings}


def column_names(scene: Scene) -> dict[str, tuple[str, str]]:
    """Return by the unit of each beam and wing the beginning of the names of its columns, empty for only one, and the
    name of the fluid's force on it."""
    forces = {"rod": "beam"} if scene.beam else {own.name: f"beam_{i}" for i, own in enumerate(scene.rods, 1)}
    forces |= {"wing": "wing"} if scene.wing else {own.name: f"wing_{i}" for i, own in enumerate(scene.wings, 1)}
    return {unit: (f"{unit}_" if len(forces) > 1 else "", force) for unit, force in forces.items()}
