"""A folder with the units of a scene for users of other masters: FMUs, SSP, SHA256SUMS, manifest.json."""

import hashlib
import json
import re
import shutil
from pathlib import Path

from nervure.errors import SceneError
from nervure.library import library
from nervure.provenance import git_revision
from nervure.resources import BINARIES
from nervure.scene import Scene
from nervure.units import package, ssp
from nervure.units.describe import describe_all
from nervure.units.notices import notices

OLDEST_GLIBC = (2, 17)  # Of 2012; the libraries must run on it
TARGETS = {
    2: {
        "linux64": "x86_64-unknown-linux-gnu",
        "win64": "x86_64-pc-windows-gnu",
        "darwin64": "universal2-apple-darwin",
        "aarch64-linux": "aarch64-unknown-linux-gnu",
    },
    3: {
        "x86_64-linux": "x86_64-unknown-linux-gnu",
        "x86_64-windows": "x86_64-pc-windows-gnu",
        "x86_64-darwin": "universal2-apple-darwin",
        "aarch64-darwin": "universal2-apple-darwin",
        "aarch64-linux": "aarch64-unknown-linux-gnu",
    },
}
"""Rust targets by the name of the platform, for each version of FMI. FMI 2.0 has no name for Linux on ARM, so the name
of FMI 3.0 is used. A library for macOS is for both processors."""
NAMES = {"x86_64-pc-windows-gnu": "fmu_{}.dll", "universal2-apple-darwin": "libfmu_{}.dylib"}
"""Names of libraries by target; on Linux `libfmu_KIND.so`."""
SSP = {2: "| `*.ssp` | both, connected (System Structure and Parameterization 1.0) |\n", 3: ""}
NOTES = {
    2: "`linux64` needs glibc 2.17 or newer, as `aarch64-linux` does, which FMI 2.0 has no name for.\n"
    "`darwin64` is for Intel and Apple processors, and was never run.",
    3: "`x86_64-linux` and `aarch64-linux` need glibc 2.17 or newer. `x86_64-darwin` and `aarch64-darwin`\n"
    "hold the same library for both processors, which was never run.",
}
"""Notes of the README in the folder, by version of FMI."""
README = Path(__file__).with_name("dist.md").read_text(encoding="utf-8")


def glibc(library: Path) -> tuple[int, int]:
    """Return the oldest version of glibc that has all symbols of a library."""
    versions = re.findall(rb"GLIBC_(\d+)\.(\d+)", library.read_bytes())
    return max(((int(major), int(minor)) for major, minor in versions), default=(0, 0))


def checksum(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def binaries(kind: str, version: int) -> dict[str, Path]:
    """Return the libraries of unit `kind` by platform: the library in use, and those of the other targets where
    `make dist` built it, or in a wheel."""
    own, targets = library(kind), TARGETS[version]
    target, built = own.parents[1].name, own.parents[2]
    if own.is_relative_to(BINARIES):  # whose folders have the names of FMI 2.0
        folders = {target: BINARIES / platform for platform, target in TARGETS[2].items()}
    elif target in targets.values():
        folders = {target: built / target / "release" for target in targets.values()}
    else:
        return {package.PLATFORM[version]: own}
    return existing(kind, version, folders)


def existing(kind: str, version: int, folders: dict[str, Path]) -> dict[str, Path]:
    """Return the libraries of unit `kind` that exist, by platform, from folders by target."""
    names = {target: NAMES.get(target, "libfmu_{}.so").format(kind) for target in folders}
    paths = {platform: folders[target] / names[target] for platform, target in TARGETS[version].items()}
    return {name: path for name, path in paths.items() if path.is_file()}


def write(scene: Scene, folder: Path, version: int = 2) -> None:
    """Write the folder, with units of that version of FMI; one that exists is replaced."""
    units, git = describe_all(scene, version), git_revision()
    libraries = {name: binaries(unit.kind, version) for name, unit in units.items()}
    needed = {
        f"{unit.kind} for {platform}": glibc(path)
        for name, unit in units.items()
        for platform, path in libraries[name].items()
    }
    for what, least in needed.items():
        if least > OLDEST_GLIBC:
            newer, oldest = (".".join(map(str, each)) for each in (least, OLDEST_GLIBC))
            raise SceneError(
                f"the library of the {what} needs glibc {newer}, but {oldest} is to suffice; `make dist` builds it so"
            )
    unfinished = folder.with_name(folder.name + ".unfinished")
    shutil.rmtree(unfinished, ignore_errors=True)
    fmus = {name: package.pack(unit, unfinished, libraries[name], notices(unit.kind)) for name, unit in units.items()}
    files = list(fmus.values())
    if len(units) > 1 and version == 2:  # SSP 1.0 has no arrays
        files.append(ssp.pack(scene, unfinished, fmus))
    platforms = sorted({name for found in libraries.values() for name in found})
    readme = unfinished / "README.md"
    text = README.format(
        scene=scene.name, version=version, platforms=", ".join(platforms), ssp=SSP[version], notes=NOTES[version]
    )
    readme.write_text(text, encoding="utf-8")
    files.append(readme)
    manifest = {
        "source_revision": git.revision + ("-dirty" if git.dirty else "") if git else None,
        "scene": scene.name,
        "fmi": f"{version}.0",
        "platforms": platforms,
        "glibc": ".".join(map(str, max(needed.values()))),
        "files": {path.name: {"size": path.stat().st_size, "sha256": checksum(path)} for path in files},
    }
    (unfinished / "manifest.json").write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
    sums = "".join(f"{checksum(path)}  {path.name}\n" for path in [*files, unfinished / "manifest.json"])
    (unfinished / "SHA256SUMS").write_text(sums, encoding="utf-8")
    shutil.rmtree(folder, ignore_errors=True)
    unfinished.rename(folder)
