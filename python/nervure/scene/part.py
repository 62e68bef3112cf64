"""What the classes of a scene are made of."""

import operator
from numbers import Real as Number
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, PlainValidator, Strict


def _real(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, Number):
        raise ValueError("must be a number")
    return value if isinstance(value, int | float) else float(value)


def _integer(value: Any) -> int:
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise ValueError("must be a whole number")
    return operator.index(value)


Real = Annotated[float, PlainValidator(_real)]
"""A number as it was given: 8 does not become 8.0, so that a scene is written as it was read."""

Integer = Annotated[int, PlainValidator(_integer)]
Flag = Annotated[bool, Strict()]


class Part(BaseModel):
    """A part of a scene. Types are checked here, also when an attribute is set; values are for the units to check."""

    model_config = ConfigDict(extra="forbid", validate_assignment=True, validate_by_name=True, defer_build=True)

    def document(self) -> dict[str, Any]:
        """What was given, as JSON has it, without defaults: a file stays as short as its author wrote it."""
        return {
            field.alias or name: _plain(getattr(self, name))
            for name, field in type(self).model_fields.items()
            if name in self.model_fields_set or getattr(self, name) != field.get_default(call_default_factory=True)
        }


def _plain(value: Any) -> Any:
    if isinstance(value, Part):
        return value.document()
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    return [_plain(part) for part in value] if isinstance(value, list | tuple) else value
