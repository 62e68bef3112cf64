"""Write the classes of a scene, `nervure/scene/types.py`, from its JSON Schema, which the Rust types give.

    python modelDescription/scene_types.py < modelDescription/scene.schema.json > python/nervure/scene/types.py

make and the installation of the package do so. Every title of the schema is a class, or the name of a choice between
classes and words.
"""

import json
import sys
import textwrap
from collections.abc import Iterator
from typing import Any

Schema = dict[str, Any]

HEADER = '''\
"""The parts of a scene. Made from modelDescription/scene.schema.json by make or an installation: do not edit."""

from typing import Literal

from pydantic import Field

from nervure.scene.part import Flag, Integer, Part, Real
'''

WIDTH = 120
SCALARS = {"number": "Real", "integer": "Integer", "string": "str", "boolean": "Flag", "null": "None"}


def docstring(text: str, indent: str = "") -> str:
    """`text` as a docstring."""
    whole = textwrap.wrap(f'"""{text}"""', WIDTH - len(indent), break_long_words=False)
    return "".join(f"{indent}{line}\n" for line in whole)


class Writer:
    """Writes each class after those that it refers to."""

    def __init__(self, schema: Schema):
        self.definitions: Schema = schema["$defs"]
        self.written: dict[str, str] = {}
        self.unfinished: set[str] = set()

    def annotation(self, schema: Schema) -> str:
        """Type of the values that `schema` allows; what it refers to is written."""
        if "$ref" in schema:
            return self.define(self.definitions[schema["$ref"].rpartition("/")[2]])
        if "anyOf" in schema:
            return " | ".join(self.annotation(part) for part in schema["anyOf"])
        if "title" in schema:
            return self.define(schema)
        if isinstance(schema["type"], list):
            return " | ".join(self.annotation(schema | {"type": name}) for name in schema["type"])
        if schema["type"] == "object":
            return f"dict[str, {self.annotation(schema['additionalProperties'])}]"
        if schema["type"] == "array":
            item, size = self.annotation(schema["items"]), schema.get("maxItems")
            least = schema.get("minItems", 0)
            if size is not None and size - least <= 1:
                return " | ".join(f"tuple[{', '.join([item] * n)}]" for n in range(least, size + 1))
            return f"list[{item}]"
        return SCALARS[schema["type"]]

    def define(self, schema: Schema) -> str:
        """Write the class or choice that `schema` describes, and return its name; in quotes within its own parts."""
        name: str = schema["title"]
        if name in self.unfinished:
            return f'"{name}"'
        if name not in self.written:
            self.unfinished.add(name)
            self.written[name] = self.choice(schema) if "oneOf" in schema else self.part(schema)
            self.unfinished.remove(name)
        return name

    def choice(self, schema: Schema) -> str:
        """Words and classes one of which a value is."""
        words = [variant for variant in schema["oneOf"] if "const" in variant]
        types = [f"Literal[{', '.join(json.dumps(word['const']) for word in words)}]"] if words else []
        types += [self.variant(variant) for variant in schema["oneOf"] if "const" not in variant]
        told = " ".join([schema["description"], *(f"`{word['const']}`: {word['description']}" for word in words)])
        line = f"{schema['title']} = {' | '.join(types)}\n"
        if len(line) > WIDTH:
            line = f"{schema['title']} = (\n    " + "\n    | ".join(types) + "\n)\n"
        return line + docstring(told)

    def variant(self, schema: Schema) -> str:
        """Write the class of an object with a tag as its only key, whose content is described where it is."""
        for content in schema["properties"].values():
            content.setdefault("description", schema["description"])
        return self.define(schema)

    def part(self, schema: Schema) -> str:
        """The class of an object."""
        return f"class {schema['title']}(Part):\n" + (
            docstring(schema["description"], "    ") + "".join(f"\n{line}" for line in self.fields(schema))
        )

    def fields(self, schema: Schema) -> Iterator[str]:
        """The fields of an object with their defaults and what they mean."""
        for key, field in schema["properties"].items():
            required, annotation = key in schema.get("required", []), self.annotation(field)
            if key == "$schema":
                assigned = f'json_schema: {annotation} = Field({field["default"]}, alias="$schema")'
            else:
                assigned = f"{key}: {annotation}" + ("" if required else f" = {self.default(field, field['default'])}")
            yield f"    {assigned}\n" + docstring(field["description"], "    ")

    def default(self, schema: Schema, value: Any) -> str:
        """The expression of a field's default."""
        if isinstance(value, dict) and value:
            return f"Field(default_factory=lambda: {self.made(schema, value)})"
        if isinstance(value, list) and value:
            return repr(tuple(value))
        return json.dumps(value) if isinstance(value, str) else repr(value)

    def made(self, schema: Schema, value: Schema) -> str:
        """The expression that makes the variant `{tag: number}` of a choice."""
        ((tag, content),) = value.items()
        variants = self.definitions[schema["$ref"].rpartition("/")[2]]["oneOf"]
        title = next(variant["title"] for variant in variants if tag in variant.get("properties", {}))
        return f"{title}({tag}={content!r})"


def generate(schema: Schema) -> str:
    """The module of the classes of `schema`."""
    writer = Writer(schema)
    writer.define(schema)
    return "\n\n".join([HEADER, *writer.written.values()])


if __name__ == "__main__":
    sys.stdout.write(generate(json.load(sys.stdin)))
