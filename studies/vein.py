"""The flapping vein: shipped scenes, convergence, stiffness, couplings, limits, and an oscillating cylinder."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from nervure.evaluate import flapping, statistics
from nervure.scene import validate
from nervure.scene.facts import Facts
from studies import limits, show, simulate
from studies.engine import COUPLED, FLUID, Case, Run, Study
from studies.limits import FORCE_WIDTH, FORCES, LIMITS, PITCHING, STIFF
from studies.simulate import on_grid

FORWARD, HOVER, SPACE = "vein-forward-384x192", "vein-hover-288x256", "vein-3d"
CYLINDER, SWINGING = "cylinder-oscillating-460x100", "fsi3-648x108"

STIFFNESS = "rod.material.section.bending_stiffness"

END = 3.02  # End of the pitching runs, s: the tip is settled in the third period, which is averaged
COUPLED_END, AT = 2.05, 1.5  # End of the runs under other couplings, s, and the time at which their tips are compared
NOISE_WIDTH = 0.08
"""Width of the box filter, s, applied twice; the remainder is called noise of the oscillating cylinder. A fiftieth of
the period, in which the cylinder passes one to six cells at its fastest."""

FSI3_PERIOD = 1 / 5.46  # s, of the benchmark

PARTS: dict[str, dict[str, Any]] = simulate.LISTED["vein"]["parts"]
COUPLINGS: dict[str, dict[str, Any]] = simulate.LISTED["vein"]["coupling"]
PART_STEPS, PART_REPEATS = 40, 9

MEANS = ("thrust", "lift", "power_in", "efficiency", "tip_amplitude", "tip_by_rigid_tip", "phase_lag_deg", "periods")
"""Recorded averages of a flapping vein."""


def tutorial() -> dict[str, Any]:
    """Return the scene of the tutorial."""
    text = (show.DOCS / "guide" / "tutorial.md").read_text(encoding="utf-8")
    (scene,) = re.findall(r"```json\n(.*?)```", text, re.DOTALL)
    found: dict[str, Any] = json.loads(scene)
    return found


def cases() -> Iterator[Case]:
    def case(name: str, scene: str, changes: dict[str, Any], **options: Any) -> Case:
        named = {"name": name.replace("/", "-").replace(" ", "-").replace(",", "")} | changes
        return Case(name, FLUID if scene == CYLINDER else COUPLED, scene, named, options)

    for scene, said in {SPACE: "in space", FORWARD: "forward", HOVER: "hover", PITCHING: "pitching"}.items():
        yield Case(f"scene/{scene}", COUPLED, scene, about={"name": said})
    for stiffness in (0.5, 1, 2, 4, 8, 16, 32, 64, 128):
        yield case(f"flexibility/{stiffness:g}", FORWARD, {"time.end": 8, STIFFNESS: stiffness})
    for nx, ny, h in ((230, 50, 4e-3), (345, 75, 2.5e-3), (460, 100, 2e-3), (690, 150, 1.6e-3), (920, 200, 1e-3)):
        yield case(f"cylinder/{nx}x{ny}", CYLINDER, {"time.end": 8.0} | on_grid(nx, ny, h))
    stiff = {"time.end": 2.0, "rod.material.section": {"line_density": 0.024} | STIFF} | on_grid(320, 240, 2e-4)
    yield Case("stiff/both", COUPLED, PITCHING, {"name": "stiff"} | stiff, action=stiff_limit)
    for step in (8e-4, 4e-4, 2e-4, 1e-4):
        yield case(f"dt/{step:g}", PITCHING, {"time.end": END} | on_grid(320, 240, step))
    for nx, ny in ((240, 180), (320, 240), (480, 360), (640, 480)):
        yield case(f"grid/{nx}x{ny}", PITCHING, {"time.end": END} | on_grid(nx, ny, 4e-4 * 320 / nx))
    for name, changes in COUPLINGS.items():
        grid = on_grid(320, 240, 8e-4) if name.endswith("8e-4") else {}
        yield case(f"coupling/{name}", PITCHING, {"time.end": COUPLED_END} | changes | grid)
    plate = {"time.end": 2.0, "beam.thickness": 0.06, "rod.material.section.line_density": 0.06}
    for nx, ny in ((128, 96), (192, 144)):
        yield case(f"noise/{nx}x{ny}", PITCHING, plate | on_grid(nx, ny, 1e-3 * 128 / nx), rigid=True)
    for name, stiffness in (("the tutorial's vein", 4.0), ("the same, five times as stiff", 20.0)):
        yield case(f"noise/{name}", FORWARD, tutorial() | {STIFFNESS: stiffness})
    yield case("noise/FSI3, 648 x 108", SWINGING, {})
    for name, changes in PARTS.items():
        # The vein stands still in a flow, because the tiny numbers of a fluid at rest slow the processor down.
        moving = {"fluid.initial_velocity": [1.0, 0.3], "rod": "absent", "coupling": "absent"}
        short = {"time.end": PART_STEPS * 4e-4}
        yield case(f"parts/{name}", PITCHING, moving | short | changes, repeats=PART_REPEATS)
    for name in LIMITS:
        yield Case(f"limits/{name}", (*COUPLED, "limits"), options={"limit": name}, action=limit)


def limit(case: Case, folder: Path) -> dict[str, Any]:
    """Return the quantities of a limit case beside their expected values."""
    all_found = LIMITS[case.options["limit"]](partial(limits.record, folder=folder))
    return {"tables": {"found": [asdict(found) | {"error": found.error} for found in all_found]}}


def extract(case: Case, run: Run) -> dict[str, Any]:
    if not run.found.get("quantities") and "tables" in run.found:
        return {"tables": run.found["tables"]}
    summary, group = run.found, case.name.split("/")[0]
    measure = {"noise": noise, "cylinder": oscillating, "coupling": under_coupling, "parts": part}.get(group, settled)
    return {"values": measure(case, run), "times": simulate.times(summary)}


def settled(case: Case, run: Run) -> dict[str, float]:
    """Return means over whole periods at the end, and the missing energy, by the loads and by the fluid's forces."""
    facts, time, rigid = Facts(validate(case.built())), run.series["time"], flapping.path(run.series, "rigid_tip")
    assert facts.scene.beam is not None and rigid is not None, f"{case.name} has no driven root"
    if case.name.startswith(("grid/", "dt/")):
        drive = statistics.principal_direction(time, rigid) @ rigid
        window = statistics.driven_window(time, drive, drive).last(1)
    else:
        window = simulate.window(run.found)
    found = flapping.evaluate(facts, facts.scene.beam, run.series, window)
    assert found, f"{case.name} has no driven root"
    there = {name: getattr(found, name) for name in MEANS}
    balance: dict[str, Any] = found.energy_balance
    values = {name: value for name, value in there.items() if value is not None} | {"missing": balance["missing"]}
    if balance.get("fluid") is not None:
        left = balance["root"] + balance["fluid"] - balance["damping"] - balance["gained"]
        values["by_fluid"] = left / balance["root"]
    return values


