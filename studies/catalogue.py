"""All studies, and the documents that show what they have found."""

import re
from collections.abc import Iterable
from pathlib import Path

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


def filled(text: str, data: Data) -> str:
    """`text` with its tables as they are now."""
    tables = {key: table for study in STUDIES for key, table in study.tables.items()}

    def table(match: re.Match[str]) -> str:
        if match[1] not in tables:
            raise KeyError(f"there is no table called {match[1]}")
        return f"<!--table:{match[1]}-->\n" + "\n".join(tables[match[1]](data)) + "\n<!--end-->"

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
