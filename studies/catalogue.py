"""All studies, and the documents that show what they have found."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from studies import coupling, fluid, fsi3, robustness, rod, running, show, speed, vein
from studies.engine import Study
from studies.report import leave_out, pages
from studies.store import REPORT, Data

STUDIES = (rod.STUDY, fluid.STUDY, fluid.MEASURES, speed.STUDY, fsi3.STUDY, coupling.STUDY, vein.STUDY, running.STUDY,
           robustness.STUDY, leave_out.STUDY, pages.STUDY)  # fmt: skip

STALE = REPORT / "stale.md"
"""Depends on the sources besides the results: it is not compared by the test of the pages."""


def load(studies: Iterable[Study] = STUDIES) -> Data:
    return Data(studies).load()


def lines_of(key: str, data: Data) -> list[str]:
    """Lines of a table: as the study makes them, or of the rows that it makes by tables.toml."""
    made = next((study.tables[key] for study in STUDIES if key in study.tables), None)
    if key not in show.SPECS:
        if made is None:
            raise KeyError(f"there is no table called {key}")
        found: list[str] = made(data)
        return found
    rows: list[dict[str, Any]] = made(data) if made else views(data, show.SPECS[key]["of"])
    return show.table(key, rows)


def views(data: Data, pattern: str) -> list[dict[str, Any]]:
    """What there is to show of the cases that match, and `NAME.off`, how far each number is from that of the last
    one."""
    rows = [record.view for record in data.of(pattern)]
    last = {name: value for name, value in rows[-1].items() if isinstance(value, float) and value}
    return [
        row | {f"{name}.off": row[name] / value - 1 for name, value in last.items() if row.get(name)} for row in rows
    ]


def filled(text: str, data: Data) -> str:
    """`text` with its tables as they are now."""

    def table(match: re.Match[str]) -> str:
        return f"<!--table:{match[1]}-->\n" + "\n".join(lines_of(match[1], data)) + "\n<!--end-->"

    return show.TABLE.sub(table, text)


def render(data: Data, check: bool = False) -> list[Path]:
    """Write the tables of documents anew; returns those that have changed. With `check` only tell."""
    changed = []
    for path in show.documents():
        before = path.read_text(encoding="utf-8")
        text = filled(before, data)
        if text != before:
            changed.append(path)
            if not check:
                path.write_text(text, encoding="utf-8")
    if not check:
        STALE.write_text(stale_page(data), encoding="utf-8")
    return changed


def shown(document: Path) -> set[str]:
    """Names of the cases that the tables of a document are made of."""
    data = load()
    filled(document.read_text(encoding="utf-8"), data)
    return data.asked


def stale_page(data: Data) -> str:
    """Cases whose sources or scenes have changed since they were run."""
    stale = data.stale()
    text = [
        "# Stale results", "",
        f"{len(stale)} of {len(data.records)} cases were run before the sources or the scene that they depend on",
        "were changed. Each is repeated by the command beside it.", "",
    ]  # fmt: skip
    rows = [[f"`{record.name}`", record.machine, f"`{record.command}`"] for record in stale]
    return "\n".join([*text, *show.markdown(["case", "run on, at", "command"], rows)]) + "\n"
