"""What a run has left in its folder, read again."""

import json
from pathlib import Path

import numpy as np

from nervure.errors import Refusal


class Results:
    """Scene, summary and recorded columns of a result folder; stands in for a `Recorder` where those are drawn."""

    def __init__(self, folder: Path):
        self.folder = folder
        try:
            self.scene, self.summary = (
                json.loads((folder / name).read_text(encoding="utf-8")) for name in ("scene.json", "summary.json")
            )
            with open(folder / "series.csv", encoding="utf-8") as file:
                self.columns = file.readline().strip().split(",")
                self.table = np.loadtxt(file, delimiter=",", ndmin=2)
        except OSError as error:
            raise Refusal(
                f"{folder} holds no results: {Path(error.filename).name}: {error.strerror}; `nervure run` makes them"
            ) from error
        except ValueError as error:
            raise Refusal(f"the results in {folder} are damaged: {error}") from error
        if self.table.shape[1] != len(self.columns):
            raise Refusal(f"the results in {folder} are damaged: series.csv has rows of another length than its header")

    def column(self, name: str) -> np.ndarray:
        return self.table[:, self.columns.index(name)]

    @property
    def unit_of(self) -> dict[str, str]:
        """Units of those columns that are evaluated; series.csv has none."""
        return dict.fromkeys(self.columns, "") | {name: quantity["unit"] for name, quantity in self.summary["quantities"].items()}


def labelled(runs: list[Results]) -> dict[str, Results]:
    """`runs` by the names of their folders, or by their paths where those are the same."""
    names = [run.folder.resolve().name for run in runs]
    unique = len(set(names)) == len(names)
    return {name if unique else str(run.folder): run for name, run in zip(names, runs)}
