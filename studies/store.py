"""Committed results of studies: studies/results/results.json and times.json.

results.json has a line for each case: its command, the digest of its scene and sources, rows of values with unit,
published value and error, and tables. times.json has times, machine and revision. A run with equal values changes at
most the digest.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from fnmatch import fnmatch
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from nervure.files import json_numbers, write_together
from nervure.resources import ROOT
from studies import machine, simulate
from studies.engine import Case, Run, Study

FOLDER = ROOT / "studies" / "results"


@dataclass
class Record:
    """A case and its committed result."""

    name: str  # `study/group/label`
    case: Case
    command: str
    digest: str  # At the time of the run; empty if it was not recorded
    values: dict[str, Any] = field(default_factory=dict)
    tables: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    error: str | None = None
    times: dict[str, Any] = field(default_factory=dict)
    machine: str = ""  # Key into the machines of times.json
    carried: bool = False  # Run on other sources than those of the digest, which reproduce it to the bit

    def __getitem__(self, name: str) -> Any:
        return self.view[name]

    def get(self, name: str, default: Any = None) -> Any:
        return self.view.get(name, default)

    @property
    def stale(self) -> bool:
        """Whether the sources or the scene have changed since the run."""
        return self.digest != self.case.digest

    @cached_property
    def published(self) -> dict[str, tuple[float, float]]:
        """Published value and scale of its quantities; an error against 0 has the scale 1."""
        found, only = simulate.published(self.case.about.get("published", "")), self.case.about.get("only")
        expected = self.case.about.get("expected", {})
        found = {name: part for name, part in found.items() if not only or name in only}
        return found | {name: (value, abs(value) or 1.0) for name, value in expected.items()}

    def errors(self) -> dict[str, float]:
        """Return the errors of its quantities."""
        found = {name: self.get(f"{name}.error") for name in self.published}
        found |= {row["quantity"]: row["error"] for row in self.tables.get("found", []) if "error" in row}
        return {name: float(error) for name, error in found.items() if error is not None}

    @cached_property
    def view(self) -> dict[str, Any]:
        """All values for tables: attributes of the case, values, `QUANTITY.error` (distance from the published value by
        its scale), `cl_mean.by_cd` (error of the lift by the drag), and medians of times, s."""
        clocks = {name: found[1] if isinstance(found, list) else found for name, found in self.times.items()}
        errors = {
            f"{quantity}.error": (float(self.values[quantity]) - expected) / scale
            for quantity, (expected, scale) in self.published.items()
            if scale and self.values.get(quantity) is not None
        }
        if "cl_mean.error" in errors and "cd_mean" in self.published:
            expected, scale = self.published["cl_mean"][0], self.published["cd_mean"][1]
            errors["cl_mean.by_cd"] = (float(self.values["cl_mean"]) - expected) / scale
        said = {"label": self.name.split("/", 2)[-1], "said": self.error or "ok", "failed": bool(self.error)}
        return said | self.case.about | clocks | errors | self.values

    def entry(self) -> dict[str, Any]:
        """Return its entry in results.json."""
        found: dict[str, Any] = {"command": self.command, "digest": self.digest}
        if self.carried:
            found["carried"] = True
        if self.error:
            found["error"] = self.error
        found["rows"] = {}
        for quantity, value in self.values.items():
            row = {"value": value, "unit": simulate.unit_of(quantity)}
            if quantity in self.published:
                row |= {"reference": self.published[quantity][0], "error": self.get(f"{quantity}.error")}
            found["rows"][quantity] = {name: part for name, part in row.items() if part not in (None, "")}
        if self.tables:  # without the names of the columns in each row
            found["tables"] = {
                key: {"columns": list(rows[0]), "rows": [list(row.values()) for row in rows]}
                for key, rows in self.tables.items()
            }
        return found

    def agrees(self, other: Record) -> bool:
        names = ("values", "tables", "error")
        return all(getattr(self, name) == getattr(other, name) for name in names)


class Data:
    """All records by name, in the order of studies and cases; remembers which ones were asked for."""

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
        """Return the records with this pattern of names and these attributes."""
        names = [
            name
            for name, (_, case) in self.cases.items()
            if fnmatch(name, pattern) and all(case.about.get(key) == value for key, value in about.items())
        ]
        self.asked.update(names)
        return [self.records[name] for name in names if name in self.records]

    def stale(self) -> list[Record]:
        return [record for record in self.records.values() if record.stale]

    def take(self, study: Study, case: Case, run: Run, new_times: bool = False) -> bool:
        """Record a run and return whether its values are new. Equal ones keep their times unless `new_times`."""
        error = run.found.get("error")
        kept = json_numbers({} if error and not run.found.get("quantities") else study.extract(case, run))
        values, tables, times = (rounded(kept.get(part, {})) for part in ("values", "tables", "times"))
        values = {quantity: value for quantity, value in values.items() if value is not None}
        name, on = f"{study.name}/{case.name}", machine.key(run.machine)
        record = Record(name, case, study.command(case), run.digest, values, tables, error, times, on)
        before = self.records.get(name)
        same = before is not None and before.agrees(record)
        if before and same and not new_times:
            if before.digest == record.digest:
                return False
            record.times, record.machine = before.times, before.machine
        self.records[name] = record
        self.machines.setdefault(on, run.machine)
        return not same

    def load(self, folder: Path = FOLDER) -> Data:
        files = [folder / name for name in ("results.json", "times.json")]
        if not files[0].is_file():
            return self
        results, times = (json.loads(path.read_text(encoding="utf-8")) for path in files)
        self.machines = times["machines"]
        for name in (name for name in results if name in self.cases):
            entry, taken = results[name], times["cases"].get(name, {})
            values = {quantity: row["value"] for quantity, row in entry.pop("rows", {}).items()}
            tables = {
                key: [dict(zip(table["columns"], row)) for row in table["rows"]]
                for key, table in entry.pop("tables", {}).items()
            }
            parts = {"values": values, "tables": tables, "machine": taken.pop("machine", ""), "times": taken}
            self.records[name] = Record(name, self.cases[name][1], **parts, **entry)
        return self

    def save(self, folder: Path = FOLDER) -> None:
        """Write both files."""
        ordered = [self.records[name] for name in self.cases if name in self.records]
        times = {record.name: {"machine": record.machine} | record.times for record in ordered}
        used = {record.machine for record in ordered}
        machines = {key: about for key, about in sorted(self.machines.items()) if key in used}
        texts = {
            "results.json": lines({record.name: record.entry() for record in ordered}),
            "times.json": '{\n"machines": ' + lines(machines) + ',\n"cases": ' + lines(times) + "\n}",
        }
        folder.mkdir(parents=True, exist_ok=True)
        write = partial(partial, Path.write_text, encoding="utf-8")
        write_together(folder, {name: write(data=text + "\n") for name, text in texts.items()})


def rounded(value: Any) -> Any:
    """Return `value` with all numbers rounded to eight digits: further ones are noise and double the file."""
    if isinstance(value, float):
        return float(f"{value:.8g}")
    if isinstance(value, dict):
        return {key: rounded(part) for key, part in value.items()}
    return [rounded(part) for part in value] if isinstance(value, list) else value


def lines(parts: dict[str, Any]) -> str:
    """Return a JSON object with a line for each part."""
    texts = (
        f"{json.dumps(k)}: {json.dumps(rounded(v), ensure_ascii=False, allow_nan=False)}" for k, v in parts.items()
    )
    return "{\n" + ",\n".join(texts) + "\n}"
