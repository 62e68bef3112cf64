"""What the classes of a scene are made of."""

import copy
import operator
from collections.abc import Iterable, Mapping
from numbers import Real as Number
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, PlainValidator, Strict, ValidationError

from nervure.errors import SceneError
from nervure.scene.keys import assign


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

    def copy(self, changes: Mapping[str, Any] | None = None, /, **more: Any) -> Self:
        """Return a copy in which the values at dotted keys are changed; in a keyword two underscores stand for a dot.

        >>> import nervure
        >>> scene = nervure.load("csm3").copy({"beam.segments": 12}, time__end=0.5)
        >>> scene.beam.segments, scene.time.end
        (12, 0.5)
        """
        changed = copy.deepcopy(self.document())
        for key, value in {
            **(changes or {}),
            **{name.replace("__", "."): value for name, value in more.items()},
        }.items():
            assign(changed, key, _plain(value))
        try:
            return type(self).model_validate(changed)
        except ValidationError as error:
            raise SceneError(f"a changed value does not have the type of its key: {error}") from error

    def __repr_args__(self) -> Iterable[tuple[str | None, Any]]:
        """Return what was given: a scene in a notebook shows no defaults."""
        return ((name, getattr(self, name)) for name in type(self).model_fields if name in self.model_fields_set)

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
