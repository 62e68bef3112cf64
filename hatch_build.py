"""Build hooks of the package: write the classes of scenes, put the units and their files into `nervure/data`, and the
project's address into metadata.

Cargo builds the units for this system. With the variable `NERVURE_LIBRARIES`, which names the folder of one target of
`make dist-libraries`, the wheel is for that target. It carries the libraries of all targets and their licences, so
that every installation packs FMUs for all systems. An editable install uses the source tree; `make build` builds its
units.
"""

import json
import os
import runpy
import subprocess
import sysconfig
import tomllib
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

NAMES = runpy.run_path(str(Path(__file__).parent / "python" / "nervure" / "resources.py"))

SHIPPED = ["scenes", "modelDescription/scene.schema.json", "LICENSE-MIT", "LICENSE-APACHE"]
SHIPPED += [f"fmu-{kind}/{name}" for kind in NAMES["KINDS"] for name in ("model.png", "documentation.html")]

SHOWN = (".py", ".json", ".stl")  # Files of examples and scripts

TAGS = {
    "x86_64-unknown-linux-gnu": "manylinux_{}_{}_x86_64",
    "aarch64-unknown-linux-gnu": "manylinux_{}_{}_aarch64",
    "x86_64-pc-windows-gnu": "win_amd64",
    "universal2-apple-darwin": "macosx_11_0_universal2",
}
"""Platform tag of a wheel by Rust's target; for Linux with the version of glibc."""


class Address(MetadataHookInterface):
    """Adds the address of the project, which stands in Cargo.toml."""

    def update(self, metadata: dict[str, Any]) -> None:
        cargo = tomllib.loads(Path(self.root, "Cargo.toml").read_text(encoding="utf-8"))
        metadata["urls"] = {"Repository": cargo["workspace"]["package"]["repository"]}


class Units(BuildHookInterface):  # type: ignore[type-arg]
    """Adds the libraries of the units."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        _write_types(Path(self.root))
        if version == "editable":
            return
        files = {Path(self.root, name): name for name in SHIPPED}
        shown = [path for name in ("examples", "scripts") for path in Path(self.root, name).rglob("*.*")]
        files |= {path: path.relative_to(self.root).as_posix() for path in shown if path.suffix in SHOWN}
        if folder := os.environ.get("NERVURE_LIBRARIES"):
            libraries, platform = _delivered(Path(folder), Path(self.root, "target", "wheel"))
        else:
            libraries, platform = _built(Path(self.root)), sysconfig.get_platform()
        files |= libraries
        build_data["tag"] = f"py3-none-{platform.replace('-', '_').replace('.', '_')}"
        build_data["pure_python"] = False
        build_data["force_include"] |= {str(source): f"nervure/data/{target}" for source, target in files.items()}


def _write_types(root: Path) -> None:
    """Write the Python classes of scenes."""
    folder, classes = root / "modelDescription", root / "python" / "nervure" / "scene" / "types.py"
    schema = json.loads((folder / "scene.schema.json").read_text(encoding="utf-8"))
    classes.write_text(runpy.run_path(str(folder / "scene_types.py"))["generate"](schema), encoding="utf-8")


def _built(root: Path) -> dict[Path, str]:
    """Build the libraries for this system and return their places in the package."""
    subprocess.run(["cargo", "build", "--release", "--locked"], cwd=root, check=True)
    built = Path(os.environ.get("CARGO_TARGET_DIR", root / "target")) / "release"
    files = [f"{NAMES['PREFIX']}fmu_{kind}{NAMES['SUFFIX']}" for kind in NAMES["KINDS"]]
    return {built / file: f"binaries/{NAMES['PLATFORM']}/{file}" for file in files}


def _delivered(folder: Path, written: Path) -> tuple[dict[Path, str], str]:
    """Return the libraries of all targets with the licences of the crates in them, which are written into `written`,
    and the platform tag for the target that `folder` belongs to."""
    from nervure.library import KINDS
    from nervure.units import delivery, notices

    target, targets = folder.parent.name, folder.parents[1]
    if target not in TAGS:
        raise SystemExit(f"NERVURE_LIBRARIES is {folder}, but must be TARGET/release with one of {', '.join(TAGS)}")
    written.mkdir(parents=True, exist_ok=True)
    folders = {name: targets / name / "release" for name in TAGS}
    files: dict[Path, str] = {}
    glibc = delivery.OLDEST_GLIBC
    for kind in KINDS:
        libraries = delivery.existing(kind, 2, folders)
        if missing := delivery.TARGETS[2].keys() - libraries:
            raise SystemExit(f"the {kind} is not built for {', '.join(sorted(missing))}; `make dist-libraries` does it")
        files |= {path: f"binaries/{platform}/{path.name}" for platform, path in libraries.items()}
        glibc = max(glibc, *(delivery.glibc(path) for path in libraries.values() if path.parent == folders[target]))
        licences = written / f"third-party-{kind}.txt"
        licences.write_text(notices.notices(kind), encoding="utf-8")
        files[licences] = f"binaries/{licences.name}"
    return files, TAGS[target].format(*glibc)
