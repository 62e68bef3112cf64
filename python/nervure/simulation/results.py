"""The result folder of a run: checked before the run, written after it, and read again."""

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from nervure.errors import InputError, SceneError
from nervure.evaluate.statistics import Series
from nervure.files import read_json, write_together
from nervure.scene import Document, Scene, document, text, validate
from nervure.scene.facts import Facts
from nervure.scene.part import refusal
from nervure.simulation.summary import Summary, adapter
from nervure.units.describe import unit_label

FILES = ("scene.json", "series.csv", "summary.json", "tip.png", "drag.png", "lift.png", "vorticity.png")
"""Files of a coupled run in its folder, besides the FMUs."""

FURTHER_FILES = (
    "coefficients.png", "flapping.png", "vorticity.gif", "vorticity.mp4", "phases.png", "motion.png", "motion.gif",
    "motion.mp4", "wing.png", "iterations.csv", "convergence.csv", "series.h5", "final.npz",
)  # fmt: skip
"""Further files of a cylinder alone, a driven root, `animate`, a wing, an iterated scheme and a long run."""

CHECKPOINT, FINAL = "checkpoint.npz", "final.npz"  # Of a run that was stopped, and of a finished one
FIELDS = FLUID_FIELDS, BEAM_FIELDS, WING_FIELDS = "fields.vtkhdf", "beam.vtkhdf", "wing.vtkhdf"
"""Files with fields; of several rods `beam-NAME.vtkhdf`."""

LONG = 10_000  # Rows from which the series is written as series.h5 too, where h5py is installed

REMARKS = ("$schema", "description", "display", "reference")
"""Keys of a scene that change no result."""

ABSENT, LONGEST_SHOWN = "absent", 60  # Word for a missing key in messages, and largest number of characters of a value


@dataclass(frozen=True)
class Results:
    """A run: the facts of its scene, its summary, and every recorded output over time."""

    facts: Facts
    folder: Path
    summary: Summary
    series: Series  # In full precision where the run was made in this process
    units: Mapping[str, str | None]  # Units of the columns; counts have none

    @property
    def scene(self) -> Scene:
        """The scene of the run."""
        return self.facts.scene


def read(folder: Path) -> Results:
    """Read the results in `folder`; series.csv has ten digits, series.h5 of a long run has all."""
    try:
        scene = _scene(folder)
        summary = read_json(folder / "summary.json")
        columns, table = _read_series(folder)
        known = adapter().validate_python(summary)
    except OSError as error:
        missing = Path(error.filename).name
        raise InputError(f"{folder} holds no results: {missing}: {error.strerror}; `nervure run` makes them") from error
    except ValidationError as error:
        raise InputError(
            f"the results in {folder} are damaged, or of another version: summary.json: {refusal(error)}"
        ) from None
    except ValueError as error:
        raise InputError(f"the results in {folder} are damaged: {error}") from error
    if table.shape[1] != len(columns):
        raise InputError(f"the results in {folder} are damaged: series.csv has rows of another length than its header")
    if lost := known.series.keys() - set(columns):
        raise InputError(f"the results in {folder} are damaged: series.csv lacks the column {min(lost)}")
    if not len(table):
        raise InputError(f"the results in {folder} are damaged: series.csv has no rows")
    if known.window_s and (end := table[-1, columns.index("time")]) < known.window_s[0]:
        raise InputError(f"the results in {folder} are damaged: series.csv ends at t = {end:g} s, before the window")
    units = {name: known.series.get(name) for name in columns}
    return Results(Facts(scene), folder, known, dict(zip(columns, table.T, strict=True)), units)


def _scene(folder: Path) -> Scene:
    """Return the scene of the results in `folder`; raise `ValueError` where the file holds none."""
    try:
        return validate(read_json(folder / "scene.json"))
    except SceneError as error:
        raise ValueError(f"scene.json: {error}") from error


def _read_series(folder: Path) -> tuple[list[str], np.ndarray]:
    """Return the names of the recorded columns and their table, `[rows, columns]`."""
    h5py = _h5py()
    if h5py and (folder / "series.h5").exists():
        with h5py.File(folder / "series.h5") as file:
            columns = list(file)
            return columns, np.column_stack([file[column] for column in columns])
    with open(folder / "series.csv", encoding="utf-8") as table:
        columns = table.readline().strip().split(",")
        rows = [line for line in table if line.strip()]
        for number, row in enumerate(rows, 1):
            if (found := row.count(",") + 1) != len(columns):
                raise ValueError(f"row {number} of series.csv has {found} values for {len(columns)} columns")
        return columns, np.loadtxt(rows, delimiter=",", ndmin=2) if rows else np.empty((0, len(columns)))


def _write_series(path: Path, run: Results) -> None:
    """Write the series as HDF5: a dataset for each column, in order, with the attribute `unit`."""
    with _h5py().File(path, "w", track_order=True) as file:
        for name, values in run.series.items():
            file.create_dataset(name, data=values).attrs["unit"] = run.units.get(name) or ""


