"""How the units take mistreatment: the tables of docs/reliability.md, from the files that `make reliability` and `make fuzz`
write."""

from functools import partial

from studies import commands, show
from studies.engine import Study
from studies.store import Data

COLUMNS = {
    "reliability": {"check": "`{check:}`", "unit": "{unit:}", "cases": "{cases:,.0f}", "result": "{result:}", "time, s": "{seconds:.0f}"},
    "fuzz": {"target": "`{target:}`", "inputs": "<{inputs:,.0f}>", "time, s": "<{seconds:,.0f}>", "found": "{found:}"},
}


def table(name: str, data: Data) -> list[str]:
    return show.table(COLUMNS[name], commands.read(show.DOCS / f"{name}.csv"))


TABLES = {"reliability-checks": partial(table, "reliability"), "reliability-fuzz": partial(table, "fuzz")}
STUDY = Study("robustness", lambda: [], lambda case, run: {}, TABLES)
