"""FSI3: its grids, what moves it, the thesis' own settings, and docs/fsi3/runs.json of it.

    python scripts/studies/fsi3.py                    run what is missing, then write docs/fsi3/runs.json
    python scripts/studies/fsi3.py --list             the runs and what is known of them
    python scripts/studies/fsi3.py --only 'coarse/*'  run only those

Every run has a folder in results/fsi3-study. It is made again only where its scene or a library has changed.
"""

import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import Annotated

import numpy as np
import typer



from nervure import sweep
from nervure.evaluate import statistics
from nervure.files import rounded, write_whole
from nervure.resources import ROOT, SCENES
from nervure.scene import customized

RESULTS = ROOT / "results" / "fsi3-study"
RUNS = ROOT / "docs" / "fsi3" / "runs.json"

QUANTITIES = ("tip_ux", "tip_uy", "drag", "lift")

COARSE, FINE, STILL, THESIS = "fsi3-325x72", "fsi3-650x144", "cfd3-650x144", "fsi3-thesis-325x72"


def on_grid(nx: int, ny: int, step: float) -> tuple[str, ...]:
    return f"fluid.box.cells=[{nx},{ny}]", f"time.communication_step={step}", f"fluid.time_stepping.max_step={step}"


NO_SHEAR = "rod.material.plane_strain.shear_factor=null"
PRESSURE_JUMP = 'coupling={"load":"pressure_jump"}'
COSINE = 'fluid.mask={"cosine":{"c_eta":1e-4,"half_width":1.0}}'

GRIDS = {
    "325x72": (COARSE,),
    "650x144": (FINE,),
    "960x216": (FINE, *on_grid(960, 216, 1.3e-4)),
    "1300x288": ("fsi3-1300x288",),
}
"""Scene and changes of each grid."""

VARIED = {
    COARSE: (
        ("time.communication_step=2e-4",),
        ("time.communication_step=1e-4",),
        ("beam.segments=84",),
        ("beam.segments=21",),
        (NO_SHEAR, "rod.clamp_setback=0"),
        ('rod.scheme={"generalised_alpha":{"rho_inf":0.5}}',),
        (PRESSURE_JUMP,),
        ("fluid.filter=two_thirds",),
        ("fluid.mask.log_linear.target=none",),
        (COSINE,),
        ("time.end=30",),
    ),
    FINE: (
        (NO_SHEAR,),
        ("rod.clamp_setback=0",),
        ("beam.segments=21",),
        ("beam.segments=60",),
        ("rod.material.plane_strain.density=1050",),
        ("fluid.mask.log_linear.c_eta=1e-4",),
        ("fluid.mask.log_linear.c_eta=1e-6",),
        ("fluid.inflow.c_eta=1e-3",),
        ("fluid.box.x=[-0.46538,2.5]", "fluid.box.cells=[720,144]", "fluid.inflow.x=[-0.46538,0]"),
        ("fluid.box.x=[-0.1771,2.78828]", "fluid.box.cells=[720,144]"),
        ("fluid.filter=two_thirds",),
        ("fluid.mask.log_linear.target=none",),
        (COSINE,),
    ),
}
"""One change at a time."""

BOX_SHORT = ("time.end=0.15", "fluid.inflow.mean_velocity.cosine_ramp.duration=0.5", PRESSURE_JUMP)
RATIOS, ACCELERATIONS = (1, 0.1, 0.01), ("iqn_ils", "aitken")

EXCHANGE_RAMP = "fluid.inflow.mean_velocity.cosine_ramp.duration=0.2"
EXCHANGE_STEPS = (4e-4, 2e-4, 1e-4)
EXCHANGE_WINDOWS = {"first": (0.0, 0.5), "swinging": (1.2, 1.6)}
"""Times over which both sides of the interface are compared, s."""

