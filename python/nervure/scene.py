"""Scene files: reading, overriding single keys, and the published values that belong to a scene.

What a scene may hold is decided by the units when they are packed (`package.describe`), not here.
"""

import json
from difflib import get_close_matches
from pathlib import Path

from nervure.errors import Refusal
from nervure.resources import SCENES

REFERENCES = SCENES / "references.json"


class SceneError(Refusal):
    """A scene or an override that cannot be used; the message names file or key."""


def find(name: str | Path) -> Path:
    """The scene file at the path `name`, or else the shipped scene of that name."""
    path, shipped = Path(name), SCENES / f"{name}.json"
    return shipped if not path.exists() and shipped.is_file() else path


def load(name: str | Path) -> dict:
    """Read a scene, a file or a shipped one by its name; raises `SceneError` if it is not a JSON object."""
    path = find(name)
    try:
        scene = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        known = {found.name: found for found in SCENES.glob("*.json")}
        near = get_close_matches(path.with_suffix(".json").name, known, 1)
        hint = f"; did you mean {near[0].removesuffix('.json')}?" if near else f"; the shipped scenes are {', '.join(sorted(path.stem for path in known.values()))}"
        raise SceneError(f"cannot read the scene file {path}: {error.strerror}{hint}") from error
    except ValueError as error:
        raise SceneError(f"the scene file {path} is not JSON: {error}") from error
    if not isinstance(scene, dict):
        raise SceneError(f"the scene file {path} holds a JSON {type(scene).__name__}, but it must be an object")
    return scene


def customized(path: str | Path, overrides: list[str] | None, end_time: float | None = None) -> dict:
    """The scene file with `overrides` (key=value) and another end time, s."""
    scene = load(path)
    for assignment in overrides or []:
        override(scene, assignment)
    if end_time is not None:
        override(scene, f"time.end={end_time}")
    return scene


def override(scene: dict, assignment: str) -> None:
    """Set one value of `scene` from `key=value`, e.g. `fluid.box.cells.0=650`; the value is JSON, or else a string."""
    key, equals, text = assignment.partition("=")
    if not (key and equals):
        raise SceneError(f"the override `{assignment}` must be of the form key=value")
    assign(scene, key, json_or_text(text))


def json_or_text(text: str):
    """The value of a JSON text, or else the text itself."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def assign(scene: dict, key: str, value) -> None:
    """Set one value of `scene` by its dotted path, in which a number is an index into a list. A last key that does not
    exist is added: whether it is allowed is for the units to say."""
    *parents, last = [int(part) if part.isdecimal() else part for part in key.split(".")]
    target = scene
    try:
        for part in parents:
            target = target[part]
        if isinstance(target, list):
            target[last]  # an index beyond the end is an error, not an addition
        target[last] = value
    except (KeyError, IndexError, TypeError) as error:
        raise SceneError(f"the override of `{key}` names a key that the scene does not have") from error


def reference(name: str) -> dict | None:
    """Published values for the scene called `name`, from the longest family of `scenes/references.json` that its
    name begins with: `{"primary": {source, quantities}, "spread": {source, quantities}}`; None if there are none."""
    families = json.loads(REFERENCES.read_text(encoding="utf-8"))
    matching = [family for family in families if name == family or name.startswith(f"{family}-")]
    return families[max(matching, key=len)] if matching else None
