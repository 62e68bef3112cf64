"""Cases that are programs: they write tables as CSV into the folder of the case."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from nervure.errors import InputError
from nervure.resources import ROOT
from studies.engine import THREADS, Case

LONGEST = 4 * 3600.0  # Wall time after which a program is stopped, s

PEERS = ROOT / "studies" / "peers"
PEERS_PYTHON = ROOT / "target" / "report" / "venv" / "bin" / "python"
LONGEST_PEER = 3600.0  # Largest wall time of a peer, s


def cargo(package: str, *arguments: str, binary: str = "", example: str = "") -> list[str]:
    """Return the command of a program of studies/rust."""
    run = ["cargo", "run", "--release", "--locked", "--manifest-path", "studies/rust/Cargo.toml", "-p", package]
    run += ["--target-dir", "target/studies"]
    which = ("--bin", binary) if binary else ("--example", example) if example else ()
    return [*run, *which, "--", *arguments]


def output(command: list[str], timeout: float = LONGEST) -> str:
    """Run a program on one thread and return its output. Raise `InputError` with the last line of its errors if it
    fails, and `FileNotFoundError` if it ends with code 2, because something is not installed."""
    environment = os.environ | THREADS
    try:
        done = subprocess.run(
            command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=timeout, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise InputError(f"no end after {timeout:g} s") from error
    if done.returncode:
        said = (done.stderr.strip().splitlines() or [f"ended with code {done.returncode}"])[-1]
        raise FileNotFoundError(said) if done.returncode == 2 else InputError(said)
    return done.stdout


def peer(script: str, *arguments: str) -> dict[str, Any]:
    """Run a peer's script in its own environment and return the last line of its output as JSON."""
    if not PEERS_PYTHON.is_file():
        raise FileNotFoundError("the peers are not installed: make target/report/venv/.ready")
    found: dict[str, Any] = json.loads(
        output([str(PEERS_PYTHON), str(PEERS / script), *arguments], LONGEST_PEER).strip().splitlines()[-1]
    )
    return found


def tables(case: Case, folder: Path) -> dict[str, Any]:
    """Run the option `command`, where `{folder}` and `{python}` are filled in; return the tables that it wrote. Raise
    `ChildProcessError` if it fails, which is no result."""
    for path in folder.glob("*.csv"):
        path.unlink()
    try:
        output([part.format(folder=folder, python=sys.executable) for part in case.options["command"]])
    except InputError as error:
        raise ChildProcessError(f"{case.name}: {error}") from error
    return {"tables": {path.stem: read(path) for path in sorted(folder.glob("*.csv"))}}


def read(path: Path) -> list[dict[str, Any]]:
    """Return the rows of a CSV without its comments, with numbers as floats and empty cells as None."""

    def value(text: str) -> float | str | None:
        try:
            return float(text) if text else None
        except ValueError:
            return text

    with open(path, encoding="utf-8", newline="") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return [{key: value(text) for key, text in row.items()} for row in rows]
