"""Changes of a scene by dotted keys, e.g. `fluid.box.cells.0`, in which a number is an index into a list."""

import json
import os
from typing import Any

from nervure.arguments import shown
from nervure.catalogue import hint, keys
from nervure.errors import SceneError

Document = dict[str, Any]  # A scene as JSON has it, not necessarily checked


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
    """Set one value of `scene` by its dotted path. A last key that does not exist is added: whether it is allowed is
    for the units to say."""
    if not (isinstance(key, str) and key.isprintable()):
        raise SceneError(f"a key is {shown(key)}, but must be a text such as `time.end`")
    *parents, last = key.split(".")
    target: Any = scene
    for number, part in enumerate(parents):
        target = target[_existing(target, part, key, parents[:number])]
    target[_existing(target, last, key, parents) if not isinstance(target, dict) else last] = plain(value)


def plain(value: Any) -> Any:
    """Return a value as JSON has it: parts of a scene, tuples, paths, and numbers and arrays of NumPy become plain."""
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, dict):
        return {key: plain(part) for key, part in value.items()}
    for method in ("document", "tolist"):
        if hasattr(value, method):
            return getattr(value, method)()
    return os.fspath(value) if isinstance(value, os.PathLike) else value


def _existing(target: Any, part: str, key: str, parents: list[str]) -> str | int:
    """Return `part` as key or index of `target`, the value at the path `parents`; raise `SceneError` without it."""
    place = ".".join(parents)
    if isinstance(target, dict):
        if part in target:
            return part
        allowed = list(keys(place))
        if part in allowed:
            why = f"there is no `{'.'.join([*parents, part])}`, which must be given as a whole, as JSON"
        else:
            why = hint(part, dict.fromkeys([*target, *allowed]))
    elif isinstance(target, list):
        if part.isdecimal() and int(part) < len(target):
            return int(part)
        why = f"`{place}` is a list of {len(target)}, counted from 0"
    else:
        why = f"`{place}` has no parts"
    raise SceneError(f"the override of `{key}` names a key that the scene does not have: {why}")
