"""Coverage of the error bars of `nervure verify`: whether they hold values that are known better, and their widths.

Each case is a scene on coarse settings. Its truth is an exact solution, a published value, or a run on `FINER` times
the cells, segments and steps, with c_eta to match, in the same box. Half of the cases, drawn by `SEED` before any was
run, are held out: terms and factors of the bars are chosen by the other half alone.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterator
from math import pi, radians
from pathlib import Path
from statistics import median
from typing import Any

from nervure.errors import InputError
from nervure.files import write_csv
from nervure.output import prior
from nervure.scene import document, validate
from nervure.scene.facts import Facts
from nervure.simulation import sweep
from nervure.verification.estimate import combine, estimate
from nervure.verification.process import Outcome, Verification
from studies import elastica, show, simulate
from studies.engine import COUPLED, FLUID, ROD, Case, Run, Study
from studies.store import Data

SEED = 2014
WITHIN, BUDGET = 0.02, 20.0  # Tolerance and processor time, s, of each verification
HALVES = ("held out", "tuned on")
IN_SAME_BOX = ("cells", "segments", "step", "c_eta")
COARSER = 0.69  # Smallest relative size of the runs beside a truth of a quarter of the size
FINER = {2: 4.0, 3: 2 * 2**0.5, 0: 8.0}  # Of the truth by dimensions of the fluid; 0: without one
STREAM = "viv-384x256"  # A free stream in the plane, whose body is replaced
FALL, BAR = "csm1", "csm3"
STEADY = ("drag_mean", "lift_mean")
SHEDDING = ("drag_mean", "lift_amplitude", "lift_frequency_hz")
FORCED = ("drag_mean", "drag_amplitude", "lift_amplitude")
FLAG = ("tip_uy_amplitude", "tip_uy_frequency_hz", "drag_mean")


def stream(
    shape: dict[str, Any], reynolds: float, cells: int, end: float, angle: float = 0.0, **more: Any
) -> dict[str, Any]:
    """Return the changes to a body of length 1 at an angle (°) in a stream of speed 1, with `cells` a length."""
    step = 0.2 / cells
    body = {"shape": shape, "position": [0.13 / 8, 0.29 / 8], "angle": -radians(angle)}
    return simulate.on_grid(6 * cells, 4 * cells, step) | {
        "time.end": end,
        "fluid.kinematic_viscosity": 1 / reynolds,
        "fluid.box.x": [-2.0, 4.0],
        "fluid.box.y": [-2.0, 2.0],
        "fluid.sponge.x": [2.8, 4.0],
        "fluid.sponge.c_eta": 0.06,
        "fluid.disturbance": "absent",
        "fluid.bodies": [body | more],
    }  # fmt: skip


def still(shape: dict[str, Any], motion: dict[str, Any], viscosity: float, cells: int, end: float) -> dict[str, Any]:
    """Return the changes to a body of length 1 that moves in still fluid."""
    changes = stream(shape, 1 / viscosity, cells, end)
    body = {"shape": shape, "position": [0.13 / 8, 0.29 / 8], "motion": motion}
    gone = dict.fromkeys(("fluid.sponge", "fluid.mean_flow", "fluid.initial_velocity"), "absent")
    kept = {key: value for key, value in changes.items() if "sponge" not in key}
    return kept | gone | {"fluid.box.x": [-3.0, 3.0], "fluid.bodies": [body]}


def sine(amplitude: float, frequency: float = 1.0, phase: float = 0.0) -> dict[str, Any]:
    return {"sine": {"amplitude": amplitude, "frequency": frequency, "phase": phase, "ramp": 0.5 / frequency}}


CIRCLE, PLATE = {"circle": {"radius": 0.5}}, {"plate": {"length": 1.0}}
ELLIPSE = {"ellipse": {"length": 1.0, "thickness": 0.4}}
SQUARE = {"rectangle": {"length": 0.8, "thickness": 0.8}}
WEDGE = {"polygon": {"corners": [[-0.5, 0.0], [0.5, -0.4], [0.5, 0.4]]}}
BLADE = {"rectangle": {"length": 1.0, "thickness": 0.3, "ends": "round"}}


def beam_exact(gravity: float) -> dict[str, float]:
    """Return mean displacements of the tip of CSM1's bar under another gravity (m/s²), m."""
    known = simulate.changed(FALL, {})["rod"]["material"]["plane_strain"]
    e, nu, h = known["youngs_modulus"], known["poisson_ratio"], 0.02
    plate, stiff = e / (1 - nu**2), known["shear_factor"] * e / (2 * (1 + nu)) * h
    x, y = elastica.tip(0.35, gravity * known["density"] * h, plate * h**3 / 12, plate * h, stiff)
    return {"tip_ux_mean": x, "tip_uy_mean": y}


