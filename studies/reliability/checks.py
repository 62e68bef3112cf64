"""All checks, each in a process of its own, and docs/reliability.csv of them."""

import csv
import multiprocessing
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import fmpy
import typer

from nervure.pack import package
from nervure.files import write_csv
from nervure.resources import ROOT

from .calls import sequences
from .files import full_disks, kills
from .hostile import hostile
from .process import forks, instances, loads, modes, threads
from .states import corrupted, forged, processes, rollbacks
from .unit import SCENE, Library


@dataclass(frozen=True)
class Check:
    run: Callable[[Library, int], str]
    full: int
    quick: int
    timeout: float = 3600.0
    """How long the full form may take before it counts as hung, s."""


CHECKS = {
    check.run.__name__: check
    for check in (
        Check(sequences, 100_000, 200),
        Check(hostile, 10_000, 300),
        Check(corrupted, 1_000_000, 3000),
        Check(forged, 100_000, 1000),
        Check(processes, 200, 2),
        Check(rollbacks, 1000, 30),
        Check(instances, 100_000, 300),
        Check(loads, 5000, 20),
        Check(threads, 64, 16),
        Check(forks, 100, 4),
        Check(modes, 160, 16),
        Check(kills, 500, 20),
        Check(full_disks, 500, 20),
    )
}


def unpack(kind: str, folder: Path) -> Path:
    """The FMU of `SCENE`, unpacked."""
    return Path(fmpy.extract(str(package.pack(kind, SCENE, folder)), str(folder / kind)))


def one(name: str, kind: str, folder: Path, count: int, answers) -> None:
    """Run a check and answer how it went."""
    try:
        answers.put((True, CHECKS[name].run(Library(kind, folder), count)))
    except AssertionError as error:
        answers.put((False, str(error)))


def guarded(name: str, kind: str, folder: Path, count: int, timeout: float, target=one) -> tuple[bool, str]:
    """The outcome of a check in a process of its own, of which a crash and a hang are two."""
    context = multiprocessing.get_context("spawn")
    answers = context.Queue()
    process = context.Process(target=target, args=(name, kind, folder, count, answers))
    process.start()
    process.join(timeout)
    if process.exitcode is None:
        process.kill()
        process.join()
        return False, f"hung: no end after {timeout:.0f} s"
    if process.exitcode != 0:
        return False, f"crashed with exit code {process.exitcode}"
    return answers.get()


RESULTS = ROOT / "docs" / "reliability.csv"
FIELDS = ("check", "unit", "cases", "result", "seconds")


def record(row: dict) -> None:
    """Put a result in the place of the former one of its check and unit, of docs/reliability.csv."""
    known = {}
    if RESULTS.is_file():
        with open(RESULTS, encoding="utf-8", newline="") as file:
            known = {(old["check"], old["unit"]): old for old in csv.DictReader(file)}
    known[row["check"], row["unit"]] = row
    rows = [known[name, kind] for name in CHECKS for kind in package.KINDS if (name, kind) in known]
    write_csv(RESULTS, rows)


def main(
    only: Annotated[list[str] | None, typer.Option(help="Checks to run; default: all.")] = None,
    share: Annotated[float, typer.Option(help="Part of the full count.")] = 1.0,
    list_: Annotated[bool, typer.Option("--list", help="Name the checks and end.")] = False,
    write: Annotated[bool, typer.Option(help="Put the results into docs/reliability.csv.")] = False,
) -> None:
    """Run the reliability checks."""
    if list_:
        for name, check in CHECKS.items():
            typer.echo(f"{name:12} {check.full:9}  {check.run.__doc__.strip()}")
        return
    if unknown := set(only or ()) - set(CHECKS):
        raise typer.BadParameter(f"{', '.join(sorted(unknown))}: the checks are {', '.join(CHECKS)}")
    all_well = True
    with tempfile.TemporaryDirectory() as temporary:
        folders = {kind: unpack(kind, Path(temporary)) for kind in package.KINDS}
        for name in only or CHECKS:
            check = CHECKS[name]
            count = max(1, round(share * check.full))
            for kind in package.KINDS:
                begin = time.perf_counter()
                well, result = guarded(name, kind, folders[kind], count, check.timeout)
                seconds = round(time.perf_counter() - begin)
                all_well &= well
                result = result if well else f"**failed**: {result}"
                typer.echo(f"{name} of the {kind}, {count:,} cases in {seconds} s: {result}")
                if write:
                    record(dict(zip(FIELDS, (name, kind, count, result, seconds))))
    raise typer.Exit(0 if all_well else 1)
