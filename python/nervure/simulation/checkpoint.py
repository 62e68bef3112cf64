"""Checkpoints: everything that a run needs to continue, in one file.

The file is an uncompressed NumPy archive (a zip file, whose checksums show damage): the scene and its options, the
serialized states of the units and the values last exchanged, the memory of the coupling scheme, the time, every row
recorded so far, and a digest of all of it, which an edited file does not have. With one file, a new checkpoint replaces
the old one at one moment, the renaming.
"""

import hashlib
import json
import os
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nervure.coupling import Drive
from nervure.errors import InputError, UnitError
from nervure.files import read_json, write_whole
from nervure.scene import Document, Scene, validate
from nervure.simulation.loop import STEP_ROUNDING, Observer, TimeLoop
from nervure.simulation.results import CHECKPOINT, FINAL, Results, scene_difference
from nervure.simulation.session import Session
from nervure.simulation.summary import RunStatus
from nervure.units.describe import unit_label

FORMAT = 10
SCENE = "scene.json"
DIGEST = "digest"  # Array with the digest of the other arrays
EXCHANGED = ("inputs", "outputs", "integers")  # Arrays of a unit that the next step or the next row may need
OPTIONS = ("checkpoint_every", "fields_every", "series_every")
About = dict[str, Any]  # Part of a checkpoint in JSON
Options = dict[str, float | None]  # `checkpoint_every` (min), `fields_every` and `series_every` (s)


class CheckpointError(InputError):
    """A checkpoint cannot be made or used."""


@dataclass(frozen=True)
class Kept:
    """The content of a checkpoint."""

    path: Path
    about: About  # Scene, digest of the replaced scene.json, FMUs, options, GUIDs of the units, steps done and times
    arrays: dict[str, np.ndarray]


def read(folder: Path, finished: bool = False) -> Kept:
    """Read the checkpoint in `folder`; that of a finished run, too, if `finished`."""
    path, final = folder / CHECKPOINT, folder / FINAL
    if not path.is_file() and final.is_file():
        if not finished:
            raise CheckpointError(f"the run in {folder} is finished: `--end-time` lets it go on to a later time")
        path = final
    if not path.is_file():
        raise CheckpointError(
            f"there is no checkpoint {path} to resume from: a run leaves one where Ctrl-C or SIGTERM stops it, and "
            "with --checkpoint-every where it is killed, or finished and to be extended by `--end-time`"
        )
    try:
        if not zipfile.is_zipfile(path):
            raise ValueError("it is no whole archive of NumPy")
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        about = json.loads(arrays["about"].tobytes())
        found = about.get("format")
    except Exception as error:  # whatever the readers of zip, NumPy and JSON raise
        raise CheckpointError(f"the checkpoint {path} is damaged: {error}") from error
    if found != FORMAT:
        raise CheckpointError(f"the checkpoint {path} has format {found}, not {FORMAT}")
    sealed = arrays.pop(DIGEST, np.zeros(0))
    if not np.array_equal(sealed, digest(arrays)):
        raise CheckpointError(f"the checkpoint {path} is damaged: it was changed after it was written")
    return Kept(path, about, arrays)