LEVEL_2 = ("fluid.box.cells=[650,144]", "beam.segments=85", "time.communication_step=7e-5", "fluid.time_stepping.max_step=7e-5")
RAMP = ("fluid.initial_velocity=[0,0]", 'fluid.inflow.mean_velocity={"cosine_ramp":{"value":2.0,"duration":2.0}}')
THESIS_RUNS = {
    "none": (),
    "mask": ("fluid.mask.cosine.displacement_corrected=true",),
    "calibration": ("rod.calibration=second_order",),
    "ramp": RAMP,
    "level 2": ("time.end=4.375", *LEVEL_2),
}

TRAPEZOID = "rod.scheme=trapezoid"
WAVES = {
    "none": (TRAPEZOID,),
    "invariant": (TRAPEZOID, "rod.bending=invariant"),
    "second order": (TRAPEZOID, "rod.calibration=second_order"),
    "ramp": (TRAPEZOID, "time.end=2", *RAMP),
    "half step": (TRAPEZOID, "time.communication_step=4.375e-5"),
    "iterated": (TRAPEZOID, 'coupling.scheme={"iterated":{"tolerance":1e-2,"max_iterations":100}}'),
    "level 2": (TRAPEZOID, *LEVEL_2),
    "generalised-alpha": ("time.end=2", 'rod.scheme={"generalised_alpha":{"rho_inf":0.8}}'),
    "bdf2": ("time.end=2",),
    "bdf2, iterated": ("time.end=0.2", 'coupling.scheme={"iterated":{"tolerance":1e-2,"max_iterations":100}}'),
}
"""Short waves on the rod under the pressure jump. Without a scheme in it: the scene's own, bdf2."""

THESIS_WINDOWS = ((1.1, 4.375), (3.5, 4.375))
"""Over which the thesis takes its extremes (table 4.2), and the part that it calls more accurate, s."""

PIECE, TREND = 0.02, 4
"""Length of the pieces in which short waves are looked for, s, and the degree of the polynomial that is not a wave."""

LARGE = 1.0
"""Velocity of the tip, m/s, up to which a wave grows exponentially."""

PICTURES = ("tip.png", "drag.png", "lift.png", "vorticity.png")
"""Of the run on 650 x 144, for docs/fsi3."""

SAMPLES, SHOWN_PERIODS = 240, 2
"""Points of the series that are kept of each grid, and the periods that they span."""


@dataclass(frozen=True)
class Run:
    """A scene with some keys changed."""

    name: str
    """Group and label."""
    scene: str
    changes: tuple[str, ...] = ()

    @property
    def folder(self) -> Path:
        return RESULTS / "".join(c if c.isalnum() or c in ".-" else "_" for c in self.name)

    @property
    def command(self) -> str:
        sets = "".join(f" --set '{change}'" for change in self.changes)
        return f"nervure run scenes/{self.scene}.json{sets}"

    def case(self) -> sweep.Case:
        return sweep.grid([customized(SCENES / f"{self.scene}.json", list(self.changes))], [])[0]


def runs() -> Iterator[Run]:
    for grid, (scene, *changes) in GRIDS.items():
        yield Run(f"grid/{grid}", scene, tuple(changes))
    yield Run("still/650x144", STILL)
    yield Run("still/1300x288", STILL, on_grid(1300, 288, 1.25e-4))
    for scene, group in ((COARSE, "coarse"), (FINE, "fine")):
        for changes in VARIED[scene]:
            yield Run(f"{group}/{', '.join(changes)}", scene, changes)
    for ratio in RATIOS:
        for name in ACCELERATIONS:
            changes = (
                *BOX_SHORT,
                f"rod.material.plane_strain.density={1000 * ratio:g}",
                f'coupling.scheme={{"iterated":{{"acceleration":"{name}"}}}}',
            )
            yield Run(f"iterations/{ratio:g}, {name}", COARSE, changes)
    for segments in (30, 42):
        for step in EXCHANGE_STEPS:
            # The shipped number of segments is looked at from the start only, the smallest step as well.
            end = "0.5" if segments == 42 or step == EXCHANGE_STEPS[-1] else "1.6"
            changes = (EXCHANGE_RAMP, f"time.end={end}", f"beam.segments={segments}", f"time.communication_step={step}")
            yield Run(f"exchange/{segments}, {step:g}", COARSE, changes)
    for name, changes in THESIS_RUNS.items():
        yield Run(f"thesis/{name}", THESIS, changes)
    for name, changes in WAVES.items():
        yield Run(f"waves/{name}", THESIS, changes)


