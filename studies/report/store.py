"""results.json and results.csv of docs/report: one schema for everything that was measured, imported or cited."""

from __future__ import annotations

import csv
import json
import os
import platform
import subprocess
from dataclasses import asdict, dataclass, fields
from importlib.metadata import version
from pathlib import Path

from nervure.files import rounded, write_together
from nervure.report import cpu_model, git_revision
from nervure.resources import ROOT

DOCS = ROOT / "docs" / "report"


@dataclass
class Row:
    """One quantity of one case; what does not apply is None."""

    case: str
    """What is solved: rod-static, csm3, cylinder-2d1, cylinder-2d2, fsi3, or the name of a map or of another table."""
    method: str
    setting: str
    """What tells this run from others of the method."""
    quantity: str
    value: float | None = None
    unit: str = ""
    reference: float | None = None
    error: float | None = None
    """(value - reference) / scale of the reference, relative; scale: |reference|, or the amplitude of an
    oscillation."""
    discretisation: float | None = None
    """The same against the limit of the model, where that is known: the exact solution, or an extrapolation."""
    size: float | None = None
    """Segments of the rod, points of the grid along x, degrees of freedom of a peer."""
    step: float | None = None
    """s."""
    wall_s: float | None = None
    wall_q1: float | None = None
    wall_q3: float | None = None
    cpu_s: float | None = None
    cpu_q1: float | None = None
    cpu_q3: float | None = None
    repeats: int | None = None
    outcome: str = "ok"
    """`ok`, `error` (it said so) or `bad` (it did not)."""
    reason: str = ""
    command: str = ""
    tolerance: float | None = None
    """Relative, within which another machine gets the value again; None where nothing is asked."""
    machine: str = ""
    """Key of the record of machine and versions in results.json; empty for what a study has and what is cited."""
    source: str = "measured"
    """`measured` by the report's command, the file of the study that it is from, or `cited`."""


class Rows(list):
    """All rows, to be asked for some."""

    def of(self, case: str, **fixed) -> Rows:
        """Those of a case whose other fields are as given."""
        return Rows(row for row in self if row.case == case and all(getattr(row, k) == v for k, v in fixed.items()))

    def one(self, case: str, method: str, setting: str, quantity: str) -> Row:
        """The only one; a KeyError that names what is missing."""
        found = self.of(case, method=method, setting=setting, quantity=quantity)
        if len(found) != 1:
            raise KeyError(f"results.json has {len(found)} rows for {case}/{method}/{setting}/{quantity}")
        return found[0]


@dataclass
class Value:
    """A number that documents show."""

    value: float
    form: str
    """Format, such as `.2f`."""
    unit: str
    command: str
    """That gives it again; empty for what is cited."""

    def __str__(self) -> str:
        return format(self.value, self.form)


def value(row: Row, form: str, unit: str | None = None, scale: float = 1.0, field: str = "value") -> Value:
    """A field of a row, times `scale`, in `unit` (that of the row unless given)."""
    return Value(scale * getattr(row, field), form, row.unit if unit is None else unit, row.command)


NAMES = [field.name for field in fields(Row)]
DEFAULTS = {field.name: field.default for field in fields(Row)}


def csv_rows(path: Path) -> list[dict[str, str]]:
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def number(text: str) -> float | None:
    """A cell of a CSV."""
    return float(text) if text else None


def machine() -> dict:
    """Machine and versions of a measurement."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    compiler = subprocess.run(["rustc", "--version"], capture_output=True, text=True).stdout.strip()
    return {
        "cpu": cpu_model(),
        "cores": os.cpu_count(),
        "memory_gb": round(memory / 1e9, 1),
        "system": platform.system(),
        "load_at_start": round(os.getloadavg()[0], 1),
        "python": platform.python_version(),
        "rustc": compiler,
        "packages": {name: version(name) for name in ("fmpy", "numpy")},
        "git": git_revision(),
    }


def load(folder: Path = DOCS) -> dict:
    """results.json with `rows` as `Rows`."""
    data = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return data | {"rows": Rows(Row(**row) for row in data["rows"])}


def text_of(data: dict) -> str:
    """results.json: a line for each row, value and series; a Row has no entry for what is as by default."""
    lines = []
    for key, part in data.items():
        if key == "rows":
            rows = [{k: v for k, v in asdict(row).items() if v != DEFAULTS[k]} for row in part]
            body = (
                "[\n"
                + ",\n".join(json.dumps(rounded(row), ensure_ascii=False, allow_nan=False) for row in rows)
                + "\n]"
            )
        elif isinstance(part, dict):
            items = (
                f"{json.dumps(k)}: {json.dumps(rounded(v), ensure_ascii=False, allow_nan=False)}"
                for k, v in part.items()
            )
            body = "{\n" + ",\n".join(items) + "\n}"
        else:
            body = json.dumps(part)
        lines.append(f"{json.dumps(key)}: {body}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def save(data: dict, folder: Path = DOCS) -> None:
    """Write results.json and results.csv."""
    folder.mkdir(parents=True, exist_ok=True)

    def table(path: Path) -> None:
        with open(path, "w", encoding="utf-8", newline="") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(NAMES)
            out.writerows(
                [["" if v is None else v for v in rounded(list(asdict(row).values()))] for row in data["rows"]]
            )

    used = {row.machine for row in data["rows"]}
    data["machine"] = {key: about for key, about in data["machine"].items() if key in used}
    text = text_of(data)
    write_together(folder, {"results.json": lambda path: path.write_text(text, encoding="utf-8"), "results.csv": table})
