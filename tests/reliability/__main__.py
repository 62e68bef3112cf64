"""python -m studies.reliability [--list] [--only forks] [--scene flag] [--share 0.01]

Each check runs with both units, in a process of its own. With the full count, its row in docs/reliability.csv is
replaced.
"""

import csv
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, NamedTuple

import fmpy
import typer

from nervure.files import write_csv
from nervure.library import KINDS
from nervure.resources import ROOT
from nervure.scene import load
from nervure.units import package

from . import calls, calls3, files, limits, trials
from .unit import SCENE, FMU2Unit, child, tried

RESULTS = ROOT / "docs" / "reliability.csv"
SCENES = {"flag": SCENE, "fsi3-325x72": load("fsi3-325x72")}
TIMEOUT = 3600.0  # How long a check may take before it counts as hung, s


class Check(NamedTuple):
    """A check, and how many cases of it there are."""

    function: Callable[[FMU2Unit, int], str]
    flag: int  # On the small scene
    shipped: int  # On the FSI3 pair as shipped
    few: int  # In the tests, on the first scene that has a count

    def counts(self) -> dict[str, int]:
        """The full count by scene."""
        return {scene: count for scene, count in zip(SCENES, (self.flag, self.shipped)) if count}


CHECKS = {
    "sequences": Check(calls.sequences, 100_000, 2000, 200),
    "sequences_3": Check(calls3.sequences, 100_000, 2000, 200),
    "hostile": Check(trials.hostile, 10_000, 2000, 300),
    "corrupted": Check(trials.corrupted, 1_000_000, 100_000, 3000),
    "forged": Check(trials.forged, 100_000, 5000, 1000),
    "processes": Check(trials.processes, 200, 40, 2),
    "rollbacks": Check(trials.rollbacks, 1000, 1000, 30),
    "instances": Check(trials.instances, 100_000, 2000, 300),
    "loads": Check(trials.loads, 5000, 500, 20),
    "threads": Check(trials.threads, 64, 64, 16),
    "forks": Check(trials.forks, 100, 40, 4),
    "modes": Check(trials.modes, 160, 160, 16),
    "kills": Check(files.kills, 500, 0, 20),
    "full_disks": Check(files.full_disks, 500, 0, 20),
    "inputs": Check(limits.inputs, 0, 1000, 20),
    "edited": Check(limits.edited, 0, 10_000, 100),
    "foreign": Check(limits.foreign, 0, 10_000, 60),
    "memory": Check(limits.memory, 0, 200, 6),
}


def unpack(kind: str, folder: Path, scene: str) -> Path:
    """The FMU of one of `SCENES`, unpacked."""
    return Path(fmpy.extract(str(package.pack(kind, SCENES[scene], folder)), str(folder / f"{kind}-{scene}")))


def main(
    only: Annotated[list[str] | None, typer.Option(help="Checks to run; default: all.")] = None,
    scene: Annotated[list[str] | None, typer.Option(help="Scenes to run them on; default: all.")] = None,
    share: Annotated[float, typer.Option(help="Part of the full count.")] = 1.0,
    list_: Annotated[bool, typer.Option("--list", help="Name the checks and end.")] = False,
) -> None:
    """Run the reliability checks."""
    for chosen, known in ((only, list(CHECKS)), (scene, list(SCENES))):
        if unknown := set(chosen or ()) - set(known):
            raise typer.BadParameter(f"{', '.join(sorted(unknown))}: there are {', '.join(known)}")
    runs = [(name, check.function, *count) for name, check in CHECKS.items() for count in check.counts().items()]
    failed = 0
    for name, function, where, full in runs:
        if list_:
            typer.echo(f"{name:12} {where:12} {full:9}  {function.__doc__}")
            continue
        for kind in KINDS if name in (only or CHECKS) and where in (scene or SCENES) else ():
            count, begin = max(1, round(share * full)), time.perf_counter()
            try:
                with TemporaryDirectory() as folder:
                    result = child("spawn", TIMEOUT, tried, function, kind, unpack(kind, Path(folder), where), count)
            except AssertionError as error:
                result, failed = f"**failed**: {error}", failed + 1
            row = {"check": name, "unit": kind, "scene": where, "cases": count, "result": result}
            row["seconds"] = round(time.perf_counter() - begin)
            typer.echo(f"{name} of the {kind} of {where}, {count:,} cases in {row['seconds']} s: {result}")
            if count == full:
                record(row)
    raise typer.Exit(failed > 0)


def record(row: dict) -> None:
    """Put a result in the place of the former one of its check, unit and scene."""
    with open(RESULTS, encoding="utf-8", newline="") as file:
        rows = {(old["check"], old["unit"], old["scene"]): old for old in csv.DictReader(file)}
    rows[row["check"], row["unit"], row["scene"]] = row
    order = [(name, kind, scene) for name in CHECKS for scene in SCENES for kind in KINDS]
    write_csv(RESULTS, [rows[key] for key in order if key in rows])


if __name__ == "__main__":
    typer.run(main)
