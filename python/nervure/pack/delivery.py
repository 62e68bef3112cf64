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

OLDEST_GLIBC = (2, 17)
"""The version that the libraries must run on: that of 2012."""


def glibc(library: Path) -> tuple[int, int]:
    """The oldest glibc that has every symbol which a library asks for."""
    versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", library.read_bytes())
    return max(((int(major), int(minor)) for major, minor in versions), default=(0, 0))


def revision() -> str | None:
    """The source's commit, with `-dirty` after it where files differ from it; None outside of git."""
    found = git_revision()
    return found.revision + ("-dirty" if found.dirty else "") if found else None


def describe(path: Path) -> dict[str, int | str]:
    """Size (bytes) and checksum of a file."""
    return {"size": path.stat().st_size, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}


def write(scene: Scene, folder: Path) -> None:
    """Make a folder to hand out, in the place of one that exists."""
    kinds, source = package.kinds(scene), revision()
    needed = {kind: glibc(package.library(kind)) for kind in kinds}
    for kind, version in needed.items():
        if sys.platform == "linux" and version > OLDEST_GLIBC:
            raise SceneError(
                f"the library of the {kind} needs glibc {'.'.join(map(str, version))}, but "
                f"{'.'.join(map(str, OLDEST_GLIBC))} is to suffice; `make dist` builds it so"
            )
    unfinished = folder.with_name(folder.name + ".unfinished")
    shutil.rmtree(unfinished, ignore_errors=True)
    files = [package.pack(kind, scene, unfinished) for kind in kinds]
    if len(kinds) > 1:
        files.append(ssp.pack(scene, unfinished))
    manifest = {
        "source_revision": source,
        "scene": scene.name,
        "platform": fmpy.platform,
        "glibc": ".".join(map(str, max(needed.values()))),
        "files": {path.name: describe(path) for path in files},
    }
    (unfinished / "manifest.json").write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
    listed = [*files, unfinished / "manifest.json"]
    sums = "".join(f"{describe(path)['sha256']}  {path.name}\n" for path in listed)
    (unfinished / "SHA256SUMS").write_text(sums, encoding="utf-8")
    shutil.rmtree(folder, ignore_errors=True)
    unfinished.rename(folder)