def bar(segments: int, gravity: float, end: float = 6.0, **more: Any) -> dict[str, Any]:
    """Return the changes to the bar that comes to rest under its weight."""
    fixed = {"rod.clamp_compliance_length": 0.0, "beam.segments": segments, "rod.gravity": [0.0, -gravity]}
    return fixed | {"time.end": end, "time.communication_step": 0.02} | more


Kind = tuple[str, dict[str, Any], tuple[str, ...], dict[str, float]]  # Scene, changes, quantities, known truth


def listed() -> Iterator[tuple[str, Kind]]:
    """Yield the cases by name."""
    names: tuple[str, ...]
    for gravity, segments in ((1.0, 8), (2.0, 8), (6.0, 12), (12.0, 16)):
        exact = {"elastica": gravity}
        yield f"bar at rest, {gravity:g} m/s²", (FALL, bar(segments, gravity), ("tip_ux_mean", "tip_uy_mean"), exact)
    for scheme, segments, step in (("trapezoid", 12, 0.005), ("bdf2", 8, 0.004), ("tr_bdf2", 16, 0.01)):
        changes = {"beam.segments": segments, "time.communication_step": step, "rod.scheme": scheme, "time.end": 5.0}
        names = ("tip_uy_mean", "tip_uy_amplitude", "tip_uy_frequency_hz")
        yield f"bar swings, {scheme}", (BAR, changes, names, {})
    for reynolds, cells in ((5, 8), (20, 10), (40, 12)):
        yield f"cylinder, Re {reynolds}", (STREAM, stream(CIRCLE, reynolds, cells, 30.0), STEADY[:1], {})
    for angle, reynolds, cells in ((30, 20, 12), (60, 20, 12), (90, 10, 8), (30, 60, 16), (15, 40, 16)):
        names = STEADY[: 1 if angle == 90 else 2]
        yield f"plate at {angle}°, Re {reynolds}", (STREAM, stream(PLATE, reynolds, cells, 25.0, angle), names, {})
    for name, shape, angle, reynolds, cells in (
        ("ellipse", ELLIPSE, 30, 20, 12),
        ("ellipse", ELLIPSE, 45, 40, 16),
        ("square", SQUARE, 20, 20, 12),
        ("wedge", WEDGE, 10, 30, 12),
        ("blade", BLADE, 25, 20, 12),
        ("blade", BLADE, 60, 10, 10),
    ):
        label = f"{name} at {angle}°, Re {reynolds}"
        yield label, (STREAM, stream(shape, reynolds, cells, 25.0, angle), STEADY, {})
    for name, shape, angle in (("cylinder", CIRCLE, 0), ("square", SQUARE, 0), ("plate", PLATE, 70)):
        changes = stream(shape, 100, 12, 60.0, angle) | {"fluid.disturbance": 0.05}
        yield f"{name} sheds at Re 100", (STREAM, changes, SHEDDING, {})
    for name, shape, motion, viscosity in (
        ("cylinder to and fro, Stokes", CIRCLE, {"x": sine(0.05)}, 0.1),
        ("cylinder to and fro, KC 3", CIRCLE, {"x": sine(0.5)}, 0.05),
        ("ellipse plunges", ELLIPSE, {"y": sine(0.2)}, 0.05),
        ("blade pitches", BLADE, {"angle": sine(0.5)}, 0.03),
        ("plate heaves", PLATE, {"y": sine(0.25)}, 0.05),
        ("plate pitches", PLATE, {"angle": sine(0.6)}, 0.03),
    ):
        names = ("drag_amplitude",) if "to and fro" in name else ("lift_amplitude",)
        yield name, (STREAM, still(shape, motion, viscosity, 12, 6.0), names, {})
    for name, shape, laws in (
        ("cylinder swings across a stream", CIRCLE, {"y": sine(0.2, 0.3)}),
        ("ellipse pitches in a stream", ELLIPSE, {"angle": sine(0.4, 0.3)}),
        ("plate flaps in a stream", PLATE, {"y": sine(0.25, 0.4), "angle": sine(0.3, 0.4, pi / 2)}),
    ):
        yield name, (STREAM, stream(shape, 80, 12, 16.0, motion=laws), FORCED, {})
    mount: dict[str, Any] = {"mount": {"mass": 2.0, "y": {"stiffness": 3.0, "damping": 0.3}}}
    names = ("body_1_y_amplitude", "body_1_y_frequency_hz", "drag_mean")
    changes = stream(CIRCLE, 100, 12, 60.0, **mount) | {"fluid.disturbance": 0.05}
    yield "cylinder on a spring", (STREAM, changes, names, {})
    names, known = ("cd_mean", "dp_mean"), simulate.published("cylinder-2d1-450x90")
    exact = {name: known[name][0] for name in names}
    for grid, step in (((220, 44), 6.4e-3), ((300, 60), 4.8e-3)):
        changes = simulate.on_grid(*grid, step) | simulate.SHALLOW
        yield f"cylinder 2D-1, {grid[0]}", ("cylinder-2d1-450x90", changes, names, exact)
    exact = {f"{name}_mean": simulate.published("cfd1-648x108")[f"{name}.mean"][0] for name in ("drag", "lift")}
    changes = simulate.on_grid(324, 54, 4e-3) | simulate.SHALLOW | {"time.end": 12.0}
    yield "CFD1", ("cfd1-648x108", changes, tuple(exact), exact)
    coarse = simulate.on_grid(96, 96, 0.01) | {"beam.segments": 12}
    names = ("tip_uy_amplitude", "tip_uy_frequency_hz", "drag_mean")
    yield "filament, line", ("filament-line-192x192", coarse | {"time.end": 20.0}, names, {})
    for mass, bending, names in ((0.075, 1e-4, FLAG[2:]), (0.3, 1e-3, FLAG)):
        changes = simulate.on_grid(200, 100, 0.004) | {"beam.segments": 24, "time.end": 14.0}
        changes |= {"rod.material.section.line_density": mass, "rod.material.section.bending_stiffness": bending}
        changes |= {"fluid.kinematic_viscosity": 0.005}
        yield f"flag, mass {mass:g}", ("flag-line-480x240", changes, names, {})
    changes = simulate.on_grid(96, 48, 2e-3) | {"beam.segments": 12, "time.end": 6.0}
    names = ("thrust", "drag_amplitude", "lift_amplitude", "tip_uy_amplitude")
    yield "vein, forward", ("vein-forward-288x144", changes, names, {})
    sphere = {"fluid.precision": "double", "fluid.threads": 1}
    for reynolds in (20, 60):
        changes = simulate.on_grid(0, 0, 0.04) | sphere | {
            "fluid.box.cells": [36, 24, 24], "fluid.box.x": [-2.0, 4.0], "fluid.box.y": [-2.0, 2.0],
            "fluid.box.z": [-2.0, 2.0], "fluid.sponge.x": [3.0, 4.0], "fluid.kinematic_viscosity": 1 / reynolds,
            "time.end": 6.0,
        }  # fmt: skip
        yield f"sphere, Re {reynolds}", ("sphere-stream-144x96x96", changes, ("drag_mean",), {})
    changes = {"fluid.box.cells": [32, 32, 32], "time.communication_step": 0.01, "fluid.time_stepping.max_step": 0.01}
    changes |= {"time.end": 2.0} | sphere
    yield "sphere to and fro", ("sphere-oscillating-64x64x64", changes, ("drag_amplitude",), {})


