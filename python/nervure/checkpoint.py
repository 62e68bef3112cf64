"""Checkpoints: all that a run needs to go on where it was, in one file.

The file is an uncompressed NumPy archive (a zip file, whose checksums show damage): the scene and how it was set up,
the units' serialized states and what was last exchanged, the memory of the coupling scheme, the clock, and every row
recorded so far. With one file there is one moment, the renaming, at which a new checkpoint replaces the old.
"""

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nervure.coupling import Single
from nervure.errors import InputError
from nervure.files import write_whole
from nervure.recorder import Recorder
from nervure.scene import Scene, unit_label
from nervure.units.fmu import Unit, UnitError

FILE = "checkpoint.npz"
FORMAT = 6
About = dict[str, Any]  # What a checkpoint says in JSON, as a whole or of one thing
EXCHANGED = ("inputs", "outputs", "integers")  # The arrays of a unit that the next step or the next row may need


class CheckpointError(InputError):
    """A checkpoint cannot be made or cannot be used."""


@dataclass(frozen=True)
class Kept:
    """What a checkpoint holds."""

    path: Path
    about: About  # The scene, its set-up, the units' GUIDs, steps done and times
    arrays: dict[str, np.ndarray]


def read(folder: Path) -> Kept:
    """The checkpoint in `folder`."""
    path = folder / FILE
    if not path.is_file():
        raise CheckpointError(
            f"there is no checkpoint {path} to resume from: a run leaves one where Ctrl-C or SIGTERM stops it, and "
            "with --checkpoint-every where it is killed"
        )
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        about = json.loads(arrays.pop("about").tobytes())
    except Exception as error:  # whatever the readers of zip, NumPy and JSON raise
        raise CheckpointError(f"the checkpoint {path} is damaged: {error}") from error
    if about["format"] != FORMAT:
        raise CheckpointError(f"the checkpoint {path} has format {about['format']}, not {FORMAT}")
    return Kept(path, about, arrays)


class Checkpoint:
    """The checkpoint of a run in `folder`; to be made after the units are connected."""

    def __init__(
        self, folder: Path, scene: Scene, setup: About, units: dict[str, Unit], scheme: Single, recorder: Recorder
    ):
        for unit in units.values():
            if not unit.can_serialize:
                raise CheckpointError(
                    f"a checkpoint needs units that serialize their state, which the {unit.name} does not offer"
                )
        self.path = folder / FILE
        self.about = {"format": FORMAT, "scene": scene.document(), "setup": setup}
        self.units, self.scheme, self.recorder = units, scheme, recorder

    def save(self, done: int, wall: float) -> None:
        """Keep the run as it is after step `done`, at `wall` (s), so that a crash at any moment leaves this or the
        one before."""
        arrays = {"series": self.recorder.table[: self.recorder.rows]}
        about: About = self.about | {"guids": {}, "done": done, "wall": wall, "seconds": {}}
        for kind, unit in self.units.items():
            arrays[f"{kind}_state"] = np.frombuffer(unit.serialize(), np.uint8)
            arrays |= {f"{kind}_{name}": getattr(unit, name) for name in EXCHANGED}
            about["guids"][kind], about["seconds"][kind] = unit.description.guid, unit.seconds
        arrays |= {f"scheme_{name}": array for name, array in self.scheme.memory().items()}
        arrays["about"] = np.frombuffer(json.dumps(about).encode(), np.uint8)

        def writer(path: Path) -> None:
            with open(path, "wb") as file:
                np.savez(file, allow_pickle=False, **arrays)
                file.flush()
                os.fsync(file.fileno())

        write_whole(self.path, writer)
        if hasattr(os, "O_DIRECTORY"):  # where a folder can be opened, let the renaming reach the disk too
            descriptor = os.open(self.path.parent, os.O_RDONLY | os.O_DIRECTORY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)

    def restore(self, kept: Kept) -> tuple[int, float]:
        """Put started units, scheme and recorder into the state that was kept; returns steps done and wall time (s)."""
        about, arrays = kept.about, kept.arrays
        for kind, unit in self.units.items():
            here, there = unit.description.guid, about["guids"][kind]
            if here != there:
                raise CheckpointError(
                    f"the checkpoint {kept.path} is of another {unit_label(kind)}: its GUID is {here} here, but "
                    f"{there} there"
                )
            try:
                unit.deserialize(arrays[f"{kind}_state"].tobytes())
            except UnitError as error:
                raise CheckpointError(
                    f"the checkpoint {kept.path} is of another build of the {unit_label(kind)}: {error}"
                ) from error
            for name in EXCHANGED:
                getattr(unit, name)[:] = arrays[f"{kind}_{name}"]
            unit.seconds = about["seconds"][kind]
        own = {name.removeprefix("scheme_"): array for name, array in arrays.items() if name.startswith("scheme_")}
        self.scheme.remember(own)
        self.recorder.resume(arrays["series"])
        return about["done"], about["wall"]

    def try_to_save(self, done: int, time: float, wall: float, warn: Callable[[str], None]) -> None:
        """Save; where the disk does not take it, say so and leave the checkpoint before."""
        try:
            self.save(done, wall)
        except OSError as error:
            warn(f"no checkpoint at t = {time:g} s: {error}")

    def every(self, interval: float, wall: float, warn: Callable[[str], None]) -> Callable[[int, float, float], None]:
        """Watcher of a run that tries to save every `interval` seconds of wall time after `wall`."""
        due = wall + interval

        def watch(done: int, time: float, wall: float) -> None:
            nonlocal due
            if wall >= due and done > 0:
                self.try_to_save(done, time, wall, warn)
                due = wall + interval

        return watch


def clear(folder: Path) -> None:
    """Remove the checkpoint from `folder`."""
    (folder / FILE).unlink(missing_ok=True)
