"""Makes the FMUs of a scene from the built libraries.

A library knows how to describe itself for a scene: `fmu_model_description` reads `scene.json` in a resources folder
and writes modelDescription.xml, or the reason why the scene cannot be run.
"""

import ctypes
import json
import os
import sys
import tempfile
import zipfile
from pathlib import Path

import fmpy

from nervure.pack import documentation
from nervure.files import write_whole
from nervure.resources import ROOT, SOURCE
from nervure.scene import SceneError

KINDS = ("rod", "fluid")
"""The units a scene can have; unit KIND is the library and the model identifier `fmu_KIND`."""

ARCHIVE_DATE = (1980, 1, 1, 0, 0, 0)
"""Date of every file in an FMU, so that the same scene and library give the same bytes."""


def library(kind: str) -> Path:
    """Path of the library of unit `kind`: that of the wheel, or as cargo built it in the source tree."""
    prefix = "" if sys.platform == "win32" else "lib"
    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    path = (built if SOURCE else ROOT / "binaries") / f"{prefix}fmu_{kind}{fmpy.sharedLibraryExtension}"
    if not path.is_file():
        raise SceneError(f"the library {path} is not built; `make build` or `nervure build SCENE.json` builds it")
    return path


def kinds(scene: dict) -> list[str]:
    """The units that `scene` has, in the order in which they step; a scene without any is for the fluid to refuse."""
    return [kind for kind in KINDS if scene.get(kind) is not None] or ["fluid"]


def describe(kind: str, scene: dict) -> str:
    """modelDescription.xml of unit `kind` for `scene`; raises `SceneError` with the unit's words if it refuses it."""
    function = ctypes.CDLL(str(library(kind)))["fmu_model_description"]
    function.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t, ctypes.POINTER(ctypes.c_size_t)]
    function.restype = ctypes.c_int
    needed = ctypes.c_size_t(1 << 16)
    with tempfile.TemporaryDirectory() as resources:
        Path(resources, "scene.json").write_text(scene_text(scene), encoding="utf-8")
        capacity = 0
        while capacity < needed.value:
            capacity = needed.value
            buffer = ctypes.create_string_buffer(capacity)
            refused = function(os.fsencode(resources), buffer, capacity, ctypes.byref(needed))
    text = buffer.value.decode("utf-8")
    if refused:
        raise SceneError(text)
    return text


def pack(kind: str, scene: dict, folder: Path) -> Path:
    """Write the FMU `NAME-KIND.fmu` of unit `kind` into `folder` and return its path; raises `SceneError` if the
    unit refuses the scene."""
    description = describe(kind, scene)
    binary = f"binaries/{fmpy.platform}/fmu_{kind}{fmpy.sharedLibraryExtension}"
    picture = (ROOT / f"fmu-{kind}" / "model.png").read_bytes()
    contents = {
        "modelDescription.xml": description.encode("utf-8"),
        binary: library(kind).read_bytes(),
        "resources/scene.json": scene_text(scene).encode("utf-8"),
        "model.png": picture,
        "documentation/index.html": documentation.page(kind, description).encode("utf-8"),
        "terminalsAndIcons/terminalsAndIcons.xml": documentation.terminals(description).encode("utf-8"),
        "terminalsAndIcons/icon.png": picture,
    }
    for licence in sorted(ROOT.glob("LICENSE*")):
        contents[f"documentation/licenses/{licence.name}"] = licence.read_bytes()

    return write_archive(folder / f"{scene['name']}-{kind}.fmu", contents)


def merge(sources: list[Path], target: Path) -> Path:
    """Write an FMU with the binaries of all `sources` to `target` and return its path; raises `SceneError` where they
    differ in anything else, or in a binary of the same system."""
    if len(sources) < 2:
        raise SceneError(f"to merge takes at least two FMUs, but there is {len(sources)}")
    contents: dict[str, bytes] = {}
    for path in sources:
        try:
            with zipfile.ZipFile(path) as archive:
                files = {name: archive.read(name) for name in archive.namelist()}
        except (OSError, zipfile.BadZipFile) as error:
            raise SceneError(f"{path} cannot be read as an FMU: {error}") from error
        others = {name for name in contents.keys() ^ files.keys() if not name.startswith("binaries/")}
        differing = sorted(
            (others if contents else set())
            | {name for name in contents.keys() & files.keys() if contents[name] != files[name]}
        )
        if differing:
            raise SceneError(f"{path} differs from {sources[0]} in {', '.join(differing)}: only other binaries are allowed")
        contents |= files
    return write_archive(target, contents)


def write_archive(path: Path, contents: dict[str, bytes]) -> Path:
    """Write a zip file of `contents` by name and return its path; the same contents give the same bytes."""
    path.parent.mkdir(parents=True, exist_ok=True)

    def writer(unfinished: Path) -> None:
        with zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            for name, data in contents.items():
                entry = zipfile.ZipInfo(name, ARCHIVE_DATE)
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
                archive.writestr(entry, data)

    write_whole(path, writer)
    return path


def scene_text(scene: dict) -> str:
    """`scene` as the text of a scene file."""
    return json.dumps(scene, indent=2, ensure_ascii=False) + "\n"