# What is kept of a run


def settled(summary: dict) -> dict[str, float]:
    """Statistics over the summary's own window, in SI units; what a signal does not have is left out."""
    found = {"periods": summary["periods"], "amplitude_drift": summary["amplitude_drift"]}
    if summary["window_s"]:
        found["window.begin"], found["window.end"] = summary["window_s"]
    if summary["interface"]:
        found["imbalance"] = summary["interface"]["imbalance"]
    for name in QUANTITIES:
        part = summary["quantities"].get(name)
        if part is None:
            continue
        for what in ("mean", "amplitude", "frequency_hz"):
            found[f"{name}.{what}"] = part[what]
        if part["fit"]:
            found[f"{name}.fit"] = part["fit"]["amplitude"]
    return {key: value for key, value in found.items() if value is not None}


def largest(series: np.ndarray) -> dict[str, float]:
    """The largest CFL number, and the mean magnitude of the difference of the powers on both sides by that of the fluid's."""
    found = {"cfl": series["cfl"].max()}
    if "load_power" in series.dtype.names:
        gave = series["beam_power"]
        found["powers"] = np.abs(series["load_power"] - gave).mean() / np.abs(gave).mean()
    return found


def extremes(series: np.ndarray) -> dict[str, float]:
    """Largest and smallest drag, lift (N/m) and deflection (m) over the thesis' windows, unfiltered."""
    found = {}
    for begin, end in THESIS_WINDOWS:
        part = (series["time"] >= begin) & (series["time"] <= end)
        if part.any():
            for name in ("drag", "lift", "tip_uy"):
                found[f"{name}.max, from {begin:g} s"] = series[name][part].max()
                found[f"{name}.min, from {begin:g} s"] = series[name][part].min()
    return found


def waves(series: np.ndarray) -> dict[str, float]:
    """Waves in the tip's velocity that are shorter than a piece: rate at which they grow or decay, 1/s, to which time, s,
    their size there, m/s, and their frequency, Hz."""
    time, sizes = series["time"], []
    starts = np.arange(2 * PIECE, time[-1] - PIECE, PIECE)
    for start in starts:
        part = (time >= start) & (time < start + PIECE)
        t, v = time[part] - start, series["tip_vy"][part]
        rest = v - np.polyval(np.polyfit(t, v, TREND), t)
        if rest.std() > LARGE:
            break
        sizes.append(rest.std())
        strongest = np.abs(np.fft.rfft(rest * np.hanning(rest.size))).argmax() / PIECE
    if len(sizes) < 3:
        return {}
    rate = np.polyfit(starts[: len(sizes)], np.log(sizes), 1)[0]
    reached = starts[len(sizes) - 1] + PIECE
    return {"growth": rate, "growth.to": reached, "growth.size": sizes[-1], "growth.frequency_hz": strongest}


def exchange(series: np.ndarray) -> dict[str, float]:
    """Differences of what the rod took and the fluid exerted: rms of the lift's by that of the lift; sum of the magnitudes
    of the work's, step by step, by that of the work exchanged; net work by the same."""
    found = {}
    for name, (begin, end) in EXCHANGE_WINDOWS.items():
        part = series[(series["time"] > begin) & (series["time"] <= end)]
        if series["time"][-1] < end - 1e-9:
            continue
        took, gave = np.diff(part["load_work"]), np.diff(part["beam_work"])
        exchanged = np.abs(gave).sum()
        found[f"{name}.lift"] = np.std(part["load_y"] - part["beam_load_y"]) / np.std(part["beam_load_y"])
        found[f"{name}.work"] = np.abs(took - gave).sum() / exchanged
        found[f"{name}.net"] = (took - gave).sum() / exchanged
        found[f"{name}.tip"] = np.ptp(part["tip_uy"]) / 2
    return found


