"""How the units take mistreatment: the tables of docs/reliability.md, from the files that `make reliability` and
`make fuzz`
write."""

from studies import commands, show
from studies.engine import Study

TABLES = {
    f"reliability-{table}": lambda data, name=name: commands.read(show.DOCS / f"{name}.csv")
    for table, name in (("checks", "reliability"), ("fuzz", "fuzz"))
}
STUDY = Study("robustness", list, lambda case, run: {}, TABLES)
