"""Which stale results hold all the same: of scenes that the units of today give the same bits for as those of the
revision that the results were made on.

A case is carried over where it is a plain run of a scene, was run on the sources in a checkout of that revision, where
of these only the units have changed since, and where both give the same outputs over the first steps, to the last bit.
"""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory

from nervure import master
from nervure.errors import InputError
from nervure.recorder import Recorder
from nervure.resources import ROOT
from studies import simulate
from studies.engine import UNITS, Case, simulated, source_digest
from studies.store import Data, Record

STEPS = 20
"""Communication steps that are compared: each of them runs all of the code that the scene needs."""


def first_steps(case: Case, checkout: Path) -> bytes:
    """What the units built in a checkout give for the scene of a case over the first steps, and how that ends."""
    os.environ["NERVURE_LIBRARIES"] = str(checkout / "target" / "release")
    scene = case.built()
    step = scene["time"]["communication_step"]
    scene["time"]["end"] = STEPS * step
    with TemporaryDirectory() as folder, ExitStack() as stack:
        try:
            units, scheme, _, _ = simulate.assemble(scene, Path(folder), stack, case.options.get("rigid", False))
        except InputError as error:
            return str(error).encode()
        recorder = Recorder(units, STEPS)
        outcome = master.run(scheme, master.Clock(STEPS * step, step), recorder)
        return b"".join(values.tobytes() for values in recorder.series.values()) + (outcome.error or "").encode()


def comparable(record: Record, checkout: Path) -> bool:
    """Whether a stale result is of a plain run on the sources in the checkout, of which only the units have changed."""
    case = record.case
    if case.action is not simulated:
        return False
    others = set(case.sources) - set(UNITS)
    unchanged = all(source_digest(room, ROOT) == source_digest(room, checkout) for room in others)
    return unchanged and record.digest == case.digest_on(checkout)


def holds(case: Case, checkout: Path) -> bool:
    """Whether the units of today give the same bits for a case as those in the checkout."""
    return first_steps(case, ROOT) == first_steps(case, checkout)


def carry_over(data: Data, names: list[str], checkout: Path, jobs: int) -> list[str]:
    """Let those of the named cases that hold have the digest of today; their names."""
    records = [record for record in data.stale() if record.name.split("/")[0] in names]
    records = [record for record in records if comparable(record, checkout)]
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        held = pool.map(partial(holds, checkout=checkout), [record.case for record in records])
        kept = [record for record, same in zip(records, held) if same]
    for record in kept:
        data.records[record.name] = replace(record, digest=record.case.digest, carried=True)
    return [record.name for record in kept]
