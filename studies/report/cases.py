"""What is measured: runs of this project's units and of the peers."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass, field

from nervure.evaluate import coefficients
from nervure.resources import ROOT
from nervure.scene import load, override, reference

from . import elastica

PEERS_PYTHON = ROOT / "target" / "report" / "venv" / "bin" / "python"

TOLERANCE = {"rod-static": 1e-6, "csm3": 1e-5, "cfd3": 0.02, "cylinder-2d1": 1e-4, "cylinder-2d2": 1e-3, "fsi3": 0.02}
"""Within which another machine gets a value again, relative to its scale: rounding of another libm grows with the
wake."""

SCENE = {
    "rod-static": "csm1",
    "csm3": "csm3",
    "cylinder-2d1": "cylinder-2d1-450x90",
    "cylinder-2d2": "cylinder-2d2-900x180",
    "fsi3": "fsi3-325x72",
    "cfd3": "cfd3-650x144",
    "cost": "fsi3-325x72",
}

FAMILY = SCENE | {"cylinder-2d1": "cylinder-2d1", "cylinder-2d2": "cylinder-2d2", "fsi3": "fsi3", "cfd3": "cfd3"}
"""Names in scenes/references.json."""

QUANTITIES = {
    "rod-static": ("tip_ux.mean", "tip_uy.mean"),
    "csm3": ("tip_uy.mean", "tip_uy.amplitude", "tip_uy.frequency_hz"),
    "cylinder-2d1": ("cd_mean", "cl_mean", "dp_mean"),
    "cylinder-2d2": ("cd_max", "cl_peak_to_peak", "st"),
    "fsi3": tuple(
        f"{q}.{what}"
        for q in ("tip_ux", "tip_uy", "drag", "lift")
        for what in ("mean", "amplitude", "frequency_hz", "fit")
    ),
    "cfd3": ("drag.mean", "drag.amplitude", "drag.fit", "lift.mean", "lift.amplitude", "lift.fit", "lift.frequency_hz"),
}

COST_STEPS = 200
"""Communication steps of the runs that only tell what a step costs."""

SCHEMES = {
    "trapezoid": "trapezoid",
    "generalised-α 0.5": {"generalised_alpha": {"rho_inf": 0.5}},
    "BDF2": "bdf2",
    "TR-BDF2": "tr_bdf2",
}


@dataclass(frozen=True)
class Case:
    """One run, in a process of its own."""

    case: str
    method: str
    setting: str
    size: int
    step: float | None
    changes: dict = field(default_factory=dict)
    """Keys of the scene and their values; of a peer the arguments of its script in `peer`."""
    peer: tuple[str, ...] = ()
    repeats: int = 3
    """After a warm-up; 0 is one run without, for those that take minutes."""
    quick: bool = True
    """Part of `make report`, not of `make report-full` only."""

    @property
    def name(self) -> str:
        return f"{self.case}/{self.method}/{self.setting}"

    def scene(self) -> dict:
        scene = load(ROOT / "scenes" / f"{SCENE[self.case]}.json")
        if self.case == "rod-static" and "with shear" not in self.method:
            del scene["rod"]["material"]["plane_strain"]["shear_factor"]
        for key, value in self.changes.items():
            override_value(scene, key, value)
        return scene

    def command(self) -> list[str]:
        if self.peer:
            script = ROOT / "studies" / "peers" / self.peer[0]
            return [str(PEERS_PYTHON), str(script), *self.peer[1:], str(self.repeats)]
        return [sys.executable, str(ROOT / "scripts" / "report" / "worker.py"), str(self.repeats)]

    def limit(self) -> dict[str, float]:
        """Values of the model without discretisation, where they are known: the exact beam."""
        if self.case != "rod-static":
            return {}
        material, beam = load(ROOT / "scenes" / "csm1.json")["rod"]["material"]["plane_strain"], 0.02
        e, nu = material["youngs_modulus"], material["poisson_ratio"]
        plate = e / (1 - nu**2)
        shear = (
            material["shear_factor"] * e / (2 * (1 + nu)) * beam
            if "shear" in self.method or self.peer
            else float("inf")
        )
        x, y = elastica.tip(0.35, 2.0 * material["density"] * beam, plate * beam**3 / 12, plate * beam, shear)
        return {"tip_ux.mean": x, "tip_uy.mean": y}


def override_value(scene: dict, key: str, value) -> None:
    import json

    override(scene, f"{key}={json.dumps(value)}")


def references(case: str) -> dict[str, tuple[float, float]]:
    """Published value and scale of each quantity of a case."""
    primary = (reference(FAMILY[case]) or {})["primary"]
    if "coefficients" in primary:
        return {name: (value, abs(value)) for name, value in coefficients.published(reference(FAMILY[case])).items()}
    found = {}
    for quantity, values in primary["quantities"].items():
        for what, value in values.items():
            swings = what == "mean" and case in ("fsi3", "cfd3") and quantity != "drag"
            found[f"{quantity}.{what}"] = value, abs(values["amplitude"] if swings else value)
    return found


def cases() -> Iterator[Case]:
    """All of them."""
    for method, calibration, setback in (
        ("rod", "second_order", 0.0),
        ("rod with shear", "second_order", 0.0),
        ("rod, calibration of the thesis", {"thesis": {"k_e": 1e5}}, 0.0),
    ):
        for n in (8, 16, 32, 64, 128):
            changes = {
                "beam.segments": n,
                "rod.calibration": calibration,
                "rod.clamp_setback": setback,
                "time.end": 8.0,
            }
            yield Case("rod-static", method, f"n = {n}", n, 5e-3, changes, repeats=5)
    for scheme, value in SCHEMES.items():
        for step in (8e-3, 4e-3, 2e-3, 1e-3):
            changes = {"rod.scheme": value, "time.communication_step": step, "beam.segments": 32}
            yield Case("csm3", scheme, f"n = 32, H = {step:g} s", 32, step, changes)
    for n in (8, 16, 32, 64, 128):
        yield Case("csm3", "TR-BDF2, H = 1 ms", f"n = {n}", n, 1e-3, {"beam.segments": n})
    for n in (8, 16, 32):
        for case in ("rod-static", "csm3"):
            peer = ("pyelastica_beam.py", {"rod-static": "csm1", "csm3": "csm3"}[case], str(n))
            yield Case(case, "PyElastica", f"n = {n}", n, None, peer=peer)
    # The fluid's study has the other grids.
    for flow, step in (("2d1", 3e-3), ("2d2", 7.5e-4)):
        changes = {
            "fluid.box.cells": [300, 60],
            "time.communication_step": step,
            "fluid.time_stepping.max_step": step,
        }
        yield Case(f"cylinder-{flow}", "wall target", "300 x 60", 300, step, changes)
    for flow, sizes in (("2d1", (0.1, 0.05, 0.03)), ("2d2", (0.1, 0.07, 0.05))):
        for size in sizes:
            peer = ("ngsolve_cylinder.py", flow, str(size))
            quick = flow == "2d1" or size > 0.07
            yield Case(
                f"cylinder-{flow}",
                "NGSolve, Taylor–Hood",
                f"mesh {size:g} m",
                0,
                None,
                peer=peer,
                quick=quick,
                repeats=1,
            )
    yield Case("fsi3", "momentum load", "325 x 72", 325, 4e-4)
    short = {"time.end": COST_STEPS * 4e-4}
    for n in (21, 42, 84, 168):
        yield Case("cost", "stations", f"{n} segments", n, 4e-4, short | {"beam.segments": n}, repeats=9)
    yield Case("cost", "bar still", "42 segments", 42, 4e-4, short | {"rod": None, "coupling": None}, repeats=9)
    for nx, ny in ((160, 36), (325, 72), (640, 144), (1280, 288)):
        changes = {
            "fluid.box.cells": [nx, ny],
            "time.communication_step": 1e-4,
            "fluid.time_stepping.max_step": 1e-4,
            "time.end": COST_STEPS * 1e-4,
        }
        yield Case("cost", "grid", f"{nx} x {ny}", nx * ny, 1e-4, changes, repeats=5)