def last_periods(series: np.ndarray) -> dict[str, list[float]]:
    """The last whole periods, from an upward crossing of uy on, by the fundamental frequency."""
    time, uy = series["time"], series["tip_uy"]
    window = statistics.find_window(time, uy)
    period = (window.end - window.begin) / window.periods
    at = np.linspace(window.end - SHOWN_PERIODS * period, window.end, SAMPLES)
    width = statistics.force_filter_width(window)
    found = {"phase": (at - at[0]) / period, "period_s": period}
    for name in QUANTITIES:
        values = statistics.box_filter(time, series[name], width) if name in ("drag", "lift") else series[name]
        found[name] = np.interp(at, time, values)
    return {key: np.asarray(value).tolist() for key, value in found.items()}


FURTHER: dict[str, Callable[[np.ndarray], dict[str, float]]] = {
    "grid": lambda series: extremes(series) | waves(series),
    "thesis": extremes,
    "waves": waves,
    "exchange": exchange,
}
"""What is made of the series of a group's runs, besides the summary."""


def kept(run: Run) -> dict | None:
    """What runs.json has of a run that was made."""
    if not (run.folder / "summary.json").is_file():
        return None
    summary, scene = (json.loads((run.folder / name).read_text(encoding="utf-8")) for name in ("summary.json", "scene.json"))
    series = np.genfromtxt(run.folder / "series.csv", delimiter=",", names=True)
    group = run.name.split("/")[0]
    found = {
        "name": run.name,
        "command": run.command,
        "cells": scene["fluid"]["box"]["cells"],
        "step": scene["time"]["communication_step"],
        "reached": summary["simulated_s"],
        "error": summary["error"],
        "iterations": summary["iterations_mean"],
        "wall_s": summary["wall_s"],
        "cpu_s": summary["cpu_s"],
        "phases_s": summary["phases_s"],
        "machine": summary["machine"] | {"packages": summary["versions"], "git": summary["git"]},
        "quantities": settled(summary) | largest(series) | FURTHER.get(group, lambda _: {})(series),
    }
    if group == "grid":
        found["series"] = last_periods(series)
    return found


# Running


def execute(run: Run) -> str:
    """Make a run, in this process; returns how it ended."""
    case = run.case()
    ended = sweep.one(case.scene, run.folder)
    (run.folder / "key").write_text(case.key, encoding="utf-8")
    return ended["reason"] or f"{ended['wall_s']:.0f} s"


def known(run: Run) -> bool:
    key = run.folder / "key"
    return key.is_file() and key.read_text(encoding="utf-8") == run.case().key


def write_runs() -> None:
    """docs/fsi3/runs.json, a line for each run that was made, and the pictures of one of them."""

    for name in PICTURES:
        shown = RESULTS / "grid_650x144" / name
        if shown.is_file():
            write_whole(RUNS.parent / name, lambda path: shutil.copy(shown, path))
    made = [json.dumps(rounded(found), ensure_ascii=False) for found in map(kept, runs()) if found]
    write_whole(RUNS, lambda path: path.write_text("[\n" + ",\n".join(made) + "\n]\n", encoding="utf-8"))


def main(
    only: Annotated[str, typer.Option(metavar="PATTERN", help="Make only the runs of this name.")] = "*",
    listing: Annotated[bool, typer.Option("--list", help="List the runs and make none.")] = False,
    jobs: Annotated[int, typer.Option(help="Runs at a time, each in a process of one thread.")] = 1,
) -> None:
    """Make what is missing, and write docs/fsi3/runs.json."""
    chosen = [run for run in runs() if fnmatch(run.name, only)]
    if listing:
        for run in chosen:
            typer.echo(f"{'known  ' if known(run) else 'missing'} {run.name}")
        return
    missing = [run for run in chosen if not known(run)]
    os.environ |= {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
    with ProcessPoolExecutor(jobs, max_tasks_per_child=1) as pool:
        for run, ended in zip(missing, pool.map(execute, missing)):
            typer.echo(f"{run.name}: {ended}")
    write_runs()


if __name__ == "__main__":
    typer.run(main)