def held_out() -> set[str]:
    """Return the names of the cases that the estimator was not tuned on."""
    names = sorted(name for name, _ in listed())
    return set(random.Random(SEED).sample(names, len(names) // 2))


def cases() -> Iterator[Case]:
    hidden = held_out()
    for name, (scene, changes, names, exact) in listed():
        with_fluid = "fluid" in simulate.shipped(scene)
        sources = ROD if not with_fluid else COUPLED if "rod" in simulate.shipped(scene) else FLUID
        about = {"exact": exact, "half": HALVES[name not in hidden]}
        options = {"names": names}
        yield Case(f"{about['half']}/{name}", (*sources, "verification"), scene, changes, options, measured, about)


def measured(case: Case, folder: Path) -> dict[str, Any]:
    """Verify the scene of a case within `WITHIN`, and make the run that is its truth."""
    scene = validate(case.built())
    names, exact = list(case.options["names"]), dict(case.about["exact"])
    parameters = () if exact and scene.fluid else IN_SAME_BOX
    limits = folder / "runs", WITHIN, BUDGET, names, parameters
    found = Verification(scene, *limits, workers=1, force=True, cpu=True).run()
    if found.verified is None:
        raise InputError("; ".join(found.problems))
    if "elastica" in exact:
        exact = beam_exact(exact["elastica"])
    own = not exact
    truth = exact or finest(found, names, folder / "truth", scene.fluid)
    shares = {
        name: {key: vars(share) for key, share in quantity.shares.items()}
        for name, quantity in found.verified.quantities.items()
        if name in truth
    }
    wall, recommended = found.verified.wall_s, found.verified.recommended_wall_s
    cost = wall / recommended if found.reached and recommended else None
    return {"truth": truth, "own": own, "shares": shares, "wall_s": wall, "cost": cost, "problems": found.problems}


def finest(found: Outcome, names: list[str], folder: Path, fluid: Any) -> dict[str, float]:
    """Return the values of the run with the smallest sizes."""
    finer = FINER[len(fluid.box.cells) if fluid else 0]
    sizes = {one.name: 1 / finer for one in found.plan.parameters if one.name != "step" or not fluid}
    setting = found.plan.setting(sizes)
    row = sweep.run_case(document(setting.scene), folder)
    if row["status"] != sweep.FINISHED:
        raise InputError(f"the truth: {row['reason']}")
    return {name: float(row[name]) for name in names if row[name] is not None}


Bar = dict[str, Any]
"""A pair of case and quantity: value on the finest run, limit with its bar, and truth."""


def bars(found: dict[str, Any]) -> Iterator[Bar]:
    """Yield the bars that the estimator makes of the runs of a case, those left out that are less than three times √2
    coarser than its truth."""
    for name, shares in found["shares"].items():
        again = {}
        for number, (key, own) in enumerate(shares.items()):
            runs = list(zip(own["sizes"], own["values"], own["noise"]))
            if number == 0 and found["own"]:
                runs = [run for run in runs if run[0] >= COARSER]
            again[key] = estimate(*zip(*runs))
        value, limit, bar = combine(again)
        kind, truth = next(iter(again.values())).kind, found["truth"][name]
        yield {"quantity": name, "value": value, "limit": limit, "bar": bar, "truth": truth, "kind": kind}


def extract(case: Case, run: Run) -> dict[str, Any]:
    found = run.found
    values = {"cost": found["cost"]} if found["cost"] else {}
    return {"values": values, "tables": {"bars": list(bars(found))}, "times": {"wall_s": found["wall_s"]}}


KINDS = {"cd": "drag", "cl": "lift", "st": "frequency", "height": "motion", "amplitude": "motion", "angle": "motion"}
"""Columns of the prior by the beginnings of quantities that are not named after them."""
METHODS = {"coupling", "fluid.mask", "fluid.filter", "fluid.mask.log_linear.wall_correction"}
"""Changes to other methods than the usual ones."""


def prior_rows(data: Data) -> Iterator[dict[str, Any]]:
    """Yield the recorded errors of all scenes with a fluid, by what makes scenes alike."""
    for name, record in data.records.items():
        errors = {quantity: error for quantity, error in record.errors().items() if abs(error) < 1}
        method = record.get("mask", "curvature"), record.case.changes.keys() & METHODS
        if not errors or not record.case.scene or method != ("curvature", set()):
            continue
        try:
            like = prior.likeness(Facts(validate(record.case.built())))
        except InputError:  # The scene is of an earlier version
            continue
        largest: dict[str, float] = {}
        for quantity, error in errors.items():
            first, *_ = re.split(r"[._]", quantity)
            kind = "frequency" if "frequency" in quantity else "motion" if first == "tip" else KINDS.get(first, first)
            if kind in prior.QUANTITIES:
                largest[kind] = max(largest.get(kind, 0.0), float(f"{abs(error):.2g}"))
        if like and largest:
            numbers = {key: f"{value:.3g}" if value else "" for key, value in zip(prior.NUMBERS, like.numbers)}
            yield {"case": name, "kind": like.kind} | numbers | {key: largest.get(key, "") for key in prior.QUANTITIES}


def known(data: Data, half: str) -> list[Bar]:
    """Return the bars of a half of the cases, with errors relative to the truth."""
    found = []
    for record in data.of(f"coverage/{half}/*"):
        for row in record.tables.get("bars", []):
            truth = abs(row["truth"])
            errors = {key: abs(row[of] - row["truth"]) / truth for key, of in (("error", "value"), ("off", "limit"))}
            found.append({**row, **errors, "bar": row["bar"] / truth, "case": record.name.split("/", 2)[2]})
    return found


def summary(data: Data) -> list[str]:
    """Return the table of both halves of the cases, and of all."""
    rows = []
    for name, halves in [(half, [half]) for half in HALVES] + [("all", list(HALVES))]:
        found = [bar for half in halves for bar in known(data, half)]
        if costs := [record.get("cost") for half in halves for record in data.of(f"coverage/{half}/*")]:
            held = sum(one["off"] <= one["bar"] for one in found)
            bar, error = (median(one[key] for one in found) for key in ("bar", "error"))
            reached = [cost for cost in costs if cost]
            shares = (
                f"{held} of {len(found)}, {held / len(found):.0%}",
                f"{bar:.1%}",
                f"{error:.1%}",
                f"{bar / error:.1f}",
            )
            rows.append([name, str(len(costs)), *shares, f"{median(reached):.1f} ({len(reached)} cases)"])
    headings = ("cases", "number", "pairs of case and quantity held", "median ±", "median error of the finest run")
    return show.markdown((*headings, "± by error", "cost of those within 2 %, by that of the recommended run"), rows)


def missed(data: Data) -> list[str]:
    """Return the bars that do not hold the truth, as a list."""
    return [
        f"- {one['case']} ({half}): {one['quantity']} off by {100 * one['off']:.2g} %, ± {100 * one['bar']:.2g} %"
        for half in HALVES
        for one in known(data, half)
        if one["off"] > one["bar"]
    ]


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    """Write the prior, and draw the bars over the true errors."""
    write_csv(prior.FILE, list(prior_rows(data)))
    figure, axes = show.panel(size=(6.4, 4.8))
    axis = axes[0, 0]
    for half, colour in zip(HALVES, show.COLOURS):
        for held, marker in ((True, "o"), (False, "x")):
            points = [(one["off"], one["bar"]) for one in known(data, half) if (one["off"] <= one["bar"]) == held]
            label = f"{half}, {'held' if held else 'missed'}"
            axis.plot(*zip(*points), marker, color=colour, markersize=4, label=label) if points else None
    ends = (1e-5, 1.0)
    axis.plot(ends, ends, color="0.5", linewidth=0.8)
    axis.set(
        xscale="log", yscale="log", xlabel="distance of the limit from the truth, relative", ylabel="± 95 %, relative"
    )
    axis.set(xlim=ends, ylim=(1e-4, 10.0))
    axis.legend(fontsize="small")
    show.save(figure, "pictures/coverage")


STUDY = Study("coverage", cases, extract, {"coverage": summary, "coverage-missed": missed}, draw)
