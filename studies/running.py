"""What it costs to keep frames and checkpoints of a run, to start and end one, and to exchange: a minute."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median
from time import perf_counter
from typing import Any

from nervure import checkpoint, master
from nervure.output import fields
from nervure.scene import validate
from studies import simulate
from studies.engine import COUPLED, Case, Study

SCENES = ("fsi3-325x72", "fsi3-650x144", "fsi3-1300x288")
REPEATS, STEPS = 10, 10  # Frames and checkpoints that are written, and steps before a frame
STARTS = 7  # Runs of one step, and of some
SOME = 500  # Steps


def measure(case: Case, folder: Path) -> dict[str, Any]:
    """Shortest wall times of a step, a frame and a checkpoint, ms, on the disk that `results` is on, and the size of a
    checkpoint at the end of the run, MB."""
    scene = case.built()
    spent: dict[str, list[float]] = {"step": [], "frame": [], "checkpoint": []}

    def timed(what: str, action: Any, *arguments: Any) -> None:
        begin = perf_counter()
        action(*arguments)
        spent[what].append(1e3 * (perf_counter() - begin))

    with ExitStack() as stack:
        units, scheme, clock, recorder = simulate.assemble(scene, folder, stack)
        frames = fields.Fields(folder, validate(scene), units, clock, STEPS * clock.communication_step, 0)
        stack.callback(frames.close)
        write, saved = frames.watch(print), checkpoint.Checkpoint(folder, validate(scene), {}, units, scheme, recorder)
        scheme.start()
        recorder.table[:] = 0.0
        recorder.record(0, 0.0, 0)
        for i in range(REPEATS * STEPS):
            t, h = clock.step(i)
            timed("step", scheme.step, t, h)
            recorder.record(i + 1, t + h, 1)
            if (i + 1) % STEPS == 0:
                timed("frame", write, i + 1, t + h, 0.0)
        recorder.rows = len(recorder.table)  # as many rows as at the end of a whole run
        for _ in range(REPEATS):
            timed("checkpoint", saved.save, clock.steps, 0.0)
        size = (folder / checkpoint.FILE).stat().st_size
    fields.clear(folder)
    checkpoint.clear(folder)
    shortest = {f"{what}_ms": round(min(found), 3) for what, found in spent.items()}
    return shortest | {"checkpoint_mb": round(size / 1e6, 2)}


def start(case: Case, folder: Path) -> dict[str, Any]:
    """Median processor time of the command for a run of one step, s: imports, packing, pictures and exit."""
    end, spent = f"--end-time={case.built()['time']['communication_step']}", []
    for _ in range(STARTS):
        before = getrusage(RUSAGE_CHILDREN)
        command = [sys.executable, "-m", "nervure", "run", case.scene, end, "--quiet", "--force"]
        subprocess.run([*command, f"--output={folder / 'start'}"], check=True)
        after = getrusage(RUSAGE_CHILDREN)
        spent.append(after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)
    return {"start_s": median(spent)}


def exchange(case: Case, folder: Path) -> dict[str, Any]:
    """Median share of a run's wall time that is neither the rod's nor the fluid's: setting, getting, recording, and
    Python."""
    scene, shares = case.built(), []
    scene["time"]["end"] = SOME * scene["time"]["communication_step"]
    for _ in range(STARTS):
        with ExitStack() as stack:
            units, scheme, clock, recorder = simulate.assemble(scene, folder, stack)
            wall = master.run(scheme, clock, recorder).wall
            shares.append(1 - sum(unit.seconds for unit in units.values()) / wall)
    return {"exchange_share": median(shares)}


def cases() -> Iterator[Case]:
    for scene in SCENES:
        yield Case(f"keeping/{scene}", (*COUPLED, "keeping"), scene, action=measure)
    yield Case(f"start/{SCENES[0]}", (*COUPLED, "command"), SCENES[0], action=start)
    yield Case(f"exchange/{SCENES[1]}", (*COUPLED, "command"), SCENES[1], action=exchange)


STUDY = Study("running", cases, lambda case, run: {"times": run.found})
