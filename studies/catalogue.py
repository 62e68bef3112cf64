"""All studies, and the documents that show their results."""

import re
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

from studies import contact, coupling, driven_bar, flapping, fluid, fsi3, lab, leave_out, reliability, report, rod

from studies import running, scenes, settling, show, slit, space, speed, thin, turek_hron, two_grids, vein, wing  # isort: skip
from studies import bars, coverage, environments, flight  # isort: skip
from studies.store import Data

MEASURED = (rod.STUDY, contact.STUDY, fluid.STUDY, fluid.MEASURES, speed.STUDY, fsi3.STUDY, coupling.STUDY,
            driven_bar.STUDY, turek_hron.STUDY, vein.STUDY, flapping.STUDY, thin.STUDY, slit.STUDY, slit.SLIP,
            two_grids.STUDY, two_grids.SIZES, two_grids.TWO, two_grids.DISTANT, two_grids.COST, space.STUDY,
            settling.STUDY, flight.STUDY, wing.STUDY, coverage.STUDY, bars.STUDY)  # fmt: skip
STUDIES = (*MEASURED, scenes.study(MEASURED), running.STUDY, environments.STUDY, lab.STUDY, leave_out.STUDY,
           report.STUDY, reliability.STUDY)  # fmt: skip


def load() -> Data:
    return Data(STUDIES).load()


def lines_of(key: str, data: Data) -> list[str]:
    """Return the lines of a table: as a study makes them, or from rows by the columns of tables.toml."""
    made: Any = next((study.tables[key] for study in STUDIES if key in study.tables), None)
    spec = show.SPECS.get(key)
    if spec is None:
        if made is None:
            raise KeyError(f"there is no table called {key}")
        found: list[str] = made(data)
        return found
    if made:
        return show.table(key, made(data))
    records = data.of(spec["of"])
    if "table" in spec:
        tables = [(record["label"], record.tables.get(spec["table"], [])) for record in records]
        return show.table(key, [{"label": label} | row for label, rows in tables for row in rows])
    ends = records[-1].view if records else {}
    last = {name: value for name, value in ends.items() if isinstance(value, float) and value}
    offs = [{f"{name}.off": r[name] / value - 1 for name, value in last.items() if r.get(name)} for r in records]
    return show.table(key, [record.view | off for record, off in zip(records, offs)])


def filled(text: str, data: Data) -> str:
    """Return `text` with its tables as the results have them."""

    def table(match: re.Match[str]) -> str:
        lines = lines_of(match[1], data)
        if only := show.SPECS.get(match[1], {}).get("only"):
            lines[2:] = [line for line in lines[2:] if any(fnmatch(line, pattern) for pattern in only)]
        return "\n".join([f"<!--table:{match[1]}-->", *lines, "<!--end-->"])

    return show.TABLE.sub(table, text)


def render(data: Data, check: bool = False) -> list[Path]:
    """Write the tables between their markers into the documents, unless `check`; return the documents that change."""
    changed = []
    for path in show.documents():
        before = path.read_text(encoding="utf-8")
        text = filled(before, data)
        if text != before:
            changed.append(path)
            if not check:
                path.write_text(text, encoding="utf-8")
    return changed


def table_pages(data: Data) -> dict[str, str]:
    """Return a page of Markdown for each study: its tables, and every recorded value of every case."""
    pages = {}
    for study in STUDIES:
        text = [f"# {study.name}"]
        for key in study.tables:
            text += ["", f"## {key}", "", *lines_of(key, data)]
        groups = show.grouped(({"group": r.name.split("/")[1], "r": r} for r in data.of(f"{study.name}/*")), "group")
        for group, rows in groups.items():
            text += ["", f"## {group}", "", *show.listing([row["r"] for row in rows])]
        pages[study.name] = "\n".join(text) + "\n"
    return pages


def shown(document: Path) -> set[str]:
    """Return the names of the cases that the tables of a document show."""
    data = load()
    filled(document.read_text(encoding="utf-8"), data)
    return data.asked
