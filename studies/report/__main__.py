"""The report: `python scripts/report measure`, `leave-out`, `collect`, `render`; `make report` does all.

python scripts/report measure --only 'rod-static/*'    measure these anew, leave the other rows of results.json
python scripts/report collect                           take the studies' tables under docs/ into it
python scripts/report render                            write docs/report and the marked numbers of the documents
"""

import sys
from datetime import date
from fnmatch import fnmatch
from pathlib import Path
from typing import Annotated

import typer

sys.path[0] = str(Path(__file__).parents[1])

from nervure.resources import ROOT
from report import cases, collect, leave_out, measure as measuring, render as rendering, store

app = typer.Typer(
    add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False, help="The report of docs/report."
)


def known() -> dict:
    """results.json, or the beginning of it."""
    if (store.DOCS / "results.json").is_file():
        return store.load()
    return {"machine": {}, "values": {}, "series": {}, "rows": store.Rows()}


def here() -> tuple[str, dict]:
    """The record of this machine and these versions, and its key."""
    about = store.machine() | {"date": date.today().isoformat()}
    return f"{about['date']}, {(about['git'] or {'revision': 'no git'})['revision'][:9]}", about


@app.command()
def measure(
    only: Annotated[str, typer.Option(metavar="PATTERN", help="Only the cases of this name.")] = "*",
    full: Annotated[bool, typer.Option("--full", help="The long cases, too.")] = False,
    listing: Annotated[bool, typer.Option("--list", help="List the cases and run nothing.")] = False,
) -> None:
    """Measure cases; rows of other ones stay as they are."""
    chosen = [case for case in cases.cases() if (full or case.quick or only != "*") and fnmatch(case.name, only)]
    if listing:
        for case in chosen:
            typer.echo(case.name)
        return
    key, about = here()
    for case in chosen:
        rows = measuring.measure(case)
        data = known()  # read only now: nothing that came meanwhile may be lost
        data["machine"][key] = about
        for row in rows:
            row.machine = key
        mine = {(row.case, row.method, row.setting) for row in rows} | {(case.case, case.method, case.setting)}
        data["rows"] = [row for row in data["rows"] if (row.case, row.method, row.setting) not in mine] + rows
        store.save(data)
        first = rows[0]
        typer.echo(f"{case.name:60} {first.outcome} {first.reason} {first.wall_s or 0:.3g} s")


@app.command("leave-out")
def leave_out_command(
    only: Annotated[str, typer.Option(metavar="PATTERN", help="Only the scenes of this name.")] = "*",
) -> None:
    """Measure what each shipped scene's missing parts would cost."""
    key, about = here()
    rows = leave_out.measure(only)
    data = known()  # read only now: nothing that came meanwhile may be lost
    data["machine"][key] = about
    for row in rows:
        row.machine = key
    scenes = {row.method for row in rows}
    kept = [row for row in data["rows"] if row.case != leave_out.CASE or row.method not in scenes]
    data["rows"] = kept + rows
    store.save(data)


@app.command("collect")
def collect_command() -> None:
    """Take in what the studies left under docs/, and make the numbers that documents show."""
    data = known()
    collect.everything(data)
    store.save(data)


@app.command()
def render(
    check: Annotated[bool, typer.Option("--check", help="Write nothing; fail if a document would change.")] = False,
) -> None:
    """Write pages, figures and marked numbers from results.json alone."""
    changed = rendering.everything(store.load(), check)
    for path in changed:
        typer.echo(f"{'would change' if check else 'wrote'} {path.relative_to(ROOT)}")
    raise typer.Exit(1 if check and changed else 0)


if __name__ == "__main__":
    app()
