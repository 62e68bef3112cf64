"""Paths of the files of the package: scenes, libraries of the units, pictures, licences, the schema.

A wheel has these files in `nervure/data`, in the layout of the source tree; without a wheel, the source tree is used.
The build hook of the wheel runs this file alone, so it imports nothing from the package.
"""

import platform
import sys
from pathlib import Path

PACKAGED = Path(__file__).parent / "data"
SOURCE = None if PACKAGED.is_dir() else Path(__file__).resolve().parents[2]
"""The source tree; None where the package is installed from a wheel."""

ROOT = SOURCE or PACKAGED
SCENES = ROOT / "scenes"
EXAMPLES = ("examples", "modelDescription", "scenes", "scripts")
"""Folders that `nervure examples` copies; a scene finds its schema beside it."""

KINDS = ("rod", "wing", "body", "fluid", "contact")
"""Kinds of units in the order of their steps; KIND has the library and the model identifier `fmu_KIND`."""

COUPLERS = ("fluid", "contact")
"""Kinds of units that give loads to rods and wings, of which a scene has at most one."""

SCENE_KEYS = {"body": "flyer"}
"""Keys of the scene for kinds of units that have another name."""

PREFIX, SUFFIX = {"win32": ("", ".dll"), "darwin": ("lib", ".dylib")}.get(sys.platform, ("lib", ".so"))

_PROCESSOR = platform.machine().lower().replace("arm64", "aarch64").replace("amd64", "x86_64")
PLATFORM = {
    ("linux", "x86_64"): "linux64",
    ("win32", "x86_64"): "win64",
    ("darwin", "x86_64"): "darwin64",
    ("darwin", "aarch64"): "darwin64",  # One library for both
}.get((sys.platform, _PROCESSOR), f"{_PROCESSOR}-{sys.platform}")
"""Name of this system in FMI 2.0; where FMI 2.0 has none, in FMI 3.0."""

BINARIES = ROOT / "binaries"
"""Libraries in a wheel, in one folder for each platform."""
