"""Keep stale results that the sources of today reproduce: `python -m studies [NAME …] --same-as CHECKOUT`.

A checkout of the revision of the results runs the first steps of a case by its own code and in its own format, and so
does this one. A stale result of the run of a scene is kept if the outputs of both have the same bits, and if the
cheapest run of its group, made to its end, gives the recorded values: that covers evaluation.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

from nervure.errors import InputError
from nervure.resources import ROOT
from studies import engine, simulate
from studies.engine import Case
from studies.store import Data, Record

STEPS = 20
"""Communication steps that are compared: each of them runs all of the code that the scene needs."""
CHEAP = 30.0  # Processor time up to which the cheapest run of a group is repeated to its end, s

PROBE = """
import hashlib, json, sys
from nervure.resources import ROOT
from studies import catalogue, same
digests, fresh = json.load(sys.stdin)
for record in catalogue.load().records.values():
    if record.digest in digests and not (fresh and record.stale) and (steps := same.first_steps(record.case, ROOT)):
        print(record.digest, hashlib.sha256(steps).hexdigest(), flush=True)
"""
"""Print the recorded digest of results and the hash of the first steps of their cases. Any checkout runs this."""


def first_steps(case: Case, checkout: Path) -> bytes | None:
    """Return outputs over the first steps, by the libraries in `checkout`, and the error that ended them; None of a
    scene that does not run by itself, such as one under a drive. The step after them, the last one, has a length that
    may differ by rounding, and is left out."""
    os.environ["NERVURE_LIBRARIES"] = str(checkout / "target" / "release")
    scene = case.built()
    step = scene["time"]["communication_step"]
    scene["time"]["end"] = (STEPS + 1) * step
    try:
        with simulate.session(scene, rigid=case.options.get("rigid", False)) as session:
            error = session.run().error
            outputs = session.recorder.series.values()
            return b"".join(values[:-1].tobytes() for values in outputs) + (error or "").encode()
    except InputError:
        return None


WHOLE = """
import json, sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from studies import catalogue, engine
data = catalogue.load()
study, case = data.cases[sys.argv[1]]
with TemporaryDirectory() as folder:
    engine.execute(replace(case, options=case.options | {"repeats": 0}), Path(folder))
    run = engine.Run(Path(folder), **json.loads((Path(folder) / "run.json").read_text(encoding="utf-8")))
    data.records.clear()
    data.take(study, case, run)
record = data.records[sys.argv[1]]
print(json.dumps([record.values, record.tables, bool(record.error)]))
"""
"""Run the case of a name to its end, once, and print values, tables and failure of its record."""


def environment(checkout: Path) -> dict[str, str]:
    """Return the environment of a process that runs the code of a checkout."""
    return os.environ | engine.THREADS | {"PYTHONPATH": f"{checkout / 'python'}{os.pathsep}{checkout}"}


def hashes(digests: Iterable[str], checkout: Path, fresh: bool, jobs: int) -> dict[str, str]:
    """Return the hash of the first steps by recorded digest, from `checkout`; with `fresh` only if not stale there."""
    ordered = sorted(digests)

    def probe(part: list[str]) -> str:
        return subprocess.run(
            [sys.executable, "-c", PROBE], input=json.dumps([part, fresh]), env=environment(checkout), cwd=checkout,
            stdout=subprocess.PIPE, text=True, check=True,
        ).stdout  # fmt: skip

    with ThreadPoolExecutor(jobs) as pool:
        lines = [
            line for text in pool.map(probe, (ordered[i::jobs] for i in range(jobs))) for line in text.splitlines()
        ]
    return dict(line.split() for line in lines)


def runs_a_scene(record: Record) -> bool:
    """Whether a result is that of a run of its scene, whatever is evaluated of it."""
    return bool(record.case.scene) and record.get("cpu_s") is not None


def group(name: str) -> str:
    return "/".join(name.split("/")[:2])


def witnesses(records: Iterable[Record], everything: Data) -> dict[str, Record]:
    """Return the record that stands for each of `records`: the cheapest of its group, or else of its study."""
    plain = [r for r in everything.records.values() if runs_a_scene(r) and not r.error]
    plain.sort(key=lambda record: float(record["cpu_s"]), reverse=True)
    by_group = {group(record.name): record for record in plain}
    by_study = {record.name.split("/")[0]: record for record in plain}
    found = {}
    for record in records:
        own = by_group.get(group(record.name))
        found[record.name] = own if own and own["cpu_s"] <= CHEAP else by_study[record.name.split("/")[0]]
    return found


def dropped(record: Record) -> set[str] | None:
    """Run the case of a record to its end, once, in a process of its own; return the recorded values that its study no
    longer takes, or None if one that it takes is another."""
    done = subprocess.run(
        [sys.executable, "-c", WHOLE, record.name], env=environment(ROOT), cwd=ROOT, stdout=subprocess.PIPE, text=True,
        check=False,
    )  # fmt: skip
    values, *rest = json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else (None,)
    old = record.values.keys() - (values or {})
    kept = {name: value for name, value in record.values.items() if name not in old}
    same = [values, *rest] == [kept, record.tables, bool(record.error)]  # messages may have other words
    print(f"{record.name}, to its end: {'the same' if same else 'not the same'} values", flush=True)
    return old if same else None


def carry_over(data: Data, names: list[str], checkout: Path, jobs: int) -> list[str]:
    """Give stale results of the named studies that hold the digest of today; return their names."""
    records = [r for r in data.stale() if runs_a_scene(r) and (not names or r.name.split("/")[0] in names)]
    there = hashes({record.digest for record in records}, checkout, True, jobs)
    here = hashes(there, ROOT, False, jobs)
    records = [record for record in records if there.get(record.digest, "") == here.get(record.digest)]
    stand_ins = witnesses(records, data)
    needed = {record.name: record for record in stand_ins.values()}
    print(f"{len(records)} cases give the same first steps; {len(needed)} of them stand for all", flush=True)
    with ThreadPoolExecutor(jobs) as pool:
        old = dict(zip(needed, pool.map(dropped, needed.values()), strict=True))
    kept = [record for record in records if old[stand_ins[record.name].name] is not None]
    for record in kept:
        values = {n: v for n, v in record.values.items() if n not in (old[stand_ins[record.name].name] or ())}
        data.records[record.name] = replace(record, values=values, digest=record.case.digest, carried=True)
    return [record.name for record in kept]
