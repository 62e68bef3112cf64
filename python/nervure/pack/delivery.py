"""The units of a scene in a folder that a master's user can take without Rust: FMUs, SSP, SHA256SUMS, manifest.json."""

import hashlib
import json
import re
import shutil
from pathlib import Path

import fmpy

from nervure.errors import SceneError
from nervure.library import library
from nervure.pack import package, ssp
from nervure.pack.notices import notices
from nervure.provenance import git_revision
from nervure.resources import BINARIES
from nervure.scene import Scene

OLDEST_GLIBC = (2, 17)  # The version that the libraries must run on: that of 2012
TARGETS = {
    "linux64": "x86_64-unknown-linux-gnu",
    "win64": "x86_64-pc-windows-gnu",
    "darwin64": "universal2-apple-darwin",
    "aarch64-linux": "aarch64-unknown-linux-gnu",
}
"""Rust's targets by the platform's name in FMI 2.0, which has none for Linux on ARM and leaves it to others: that of
FMI 3.0. A library for macOS is for both of its processors."""
README = Path(__file__).with_name("dist.md").read_text(encoding="utf-8")


def glibc(library: Path) -> tuple[int, int]:
    """The oldest glibc that has every symbol which a library asks for."""
    versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", library.read_bytes())
    return max(((int(major), int(minor)) for major, minor in versions), default=(0, 0))


def checksum(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def binaries(kind: str) -> dict[str, Path]:
    """The libraries of unit `kind` by platform: that in use, and where `make dist` built it, or in a wheel, those of
    other targets."""
    own = library(kind)
    if own.is_relative_to(BINARIES):
        return {path.parent.name: path for path in sorted(BINARIES.glob(f"*/*fmu_{kind}.*"))}
    target, built = own.parents[1].name, own.parents[2]
    if target not in TARGETS.values():
        return {fmpy.platform: own}
    names = {"win64": f"fmu_{kind}.dll", "darwin64": f"libfmu_{kind}.dylib"}
    paths = {name: built / folder / "release" / names.get(name, own.name) for name, folder in TARGETS.items()}
    return {name: path for name, path in paths.items() if path.is_file()}


def write(scene: Scene, folder: Path) -> None:
    """Make a folder to hand out, in the place of one that exists."""
    kinds, git = package.kinds(scene), git_revision()
    libraries = {kind: binaries(kind) for kind in kinds}
    needed = {f"{kind} for {name}": glibc(path) for kind in kinds for name, path in libraries[kind].items()}
    for what, version in needed.items():
        if version > OLDEST_GLIBC:
            newer, oldest = (".".join(map(str, each)) for each in (version, OLDEST_GLIBC))
            raise SceneError(
                f"the library of the {what} needs glibc {newer}, but {oldest} is to suffice; `make dist` builds it so"
            )
    unfinished = folder.with_name(folder.name + ".unfinished")
    shutil.rmtree(unfinished, ignore_errors=True)
    fmus = {kind: package.pack(kind, scene, unfinished, libraries[kind], notices(kind)) for kind in kinds}
    files = list(fmus.values())
    if len(kinds) > 1:
        files.append(ssp.pack(scene, unfinished, fmus))
    platforms = sorted({name for found in libraries.values() for name in found})
    readme = unfinished / "README.md"
    readme.write_text(README.format(scene=scene.name, platforms=", ".join(platforms)), encoding="utf-8")
    files.append(readme)
    manifest = {
        "source_revision": git.revision + ("-dirty" if git.dirty else "") if git else None,
        "scene": scene.name,
        "platforms": platforms,
        "glibc": ".".join(map(str, max(needed.values()))),
        "files": {path.name: {"size": path.stat().st_size, "sha256": checksum(path)} for path in files},
    }
    (unfinished / "manifest.json").write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
    sums = "".join(f"{checksum(path)}  {path.name}\n" for path in [*files, unfinished / "manifest.json"])
    (unfinished / "SHA256SUMS").write_text(sums, encoding="utf-8")
    shutil.rmtree(folder, ignore_errors=True)
    unfinished.rename(folder)
