"""How the units take mistreatment: the tables of docs/reliability.md, from the files that `make reliability` and
`make fuzz`
write."""

from collections.abc import Callable
from typing import Any

from studies import commands, show
from studies.engine import Study

TABLES: dict[str, Callable[[Any], Any]] = {
    "reliability-checks": lambda data: commands.read(show.DOCS / "reliability.csv"),
    "reliability-fuzz": lambda data: commands.read(show.DOCS / "fuzz.csv"),
}
STUDY = Study("robustness", list, lambda case, run: {}, TABLES)
