"""What the report measures itself: the rod at rest, CSM3, short cylinders, FSI3, the cost of a step, and the peers."""

import json
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from nervure.resources import ROOT
from studies import commands, simulate
from studies.engine import COUPLED, ROD, Case, Run, simulated
from studies.report import elastica
from studies.simulate import on_grid

LISTED: dict[str, Any] = simulate.LISTED["report"]
SCENES: dict[str, str] = LISTED["scenes"]

PEERS = ROOT / "studies" / "peers"
PYTHON = ROOT / "target" / "report" / "venv" / "bin" / "python"
LONGEST = 3600.0  # Wall time that a peer may take, s

LARGEST = (8192, 2048)  # Grid whose step and memory are measured
COST_STEPS = 200  # Communication steps of the runs that only tell what a step costs


def case(kind: str, method: str, setting: str, changes: dict[str, Any], size: float = 0, **options: Any) -> Case:
    sources = ("peers",) if "command" in options else COUPLED if kind == "cost" else ROD
    scene, action, quick = SCENES[kind], simulated, options.pop("quick", True)
    about = {"published": scene, "kind": kind, "method": method, "setting": setting, "size": size}
    if "command" in options:
        scene, action = "", run_peer
    return Case(f"{kind}/{method}/{setting}", sources, scene, changes, options, action, about, quick)


def run_peer(case: Case, folder: Path) -> dict[str, Any]:
    """Run a peer's script in its own environment: what it prints last."""
    if not PYTHON.is_file():
        raise FileNotFoundError("the peers are not installed: make target/report/venv/.ready")
    script, *arguments = case.options["command"]
    command = [str(PYTHON), str(PEERS / script), *arguments]
    found: dict[str, Any] = json.loads(commands.output(command, LONGEST).strip().splitlines()[-1])
    return found


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
    short = {"time.end": COST_STEPS * 4e-4}
    for n in (21, 42, 84, 168):
        yield case("cost", "stations", f"{n} segments", short | {"beam.segments": n}, n, repeats=9)
    still = {"rod": "absent", "coupling": "absent"}
    yield case("cost", "bar still", "42 segments", short | still, 42, repeats=9)
    for nx, ny in ((160, 36), (325, 72), (640, 144), (1280, 288)):
        changes = on_grid(nx, ny, 1e-4) | {"time.end": COST_STEPS * 1e-4}
        yield case("cost", "grid", f"{nx} x {ny}", changes, nx * ny, repeats=5)
    changes = on_grid(*LARGEST, 1e-4) | {"time.end": 20 * 1e-4}
    yield case("cost", "grid", "{} x {}".format(*LARGEST), changes, LARGEST[0] * LARGEST[1], repeats=1, quick=False)


def extract(case: Case, run: Run) -> dict[str, Any]:
    found = run.found
    if "command" in case.options:
        walls, cpus = (np.percentile(spent, [25, 50, 75]).tolist() for spent in zip(*found["runs"]))
        times = {"wall_s": walls, "cpu_s": cpus, "runs": len(found["runs"])}
        return {"values": found["values"], "times": times}
    cost = case.about["kind"] == "cost"
    values = {name: found[name] for name in ("steps", "memory")} if cost else simulate.quantities(found)
    return {"values": values, "times": simulate.times(found)}


@lru_cache
def exact(shear: bool) -> dict[str, float]:
    """The tip of CSM1's bar as an exact beam, m."""
    material, thickness = simulate.changed("csm1", {})["rod"]["material"]["plane_strain"], 0.02
    e, nu = material["youngs_modulus"], material["poisson_ratio"]
    plate, stiff = e / (1 - nu**2), material["shear_factor"] * e / (2 * (1 + nu)) * thickness
    weight = 2.0 * material["density"] * thickness
    x, y = elastica.tip(0.35, weight, plate * thickness**3 / 12, plate * thickness, stiff if shear else np.inf)
    return {"tip_ux.mean": x, "tip_uy.mean": y}
