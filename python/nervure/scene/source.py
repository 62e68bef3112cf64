"""The text of a scene file as its author wrote it: what is wrong is said with line and column."""

import json
import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nervure.errors import SceneError

DEEPEST = 64  # Levels of lists and objects in a scene: its keys are ten deep; parsers give up somewhere
INDEX = re.compile(r"\.(\d+)(?=\.|$)")  # An index in a dotted path: the units write it in brackets
TOKEN = re.compile(r'\s*("(?:[^"\\]|\\.)*"|[\[\]{},:]|[^\s\[\]{},:"]+)')
"""A text, a mark of JSON, or what else stands between marks."""


def parse(text: str) -> Any:
    """The value of a JSON text; raises `ValueError` with the place of what is not JSON, of a key that is there twice
    and of what is nested too deeply. Numbers that JSON does not have become texts, for the units to refuse under
    their key."""
    _check_depth(text)
    value = json.loads(text, parse_constant=str, parse_float=_real, parse_int=_integer)
    for key, begin in _places(text, twice=True):
        raise ValueError(f"the key `{key}` is there twice, but it may be there once: {place(text, begin)}")
    return value


def _check_depth(text: str) -> None:
    depth = 0
    for token in TOKEN.finditer(text):
        depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(token[1], 0)
        if depth > DEEPEST:
            raise ValueError(f"lists and objects are more than {DEEPEST} deep: {place(text, token.start(1))}")


def _real(text: str) -> float | str:
    value = float(text)
    return value if math.isfinite(value) else text


def _integer(text: str) -> int | str:
    return int(text) if math.isfinite(float(text)) else text


def place(text: str, begin: int) -> str:
    """Line and column of a character, from 1."""
    return f"line {text.count(chr(10), 0, begin) + 1} column {begin - text.rfind(chr(10), 0, begin)}"


def _places(text: str, twice: bool = False) -> Iterator[tuple[str, int]]:
    """Each key path of a JSON text, as the units write it, and where it begins; or those that are there `twice`."""
    tokens = [(match[1], match.start(1)) for match in TOKEN.finditer(text)]
    seen: set[str] = set()
    # The open lists and objects: path, and the number of the next part of a list; None of an object.
    above: list[tuple[str, int | None]] = []
    path, last = "", len(tokens) - 1
    for i, (token, begin) in enumerate(tokens):
        part = None
        if token in "]}":
            above.pop()
        elif above and above[-1][1] is None:
            if i < last and tokens[i + 1][0] == ":":
                part = f"{above[-1][0]}.{json.loads(token)}".lstrip(".")
        elif above and token not in ",:":
            outer, number = above[-1]
            part, above[-1] = f"{outer}[{number}]", (outer, (number or 0) + 1)
        if part is not None:
            path = part
            if (part in seen) == twice:
                yield part, begin
            seen.add(part)
        if token in "[{":
            above.append((path, 0 if token == "[" else None))


@dataclass(frozen=True)
class Source:
    """A scene file, to say where in it a key is."""

    path: Path
    text: str

    def document(self) -> dict[str, Any]:
        """The scene of the file; raises `SceneError` if it is not a JSON object."""
        try:
            scene = parse(self.text)
        except json.JSONDecodeError as error:
            raise SceneError(f"the scene file {self.path} is not JSON: {error}") from error
        except ValueError as error:
            raise SceneError(f"the scene file {self.path} cannot be used: {error}") from error
        if not isinstance(scene, dict):
            raise SceneError(f"the scene file {self.path} holds {_kind(scene)}, but it must be an object")
        return scene

    def place_of(self, key: str, changed: Iterable[str] = ()) -> str | None:
        """File, line and column of `key`, or of the part that it is missing from; None where it does not come from the
        file, because it, a part of it or what it belongs to was `changed`."""
        for other in changed:
            path = INDEX.sub(r"[\1]", other)
            if path == key or path.startswith((f"{key}.", f"{key}[")) or key.startswith((f"{path}.", f"{path}[")):
                return None
        places = dict(_places(self.text))
        while key not in places and "." in key:
            key = key.rpartition(".")[0]
        return f"{self.path}, {place(self.text, places[key])}" if key in places else str(self.path)


def _kind(value: Any) -> str:
    names = {list: "a list", str: "a text", bool: "true or false", type(None): "null"}
    return names.get(type(value), "a number")
