"""The shipped scenes, and the keys that a scene may have: for lists, completion and hints.

Nothing here checks a scene, so nothing heavy is imported: a shell waits for the answer while its user types.
"""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

from nervure.resources import ROOT, SCENES

Schema = dict[str, Any]  # A part of scene.schema.json


@dataclass(frozen=True)
class Shipped:
    """A shipped scene."""

    name: str
    description: str
    path: Path


def shipped() -> list[Shipped]:
    """Return the shipped scenes, by name."""
    scenes = ((path, json.loads(path.read_text(encoding="utf-8"))) for path in sorted(SCENES.glob("*.json")))
    return [Shipped(path.stem, scene.get("description", ""), path) for path, scene in scenes]


def hint(name: str, known: Iterable[str], otherwise: str = "there are") -> str:
    """Return the question whether one of the `known` names was meant, or else the list of them."""
    names = list(known)
    near = [other for other in names if name and other.startswith(name)] or get_close_matches(name, names, 1)
    return f"did you mean {' or '.join(near)}?" if near else f"{otherwise} {', '.join(names)}"


def complete_key(typed: str) -> list[str]:
    """Return the dotted scene keys that begin with `typed`; of a single one its parts too, so that typing goes on."""
    place, dot, _ = typed.rpartition(".")
    found = [f"{place}{dot}{name}" for name in keys(place) if f"{place}{dot}{name}".startswith(typed)]
    return found if len(found) != 1 else [*found, *(f"{found[0]}.{name}" for name in keys(found[0]))]


def keys(place: str) -> Iterable[str]:
    """Return the keys of the part at the dotted path `place`; of a list the first index."""
    parts = [_schema()]
    for key in filter(None, place.split(".")):
        parts = [inner for part in _choices(parts) for inner in _inside(part, key)]
    choices = list(_choices(parts))
    lists = ["0"] if any("properties" in one for part in choices for one in _choices(_inside(part, "0"))) else []
    return dict.fromkeys([*(key for part in choices for key in part.get("properties", ())), *lists])


@cache
def _schema() -> Schema:
    schema: Schema = json.loads((ROOT / "modelDescription" / "scene.schema.json").read_text(encoding="utf-8"))
    return schema


def _inside(part: Schema, key: str) -> list[Schema]:
    if key.isdecimal():
        return [part["items"]] if "items" in part else []
    return [part["properties"][key]] if key in part.get("properties", {}) else []


def _choices(parts: Iterable[Schema]) -> Iterator[Schema]:
    """Yield the `parts` with references followed, and every choice where a part may be one of several."""
    for part in parts:
        yield part
        if reference := part.get("$ref"):
            yield from _choices([_schema()["$defs"][reference.rpartition("/")[2]]])
        for choice in ("anyOf", "oneOf"):
            yield from _choices(part.get(choice, ()))
