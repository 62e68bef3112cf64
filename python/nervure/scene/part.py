"""What the classes of a scene are made of."""

import copy
import operator
import re
from collections.abc import Iterable, Mapping
from numbers import Real as Number
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, GetPydanticSchema, PrivateAttr, Strict, ValidationError
from pydantic_core.core_schema import no_info_plain_validator_function

from nervure.arguments import shown
from nervure.catalogue import hint, keys
from nervure.errors import SceneError
from nervure.scene.files import Files
from nervure.scene.keys import plain

LONGEST_SHOWN = 60  # Characters of a value in a message


def _real(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, Number):
        raise ValueError("must be a number")
    return value if isinstance(value, int | float) else float(value)


def _integer(value: Any) -> int:
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise ValueError("must be a whole number")
    return operator.index(value)


# `PlainValidator` would inspect the function once for each of some 200 fields.
Real = Annotated[float, GetPydanticSchema(lambda *_: no_info_plain_validator_function(_real))]
"""A number as it was given: 8 does not become 8.0, so that a scene is written as it was read."""

Integer = Annotated[int, GetPydanticSchema(lambda *_: no_info_plain_validator_function(_integer))]
Flag = Annotated[bool, Strict()]


def _listed(value: Any) -> Any:
    """Return an array as a list; any other value as it is."""
    return value.tolist() if hasattr(value, "tolist") else value


class TypeFault(SceneError, ValueError):
    """A value that does not have the type of its key."""


def refusal(error: ValidationError) -> TypeFault:
    """Return the innermost reason why a part does not have its types as a sentence with key and value."""
    faults = [one | {"loc": one["loc"] or ("",)} for one in error.errors(include_url=False)]
    depth = max(len(one["loc"]) for one in faults)
    deepest = [one for one in faults if len(one["loc"]) == depth]
    # Of a value that has one of several keys, a key is unknown where no choice knows it.
    choices = {one["loc"][:-1] for one in deepest}
    extra = [one["loc"][-1] for one in deepest if one["type"] == "extra_forbidden"]
    found = next((one for one in deepest if extra.count(one["loc"][-1]) == len(choices)), None)
    of_several = found is None and len(choices) > 1
    found = found or deepest[0]
    # Between the keys stand the names of the types that a value may have.
    path = [part for part in found["loc"] if isinstance(part, int) or re.fullmatch("[a-z_0-9]+", part)]
    key, shown = ".".join(map(str, path)), repr(found["input"])
    if of_several and found["type"] in ("extra_forbidden", "missing"):
        has = f"has {', '.join(map(str, dict.fromkeys(extra)))}" if extra else "is empty"
        whole, names = ".".join(map(str, path[:-1])), dict.fromkeys(str(one["loc"][-1]) for one in deepest)
        return TypeFault(f"`{whole}` {has}, but must have exactly one of the keys {', '.join(names)}")
    if found["type"] == "extra_forbidden":
        path = [*path[: -1 if path[-1:] == [found["loc"][-1]] else None], found["loc"][-1]]
        key = ".".join(map(str, path))
        near = hint(str(path[-1]), keys(".".join(map(str, path[:-1])))) if error.title == "Scene" else ""
        return TypeFault(": ".join(filter(None, [f"unknown key `{key}`", near])))
    if found["type"] == "missing":
        return TypeFault(f"the key `{key}` is missing")
    reason = found["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    reason = re.sub(r"a valid dictionary or instance of \w+", "an object", reason)
    short = shown if len(shown) <= LONGEST_SHOWN else f"{shown[:LONGEST_SHOWN]}…"
    return TypeFault(f"{f'`{key}`' if key else 'it'} is {short}, but {reason}")


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as _Checked
else:

    class _Checked(type(BaseModel)):
        """Makes parts, and refuses what does not fit in a sentence."""

        def __call__(cls, *arguments, **fields):
            try:
                return super().__call__(*arguments, **{name: _listed(value) for name, value in fields.items()})
            except ValidationError as error:
                raise refusal(error) from None


class Part(BaseModel, metaclass=_Checked):
    """A part of a scene. Types are checked here, also when an attribute is set; values are for the units to check."""

    model_config = ConfigDict(extra="forbid", validate_assignment=True, validate_by_name=True, defer_build=True)

    _files: Files = PrivateAttr(default_factory=Files)

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and name not in type(self).model_fields:
            raise TypeFault(f"unknown key `{name}`: {hint(name, type(self).model_fields)}")
        try:
            super().__setattr__(name, _listed(value))
        except ValidationError as error:
            raise refusal(error) from None

    def copy(self, changes: Mapping[str, Any] | None = None, /, **more: Any) -> Self:
        """Return a copy in which the values at dotted keys are changed; in a keyword two underscores stand for a dot.

        >>> import nervure
        >>> scene = nervure.load("csm3").copy({"beam.segments": 12}, time__end=0.5)
        >>> scene.beam.segments, scene.time.end
        (12, 0.5)
        """
        if not (changes is None or isinstance(changes, Mapping)):
            raise SceneError(f"the changes are {shown(changes)}, but must be a dictionary of values by dotted key")
        changed = copy.deepcopy(self.document())
        by_name = {name.replace("__", "."): value for name, value in more.items()}
        files = self._files.change(changed, {**(changes or {}), **by_name})
        try:
            made = type(self).model_validate(changed)
        except ValidationError as error:
            raise refusal(error) from None
        made._files = files
        return made

    def __repr_args__(self) -> Iterable[tuple[str | None, Any]]:
        """Return what was given: a scene in a notebook shows no defaults."""
        return ((name, getattr(self, name)) for name in type(self).model_fields if name in self.model_fields_set)

    def document(self) -> dict[str, Any]:
        """Return what was given, as JSON has it, without defaults: a file stays as short as its author wrote it."""
        return {
            field.alias or name: plain(getattr(self, name))
            for name, field in type(self).model_fields.items()
            if name in self.model_fields_set or getattr(self, name) != field.get_default(call_default_factory=True)
        }
