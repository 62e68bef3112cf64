"""Error against run time beside other solvers, and what a step costs: peers, the rod at rest, CSM3, short cylinders."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from studies import commands, elastica, maps, show, simulate, space, speed, turek_hron
from studies.engine import COUPLED, FLUID, ROD, Case, Run, Study, simulated
from studies.show import COLOURS
from studies.simulate import on_grid
from studies.store import Data, Record

LISTED: dict[str, Any] = simulate.LISTED["report"]
SCENES: dict[str, str] = LISTED["scenes"]

LARGEST = (8192, 2048)  # Grid of the largest measured step
BESIDE = {
    "cylinder-2d2-900x180": (1e-4, ((450, 90), (900, 180))),
    "sphere-stream-144x96x96": (5e-3, ((96, 64, 64), (144, 96, 96))),
}
"""Scenes of the fluid whose steps are timed beside fluidsim's, a step (s) that no limit divides, and their points."""
TURNS = 3  # Of fluidsim and ours
PLATE, ANGLE = "plate in space", 30  # Angle, °

SPIN = {"sine": {"amplitude": 0.5, "frequency": 0.2}}
COST_STEPS = 200  # Communication steps of the runs that measure the cost of a step


def case(kind: str, method: str, setting: str, changes: dict[str, Any], size: float = 0, **options: Any) -> Case:
    sources = ("peers",) if "command" in options else {"cost": COUPLED, "bodies": FLUID}.get(kind, ROD)
    scene, action, quick = SCENES[kind], simulated, options.pop("quick", True)
    about = {"published": scene, "kind": kind, "method": method, "setting": setting, "size": size}
    if "command" in options:
        scene, action = "", run_peer
    return Case(f"{kind}/{method}/{setting}", sources, scene, changes, options, action, about, quick)


def run_peer(case: Case, folder: Path) -> dict[str, Any]:
    """Run a peer's script with its arguments."""
    return commands.peer(*case.options["command"])


def time_beside(case: Case, folder: Path) -> dict[str, Any]:
    """Time steps of a peer and of a scene in turn; return the medians of both, ms."""
    turns = [run_peer(case, folder) | space.time_steps(case, folder)["times"] for _ in range(TURNS)]
    times = {name: float(np.median([turn[name] for turn in turns])) for name in turns[0]}
    return {"times": times | {"step/rk2": times["step_ms"] / times["rk2_ms"]}}


