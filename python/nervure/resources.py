"""The files that come with the package: scenes, libraries of the units, pictures, licences, the schema.

A wheel carries them in `nervure/data`, laid out as in the source tree; run from the source tree, they are that tree
itself. The build hook of the wheel reads this file alone, so it imports nothing of the package.
"""

import platform
import sys
from pathlib import Path

PACKAGED = Path(__file__).parent / "data"
SOURCE = None if PACKAGED.is_dir() else Path(__file__).resolve().parents[2]
"""The source tree; None where the package is installed from a wheel."""

ROOT = SOURCE or PACKAGED
SCENES = ROOT / "scenes"

KINDS = ("rod", "fluid")  # Units that a scene can have; unit KIND is the library and the model identifier `fmu_KIND`
PREFIX, SUFFIX = {"win32": ("", ".dll"), "darwin": ("lib", ".dylib")}.get(sys.platform, ("lib", ".so"))

_PROCESSOR = platform.machine().lower().replace("arm64", "aarch64").replace("amd64", "x86_64")
PLATFORM = {
    ("linux", "x86_64"): "linux64",
    ("win32", "x86_64"): "win64",
    ("darwin", "x86_64"): "darwin64",
    ("darwin", "aarch64"): "darwin64",  # One library is for both
}.get((sys.platform, _PROCESSOR), f"{_PROCESSOR}-{sys.platform}")
"""This system's name in FMI 2.0; where that has none, one as in FMI 3.0."""

BINARIES = ROOT / "binaries"
"""The libraries of a wheel, in a folder for each platform."""
