"""Build hook of the wheel: puts the units and all that belongs to them into `nervure/data`.

The units are built with cargo, for this system. Where the variable `NERVURE_LIBRARIES` names a folder of `make dist`,
as in `make wheel`, the libraries for all systems are taken from there, and their licences with them. An editable
install takes everything from the source tree instead; `make build` builds its units.
"""

import os
import runpy
import subprocess
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SHIPPED = ["scenes", "modelDescription/scene.schema.json", "LICENSE-MIT", "LICENSE-APACHE"]
SHIPPED += [f"fmu-{kind}/{name}" for kind in ("rod", "fluid") for name in ("model.png", "documentation.html")]


class Units(BuildHookInterface):  # type: ignore[type-arg]
    """Adds the libraries of the units."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        files = {Path(self.root, name): name for name in SHIPPED}
        if "NERVURE_LIBRARIES" in os.environ:
            files |= _delivered(Path(self.root, "target", "wheel"))
            build_data["tag"] = "py3-none-any"
        else:
            files |= _built(Path(self.root))
            build_data["tag"] = f"py3-none-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
            build_data["pure_python"] = False
        build_data["force_include"] |= {str(source): f"nervure/data/{target}" for source, target in files.items()}


def _built(root: Path) -> dict[Path, str]:
    """The libraries of this system, which cargo builds, and where in the package they go."""
    subprocess.run(["cargo", "build", "--release", "--locked"], cwd=root, check=True)
    built = Path(os.environ.get("CARGO_TARGET_DIR", root / "target")) / "release"
    names = runpy.run_path(str(root / "python" / "nervure" / "resources.py"))
    files = [f"{names['PREFIX']}fmu_{kind}{names['SUFFIX']}" for kind in names["KINDS"]]
    return {built / file: f"binaries/{names['PLATFORM']}/{file}" for file in files}


def _delivered(folder: Path) -> dict[Path, str]:
    """The libraries of all systems and the licences of what is linked into them, which are written into `folder`."""
    from nervure.library import KINDS
    from nervure.units import delivery, notices

    folder.mkdir(parents=True, exist_ok=True)
    files: dict[Path, str] = {}
    for kind in KINDS:
        libraries = delivery.binaries(kind, 2)
        if missing := delivery.TARGETS[2].keys() - libraries:
            raise SystemExit(f"the {kind} is not built for {', '.join(sorted(missing))}; `make dist-libraries` does it")
        files |= {path: f"binaries/{platform}/{path.name}" for platform, path in libraries.items()}
        licences = folder / f"third-party-{kind}.txt"
        licences.write_text(notices.notices(kind), encoding="utf-8")
        files[licences] = f"binaries/{licences.name}"
    return files
