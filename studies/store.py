"""What studies have found, as it is committed: docs/report/results.json, and docs/report/times.json beside it.

results.json has a line for each case: the command that repeats it, the digest of what it depends on, and its rows, a
value
with unit, published value and error each; tables of map cells and the like besides. times.json has what it took and
on which
machine and revision. A case that is run again with the same digest and the same values changes neither.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from fnmatch import fnmatch
from functools import partial
from pathlib import Path
from typing import Any

from nervure.files import write_together
from nervure.resources import ROOT
from studies import machine, simulate
from studies.engine import Case, Run, Study

DOCS = ROOT / "docs"
REPORT = DOCS / "report"


@dataclass
class Record:
    """A case and what is committed of it."""

    name: str
    """`study/group/label`."""
    case: Case
    command: str
    digest: str
    """Of when it was run; empty where that was not recorded."""
    values: dict[str, Any] = field(default_factory=dict)
    tables: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    error: str | None = None
    times: dict[str, Any] = field(default_factory=dict)
    machine: str = ""
    """Key into the machines of times.json."""

    def __getitem__(self, quantity: str) -> Any:
        return self.values[quantity]

    def get(self, quantity: str, default: Any = None) -> Any:
        return self.values.get(quantity, default)

    @property
    def label(self) -> str:
        """The name without study and group."""
        return self.name.split("/", 2)[-1]

    @property
    def about(self) -> dict[str, Any]:
        return self.case.about

    @property
    def stale(self) -> bool:
        """Whether what it depends on has changed since."""
        return self.digest != self.case.digest

    @property
    def published(self) -> dict[str, tuple[float, float]]:
        """Published value and scale of its quantities."""
        return simulate.published(self.about.get("published", ""))

    def off(self, quantity: str) -> float | None:
        """Distance from the published value by its scale."""
        if quantity not in self.published or self.values.get(quantity) is None:
            return None
        expected, scale = self.published[quantity]
        return float(self.values[quantity] - expected) / scale if scale else None

    def clock(self, name: str) -> float | None:
        """Median of a time, s: `cpu_s` or `wall_s`."""
        found = self.times.get(name)
        return found[1] if isinstance(found, list) else found

    @property
    def view(self) -> dict[str, Any]:
        """Everything that a table can show of it: what it is about, values, `QUANTITY.error`, and times by their
        medians."""
        clocks = {name: self.clock(name) for name in self.times}
        errors = {f"{quantity}.error": self.off(quantity) for quantity in self.published}
        about = {"label": self.label, "said": self.error or "ok"} | self.about
        return about | clocks | errors | self.values

    def rows(self) -> dict[str, dict[str, Any]]:
        """Value, unit, published value and error by quantity."""
        found = {}
        for quantity, value in self.values.items():
            row = {"value": value, "unit": simulate.unit_of(quantity)}
            if quantity in self.published:
                row |= {"reference": self.published[quantity][0], "error": self.off(quantity)}
            found[quantity] = {name: part for name, part in row.items() if part not in (None, "")}
        return found


class Data:
    """All records by name, in the order of the studies and their cases; knows which ones it was asked for."""

    def __init__(self, studies: Iterable[Study]):
        self.cases = {f"{study.name}/{case.name}": (study, case) for study in studies for case in study.cases()}
        self.records: dict[str, Record] = {}
        self.machines: dict[str, dict[str, Any]] = {}
        self.asked: set[str] = set()

    def __getitem__(self, name: str) -> Record:
        self.asked.add(name)
        return self.records[name]

    def get(self, name: str) -> Record | None:
        self.asked.add(name)
        return self.records.get(name)

    def of(self, pattern: str, **about: Any) -> list[Record]:
        """Records of this name whose cases are described so."""
        found = []
        for name, (_, case) in self.cases.items():
            if fnmatch(name, pattern) and all(case.about.get(key) == value for key, value in about.items()):
                self.asked.add(name)
                if name in self.records:
                    found.append(self.records[name])
        return found

    def stale(self) -> list[Record]:
        return [record for record in self.records.values() if record.stale]

    def take(self, study: Study, case: Case, run: Run, new_times: bool = False) -> bool:
        """Take in a run; whether that has changed anything."""
        error = run.found.get("error")
        kept = {} if error and not run.found.get("quantities") else study.keep(case, run)
        record = Record(
            f"{study.name}/{case.name}",
            case,
            study.command(case),
            run.digest,
            rounded(kept.get("values", {})),
            rounded(kept.get("tables", {})),
            error,
            rounded(kept.get("times", {})),
            machine.key(run.machine),
        )
        before = self.records.get(record.name)
        if before and result_of(before) == result_of(record) and not (new_times and before.times != record.times):
            return False
        self.records[record.name] = record
        self.machines[record.machine] = run.machine
        return True

    # Files

    def load(self, folder: Path = REPORT) -> Data:
        if (folder / "results.json").is_file():
            results, times = (
                json.loads((folder / name).read_text(encoding="utf-8")) for name in ("results.json", "times.json")
            )
            self.machines = times["machines"]
            for name, entry in results.items():
                if name not in self.cases:
                    continue
                values = {quantity: row["value"] for quantity, row in entry.pop("rows", {}).items()}
                tables = {key: unpacked(table) for key, table in entry.pop("tables", {}).items()}
                taken = times["cases"].get(name, {})
                self.records[name] = Record(
                    name,
                    self.cases[name][1],
                    values=values,
                    tables=tables,
                    times=taken,
                    machine=taken.pop("machine", ""),
                    **entry,
                )
        return self

    def save(self, folder: Path = REPORT) -> None:
        """Write both files."""
        ordered = [self.records[name] for name in self.cases if name in self.records]
        times = {record.name: {"machine": record.machine} | record.times for record in ordered}
        used = {record.machine for record in ordered}
        machines = {key: about for key, about in sorted(self.machines.items()) if key in used}
        texts = {
            "results.json": lines({record.name: entry_of(record) for record in ordered}),
            "times.json": '{\n"machines": ' + lines(machines) + ',\n"cases": ' + lines(times) + "\n}",
        }
        folder.mkdir(parents=True, exist_ok=True)
        write_together(folder, {name: partial(write, text + "\n") for name, text in texts.items()})


def rounded(value: Any) -> Any:
    """Numbers with eight digits, anywhere in `value`: what is beyond is noise, and makes a file twice as long."""
    if isinstance(value, float):
        return float(f"{value:.8g}")
    if isinstance(value, dict):
        return {key: rounded(part) for key, part in value.items()}
    return [rounded(part) for part in value] if isinstance(value, list) else value


def result_of(record: Record) -> tuple[Any, ...]:
    """What must be the same for a run to agree with what is committed."""
    return record.digest, record.values, record.tables, record.error


def entry_of(record: Record) -> dict[str, Any]:
    """A record as it stands in results.json."""
    entry: dict[str, Any] = {"command": record.command, "digest": record.digest}
    if record.error:
        entry["error"] = record.error
    entry["rows"] = record.rows()
    if record.tables:
        entry["tables"] = {key: packed(rows) for key, rows in record.tables.items()}
    return entry


def write(text: str, path: Path) -> None:
    path.write_text(text, encoding="utf-8")


def lines(parts: dict[str, Any]) -> str:
    """A JSON object with a line for each part."""
    texts = (
        f"{json.dumps(k)}: {json.dumps(rounded(v), ensure_ascii=False, allow_nan=False)}" for k, v in parts.items()
    )
    return "{\n" + ",\n".join(texts) + "\n}"


def packed(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """A table without its columns' names in each row."""
    return {"columns": list(rows[0]), "rows": [list(row.values()) for row in rows]}


def unpacked(table: dict[str, Any]) -> list[dict[str, Any]]:
    return [dict(zip(table["columns"], row)) for row in table["rows"]]
