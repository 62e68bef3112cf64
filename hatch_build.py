"""Build hook of the wheel: builds the units with cargo and puts them and all that belongs to them into `nervure/data`.

An editable install takes everything from the source tree instead; `make build` builds its units.
"""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SHIPPED = ["scenes", "modelDescription/scene.schema.json", "LICENSE-MIT", "LICENSE-APACHE"]
SHIPPED += [f"fmu-{kind}/{name}" for kind in ("rod", "fluid") for name in ("model.png", "documentation.html")]


class Units(BuildHookInterface):  # type: ignore[type-arg]
    """Adds the libraries of this system."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable":
            return
        root = Path(self.root)
        subprocess.run(["cargo", "build", "--release", "--locked"], cwd=root, check=True)
        built = Path(os.environ.get("CARGO_TARGET_DIR", root / "target")) / "release"
        files = {root / name: f"nervure/data/{name}" for name in SHIPPED}
        for kind in ("rod", "fluid"):
            name = {"win32": f"fmu_{kind}.dll", "darwin": f"libfmu_{kind}.dylib"}.get(sys.platform, f"libfmu_{kind}.so")
            files[built / name] = f"nervure/data/binaries/{name}"
        build_data["force_include"] |= {str(source): target for source, target in files.items()}
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
