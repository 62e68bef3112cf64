"""FMUs of described units, from the built libraries."""

import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path

import fmpy

from nervure.errors import SceneError
from nervure.files import write_whole
from nervure.library import library
from nervure.resources import ROOT, SUFFIX
from nervure.units import documentation
from nervure.units.describe import Description

COMPRESSION = zipfile.ZIP_DEFLATED
ARCHIVE_DATE = (1980, 1, 1, 0, 0, 0)  # Of every file: the same scene and library give the same bytes

PLATFORM = {2: fmpy.platform, 3: fmpy.platform_tuple}
"""Name of this system by the version of FMI."""


def pack(
    unit: Description, folder: Path, binaries: Mapping[str, Path] | None = None, notices: str | None = None
) -> Path:
    """Write the FMU `SCENE-UNIT.fmu` into `folder` and return its path.

    `binaries` are the libraries by platform, named as in the unit's version of FMI; by default the library of this
    system alone. `notices` are the licences of the crates that are linked into them.
    """
    libraries = binaries or {PLATFORM[unit.version]: library(unit.kind)}
    picture = (ROOT / f"fmu-{unit.kind}" / "model.png").read_bytes()
    contents = {
        "modelDescription.xml": unit.xml.encode("utf-8"),
        **{f"binaries/{name}/fmu_{unit.kind}{path.suffix}": path.read_bytes() for name, path in libraries.items()},
        "resources/scene.json": unit.scene.encode("utf-8"),
        **({"model.png": picture} if unit.version == 2 else {}),
        "documentation/index.html": documentation.page(unit.kind, unit.xml).encode("utf-8"),
        "terminalsAndIcons/terminalsAndIcons.xml": documentation.terminals(unit.xml).encode("utf-8"),
        "terminalsAndIcons/icon.png": picture,
    }
    for licence in sorted(ROOT.glob("LICENSE*")):
        contents[f"documentation/licenses/{licence.name}"] = licence.read_bytes()
    if notices is not None:
        contents["documentation/licenses/third-party.txt"] = notices.encode("utf-8")
    return write_archive(folder / f"{unit.scene_name}-{unit.unit}.fmu", contents)


def lay_out(unit: Description, folder: Path) -> Path:
    """Lay out what a unit needs to run here, with a link to its library, in a new folder below `folder`; return the
    path. It takes a hundredth of the time of packing and unpacking an FMU."""
    place, built = folder / unit.unit, library(unit.kind)
    linked = place / "binaries" / PLATFORM[unit.version] / f"fmu_{unit.kind}{SUFFIX}"
    linked.parent.mkdir(parents=True)
    (place / "resources").mkdir()
    (place / "modelDescription.xml").write_text(unit.xml, encoding="utf-8")
    (place / "resources" / "scene.json").write_text(unit.scene, encoding="utf-8")
    try:
        linked.symlink_to(built.resolve())
    except OSError:  # Windows allows links to some users only
        shutil.copy(built, linked)
    return place


def merge(sources: list[Path], target: Path) -> Path:
    """Write an FMU with the binaries of all `sources` to `target` and return its path. Raise `SceneError` where the
    sources differ in another file, or in a binary of the same system."""
    if len(sources) < 2:
        raise SceneError(f"`merge` needs at least two FMUs, but {len(sources)} is given")
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
                archive.writestr(entry, data, compresslevel=1)  # An entry does not inherit the level

    write_whole(path, writer)
    return path
