"""Mistreated units at full count, by tests/reliability, and fuzzed ones, by tests/fuzz."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from studies import commands, simulate
from studies.engine import UNITS, Case, Run, Study

LISTED: dict[str, Any] = simulate.LISTED["reliability"]
KINDS = ("rod", "fluid")


def cases() -> Iterator[Case]:
    for check, counts in LISTED["checks"].items():
        for scene, count in counts.items():
            for kind in ("wing",) if scene == "wing" else KINDS:
                arguments = [check, kind, scene, str(count), "{folder}/found.csv"]
                about = {"check": check, "unit": kind, "scene": scene, "cases": count}
                yield program(f"check/{check}, {kind}, {scene}", "reliability", arguments, about)
    for target in LISTED["fuzz"]["targets"]:
        arguments = [target, str(LISTED["fuzz"]["seconds"]), "{folder}/found.csv"]
        yield program(f"fuzz/{target}", "fuzz", arguments, {"target": target}, quick=False)


def program(name: str, module: str, arguments: list[str], about: dict[str, Any], quick: bool = True) -> Case:
    options = {"command": ["{python}", "-m", f"tests.{module}", *arguments]}
    sources = (*UNITS, "wing", "export", module) if ", wing," in name else (*UNITS, "export", module)
    return Case(name, sources, options=options, action=commands.tables, about=about, quick=quick)


def extract(case: Case, run: Run) -> dict[str, Any]:
    (row,) = run.found["tables"]["found"]
    seconds = row.pop("seconds")
    return {"values": row, "times": {"seconds": seconds}}


STUDY = Study("reliability", cases, extract)
