"""A scene, run several times in a process of its own: `python worker.py REPEATS < scene.json` prints one JSON object.

One run goes before the others and is not timed; with 0 repeats it is the only one and is timed. Phases are the
shortest of the
timed runs, each for itself. What is timed is the loop over the steps, with Python and FMI in it, without
loading, packing and evaluation; `output` is what writing the tables takes after it. Memory is what the resident set has grown by from before the units are loaded to the
end of that first run.
"""

import ctypes
import json
import resource
import sys
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from time import perf_counter, process_time

sys.path.insert(0, str(Path(__file__).parents[1]))

from nervure import master, report, simulation
from nervure.pack import package
from nervure.errors import Refusal


def resident() -> float:
    """Resident set of this process, MB, without what is free: packing has had the units' memory before."""
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def timed(call: Callable, seconds: dict[str, float], phase: str) -> Callable:
    """`call`, whose wall time is added to `seconds[phase]`."""

    def wrapped(*arguments):
        begin = perf_counter()
        result = call(*arguments)
        seconds[phase] += perf_counter() - begin
        return result

    return wrapped


def once(scene: dict, fmus: dict[str, Path]) -> tuple[dict, list[float]]:
    """Summary of a run with the memory it has added, and its wall and CPU time, s."""
    with ExitStack() as stack:
        before = resident()
        units, scheme, clock, recorder = simulation.assemble(scene, fmus, stack)
        seconds = {"fmi": 0.0, "recording": 0.0, "output": 0.0}
        for unit in units.values():
            unit.set, unit.get = (timed(call, seconds, "fmi") for call in (unit.set, unit.get))
        recorder.record = timed(recorder.record, seconds, "recording")
        begin = process_time()
        outcome = master.run(scheme, clock, recorder)
        times = [outcome.wall, process_time() - begin]
        memory = resident() - before
        summary = report.summarize(scene, units, scheme, recorder, outcome)
        with tempfile.TemporaryDirectory() as folder:
            timed(report.write, seconds, "output")(Path(folder), scene, recorder, scheme, summary)
        phases = summary["phases_s"]
        phases["python"] = phases.pop("exchange_and_python") - seconds["fmi"] - seconds["recording"]
        phases |= seconds
        return summary | {"last": recorder.latest, "memory_mb": memory}, times


def main() -> None:
    repeats, scene = int(sys.argv[1]), json.load(sys.stdin)
    with tempfile.TemporaryDirectory() as folder:
        try:
            fmus = {kind: package.pack(kind, scene, Path(folder)) for kind in package.kinds(scene)}
            summary, first = once(scene, fmus)
            more = [once(scene, fmus) for _ in range(repeats)] if summary["error"] is None else []
        except Refusal as error:
            print(json.dumps({"error": str(error)}))
            return
    kept = (
        "error",
        "quantities",
        "coefficients",
        "phases_s",
        "wall_s",
        "steps",
        "iterations_mean",
        "periods",
        "last",
        "memory_mb",
    )
    timed = more or [(summary, first)]
    found = {key: summary[key] for key in kept} | {"runs": [times for _, times in timed]}
    found["phases_s"] = {phase: min(run["phases_s"][phase] for run, _ in timed) for phase in summary["phases_s"]}
    print(json.dumps(report.json_numbers(found)))


if __name__ == "__main__":
    main()
