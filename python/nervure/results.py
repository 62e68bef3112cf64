"""What a run leaves in its folder: written, and read again."""

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from nervure.coupling import Single
from nervure.errors import InputError
from nervure.evaluate.summary import Summary
from nervure.files import write_together
from nervure.recorder import Series
from nervure.resources import KINDS
from nervure.scene import Document, Scene, document, text, unit_label, validate

FILES = ("scene.json", "series.csv", "summary.json", "tip.png", "drag.png", "lift.png", "vorticity.png")
"""The files that a coupled run leaves in its folder, besides the FMUs."""

FURTHER_FILES = (
    "coefficients.png", "flapping.png", "vorticity.gif", "vorticity.mp4", "phases.png", "motion.png", "motion.gif",
    "motion.mp4", "iterations.csv", "convergence.csv", "series.h5",
)  # fmt: skip
"""What a cylinder alone, a driven root, `animate`, an iterated scheme and a long run leave besides."""

LONG = 10_000  # Rows from which on the series is written as series.h5 too, where h5py is there

REMARKS = ("$schema", "description", "display", "reference")
"""Keys of a scene that change no result."""

ABSENT, LONGEST_SHOWN = "absent", 60  # How a message shows a key that is not there, and the most characters of a value


@dataclass(frozen=True)
class Results:
    """A run: its scene, what came out, and every recorded output over time."""

    scene: Scene
    folder: Path
    summary: Summary
    series: Series  # In full precision where the run was made in this process
    units: Mapping[str, str | None]  # Their units; a column without one counts something


def read(folder: Path) -> Results:
    """The results in `folder`; series.csv has ten digits, series.h5 of a long run has all."""
    try:
        scene = validate(json.loads((folder / "scene.json").read_text(encoding="utf-8")))
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        columns, table = _read_series(folder)
        known = TypeAdapter(Summary).validate_python(summary)
    except OSError as error:
        missing = Path(error.filename).name
        raise InputError(f"{folder} holds no results: {missing}: {error.strerror}; `nervure run` makes them") from error
    except ValidationError as error:
        raise InputError(
            f"the results in {folder} are damaged, or of another version: summary.json: {error}"
        ) from error
    except ValueError as error:
        raise InputError(f"the results in {folder} are damaged: {error}") from error
    if table.shape[1] != len(columns):
        raise InputError(f"the results in {folder} are damaged: series.csv has rows of another length than its header")
    return Results(scene, folder, known, dict(zip(columns, table.T, strict=True)), known.series)


def _read_series(folder: Path) -> tuple[list[str], np.ndarray]:
    """Names and table of what was recorded, `[rows, columns]`."""
    h5py = _h5py()
    if h5py and (folder / "series.h5").exists():
        with h5py.File(folder / "series.h5") as file:
            columns = list(file)
            return columns, np.column_stack([file[column] for column in columns])
    with open(folder / "series.csv", encoding="utf-8") as table:
        columns = table.readline().strip().split(",")
        return columns, np.loadtxt(table, delimiter=",", ndmin=2)


def _write_series(path: Path, run: Results) -> None:
    """Write the series as HDF5: a dataset for each column in its order, with the attribute `unit`."""
    with _h5py().File(path, "w", track_order=True) as file:
        for name, values in run.series.items():
            file.create_dataset(name, data=values).attrs["unit"] = run.units.get(name) or ""


def _h5py() -> Any:
    """The package h5py, which only runs with fields need; None without it."""
    try:
        import h5py
    except ImportError:
        return None
    return h5py


def other(folder: Path, scene: Scene | Document, models: Mapping[str, str]) -> str | None:
    """What `folder` holds that a run of `scene` with units of these `models` would replace by something else; None
    where there is nothing, or the same run."""
    held = [name for name in (*FILES, *FURTHER_FILES) if (folder / name).exists()]
    if not held:
        return None
    try:
        there = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
        units = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["units"]
        ran = {kind: unit["model"] for kind, unit in units.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return f"{held[0]}, but no results that can be read"
    here = dict(document(scene))
    for remark in REMARKS:
        there.pop(remark, None)
        here.pop(remark, None)
    if found := _difference(there, here):
        return "the results of another scene: {} is {} there, but {} here".format(*found)
    for kind, model in models.items():
        if ran.get(kind) != model:
            return f"the results of another {unit_label(kind)}: it is {ran.get(kind)} there, but {model} here"
    return None


def scene_name(folder: Path) -> str | None:
    """The name of the scene whose results are in `folder`; None where that cannot be read."""
    try:
        return str(json.loads((folder / "scene.json").read_text(encoding="utf-8"))["name"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def unit_names(folder: Path) -> list[str]:
    """Names of the units whose results are in `folder`; those of one rod and a fluid where that cannot be read."""
    try:
        return list(json.loads((folder / "summary.json").read_text(encoding="utf-8"))["units"])
    except (OSError, ValueError, KeyError, TypeError):
        return list(KINDS)


def _difference(there: Any, here: Any, key: str = "") -> tuple[str, str, str] | None:
    """Dotted key and both values of the first difference of two JSON values; None where they are the same."""
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


def write(run: Results, scheme: Single, strays: Iterable[Path] = ()) -> None:
    """Write scene.json, series.csv, the scheme's logs and, last, summary.json into the folder of `run`, in the place of
    the results of an earlier run, whose other files are `strays`: where one cannot be written those stay, else nothing
    of theirs does."""
    run.folder.mkdir(parents=True, exist_ok=True)
    summarized = json.dumps(run.summary.document(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    writers: dict[str, Callable[[Path], object]] = {
        "scene.json": lambda path: path.write_text(text(run.scene), encoding="utf-8")
    }
    tables = {"series": (list(run.series), np.column_stack(list(run.series.values())))}
    tables |= {name: (list(log.dtype.names or ()), log) for name, log in scheme.logs().items()}
    for name, (columns, table) in tables.items():
        header = ",".join(columns)
        writers[f"{name}.csv"] = partial(np.savetxt, X=table, fmt="%.10g", delimiter=",", header=header, comments="")
    if len(run.series["time"]) >= LONG and _h5py():
        writers["series.h5"] = lambda path: _write_series(path, run)
    # Where it is new, the others are.
    writers["summary.json"] = lambda path: path.write_text(summarized, encoding="utf-8")
    write_together(run.folder, writers)
    gone = [run.folder / name for name in {*FILES, *FURTHER_FILES} - writers.keys()]
    for path in [*gone, *run.folder.glob("flapping-*.png")]:
        path.unlink(missing_ok=True)
    for path in strays:
        path.unlink(missing_ok=True)
