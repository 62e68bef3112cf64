"""What it costs to keep frames and checkpoints of a run, and docs/running.csv of it: half a minute.

    python scripts/studies/keeping.py

Shortest wall times of a step, a frame and a checkpoint, in one process, on the disk that `results` is on.
"""

import sys
from contextlib import ExitStack
from pathlib import Path
from time import perf_counter

import typer



from nervure import checkpoint, simulation
from nervure.pack import package
from nervure.show import fields
from nervure.files import write_csv
from nervure.resources import ROOT, SCENES
from nervure.scene import load

RESULTS, TABLE = ROOT / "results" / "keeping", ROOT / "docs" / "running.csv"
NAMES = ("fsi3-325x72", "fsi3-650x144", "fsi3-1300x288")
REPEATS, STEPS = 10, 10
"""Frames and checkpoints that are written, and steps before a frame."""


def measure(name: str, folder: Path) -> dict:
    """Times, ms, and the size of a checkpoint at the end of the run, MB."""
    scene, spent = load(SCENES / f"{name}.json"), {"step": [], "frame": [], "checkpoint": []}

    def timed(what: str, action, *arguments) -> None:
        begin = perf_counter()
        action(*arguments)
        spent[what].append(1e3 * (perf_counter() - begin))

    with ExitStack() as stack:
        fmus = {kind: package.pack(kind, scene, folder) for kind in package.KINDS}
        units, scheme, clock, recorder = simulation.assemble(scene, fmus, stack)
        frames = fields.Fields(folder, scene, units, clock, STEPS * clock.communication_step, 0)
        stack.callback(frames.close)
        write, saved = frames.watch(print), checkpoint.Checkpoint(folder, scene, {}, units, scheme, recorder)
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
    times = {f"{what}_ms": round(min(found), 3) for what, found in spent.items()}
    return {"scene": name} | times | {"checkpoint_mb": round(size / 1e6, 2)}


def main() -> None:
    """Measure on each grid of FSI3."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    rows = [measure(name, RESULTS) for name in NAMES]
    write_csv(TABLE, rows)
    fields.clear(RESULTS)
    checkpoint.clear(RESULTS)


if __name__ == "__main__":
    typer.run(main)
