"""Results of a run: series.csv, summary.json, scene.json, and the table in the terminal."""

import json
import math
import os
import platform
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from nervure.evaluate import coefficients, flapping, statistics
from nervure.coupling import Single
from nervure.files import write_together
from nervure.master import Outcome
from nervure.pack.package import scene_text
from nervure.recorder import Recorder
from nervure.resources import ROOT
from nervure.scene import reference
from nervure.unit import Unit

QUANTITIES = ("tip_ux", "tip_uy", "tip_uz", "drag", "lift")
"""The outputs that are evaluated, as far as the units have them."""

MAIN_SIGNALS = ("tip_uy", "lift")
"""The first of these that there is decides on the periods."""

FORCES = ("drag", "lift")
"""The outputs that a box filter goes over before their extremes are taken."""

FILES = ("scene.json", "series.csv", "summary.json", "tip.png", "drag.png", "lift.png", "vorticity.png")
"""The files that a coupled run leaves in its folder, besides the FMUs."""

FURTHER_FILES = (
    "coefficients.png", "flapping.png", "vorticity.gif", "phases.png", "motion.png", "iterations.csv", "convergence.csv"
)  # fmt: skip
"""What a cylinder alone and a driven root leave besides, what `animate` makes of a run, and what an iterated scheme leaves."""

DISPLAY = {"m": ("mm", 1e3)}
"""Units that people read in another scale."""


def main_signal(columns: Sequence[str], column: Callable[[str], np.ndarray]) -> str | None:
    """Which of the recorded `columns` decides on the periods: where a root is driven, the tip along its main axis."""
    axis = flapping.main_axis(columns, column)
    signals = (f"tip_u{axis}", *MAIN_SIGNALS) if axis else MAIN_SIGNALS
    return next((signal for signal in signals if signal in columns), None)


def evaluate(recorder: Recorder, name: str) -> tuple[dict, statistics.Window | None, float]:
    """`quantities` of the summary for the scene called `name`, their window (None without a signal to take it from)
    and the width of the filter over forces (s)."""
    time, main = recorder.column("time"), main_signal(recorder.columns, recorder.column)
    if main is None or time.size < 3:
        return {}, None, 0.0
    window = statistics.find_window(time, recorder.column(main))
    width = statistics.force_filter_width(window)
    published = (reference(name) or {}).get("primary")

    quantities = {}
    for quantity in QUANTITIES:
        if quantity not in recorder.columns:
            continue
        values = recorder.column(quantity)
        if quantity in FORCES:
            values = statistics.box_filter(time, values, width)
        extremes = statistics.evaluate(time, values, window)
        oscillates = extremes.frequency_hz is not None
        quantities[quantity] = asdict(extremes) | {
            "unit": recorder.unit_of[quantity],
            "fit": asdict(statistics.fit(time, values, window)) if oscillates else None,
        }
        if published and quantity in published.get("quantities", {}):
            quantities[quantity]["reference"] = published["quantities"][quantity] | {"source": published["source"]}
    return quantities, window, width


def summarize(scene: dict, units: dict[str, Unit], scheme: Single, recorder: Recorder, outcome: Outcome) -> dict:
    """Everything that summary.json holds."""
    quantities, window, width = evaluate(recorder, scene["name"])
    time = recorder.column("time")
    iterations = recorder.column("iterations")[1:]
    main = main_signal(recorder.columns, recorder.column) if quantities else None
    scale = coefficients.scale(scene) if quantities else None
    dimensionless = coefficients.evaluate(scale, recorder, window, width) if scale else {}
    published = reference(scene["name"])
    inside = {kind: unit.seconds for kind, unit in units.items()}
    return {
        "scene": scene["name"],
        "completed": outcome.completed,
        "error": outcome.error,
        "quantities": quantities,
        "coefficients": {
            "values": dimensionless,
            "reference": coefficients.published(published),
            "source": (published or {}).get("primary", {}).get("source"),
        }
        if dimensionless
        else None,
        "flapping": flapping.evaluate(scene, recorder, window),
        "window_s": [window.begin, window.end] if window else None,
        "periods": window.periods if window else 0,
        "amplitude_drift": statistics.drift(time, recorder.column(main), window) if main else None,
        "method": {
            "coupling": scheme.choice,
            "communication_step_s": scene["time"]["communication_step"],
            "statistics": "mean = (max + min) / 2 and amplitude = (max - min) / 2 over the window, frequency by upward "
            f"crossings of the mean; forces under a box filter of {width * 1e3:.3g} ms; `fit`: the same of the "
            f"least-squares fit of {statistics.HARMONICS} harmonics",
            "amplitude_drift": f"change of the amplitude of {main} from the first to the second half of the window, "
            "relative",
        },
        "interface": interface(recorder),
        "simulated_s": outcome.simulated,
        "wall_s": outcome.wall,
        "cpu_s": outcome.cpu,
        "wall_s_per_simulated_s": outcome.wall / outcome.simulated if outcome.simulated else None,
        "steps": outcome.steps,
        "iterations_mean": float(iterations.mean()) if iterations.size else None,
        "phases_s": inside | {"exchange_and_python": outcome.wall - sum(inside.values())},
        "units": {
            kind: {
                "model": unit.description.modelName,
                "version": unit.description.version,
                "generation_tool": unit.description.generationTool,
                "guid": unit.description.guid,
            }
            for kind, unit in units.items()
        },
        "versions": {"python": platform.python_version()} | {name: version(name) for name in ("fmpy", "numpy")},
        "git": git_revision(),
        "machine": {"cpu": cpu_model(), "cores": os.cpu_count(), "system": platform.platform()},
    }


