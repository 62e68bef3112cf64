"""`python -m studies NAME …` runs the missing cases of studies and updates the tables of the documents.

python -m studies                               update the tables of the documents
python -m studies fluid --list                  list the cases and whether their results are known
python -m studies fluid --only 'dt/*' --jobs 2  run the missing cases of a group, two at a time
python -m studies --shown README.md             run the stale cases that a document shows
python -m studies --stale                       list the results that are older than the sources
python -m studies --tables FOLDER               write a page with all tables of each study
python -m studies --check                       fail if the table of a document is out of date
python -m studies fluid --same-as CHECKOUT      keep stale results that the units of a checkout reproduce to the bit
"""

import sys
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from studies import catalogue, engine, same
from studies.engine import Case, Study
from studies.store import Data


def state(study: Study, case: Case, data: Data) -> str:
    """Return what is known of a case: a committed result, a run in results, a stale result, or nothing."""
    record, run = data.get(f"{study.name}/{case.name}"), study.run_of(case)
    if record and not record.stale:
        return "known"
    if run and run.digest == case.digest:
        return "run"
    return "stale" if record else "missing"


def main(
    names: Annotated[list[str] | None, typer.Argument(metavar="[NAME]…", help="Studies.")] = None,
    only: Annotated[
        str, typer.Option(metavar="PATTERN", help="Run only cases with such a name, for example 'dt/*'.")
    ] = "*",
    listing: Annotated[bool, typer.Option("--list", help="List the cases and run nothing.")] = False,
    jobs: Annotated[int, typer.Option(min=1, help="Runs at a time.")] = 1,
    scheduler: Annotated[str | None, typer.Option(help="Address of a Dask scheduler that runs the cases.")] = None,
    full: Annotated[bool, typer.Option("--full", help="Run long cases, too.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Run cases with known results as well.")] = False,
    update_timings: Annotated[bool, typer.Option(help="Record new times of results that did not change.")] = False,
    shown: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Run only the cases that this document shows.")
    ] = None,
    check: Annotated[bool, typer.Option("--check", help="Write nothing; fail if a document would change.")] = False,
    stale: Annotated[
        bool, typer.Option("--stale", help="List stale results with the commands that repeat them.")
    ] = False,
    tables: Annotated[Path | None, typer.Option(metavar="FOLDER", help="Write pages with all tables there.")] = None,
    same_as: Annotated[
        Path | None,
        typer.Option(metavar="CHECKOUT", help="Run nothing; keep stale results that this checkout gives to the bit."),
    ] = None,
) -> None:
    """Run studies and update the tables of the documents."""
    data = catalogue.load()
    if check:
        changed_pages = catalogue.render(data, check=True)
        for path in changed_pages:
            typer.echo(f"{path} would change")
        raise typer.Exit(bool(changed_pages))
    if stale:
        for record in data.stale():
            typer.echo(f"{record.name} ({record.machine}): {record.command}")
        carried = sum(record.carried for record in data.records.values())
        typer.echo(f"{len(data.stale())} of {len(data.records)} results are stale; {carried} others were carried over")
        return
    if tables:
        tables.mkdir(parents=True, exist_ok=True)
        for name, text in catalogue.table_pages(data).items():
            (tables / f"{name}.md").write_text(text, encoding="utf-8")
        return
    known = {study.name: study for study in catalogue.STUDIES}
    if unknown := [name for name in names or () if name not in known]:
        raise typer.BadParameter(f"there is no study {unknown[0]!r}; there are {', '.join(known)}")
    studies = [known[name] for name in names or ()]
    if same_as:
        kept = same.carry_over(data, names or [], same_as.resolve(), jobs)
        data.save()
        catalogue.render(data)
        typer.echo(f"{len(kept)} cases hold")
        return
    if shown:
        wanted = catalogue.shown(shown.resolve())
        cases = [found for found in engine.chosen(catalogue.STUDIES) if f"{found[0].name}/{found[1].name}" in wanted]
        studies = list({study.name: study for study, _ in cases}.values())
    else:
        cases = engine.chosen(studies, only, full)
    todo = []
    for study, case in cases:
        found = state(study, case, data)
        if listing:
            typer.echo(f"{found:8} {study.name}/{case.name}")
        elif force or found in ("stale", "missing"):
            todo.append((study, case))
        elif found == "run" and (run := study.run_of(case)):
            data.take(study, case, run, update_timings)
    if listing:
        return
    try:
        for study, case, run in engine.run(todo, jobs, scheduler):
            changed = data.take(study, case, run, update_timings)
            data.save()
            typer.echo(f"{study.name}/{case.name}: {run.found.get('error') or ('new' if changed else 'as before')}")
    except ChildProcessError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(1) from error
    data.save()
    by_name = {f"{study.name}/{case.name}": partial(study.run_of, case) for study, case in data.cases.values()}
    for study in studies:
        study.draw(data, lambda name: by_name[name]())
    for path in catalogue.render(data):
        typer.echo(f"wrote {path}")


if __name__ == "__main__":
    sys.argv[0] = "python -m studies"
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command()(main)
    app()