def cases() -> Iterator[Case]:
    for method, calibration in LISTED["calibrations"].items():
        for n in (8, 16, 32, 64, 128):
            changes: dict[str, Any] = {
                "beam.segments": n,
                "rod.clamp_compliance_length": 0.0,
                "time.end": 8.0,
            } | calibration
            yield case("rod-static", method, f"n = {n}", changes, repeats=5)
    for scheme, value in LISTED["schemes"].items():
        for step in (8e-3, 4e-3, 2e-3, 1e-3):
            changes = {"rod.scheme": value, "time.communication_step": step, "beam.segments": 32}
            yield case("csm3", scheme, f"n = 32, H = {step:g} s", changes, repeats=3)
    for n in (8, 16, 32, 64, 128):
        yield case("csm3", "TR-BDF2, H = 1 ms", f"n = {n}", {"beam.segments": n}, repeats=3)
    for n in (8, 16, 32):
        for kind in ("rod-static", "csm3"):
            command = ["pyelastica_beam.py", SCENES[kind], str(n), "3"]
            yield case(kind, "PyElastica", f"n = {n}", {}, command=command)
    for flow, sizes in (("2d1", (0.1, 0.05, 0.03)), ("2d2", (0.1, 0.07, 0.05))):
        for size in sizes:
            command, quick = ["ngsolve_cylinder.py", flow, f"{size:g}", "1"], flow == "2d1" or size > 0.07
            name = f"cylinder-{flow}"
            yield case(name, "NGSolve, Taylor–Hood", f"mesh {size:g} m", {}, command=command, quick=quick)
    for name, (step, grids) in BESIDE.items():
        for points in grids:
            command = ["fluidsim_step.py", "x".join(map(str, points))]
            changes = space.grid(list(points), step) | {"fluid.precision": "double", "fluid.threads": 1}
            options, about = {"command": command}, {"kind": "step", "grid": " x ".join(map(str, points))}
            yield Case(f"step/{about['grid']}", ("peers", *FLUID), name, changes, options, time_beside, about)
    for panels in (8, 12, 16):
        command = ["pterasoftware_plate.py", str(ANGLE), str(panels), "5"]
        by: dict[str, Any] = {"kind": PLATE, "method": "PteraSoftware", "setting": f"{panels} panels a chord"}
        by["expected"] = space.expected(f"sheet/{ANGLE}°")
        name = f"{PLATE}/PteraSoftware/{panels}"
        yield Case(name, ("vortices",), options={"command": command}, action=run_peer, about=by)
    short = {"time.end": COST_STEPS * 4e-4}
    for n in (21, 42, 84, 168):
        yield case("cost", "stations", f"{n} segments", short | {"beam.segments": n}, n, repeats=9)
    still = {"rod": "absent", "coupling": "absent"}
    yield case("cost", "bar still", "42 segments", short | still, 42, repeats=9)
    still = on_grid(300, 180, 0.01) | {"time.end": COST_STEPS * 0.01}
    for n in (1, 4, 16, 64):
        at = [[-8.75 + 2.5 * (i % 8), -5.25 + 1.5 * (i // 8)] for i in range(n)]
        bodies = [{"shape": {"circle": {"radius": 0.5}}, "position": p, "motion": {"angle": SPIN}} for p in at]
        yield case("bodies", "cylinders", f"{n}", still | {"fluid.bodies": bodies}, n, repeats=5)
    for nx, ny in ((160, 36), (325, 72), (640, 144), (1280, 288)):
        changes = on_grid(nx, ny, 1e-4) | {"time.end": COST_STEPS * 1e-4}
        yield case("cost", "grid", f"{nx} x {ny}", changes, nx * ny, repeats=5)
    changes = on_grid(*LARGEST, 1e-4) | {"time.end": 20 * 1e-4}
    yield case("cost", "grid", "{} x {}".format(*LARGEST), changes, LARGEST[0] * LARGEST[1], repeats=1, quick=False)


def extract(case: Case, run: Run) -> dict[str, Any]:
    found = run.found
    if case.about["kind"] == "step":
        return found
    if "command" in case.options:
        walls, cpus = (np.percentile(spent, [25, 50, 75]).tolist() for spent in zip(*found["runs"]))
        times = {"wall_s": walls, "cpu_s": cpus, "runs": len(found["runs"])}
        return {"values": found["values"], "times": times}
    if case.about["kind"] in ("cost", "bodies"):
        return {"values": {"steps": found["steps"]}, "times": simulate.times(found) | {"memory": found["memory"]}}
    return {"values": simulate.quantities(found), "times": simulate.times(found)}


@lru_cache
def exact(shear: bool) -> dict[str, float]:
    """Return the displacement of the tip of CSM1's bar as an exact beam, m."""
    material, thickness = simulate.changed("csm1", {})["rod"]["material"]["plane_strain"], 0.02
    e, nu = material["youngs_modulus"], material["poisson_ratio"]
    plate, stiff = e / (1 - nu**2), material["shear_factor"] * e / (2 * (1 + nu)) * thickness
    weight = 2.0 * material["density"] * thickness
    x, y = elastica.tip(0.35, weight, plate * thickness**3 / 12, plate * thickness, stiff if shear else np.inf)
    return {"tip_ux.mean": x, "tip_uy.mean": y}


PEER_METHODS = ("PyElastica", "NGSolve, Taylor–Hood", "PteraSoftware")

QUANTITIES: dict[str, list[str]] = LISTED["quantities"]
FLOWS = {"cylinder-2d1": "2D-1", "cylinder-2d2": "2D-2"}
MASKS = {"none": "bare profile", "cosine": "cosine mask", "sharp": "sharp mask", "curvature": "wall target"}

CITED: list[dict[str, Any]] = simulate.LISTED["solvers"]

Point = dict[str, Any]
"""A run for error against run time: the view of its record, `method`, `setting`, quartiles of `cpu` and `wall`, s, and
for the rod at rest `QUANTITY.discretisation`, the error against the exact beam."""


def kind_of(case: str) -> str:
    return "discretisation" if case == "rod-static" else "error"


def point(record: Record, **about: Any) -> Point:
    times = {name: record.times[f"{name}_s"] for name in ("cpu", "wall") if f"{name}_s" in record.times}
    quartiles = {name: spent if isinstance(spent, list) else [spent] * 3 for name, spent in times.items()}
    found = record.view | quartiles | about
    if record.name.startswith("report/rod-static"):
        beam = exact("shear" in found["method"] or found["method"] in PEER_METHODS)
        found |= {f"{q}.discretisation": (found[q] - exact) / abs(exact) for q, exact in beam.items() if q in found}
    return found


def points(data: Data, case: str) -> list[Point]:
    """Return the runs of a case that are compared, method by method."""
    flow = FLOWS.get(case)
    found = [point(r) for r in data.of(f"report/{case}/*") if not flow or r["method"] in PEER_METHODS]
    for record in data.of("fluid/grid/*", flow=flow) if flow else ():
        found.append(point(record, method=MASKS[record["mask"]], setting=record["grid"]))
    if case == PLATE:
        found += [
            point(record, method="a surface", setting=record["grid"]) for record in data.of(f"space/sheet/{ANGLE}*")
        ]
    return found


def beaten(data: Data) -> list[Point]:
    """Return CPU times of ours and of the peers for the largest error of a case, because a single error may pass
    through zero. The most exact run of a peer comes last."""
    rows = []
    for case, quantities in QUANTITIES.items():
        worst = []
        for p in points(data, case):
            there = [abs(p[name]) for q in quantities if (name := f"{q}.{kind_of(case)}") in p]
            if there and p.get("cpu"):
                cpu = float(f"{p['cpu'][1]:.2g}")
                said = f"{p['method']} ({p['setting']}): {100 * max(there):.2g} % in {cpu:g} s"
                worst.append((max(there), p["cpu"][1], said, p["method"] in PEER_METHODS))
        ours = [run for run in worst if not run[3]]
        for theirs in sorted((run for run in worst if run[3]), reverse=True):
            # The cheapest of ours that is at least as exact, or else the most exact one.
            enough = [run for run in ours if run[0] <= theirs[0]]
            mine = min(enough, key=lambda run: run[1]) if enough else min(ours)
            verdict = f"{mine[1] / theirs[1]:.2g} of its CPU time" if enough else "**does not reach its error**"
            rows.append({"case": case, "theirs": theirs[2], "mine": mine[2], "verdict": verdict})
    return rows


def cited(data: Data) -> list[Point]:
    """Return the swinging benchmarks by ours and as cited of others."""
    rows = []
    for name, grid in (("fsi2", "648x108"), ("fsi3", "648x108"), ("fsi3", "1296x216")):
        record = data[f"turek-hron/{name}/{grid}"]
        about = {"case": name.upper(), "method": "ours", "setting": grid.replace("x", " x "), "on": "1"}
        end = simulate.changed(turek_hron.scene_of(name), {})["time"]["end"]
        rows.append(record.view | about | {"wall": float(f"{record['wall_s'] / end:.2g}")})
    return rows + [row | row["values"] for row in CITED]


def steps(data: Data, pattern: str) -> list[Point]:
    """Return median CPU time of a step, and shortest wall times of its parts, µs."""
    rows = []
    for record in data.of(f"report/{pattern}/*"):
        seconds = record.times["phases_s"] | {"step": record["cpu_s"]}
        phases = {phase: 1e6 * spent / record["steps"] for phase, spent in seconds.items()}
        rows.append(record.case.about | phases)
    return rows


def costs(data: Data) -> list[tuple[str, str, list[float], list[float]]]:
    """Return name, variable, sizes and µs of each measured cost."""
    times = [row for row in data["rod/study/runtime"].times["rows"] if row["n"] >= 64]
    bench, grid, stations = speed.found(data, "step"), steps(data, "cost/grid"), steps(data, "cost/stations")
    bar = next(speed.jumps(row, "bar") for row in speed.found(data, "motion") if row["grid"] == "650 x 144")

    def column(rows: list[Point], name: str, scale: float = 1.0) -> list[float]:
        return [scale * row[name] for row in rows]

    points = "points of the grid"
    return [
        ("a step of the fluid", points, column(bench, "points"), column(bench, "step")),
        ("a Newton iteration of the rod in the plane", "segments n", column(times, "n"),
         column(times, "iteration_2d", 1e6)),
        ("a step of FSI3, all of it", points, column(grid, "size"), column(grid, "step")),
        ("a step of FSI3, the rod's part", "segments", column(stations, "size"), column(stations, "rod")),
        ("the bar in a step of the fluid, 650 x 144", "cells that its stations move in it",
         [jump for jump in bar if jump > 0], [bar[jump] for jump in bar if jump > 0]),
        *([("a step with moving cylinders, 300 x 180", "cylinders", column(many, "size"), column(many, "step"))]
          if (many := steps(data, "bodies/cylinders")) else []),
    ]  # fmt: skip


def draw_cost(data: Data) -> None:
    figure, axes = show.panel(2, 3, (12, 7.2))
    for axis, (name, over, x, y) in zip(axes.flat, costs(data)):
        slope, offset = np.polyfit(np.log(x), np.log(y), 1)
        axis.plot(x, y, "o", color=COLOURS[0])
        axis.plot(
            sorted(x), np.exp(offset) * np.sort(x) ** slope, "--", color=COLOURS[1], label=f"exponent {slope:.2f}"
        )
        axis.set(xscale="log", yscale="log", xlabel=over, ylabel="µs")
        if max(y) < 2 * min(y):
            axis.set_ylim(min(y) / 3, max(y) * 3)  # a cost that does not depend on x must look constant
        axis.set_title(name, fontsize=9)
        show.few_labels(axis.xaxis)
        axis.legend(fontsize=8)
    show.save(figure, "pictures/cost")


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    maps.draw(data)
    draw_cost(data)


TABLES: dict[str, Callable[[Data], Any]] = {"report-peers": beaten, "report-cited": cited}
STUDY = Study("report", cases, extract, TABLES, draw)
