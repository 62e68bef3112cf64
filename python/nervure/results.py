"""What a run leaves in its folder: written, and read again."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter, ValidationError

from nervure.coupling import Single
from nervure.errors import Refusal
from nervure.evaluate.summary import Summary
from nervure.files import write_together
from nervure.recorder import Recorder
from nervure.scene import Scene, text, typed

FILES = ("scene.json", "series.csv", "summary.json", "tip.png", "drag.png", "lift.png", "vorticity.png")
"""The files that a coupled run leaves in its folder, besides the FMUs."""

FURTHER_FILES = (
    "coefficients.png", "flapping.png", "vorticity.gif", "phases.png", "motion.png", "iterations.csv", "convergence.csv"
)  # fmt: skip
"""What a cylinder alone, a driven root, `animate` and an iterated scheme leave besides."""


@dataclass(frozen=True)
class Results:
    """A run: its scene, what came out, and every recorded output over time."""

    scene: Scene
    folder: Path
    summary: Summary
    series: Mapping[str, np.ndarray]  # Columns by name
    units: Mapping[str, str | None]  # Their units; a column without one counts something

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return list(self.series)

    @property
    def unit_of(self) -> Mapping[str, str | None]:
        """The same as `units`: so a run that was read stands in for a `Recorder` where it is drawn."""
        return self.units

    def column(self, name: str) -> np.ndarray:
        """The values of column `name`."""
        return self.series[name]


def of(scene: Scene, folder: Path, summary: Summary, recorder: Recorder) -> Results:
    """The results of a run in this process, in full precision."""
    series = {name: recorder.column(name).copy() for name in recorder.columns}
    return Results(scene, folder, summary, series, dict(recorder.unit_of))


def read(folder: Path) -> Results:
    """The results in `folder`; series.csv has ten digits."""
    try:
        scene = typed(json.loads((folder / "scene.json").read_text(encoding="utf-8")))
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        with open(folder / "series.csv", encoding="utf-8") as file:
            columns = file.readline().strip().split(",")
            table = np.loadtxt(file, delimiter=",", ndmin=2)
    except OSError as error:
        missing = Path(error.filename).name
        raise Refusal(f"{folder} holds no results: {missing}: {error.strerror}; `nervure run` makes them") from error
    except ValueError as error:
        raise Refusal(f"the results in {folder} are damaged: {error}") from error
    if table.shape[1] != len(columns):
        raise Refusal(f"the results in {folder} are damaged: series.csv has rows of another length than its header")
    try:
        known = TypeAdapter(Summary).validate_python(summary)
    except ValidationError as error:
        raise Refusal(f"the results in {folder} are damaged, or of another version: summary.json: {error}") from error
    return Results(scene, folder, known, dict(zip(columns, table.T, strict=True)), known.series)


def write(folder: Path, scene: Scene, recorder: Recorder, scheme: Single, summary: Summary) -> None:
    """Write scene.json, series.csv, the scheme's logs and summary.json into `folder`, in the place of the results of an
    earlier run: where one cannot be written those stay, else nothing of theirs does."""
    folder.mkdir(parents=True, exist_ok=True)

    def series(path: Path) -> None:
        header = ",".join(recorder.columns)
        np.savetxt(path, recorder.table[: recorder.rows], "%.10g", ",", header=header, comments="")

    summarized = json.dumps(summary.document(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    writers: dict[str, Callable[[Path], object]] = {
        "scene.json": lambda path: path.write_text(text(scene), encoding="utf-8"),
        "series.csv": series,
        "summary.json": lambda path: path.write_text(summarized, encoding="utf-8"),
    }
    for name, log in scheme.logs().items():
        header = ",".join(log.dtype.names or ())
        writers[f"{name}.csv"] = partial(np.savetxt, X=log, fmt="%.10g", delimiter=",", header=header, comments="")
    write_together(folder, writers)
    for name in {*FILES, *FURTHER_FILES} - writers.keys():
        (folder / name).unlink(missing_ok=True)


def labelled(runs: list[Results]) -> dict[str, Results]:
    """`runs` by the names of their folders, or by their paths where those are the same."""
    names = [run.folder.resolve().name for run in runs]
    unique = len(set(names)) == len(names)
    return {name if unique else str(run.folder): run for name, run in zip(names, runs, strict=True)}