def digest(arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the digest of arrays with their names, types and shapes, as an array of bytes."""
    found = hashlib.blake2b(digest_size=32)
    for name, array in sorted(arrays.items()):
        found.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        found.update(np.ascontiguousarray(array).ravel().view(np.uint8).data)
    return np.frombuffer(found.digest(), np.uint8)


def resume(folder: Path, end_time: float | None = None, drive: Drive | None = None) -> tuple[Session, Options]:
    """Open the session of the run in `folder` at its checkpoint, with the FMUs that the run had, the `drive` that it
    had, and with another end time (s) if it is given."""
    kept = read(folder, end_time is not None)
    try:
        return _resume(folder, kept, end_time, drive)
    except InputError:
        raise
    except Exception as error:  # Its digest fits, but anything may stand in it
        raise CheckpointError(f"the checkpoint {kept.path} holds what no run wrote: {error!r}") from error


def _resume(folder: Path, kept: Kept, end_time: float | None, drive: Drive | None) -> tuple[Session, Options]:
    fmus = {unit: folder / path for unit, path in kept.about["fmus"].items()}
    for unit, path in fmus.items():
        if not path.is_file():
            raise InputError(f"the {unit_label(unit)} of the run in {folder} is not there any more: {path}")
    options: Options = {name: None if kept.about["options"][name] is None else float(kept.about["options"][name])
                        for name in OPTIONS}  # fmt: skip
    for unit, path in fmus.items():
        if unit not in kept.about["foreign"] and _lasting(_carried(path)) != _lasting(kept.about["scene"]):
            raise CheckpointError(f"the checkpoint {kept.path} is of another scene than the {unit_label(unit)}, {path}")
    _check_scene_file(folder, kept)
    scene, done = validate(kept.about["scene"]), kept.about["done"]
    if end_time is not None:
        _extend(scene, done, end_time, options, folder)
    foreign, series_every = kept.about["foreign"], options["series_every"]
    session = Session(scene, folder, fmus, foreign=foreign, drive=drive, series_every=series_every)
    try:
        restore(session, kept)
    except BaseException:
        session.close()
        raise
    return session, options


def _check_scene_file(folder: Path, kept: Kept) -> None:
    """Raise `CheckpointError` where the scene.json in `folder`, which the run would replace, was edited. That of an
    earlier run, which the run began to replace, may be of another scene."""
    path, known = folder / SCENE, kept.about.get("replaced")
    if (found := _scene_digest(folder)) is None or found == known:
        return
    try:
        difference = scene_difference(read_json(path), kept.about["scene"])
    except (ValueError, AttributeError) as error:
        raise CheckpointError(f"{path} cannot be read, and the run would replace it: {error}") from error
    if difference:
        key, there, here = difference
        end = "`--end-time` changes the end; " if key == "time.end" else ""
        raise CheckpointError(
            f"{key} is {there} in {path}, but {here} in the scene of the run, which goes on with it: {end}take the "
            "change back, or start again by `nervure run` with another --output"
        )


def _scene_digest(folder: Path) -> str | None:
    """Return a digest of the scene.json in `folder`; None without one."""
    path = folder / SCENE
    return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest() if path.is_file() else None


def _carried(fmu: Path) -> Document:
    """Return the scene that a unit carries."""
    with zipfile.ZipFile(fmu) as archive:
        carried: Document = json.loads(archive.read("resources/scene.json"))
    return carried


def _lasting(scene: Document) -> Document:
    """Return a scene without what differs between units, or after an extension."""
    time = {name: value for name, value in scene["time"].items() if name != "end"}
    return {name: part for name, part in scene.items() if name not in ("this_rod", "this_wing")} | {"time": time}


def _extend(scene: Scene, done: int, end: float, options: Options, folder: Path) -> None:
    """Give a scene, of which steps are `done`, another end (s); raise `InputError` where a run cannot go on to it."""
    step = scene.time.communication_step
    if not end > done * step * (1 + STEP_ROUNDING):
        raise InputError(f"the end time is {end:g} s, but the run in {folder} has reached {done * step:g} s")
    if done * step > scene.time.end * (1 + STEP_ROUNDING):
        raise InputError(f"the run in {folder} ended within a step of {step:g} s, after which it cannot go on")
    if options["fields_every"] is not None:
        raise InputError(f"the run in {folder} wrote fields, whose files have no room for more times")
    scene.time.end = end


def restore(session: Session, kept: Kept) -> None:
    """Start the units of a session and put it into the kept state. Raise `ValueError` where an array or a number is
    not what the session has in its place."""
    about, arrays = kept.about, kept.arrays
    session.scheme.start()
    for name, unit in session.units.items():
        here, there = unit.description.guid, about["guids"][name]
        if here != there:
            raise CheckpointError(
                f"the checkpoint {kept.path} is of another {unit_label(name)}: its GUID is {here} here, but "
                f"{there} there"
            )
        try:
            unit.deserialize(arrays[f"{name}_state"].tobytes())
        except UnitError as error:
            raise CheckpointError(
                f"the checkpoint {kept.path} is of another build of the {unit_label(name)}: {error}"
            ) from error
        for exchanged in EXCHANGED:
            own = getattr(unit, exchanged)
            own[:] = _like(own, arrays[f"{name}_{exchanged}"], own.shape)
        unit.seconds = float(about["seconds"][name])
    memory = {name.removeprefix("scheme_"): array for name, array in arrays.items() if name.startswith("scheme_")}
    for name, array in session.scheme.memory().items():
        _like(array, memory[name], (len(memory[name]), *array.shape[1:]))
    session.scheme.remember(memory)
    if session.driver.drive:
        session.driver.remember(about["drive"])
    session.scheme.logs()
    done, recorder = about["done"], session.recorder
    if not (isinstance(done, int) and 0 <= done <= session.grid.steps):
        raise ValueError(f"{done} steps are done of {session.grid.steps}")
    rows, series = done // recorder.stride + 1, arrays["series"]
    # A run that goes on records no end of the shorter one.
    series = series[:1] if rows == 1 else series
    recorder.resume(_like(recorder.table, series, (rows, len(recorder.columns))))
    session.resume_at(done, float(about["wall"]))
    if not all(isinstance(text, str) for text in about["warnings"]):
        raise ValueError("its warnings are no texts")
    session.warnings, session.places.memory = list(about["warnings"]), about["places"]


def _like(own: np.ndarray, kept: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return a kept array; raise `ValueError` where its shape is not `shape`, or its type not that of `own`."""
    if kept.shape != shape or kept.dtype != own.dtype:
        raise ValueError(f"an array is {kept.dtype} {kept.shape} in the place of {own.dtype} {shape}")
    return kept


class Checkpoint(Observer):
    """Keeps the checkpoint of a session: every `interval` minutes of wall time and at the end, if given, and where a
    run is stopped.

    Where the disk does not take a checkpoint, `warn` is called and the checkpoint before stays.
    """

    def __init__(self, session: Session, options: Options, warn: Callable[[str], None] = lambda _: None):
        for unit in session.units.values():
            if not unit.can_serialize:
                raise CheckpointError(
                    f"a checkpoint needs units that serialize their state, which the {unit.name} does not offer"
                )
        self.session, self.warn, self.path = session, warn, session.folder / CHECKPOINT
        home, fmus = session.folder.resolve(), {unit: path.resolve() for unit, path in session.fmus.items()}
        self.about: About = {
            "format": FORMAT,
            "scene": session.scene.document(),
            # Relative within the folder, which may be moved.
            "fmus": {unit: str(p.relative_to(home) if p.is_relative_to(home) else p) for unit, p in fmus.items()},
            "foreign": sorted(session.foreign),
            "options": options,
            "replaced": _scene_digest(session.folder),
        }
        minutes = options["checkpoint_every"]
        self.interval = None if minutes is None else minutes * 60  # s
        self.due = (session.wall if session.steps else 0.0) + (self.interval or 0.0)

    def save(self) -> None:
        """Write the state of the session: a crash at any moment leaves this checkpoint or the one before."""
        session = self.session
        arrays = {"series": session.recorder.table[: session.recorder.rows]}
        about: About = self.about | {"guids": {}, "seconds": {}, "done": session.steps, "wall": session.wall}
        about |= {"warnings": session.warnings, "places": session.places.memory, "drive": session.driver.memory()}
        for name, unit in session.units.items():
            arrays[f"{name}_state"] = np.frombuffer(unit.serialize(), np.uint8)
            arrays |= {f"{name}_{array}": getattr(unit, array) for array in EXCHANGED}
            about["guids"][name], about["seconds"][name] = unit.description.guid, unit.seconds
        arrays |= {f"scheme_{name}": array for name, array in session.scheme.memory().items()}
        arrays["about"] = np.frombuffer(json.dumps(about).encode(), np.uint8)
        arrays[DIGEST] = digest(arrays)

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

    def try_to_save(self) -> None:
        """Save the state; warn where the disk does not take it."""
        try:
            self.save()
        except OSError as error:
            self.warn(f"no checkpoint at t = {self.session.time:g} s: {error}")

    def step(self, loop: TimeLoop) -> None:
        at_end = loop.steps == loop.grid.steps
        if self.interval is not None and loop.steps > 0 and ((wall := loop.wall) >= self.due or at_end):
            self.try_to_save()
            self.due = wall + self.interval

    def end(self, status: RunStatus | None) -> None:
        if status and status.stopped and status.steps > 0:
            self.try_to_save()

    def finish(self, results: Results) -> None:
        if results.summary.completed and self.interval is not None and self.path.exists():
            self.path.replace(self.path.with_name(FINAL))
        elif results.summary.completed:
            self.path.unlink(missing_ok=True)
