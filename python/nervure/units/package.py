"""Makes the FMUs of a scene from the built libraries."""

import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path

import fmpy

from nervure import library as libraries
from nervure.errors import SceneError
from nervure.files import write_whole
from nervure.library import SUFFIX, kind_of, library
from nervure.resources import KINDS, ROOT
from nervure.scene import Document, Scene, document, kinds, scene_of_unit
from nervure.units import documentation

__all__ = ["KINDS", "describe", "kind_of", "kinds", "library", "merge", "pack", "unpacked", "write_archive"]

COMPRESSION = zipfile.ZIP_DEFLATED
ARCHIVE_DATE = (1980, 1, 1, 0, 0, 0)  # Of every file in an FMU: the same scene and library give the same bytes


PLATFORM = {2: fmpy.platform, 3: fmpy.platform_tuple}
"""Name of this system by the version of FMI."""


def describe(kind: str, scene: Scene | Document, version: int = 2) -> str:
    """modelDescription.xml of unit `kind` for `scene` in that version of FMI, 2 or 3; raises `SceneError` with the
    unit's words if it refuses it. `kind` is `rod`, `fluid`, or the name of one of several rods."""
    return libraries.describe(kind_of(kind), scene_of_unit(scene, kind), version)


def pack(
    kind: str,
    scene: Scene | Document,
    folder: Path,
    binaries: Mapping[str, Path] | None = None,
    notices: str | None = None,
    version: int = 2,
) -> Path:
    """Write the FMU `NAME-KIND.fmu` of that version of FMI into `folder`; raises `SceneError` if the unit refuses the
    scene.

    `binaries` are the libraries by the platform's name in that version, by default that of this system alone. `notices`
    are the licences of what is linked into them.
    """
    description = describe(kind, scene, version)
    built = kind_of(kind)
    libraries = binaries or {PLATFORM[version]: library(built)}
    picture = (ROOT / f"fmu-{built}" / "model.png").read_bytes()
    contents = {
        "modelDescription.xml": description.encode("utf-8"),
        **{f"binaries/{name}/fmu_{built}{path.suffix}": path.read_bytes() for name, path in libraries.items()},
        "resources/scene.json": scene_of_unit(scene, kind).encode("utf-8"),
        **({"model.png": picture} if version == 2 else {}),
        "documentation/index.html": documentation.page(built, description).encode("utf-8"),
        "terminalsAndIcons/terminalsAndIcons.xml": documentation.terminals(description).encode("utf-8"),
        "terminalsAndIcons/icon.png": picture,
    }
    for licence in sorted(ROOT.glob("LICENSE*")):
        contents[f"documentation/licenses/{licence.name}"] = licence.read_bytes()
    if notices is not None:
        contents["documentation/licenses/third-party.txt"] = notices.encode("utf-8")
    return write_archive(folder / f"{document(scene)['name']}-{kind}.fmu", contents)


def unpacked(kind: str, scene: Scene | Document, folder: Path) -> Path:
    """Lay out what an FMU of FMI 2.0 needs to run here, unpacked and with a link to the library, in a folder of its own
    below `folder`; returns it. Costs a hundredth of packing and unpacking one."""
    description = describe(kind, scene)
    place, built = folder / kind, library(kind_of(kind))
    (place / "binaries" / PLATFORM[2]).mkdir(parents=True)
    (place / "resources").mkdir()
    (place / "modelDescription.xml").write_text(description, encoding="utf-8")
    (place / "resources" / "scene.json").write_text(scene_of_unit(scene, kind), encoding="utf-8")
    linked = place / "binaries" / PLATFORM[2] / f"fmu_{kind_of(kind)}{SUFFIX}"
    try:
        linked.symlink_to(built.resolve())
    except OSError:  # Windows allows links to some only
        shutil.copy(built, linked)
    return place


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
        both = contents.keys() & files.keys()
        differing = {name for name in both if contents[name] != files[name]}
        differing |= {name for name in contents.keys() ^ files.keys() if not name.startswith("binaries/")}
        if contents and differing:
            raise SceneError(
                f"{path} differs from {sources[0]} in {', '.join(sorted(differing))}: only other binaries are allowed"
            )
        contents |= files
    return write_archive(target, contents)


def write_archive(path: Path, contents: dict[str, bytes]) -> Path:
    """Write a zip file of `contents` by name and return its path; the same contents give the same bytes."""
    path.parent.mkdir(parents=True, exist_ok=True)

    def writer(unfinished: Path) -> None:
        with zipfile.ZipFile(unfinished, "w") as archive:
            for name, data in contents.items():
                entry = zipfile.ZipInfo(name, ARCHIVE_DATE)
                entry.compress_type = COMPRESSION
                entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
                archive.writestr(entry, data, compresslevel=1)  # said here: an entry does not take the archive's

    write_whole(path, writer)
    return path
