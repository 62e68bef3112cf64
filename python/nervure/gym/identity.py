"""What a function computes with: a digest that another function, or the same one with other values, does not have.

A function is its code, defaults, closure and the globals that it names, and so on through all that it refers to; a
class is its methods and values, an object its class and what `pickle` would keep. What belongs to Python or to an
installed package, as nervure, is its name, the version of the package and the text of its file.
"""

import copyreg
import dis
import hashlib
import importlib
import pickle
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

PLAIN = (type(None), type(...), bool, int, float, complex, str, bytes)
IMMUTABLE = (*PLAIN, tuple, frozenset, CodeType)
"""Types whose values may be one object or several that are equal, by chance."""
INSTALLED = ("stdlib", "platstdlib", "purelib", "platlib")
UNUSED = ("__doc__", "__module__", "__dict__", "__weakref__", "_abc_impl")
"""Attributes of a class on which no method depends."""


class UnknownError(Exception):
    """An object that cannot be told from another one."""


def digest(value: object) -> str:
    """Return a digest of a function or any other object; raise `UnknownError` where a part of it has none."""
    found = hashlib.blake2b(digest_size=16)
    try:
        for part in _Walk().of(value):
            found.update(f"{len(part)} ".encode() + part)
    except RecursionError:
        raise UnknownError("what is nested too deeply") from None
    return found.hexdigest()


class _Walk:
    """Goes through all that an object refers to, once."""

    def __init__(self) -> None:
        self.seen: dict[int, int] = {}  # Number of an object by its id
        self.kept: list[object] = []  # So that no id is used twice

    def of(self, value: Any) -> Iterator[bytes]:
        """Yield what tells an object from others."""
        kind = type(value)
        yield f"{kind.__module__}.{kind.__qualname__}".encode()
        if kind in PLAIN:
            yield repr(value).encode()
            return
        if kind not in IMMUTABLE:
            if (number := self.seen.get(id(value))) is not None:
                yield b"again %d" % number
                return
            self.seen[id(value)] = len(self.kept)
            self.kept.append(value)
        if kind in (tuple, list):
            yield from self.all_of(value)
        elif kind is dict:
            yield from self.all_of(part for item in value.items() for part in item)
        elif kind in (set, frozenset):
            yield from sorted(digest(part).encode() for part in value)
        elif kind is np.ndarray and not value.dtype.hasobject:
            yield f"{value.dtype!r} {value.shape}".encode()
            yield value.tobytes()
        elif kind is CodeType:
            yield from self.of_code(value)
        elif kind is FunctionType:
            yield from self.of_function(value)
        elif kind is MethodType:
            yield from self.all_of((value.__func__, value.__self__))
        elif kind is BuiltinFunctionType:
            own = value.__self__
            yield f"{value.__module__} {value.__qualname__}".encode()
            yield from () if own is None or isinstance(own, ModuleType) else self.of(own)
        elif kind is ModuleType:
            yield from self.of_module(value, ())
        elif isinstance(value, type):
            yield from self.of_class(value)
        elif kind in (staticmethod, classmethod):
            yield from self.of(value.__func__)
        elif kind is property:
            yield from self.all_of((value.fget, value.fset, value.fdel))
        else:
            yield from self.of_object(value)

    def all_of(self, parts: Iterable[Any]) -> Iterator[bytes]:
        for part in parts:
            yield from self.of(part)
        yield b"end"

    def of_code(self, code: CodeType) -> Iterator[bytes]:
        """Yield the code without its place in a file."""
        yield code.co_code
        names = code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars
        counts = code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags
        yield from self.all_of((*names, *counts, code.co_exceptiontable, code.co_consts))

    def of_function(self, function: FunctionType) -> Iterator[bytes]:
        code = function.__code__
        if is_installed(code.co_filename):
            yield from _name(function.__module__, function.__qualname__, code.co_filename)
        else:
            yield from self.of(code)
        yield from self.all_of((function.__defaults__, function.__kwdefaults__))
        for cell in function.__closure__ or ():
            try:
                content = cell.cell_contents
            except ValueError:  # Not yet set
                continue
            yield from self.of(content)
        if is_installed(code.co_filename):
            return
        yield from self.all_of(vars(function).items())
        names = {*_names_in(code)}
        for name, is_import in dict.fromkeys(_globals_in(code)):
            yield name.encode()
            if is_import:
                found = _imported(name)
            elif name in function.__globals__:
                found = function.__globals__[name]
            else:
                continue  # Of Python, or missing
            yield from self.of_module(found, sorted(names)) if isinstance(found, ModuleType) else self.of(found)

    def of_module(self, module: ModuleType, names: Iterable[str]) -> Iterator[bytes]:
        """Yield what tells a module from others, and the attributes `names` of one that is not installed."""
        file = getattr(module, "__file__", None)
        yield from _name(module.__name__, "", file)
        if _is_owned(module.__name__, file):
            return
        for name in names:
            if name in vars(module):
                found = vars(module)[name]
                yield name.encode()
                is_module = isinstance(found, ModuleType)
                yield from self.of_module(found, names if found is not module else ()) if is_module else self.of(found)

    def of_class(self, own: type) -> Iterator[bytes]:
        file = getattr(sys.modules.get(own.__module__), "__file__", None)
        yield from _name(own.__module__, own.__qualname__, file)
        if _is_owned(own.__module__, file):
            return
        yield from self.all_of(own.__bases__)
        for name, part in vars(own).items():
            is_method = isinstance(part, FunctionType | staticmethod | classmethod | property)
            is_place = type(part).__name__ in ("member_descriptor", "getset_descriptor")
            if name in UNUSED or is_place or (name.startswith("__") and not is_method):
                continue
            yield name.encode()
            yield from self.of(part)

    def of_object(self, value: object) -> Iterator[bytes]:
        """Yield what `pickle` would keep of an object, and its class."""
        reduce = copyreg.dispatch_table.get(type(value))
        try:
            kept = reduce(value) if reduce else value.__reduce_ex__(4)
            wrapped = getattr(value, "__wrapped__", None)
            if isinstance(kept, str) and wrapped is None:
                pickle.dumps(value)  # Fails where another object has the name
        except Exception as error:  # Whatever a class raises
            raise UnknownError(f"a {type(value).__name__}, which cannot be pickled") from error
        yield from self.of(type(value))
        if isinstance(kept, str):
            yield kept.encode()
            yield from self.of(wrapped)
            return
        make, arguments, state, several, items = (*kept, None, None, None, None)[:5]
        yield from self.all_of((make, arguments, state))
        yield from self.all_of(several or ())
        yield from self.all_of(part for item in items or () for part in item)