def _h5py() -> Any:
    """Return the package h5py; None where it is not installed: only fields need it."""
    try:
        import h5py
    except ImportError:
        return None
    return h5py


def check_output_folder(folder: Path, scene: Scene, models: Mapping[str, str], force: bool) -> set[Path]:
    """Check that a run of `scene`, with units of these `models`, loses no results in `folder`: raise `InputError` where
    it would, unless `force` allows it. Return the stale files, which the results will replace."""
    if (folder / CHECKPOINT).exists():
        if not force:
            raise InputError(
                f"{folder} holds the checkpoint of a run that was stopped: `nervure resume {folder}` continues it; to "
                "start again, give another --output, or --force to replace it"
            )
        (folder / CHECKPOINT).unlink()
    if not (held := conflicting_results(folder, scene, models)):
        return set()
    if not force:
        raise InputError(f"{folder} holds {held}; give another --output, or --force to replace what is there")
    earlier, units = _earlier(folder) or ({}, {})
    return {folder.resolve() / name for name in (*(f"{earlier.get('name')}-{unit}.fmu" for unit in units), "row.json")}


def conflicting_results(folder: Path, scene: Scene | Document, models: Mapping[str, str]) -> str | None:
    """Return a description of the results in `folder` that are not of `scene` with units of these `models`; None where
    there are no results, or results of the same run."""
    held = [name for name in (*FILES, *FURTHER_FILES) if (folder / name).exists()]
    if not held:
        return None
    if (earlier := _earlier(folder)) is None:
        return f"{held[0]}, but no results that can be read"
    there, ran = earlier
    if found := scene_difference(there, document(scene)):
        return "the results of another scene: {} is {} there, but {} here".format(*found)
    for unit, model in models.items():
        if ran.get(unit) != model:
            return f"the results of another {unit_label(unit)}: it is {ran.get(unit)} there, but {model} here"
    return None


def _earlier(folder: Path) -> tuple[Document, dict[str, str]] | None:
    """Return the scene and the models of the units of the results in `folder`; None where they cannot be read."""
    try:
        scene = read_json(folder / "scene.json")
        units = read_json(folder / "summary.json")["units"]
        return scene, {unit: info["model"] for unit, info in units.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def scene_difference(there: Document, here: Document) -> tuple[str, str, str] | None:
    """Return the dotted key and both values of the first difference of two scenes; None where results are the same."""
    old, new = ({key: part for key, part in own.items() if key not in REMARKS} for own in (there, here))
    return _difference(old, new)


def _difference(there: Any, here: Any, key: str = "") -> tuple[str, str, str] | None:
    """Return the dotted key and both values of the first difference of two JSON values; None where they are equal."""
    for kind in (dict, list):
        if isinstance(there, kind) and isinstance(here, kind):
            mine, theirs = (dict(part if kind is dict else enumerate(part)) for part in (here, there))
            parts = ((name, theirs.get(name, ABSENT), mine.get(name, ABSENT)) for name in {**theirs, **mine})
            found = (_difference(old, new, f"{key}.{name}" if key else str(name)) for name, old, new in parts)
            return next(filter(None, found), None)
    if there == here:
        return None
    shown = [str(value) if value is ABSENT else json.dumps(value, ensure_ascii=False) for value in (there, here)]
    short = [text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}…" for text in shown]
    return key, short[0], short[1]


def field_files(folder: Path) -> set[Path]:
    """Return the field files in `folder`."""
    return {path for name in (*FIELDS, "beam-*.vtkhdf") for path in folder.glob(name)}


def write(run: Results, logs: Mapping[str, np.ndarray], stale_files: Iterable[Path] = ()) -> None:
    """Write scene.json, series.csv, the `logs` of the scheme and, last, summary.json into the folder of `run`, then
    remove all other files of an earlier run, and `stale_files`. Where one file cannot be written, the earlier results
    stay as they are."""
    run.folder.mkdir(parents=True, exist_ok=True)
    summarized = json.dumps(run.summary.document(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    writers: dict[str, Callable[[Path], object]] = {
        "scene.json": lambda path: path.write_text(text(run.scene), encoding="utf-8")
    }
    tables = {"series": (list(run.series), np.column_stack(list(run.series.values())))}
    tables |= {name: (list(log.dtype.names or ()), log) for name, log in logs.items()}
    for name, (columns, table) in tables.items():
        header = ",".join(columns)
        writers[f"{name}.csv"] = partial(np.savetxt, X=table, fmt="%.10g", delimiter=",", header=header, comments="")
    if len(run.series["time"]) >= LONG and _h5py():
        writers["series.h5"] = lambda path: _write_series(path, run)
    # Last: a reader who finds a new summary finds the other files new too.
    writers["summary.json"] = lambda path: path.write_text(summarized, encoding="utf-8")
    write_together(run.folder, writers)
    other_files = [run.folder / name for name in {*FILES, *FURTHER_FILES} - writers.keys()]
    for path in [*other_files, *run.folder.glob("flapping-*.png"), *stale_files]:
        path.unlink(missing_ok=True)
