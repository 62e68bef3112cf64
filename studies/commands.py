"""Cases that are a program of their own: one that writes tables as CSV."""

from __future__ import annotations

import csv
import subprocess
from pathlib import Path
from typing import Any

from nervure.errors import InputError
from nervure.resources import ROOT
from studies.engine import Case


def cargo(package: str, *arguments: str, binary: str = "", example: str = "") -> list[str]:
    """Return the command of a program of studies/rust."""
    run = ["cargo", "run", "--release", "--locked", "--manifest-path", "studies/rust/Cargo.toml", "-p", package]
    run += ["--target-dir", "target/studies"]
    which = ("--bin", binary) if binary else ("--example", example) if example else ()
    return [*run, *which, "--", *arguments]


def tables(case: Case, folder: Path) -> dict[str, Any]:
    """Run the option `command`, with the case's folder for `{folder}`; the tables that it has written there."""
    command = [part.format(folder=folder) for part in case.options["command"]]
    done = subprocess.run(command, cwd=ROOT, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        raise InputError(done.stderr.strip().splitlines()[-1])
    return {"tables": {path.stem: read(path) for path in sorted(folder.glob("*.csv"))}}


def read(path: Path) -> list[dict[str, Any]]:
    """Rows of a CSV with numbers as floats and empty cells as None."""

    def value(text: str) -> float | str | None:
        try:
            return float(text) if text else None
        except ValueError:
            return text

    with open(path, encoding="utf-8", newline="") as file:
        return [{key: value(text) for key, text in row.items()} for row in csv.DictReader(file)]