def _globals_in(code: CodeType) -> Iterator[tuple[str, bool]]:
    """Yield the names of globals that a code takes, and of modules that it imports, each with whether it is one."""
    for step in dis.get_instructions(code):
        if step.opname in ("LOAD_GLOBAL", "LOAD_NAME", "IMPORT_NAME"):
            yield str(step.argval), step.opname == "IMPORT_NAME"
    for part in code.co_consts:
        if isinstance(part, CodeType):
            yield from _globals_in(part)


def _names_in(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for part in code.co_consts:
        if isinstance(part, CodeType):
            yield from _names_in(part)


def _imported(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except Exception as error:  # Whatever a module raises
        raise UnknownError(f"an import of {name}, which fails") from error


def is_installed(file: str) -> bool:
    """Return whether a file belongs to Python or an installed package."""
    return file.startswith("<frozen ") or any(Path(file).is_relative_to(folder) for folder in _folders())


def _is_owned(module: str, file: str | None) -> bool:
    return module in sys.builtin_module_names if file is None else is_installed(file)


@cache
def _folders() -> tuple[str, ...]:
    return (str(Path(__file__).parents[1]), *(sysconfig.get_paths()[name] for name in INSTALLED))


def _name(module: str | None, name: str, file: str | None) -> Iterator[bytes]:
    """Yield the name of a part of a module, and of an installed one its version and the digest of its file."""
    yield f"{module} {name}".encode()
    if file is not None and is_installed(file):
        top = sys.modules.get((module or "").partition(".")[0])
        yield str(getattr(top, "__version__", sys.version)).encode()
        yield _file_digest(file)


@cache
def _file_digest(file: str) -> bytes:
    try:
        return hashlib.blake2b(Path(file).read_bytes(), digest_size=16).digest()
    except OSError:  # Frozen into Python
        return b""
