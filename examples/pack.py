"""Make an FMU of one of the units here for a scene, to be run in place of ours:

python examples/pack.py examples/modal_beam.py scenes/fsi3-325x72.json results/modal_beam.fmu
nervure run fsi3-325x72 --end-time 0.3 --rod-fmu results/modal_beam.fmu
"""

import shutil
import sys
import tempfile
from pathlib import Path

try:
    from pythonfmu.builder import FmuBuilder
except ImportError:
    print(f"error: an FMU in Python needs pythonfmu: `{sys.executable} -m pip install pythonfmu`", file=sys.stderr)
    sys.exit(2)


def pack(unit: Path, scene: Path, fmu: Path) -> None:
    """Write `fmu` with the class in the module `unit`; its resources hold the scene and what the module imports."""
    with tempfile.TemporaryDirectory() as folder:
        described = Path(folder, "scene.json")
        shutil.copy(scene, described)
        FmuBuilder.build_FMU(
            unit,
            dest=fmu,
            project_files=[unit.with_name("contract.py"), described],
            canGetAndSetFMUstate=True,
            canSerializeFMUstate=True,
        )


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit("usage: pack.py UNIT.py SCENE.json OUT.fmu")
    try:
        pack(*map(Path, sys.argv[1:]))
    except (OSError, ValueError) as error:
        sys.exit(f"error: {error}")
    except KeyError as error:
        sys.exit(f"error: the scene {sys.argv[2]} lacks {error}, which {sys.argv[1]} needs")
