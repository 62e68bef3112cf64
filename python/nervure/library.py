"""The libraries of the units: where they are, and what they say of a scene.

A library knows how to describe itself for a scene: `fmu_model_description` reads `scene.json` in a resources folder
and writes modelDescription.xml, or the reason why the scene cannot be run.
"""

import ctypes
import os
import tempfile
from functools import lru_cache
from pathlib import Path

from nervure.errors import SceneError
from nervure.resources import BINARIES, KINDS, PLATFORM, PREFIX, ROOT, SOURCE, SUFFIX

__all__ = ["KINDS", "SUFFIX", "check", "describe", "is_built", "kind_of", "library"]


def kind_of(unit: str) -> str:
    """The kind of a unit of a scene: every one but the fluid is a rod."""
    return "fluid" if unit == "fluid" else "rod"


def library(kind: str) -> Path:
    """Path of the library of unit `kind`: in the folder that the variable `NERVURE_LIBRARIES` names, or that of the
    wheel, or as cargo built it in the source tree."""
    path = _path(kind)
    if path.is_file():
        return path
    if path.is_relative_to(BINARIES):
        there = ", ".join(sorted(folder.name for folder in BINARIES.iterdir() if folder.is_dir()))
        raise SceneError(
            f"this system is {PLATFORM}, but nervure was installed with units for {there}; `pip install .` in the "
            "folder of the project compiles them for this one"
        )
    raise SceneError(f"the library {path} is not built; `make build` or `nervure build SCENE.json` builds it")


def _path(kind: str) -> Path:
    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    folder = Path(os.environ.get("NERVURE_LIBRARIES") or (built if SOURCE else BINARIES / PLATFORM))
    return folder / f"{PREFIX}fmu_{kind}{SUFFIX}"


def is_built(kind: str) -> bool:
    """Whether there is a library of unit `kind`."""
    return _path(kind).is_file()


def check(text: str) -> None:
    """Raise `SceneError` with the units' words where they refuse a key or a value of a scene. Either library reads all
    of it, also where the scene has no such unit; the rod's makes least besides."""
    try:
        describe("rod", text)
    except SceneError as error:
        if error.key:
            raise


def describe(kind: str, text: str, version: int = 2) -> str:
    """modelDescription.xml of unit `kind` in that version of FMI, 2 or 3, for the text of a scene, or `SceneError` with
    the unit's words."""
    return _described(library(kind), text, version)


@lru_cache(maxsize=4)  # A fluid takes a tenth of a second, and a run wants it twice: to check the scene and to pack it
def _described(path: Path, text: str, version: int) -> str:
    name = {2: "fmu_model_description", 3: "fmu_model_description_3"}[version]
    function = ctypes.CDLL(str(path))[name]
    function.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t, ctypes.POINTER(ctypes.c_size_t)]
    needed, buffer = ctypes.c_size_t(1 << 20), ctypes.create_string_buffer(1)
    with tempfile.TemporaryDirectory() as resources:
        Path(resources, "scene.json").write_bytes(text.encode("utf-8"))  # the GUID is of the bytes
        while len(buffer) < needed.value:
            buffer = ctypes.create_string_buffer(needed.value)
            refused = function(os.fsencode(resources), buffer, len(buffer), ctypes.byref(needed))
    said = buffer.value.decode("utf-8")
    if refused:
        raise SceneError(said)
    return said
