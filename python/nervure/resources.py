"""The files that come with the package: scenes, libraries of the units, pictures, licences, the schema.

A wheel carries them in `nervure/data`, laid out as in the source tree; run from the source tree, they are that tree
itself.
"""

from pathlib import Path

PACKAGED = Path(__file__).parent / "data"
SOURCE = None if PACKAGED.is_dir() else Path(__file__).resolve().parents[2]
"""The source tree; None where the package is installed from a wheel."""

ROOT = SOURCE or PACKAGED
SCENES = ROOT / "scenes"
