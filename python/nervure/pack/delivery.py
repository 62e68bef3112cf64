"""The units of a scene in a folder that a master's user can take without Rust: FMUs, SSP, SHA256SUMS, manifest.json."""

import hashlib
import json
import re
import shutil
import sys
from pathlib import Path

import fmpy

from nervure.errors import SceneError
from nervure.pack import package, ssp
from nervure.provenance import git_revision
from nervure.scene import Scene

OLDEST_GLIBC = (2, 17)  # The version that the libraries must run on: that of 2012


def glibc(library: Path) -> tuple[int, int]:
    """The oldest glibc that has every symbol which a library asks for."""
    versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", library.read_bytes())
    return max(((int(major), int(minor)) for major, minor in versions), default=(0, 0))


def checksum(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def write(scene: Scene, folder: Path) -> None:
    """Make a folder to hand out, in the place of one that exists."""
    kinds, git = package.kinds(scene), git_revision()
    needed = {kind: glibc(package.library(kind)) for kind in kinds}
    for kind, version in needed.items():
        if sys.platform == "linux" and version > OLDEST_GLIBC:
            newer, oldest = (".".join(map(str, each)) for each in (version, OLDEST_GLIBC))
            raise SceneError(
                f"the library of the {kind} needs glibc {newer}, but {oldest} is to suffice; `make dist` builds it so"
            )
    unfinished = folder.with_name(folder.name + ".unfinished")
    shutil.rmtree(unfinished, ignore_errors=True)
    files = [package.pack(kind, scene, unfinished) for kind in kinds]
    if len(kinds) > 1:
        files.append(ssp.pack(scene, unfinished))
    manifest = {
        "source_revision": git.revision + ("-dirty" if git.dirty else "") if git else None,
        "scene": scene.name,
        "platform": fmpy.platform,
        "glibc": ".".join(map(str, max(needed.values()))),
        "files": {path.name: {"size": path.stat().st_size, "sha256": checksum(path)} for path in files},
    }
    (unfinished / "manifest.json").write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
    sums = "".join(f"{checksum(path)}  {path.name}\n" for path in [*files, unfinished / "manifest.json"])
    (unfinished / "SHA256SUMS").write_text(sums, encoding="utf-8")
    shutil.rmtree(folder, ignore_errors=True)
    unfinished.rename(folder)