def under_coupling(case: Case, run: Run) -> dict[str, float]:
    """Return time reached, iterations a step, the tip at `AT`, and the least residual if the iteration stopped."""
    time, values = run.series["time"], {"reached": run.found["simulated_s"], "iterations": run.found["iterations_mean"]}
    if time[-1] > AT:
        values["tip_uy"] = float(np.interp(AT, time, run.series["tip_uy"]))
    if run.found["error"]:
        last = np.genfromtxt(run.folder / "convergence.csv", delimiter=",", names=True)
        values["residual"] = float(last["residual"][last["step"] == last["step"][-1]].min())
    return values


def noise(case: Case, run: Run) -> dict[str, float]:
    """Return the rms, over the second half, of the part of the drag that the box filter removes, by the rms and by the
    amplitude of the remaining part."""
    time, swings = run.series["time"], case.scene == SWINGING
    drag, width = (run.series["drag"], FSI3_PERIOD / 50) if swings else (run.series["beam_drag"], FORCE_WIDTH)
    smooth, later = statistics.box_filter(time, drag, width), (time > time[-1] / 2) & (time < time[-1] - width)
    rest, left = (drag - smooth)[later].std(), smooth[later]
    return {
        "noise": float(rest / np.sqrt(np.mean(left**2))),
        "noise_by_amplitude": float(rest / (np.ptp(left) / 2)),
    }


def oscillating(case: Case, run: Run) -> dict[str, float]:
    """Return the drag of the second period: amplitude, first harmonic (N/m), and noise and largest lift by the
    amplitude."""
    time, drag = run.series["time"], run.series["drag"]
    window = statistics.Window(4.0, 8.0, 1)
    part = window.of(time)
    smooth = statistics.box_filter(time, statistics.box_filter(time, drag, NOISE_WIDTH), NOISE_WIDTH)
    inside = (time > 4.0) & (time < 8.0 - 2 * NOISE_WIDTH)
    amplitude, rest = float(np.ptp(smooth[part]) / 2), (drag - smooth)[inside]
    harmonic = flapping.harmonic(time, drag, window)
    return {
        "amplitude": amplitude,
        "harmonic": float(abs(harmonic)),
        "phase_deg": float(np.degrees(np.angle(harmonic))),
        "noise_largest": float(np.abs(rest).max() / amplitude),
        "noise_rms": float(rest.std() / amplitude),
        "largest_lift": float(np.abs(run.series["lift"][part]).max() / amplitude),
    }


def part(case: Case, run: Run) -> dict[str, float]:
    """Return the number of scalar variables of the fluid."""
    return {"variables": simulate.sizes(case.built())[1]}


def stiff_limit(case: Case, folder: Path) -> dict[str, Any]:
    """Return the differences of the forces of a stiff rod from those of the prescribed motion."""
    coupled, prescribed = (limits.record(case.built(), folder, rigid=rigid) for rigid in (False, True))
    time, rows = coupled["time"], []
    later = time > 1.0
    for name in FORCES:
        forces = [run[name] for run in (coupled, prescribed)]
        stiff, rigid = (limits.filtered(time, force) for force in forces)
        row = {
            "rms": np.sqrt(np.mean((stiff - rigid) ** 2) / np.mean(rigid**2)),
            "largest": np.abs(stiff - rigid).max() / np.abs(rigid).max(),
            "raw": np.abs(forces[0] - forces[1]).max() / np.abs(forces[1]).max(),
            "coupled": np.trapezoid(forces[0][later], time[later]),
            "prescribed": np.trapezoid(forces[1][later], time[later]),
        }
        rows.append({"force": name} | {key: float(value) for key, value in row.items()})
    return {"tables": {"stiff": rows}}


STUDY = Study("vein", cases, extract)
