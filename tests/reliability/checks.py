"""The checks by name, and the scenes on which they run. `cases.toml` of the studies has the full counts."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import fmpy

from nervure.scene import load
from nervure.units import package
from nervure.units.describe import describe

from . import calls_fmi2, calls_fmi3, files, limits, trials
from .unit import SCENE, WING, FMU2Unit

SHIPPED = "fsi3-325x72"


class Check(NamedTuple):
    """A check, the number of cases of it in a quick test, and the scene of that test."""

    function: Callable[[FMU2Unit, int], str]
    few: int
    scene: str = "flag"


CHECKS = {
    "sequences": Check(calls_fmi2.sequences, 60),
    "sequences_3": Check(calls_fmi3.sequences, 60),
    "hostile": Check(trials.hostile, 100),
    "corrupted": Check(trials.corrupted, 3000),
    "forged": Check(trials.forged, 1000),
    "processes": Check(trials.processes, 2),
    "rollbacks": Check(trials.rollbacks, 30),
    "instances": Check(trials.instances, 100),
    "loads": Check(trials.loads, 20),
    "threads": Check(trials.threads, 16),
    "forks": Check(trials.forks, 4),
    "modes": Check(trials.modes, 16),
    "kills": Check(files.kills, 8),
    "full_disks": Check(files.full_disks, 8),
    "inputs": Check(limits.inputs, 20, SHIPPED),
    "edited": Check(limits.edited, 100, SHIPPED),
    "foreign": Check(limits.foreign, 60, SHIPPED),
    "memory": Check(limits.memory, 6, SHIPPED),
}


def unpack(kind: str, folder: Path, scene: str = "flag") -> Path:
    """Unpack the FMU of the small scene `flag`, or of a shipped one; that of a wing is of its own small scene."""
    given = WING if kind == "wing" else SCENE if scene == "flag" else load(scene)
    packed = package.pack(describe(kind, given), folder)
    return Path(fmpy.extract(str(packed), str(folder / f"{kind}-{scene}")))
