"""The libraries of the units: their places, and their functions beside FMI.

`fmu_scene_check` lists the faults of a scene, `fmu_scene_facts` its facts, `fmu_scene_monitor` warnings about places in
a run. `fmu_model_description` reads `scene.json` in a resources folder and writes modelDescription.xml, or the reason
why the scene cannot be run.
"""

import ctypes
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from nervure.errors import Fault, InputError, SceneError
from nervure.resources import BINARIES, KINDS, PLATFORM, PREFIX, ROOT, SOURCE, SUFFIX

__all__ = ["KINDS", "SUFFIX", "build", "check", "describe", "facts", "library", "monitor"]

BUFFER: list[Any] = [ctypes.c_char_p, ctypes.c_size_t, ctypes.POINTER(ctypes.c_size_t)]
"""Types of the arguments by which a function writes a text: buffer, capacity, and size of the text."""


def library(kind: str) -> Path:
    """Return the path of the library of unit `kind`: in the folder `NERVURE_LIBRARIES`, in the wheel, or in the source
    tree, where cargo builds it if it is missing."""
    path = _path(kind)
    if SOURCE and not path.is_file() and not os.environ.get("NERVURE_LIBRARIES"):
        print("building the libraries, once, which takes some minutes", file=sys.stderr)
        build()
    if path.is_file():
        return path
    if path.is_relative_to(BINARIES):
        there = ", ".join(sorted(folder.name for folder in BINARIES.iterdir() if folder.is_dir()))
        raise SceneError(
            f"this system is {PLATFORM}, but nervure was installed with units for {there}; `pip install .` in the "
            "folder of the project compiles them for this one"
        )
    raise SceneError(f"there is no library {path}, in the folder that NERVURE_LIBRARIES names")


def build() -> None:
    """Build the libraries of the units in the source tree; cargo shows its progress on the standard error."""
    try:
        done = subprocess.run(["cargo", "build", "--release", "--locked"], cwd=SOURCE)
    except FileNotFoundError:
        raise InputError("there is no `cargo` on the PATH: install Rust, https://rustup.rs") from None
    if done.returncode != 0:
        raise InputError("the libraries cannot be built; see the messages of cargo above")


def _path(kind: str) -> Path:
    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    folder = Path(os.environ.get("NERVURE_LIBRARIES") or (built if SOURCE else BINARIES / PLATFORM))
    return folder / f"{PREFIX}fmu_{kind}{SUFFIX}"


def check(text: str, original: str | None = None) -> list[Fault]:
    """Return the faults of the text of a scene, none for a scene that can be run.

    Places are those in `original`, the text before changes; by default those in `text`.
    """
    return [Fault(**fault) for fault in json.loads(_answer(_function("fmu_scene_check"), text, original))]


def facts(text: str) -> dict[str, Any] | None:
    """Return the facts of a scene (`Facts` in `crates/scene`); None for a scene with faults."""
    found: dict[str, Any] | None = json.loads(_answer(_function("fmu_scene_facts"), text))
    return found


def monitor(scene: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """Return a function of places of a run at one time, which returns the new `warnings` about them and the `memory`
    for the next time (`monitor_text` in `crates/scene`)."""
    function = _function("fmu_scene_monitor")
    return lambda places: json.loads(_answer(function, json.dumps(places), scene))


def _answer(function: Callable[..., int], *texts: str | None) -> str:
    """Return the answer of a function of the library."""
    encoded = [None if text is None else text.encode("utf-8", "surrogatepass") for text in texts]
    refused, answer = _written(partial(function, *encoded, *[None] * (2 - len(encoded))))
    if refused:
        raise SceneError(f"the scene cannot be checked: {answer}")
    return answer


def _function(name: str) -> Callable[..., int]:
    """Return a function of the rod's library; the fluid's has the same."""
    path = library("rod")
    try:
        function = ctypes.CDLL(str(path))[name]
    except AttributeError as error:
        remedy = "`make build` builds it again"
        raise SceneError(f"the library {path} is older than this nervure; {remedy}") from error
    function.argtypes = [ctypes.c_char_p, ctypes.c_char_p, *BUFFER]
    return function


def _written(function: Callable[..., int], room: int = 1 << 16) -> tuple[int, str]:
    """Return code and text of a C function that writes a text where there is room for it.

    Fresh memory costs a run more than its checks, so short answers get a little that was used before."""
    needed, buffer, code = ctypes.c_size_t(room), bytearray(), 0
    while len(buffer) < needed.value:
        buffer = bytearray(needed.value)
        there = (ctypes.c_char * len(buffer)).from_buffer(buffer)  # Unlike a buffer of ctypes, it is not filled first
        code = function(there, len(buffer), ctypes.byref(needed))
    return code, there.value.decode("utf-8")


def describe(kind: str, text: str, version: int = 2) -> str:
    """Return modelDescription.xml of unit `kind` in that version of FMI, 2 or 3, for the text of a scene.

    Raises `SceneError` with the faults of the scene, or with the unit's words where only the unit refuses it.
    """
    name = {2: "fmu_model_description", 3: "fmu_model_description_3"}[version]
    function = ctypes.CDLL(str(library(kind)))[name]
    function.argtypes = [ctypes.c_char_p, *BUFFER]
    with tempfile.TemporaryDirectory() as resources:
        Path(resources, "scene.json").write_bytes(text.encode("utf-8"))  # the GUID is of the bytes
        refused, answer = _written(partial(function, os.fsencode(resources)), 1 << 20)
    if refused:
        faults = check(text)
        raise SceneError("\n".join(fault.text for fault in faults) or answer, faults)
    return answer