def interface(recorder: Recorder) -> dict | None:
    """Work done across the interface, J, by what the rod took and by what the fluid exerted; None where a unit does not
    tell."""
    if not {"load_work", "beam_work"} <= set(recorder.columns):
        return None
    took, gave = (recorder.column(name) for name in ("load_work", "beam_work"))
    exchanged = float(np.abs(np.diff(gave)).sum())
    return {
        "work_on_rod": float(took[-1]),
        "work_by_fluid": float(gave[-1]),
        "exchanged": exchanged,
        "imbalance": float(took[-1] - gave[-1]) / exchanged if exchanged else None,
    }


def write(folder: Path, scene: dict, recorder: Recorder, scheme: Single, summary: dict) -> None:
    """Write scene.json, series.csv, the scheme's logs and summary.json into `folder`, in the place of the results of an
    earlier run: where one cannot be written those stay, else nothing of theirs does."""
    folder.mkdir(parents=True, exist_ok=True)

    def series(path: Path):
        header = ",".join(recorder.columns)
        np.savetxt(path, recorder.table[: recorder.rows], "%.10g", ",", header=header, comments="")

    text = json.dumps(json_numbers(summary), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    writers = {
        "scene.json": lambda path: path.write_text(scene_text(scene), encoding="utf-8"),
        "series.csv": series,
        "summary.json": lambda path: path.write_text(text, encoding="utf-8"),
    }
    for name, log in scheme.logs().items():
        header = ",".join(log.dtype.names)
        writers[f"{name}.csv"] = partial(np.savetxt, X=log, fmt="%.10g", delimiter=",", header=header, comments="")
    write_together(folder, writers)
    for name in {*FILES, *FURTHER_FILES} - writers.keys():
        (folder / name).unlink(missing_ok=True)


def print_table(console: Console, summary: dict) -> None:
    """Show quantities against the reference, window and cost."""
    table = Table("quantity", title=summary["scene"])
    for heading in ("computed", "reference", "difference"):
        table.add_column(heading, justify="right")

    def difference(value: float | None, expected: float | None) -> str:
        return f"{(value / expected - 1) * 100:+.1f} %" if value is not None and expected else ""

    for name, quantity in summary["quantities"].items():
        unit, scale = DISPLAY.get(quantity["unit"], (quantity["unit"], 1.0))
        published = quantity.get("reference", {})
        for what, shown, factor in (("mean", unit, scale), ("amplitude", unit, scale), ("frequency_hz", "Hz", 1.0)):
            value, expected = quantity[what], published.get(what)
            label = what.removesuffix("_hz")
            cells = [f"{v * factor:.4g}" if v is not None else "–" for v in (value, expected)]
            table.add_row(f"{name} {label} [{shown}]".replace("[", r"\["), *cells, difference(value, expected))
    found = summary["coefficients"] or {"values": {}}
    for name, value in found["values"].items():
        expected = found["reference"].get(name)
        cells = [f"{v:.6g}" if v is not None else "–" for v in (value, expected)]
        table.add_row(name.replace("_", " "), *cells, difference(value, expected))
    for name, value in (summary["flapping"] or {}).items():
        if isinstance(value, float):
            table.add_row(name.replace("_", " "), f"{value:.4g}", "–", "")
    console.print(table)
    if summary["window_s"]:
        begin, end = summary["window_s"]
        drift = summary["amplitude_drift"]
        steady = "" if drift is None else f", amplitude drift {drift * 100:+.1f} %"
        console.print(f"window {begin:.3f} – {end:.3f} s, {summary['periods']} periods{steady}")
    if summary["interface"] and summary["interface"]["imbalance"] is not None:
        work = "interface: work on the rod {work_on_rod:.4g} J, by the fluid {work_by_fluid:.4g} J, {imbalance:+.1%} of {exchanged:.4g} J"
        console.print(work.format(**summary["interface"]), soft_wrap=True)
    phases = ", ".join(f"{phase.replace('_', ' ')} {seconds:.1f} s" for phase, seconds in summary["phases_s"].items())
    reached = f"{summary['steps']} steps to t = {summary['simulated_s']:g} s"
    console.print(f"{reached} in {summary['wall_s']:.1f} s of wall time ({phases})", soft_wrap=True)


def json_numbers(value):
    """`value` with null for the numbers that JSON does not have: a run that failed can leave infinities."""
    if isinstance(value, dict):
        return {key: json_numbers(part) for key, part in value.items()}
    if isinstance(value, list):
        return [json_numbers(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def git_revision() -> dict | None:
    """Revision of the working tree and whether files of it but documents have changed; None outside of git."""

    def git(*arguments):
        return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()

    try:
        changed = git("status", "--porcelain", "--untracked-files=no", "--", ":!docs", ":!README.md")
        return {"revision": git("rev-parse", "HEAD"), "dirty": bool(changed)}
    except (OSError, subprocess.CalledProcessError):
        return None


def cpu_model() -> str:
    """What the system calls the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()
