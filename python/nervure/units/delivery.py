"""A folder with the units of a scene for users of other masters: FMUs, SSP, SHA256SUMS, manifest.json."""

import hashlib
import json
import re
import shutil
import tempfile
from pathlib import Path

from nervure.errors import InputError, SceneError
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
SSP = {2: "| `*.ssp` | both, connected (SSP 1.0); fmpy's `simulate_ssp` cannot start it |\n", 3: ""}
NOTES = {
    2: "`linux64` needs glibc 2.17 or newer, as `aarch64-linux` does, which FMI 2.0 has no name for.\n"
    "`darwin64` is for Intel and Apple processors, and was never run.",
    3: "`x86_64-linux` and `aarch64-linux` need glibc 2.17 or newer. `x86_64-darwin` and `aarch64-darwin`\n"
    "hold the same library for both processors, which was never run.",
}
"""Notes of the README in the folder, by version of FMI."""
MANIFEST, SUMS = "manifest.json", "SHA256SUMS"
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
    """Write the folder, with units of that version of FMI; one that this function wrote is replaced."""
    folder = folder.resolve()
    if found := foreign_content(folder):
        raise InputError(f"{folder} holds {found}, which `nervure dist` did not write: give a folder that is new")
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
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".nervure-", dir=folder.parent) as beside:
        unfinished = Path(beside, folder.name)
        fmus = {
            name: package.pack(unit, unfinished, libraries[name], notices(unit.kind)) for name, unit in units.items()
        }
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
        (unfinished / MANIFEST).write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
        sums = "".join(f"{checksum(path)}  {path.name}\n" for path in [*files, unfinished / MANIFEST])
        (unfinished / SUMS).write_text(sums, encoding="utf-8")
        shutil.rmtree(folder, ignore_errors=True)
        unfinished.rename(folder)


def foreign_content(folder: Path) -> str | None:
    """Return the name of something in `folder` that no earlier `write` left there as it is; None without one."""
    if not folder.exists():
        return None
    if not folder.is_dir():
        return "a file"
    try:
        known = dict(line.split("  ", 1)[::-1] for line in (folder / SUMS).read_text(encoding="utf-8").splitlines())
    except (OSError, ValueError):
        known = {}
    for path in sorted(folder.iterdir()):
        if not (path.name == SUMS and known) and (not path.is_file() or known.get(path.name) != checksum(path)):
            return path.name
    return None
