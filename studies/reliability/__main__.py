"""python -m studies.reliability [--list] [--only forks] [--share 0.01]

Each check runs with both units, in a process of its own; with its full count, its row in docs/reliability.csv is
replaced.
"""

import csv
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import fmpy
import typer

from nervure.files import write_csv
from nervure.library import KINDS
from nervure.pack import package
from nervure.resources import ROOT
from nervure.scene import load

from . import calls, calls3, files, limits, trials
from .unit import SCENE, FMU2Unit, child, tried

RESULTS = ROOT / "docs" / "reliability.csv"
TIMEOUT = 3600.0  # How long a check may take before it counts as hung, s
CHECKS: dict[str, tuple[Callable[[FMU2Unit, int], str], int, int]] = {
    "sequences": (calls.sequences, 100_000, 200),
    "sequences_3": (calls3.sequences, 100_000, 200),
    "hostile": (trials.hostile, 10_000, 300),
    "corrupted": (trials.corrupted, 1_000_000, 3000),
    "forged": (trials.forged, 100_000, 1000),
    "processes": (trials.processes, 200, 2),
    "rollbacks": (trials.rollbacks, 1000, 30),
    "instances": (trials.instances, 100_000, 300),
    "loads": (trials.loads, 5000, 20),
    "threads": (trials.threads, 64, 16),
    "forks": (trials.forks, 100, 4),
    "modes": (trials.modes, 160, 16),
    "kills": (files.kills, 500, 20),
    "full_disks": (files.full_disks, 500, 20),
    "inputs": (limits.inputs, 1000, 20),
    "edited": (limits.edited, 10_000, 100),
    "foreign": (limits.foreign, 10_000, 60),
    "memory": (limits.memory, 200, 6),
}
"""Each check with its full count of cases and that of the tests."""

SHIPPED = ("inputs", "edited", "foreign", "memory")  # Checks on the FSI3 pair as shipped; the others are on `SCENE`


def unpack(kind: str, folder: Path, shipped: bool = False) -> Path:
    """The FMU of `SCENE`, or of the shipped FSI3 scene, unpacked."""
    scene = load("fsi3-325x72") if shipped else SCENE
    return Path(fmpy.extract(str(package.pack(kind, scene, folder)), str(folder / f"{kind}-{shipped}")))


def main(
    only: Annotated[list[str] | None, typer.Option(help="Checks to run; default: all.")] = None,
    share: Annotated[float, typer.Option(help="Part of the full count.")] = 1.0,
    list_: Annotated[bool, typer.Option("--list", help="Name the checks and end.")] = False,
) -> None:
    """Run the reliability checks."""
    if unknown := set(only or ()) - set(CHECKS):
        raise typer.BadParameter(f"{', '.join(sorted(unknown))}: the checks are {', '.join(CHECKS)}")
    failed = 0
    with TemporaryDirectory() as temporary:
        for name, (function, full, _) in CHECKS.items():
            if list_:
                typer.echo(f"{name:12} {full:9}  {function.__doc__}")
                continue
            for kind in KINDS if name in (only or CHECKS) else ():
                count, begin = max(1, round(share * full)), time.perf_counter()
                try:
                    result = child(
                        "spawn", TIMEOUT, tried, function, kind, unpack(kind, Path(temporary), name in SHIPPED), count
                    )
                except AssertionError as error:
                    result, failed = f"**failed**: {error}", failed + 1
                seconds = round(time.perf_counter() - begin)
                typer.echo(f"{name} of the {kind}, {count:,} cases in {seconds} s: {result}")
                if count == full:
                    record({"check": name, "unit": kind, "cases": count, "result": result, "seconds": seconds})
    raise typer.Exit(failed > 0)


def record(row: dict) -> None:
    """Put a result in the place of the former one of its check and unit."""
    with open(RESULTS, encoding="utf-8", newline="") as file:
        rows = {(old["check"], old["unit"]): old for old in csv.DictReader(file)}
    rows[row["check"], row["unit"]] = row
    write_csv(RESULTS, [rows[name, kind] for name in CHECKS for kind in KINDS if (name, kind) in rows])


if __name__ == "__main__":
    typer.run(main)
