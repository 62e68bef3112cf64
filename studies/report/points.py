"""Runs of a case with their errors and times, whichever study they belong to."""

from __future__ import annotations

from typing import Any

from studies import driven_bar, fsi3, simulate, turek_hron
from studies.report import cases
from studies.store import Data, Record

PEERS = ("PyElastica", "NGSolve, Taylor–Hood")

LISTED: dict[str, Any] = simulate.LISTED["report"]
QUANTITIES: dict[str, list[str]] = LISTED["quantities"]
FLOWS = {"cylinder-2d1": "2D-1", "cylinder-2d2": "2D-2"}
MASKS = {"none": "bare profile", "cosine": "cosine mask", "curvature": "wall target"}

OURS = ("wall target", "momentum load", "BDF2")  # Methods that goals are for
CITED: list[dict[str, Any]] = simulate.LISTED["solvers"]
SIMULATED = 8.0  # End of the FSI3 scenes, s

FSI3_METHODS: dict[str, str] = LISTED["fsi3"]
"""Changes of FSI3 that have a line of their own beside the shipped scenes."""

Point = dict[str, Any]
"""A run for error against run time: its record's view, `method`, `setting`, quartiles of `cpu` and `wall`, s, and
`QUANTITY.discretisation`, of the rod at rest the error against the exact beam."""


def kind_of(case: str) -> str:
    return "discretisation" if case == "rod-static" else "error"


def point(record: Record, **about: Any) -> Point:
    times = {name: record.times[f"{name}_s"] for name in ("cpu", "wall") if f"{name}_s" in record.times}
    quartiles = {name: spent if isinstance(spent, list) else [spent] * 3 for name, spent in times.items()}
    found = record.view | quartiles | about
    if record.name.startswith("report/rod-static"):
        beam = cases.exact("shear" in found["method"] or found["method"] in PEERS)
        found |= {f"{q}.discretisation": (found[q] - exact) / abs(exact) for q, exact in beam.items() if q in found}
    return found


def points(data: Data, case: str) -> list[Point]:
    """What is compared of a case, method by method."""
    found = []
    if case == "fsi3":
        for record in data.of("fsi3/grid/*"):
            found.append(point(record, method="momentum load", setting=record["name"]))
        changed = [(method, group) for method in FSI3_METHODS for group in fsi3.VARIED]
        for method, group in changed:
            found += [point(r, method=method, setting=group) for r in data.of(f"fsi3/{group}/{FSI3_METHODS[method]}")]
        expected = simulate.published(fsi3.COARSE)
        for row in CITED[:2]:
            errors = {f"{q}.error": (value - expected[q][0]) / expected[q][1] for q, value in row["values"].items()}
            found.append(row | errors | {"wall": [SIMULATED * row["wall"]] * 3, "failed": False})
        return found
    if case == "driven-bar":
        exact = driven_bar.LISTED["stream"]["moving mesh"]
        grids = [data.get(f"driven-bar/stream/{nx}x{ny}") for nx, ny in driven_bar.GRIDS]
        for run in filter(None, grids):
            off = {f"{q}.error": (run[q] - exact[q]) / abs(exact[q]) for q in QUANTITIES[case]}
            found.append(point(run, method="wall target", setting=run["name"], **off))
        return found
    if case in turek_hron.FLOWS:
        swings = {grid.replace("x", " x "): data.get(f"turek-hron/{case}/{grid}") for grid in turek_hron.GRIDS}
        return [point(run, method="momentum load", setting=grid) for grid, run in swings.items() if run]
    flow = FLOWS.get(case)
    found = [point(r) for r in data.of(f"report/{case}/*") if not flow or r["method"] in PEERS]
    for record in data.of("fluid/*", flow=flow) if flow else ():
        group, nx = record.name.split("/")[1], record["nx"]
        name = "thesis: sharp, uncorrected, Heun" if group == "thesis" else MASKS.get(record["mask"])
        if name and (group == "thesis" or (group == "grid" and record["scheme"] == "sbdf2")):
            found.append(point(record, method=name, setting=f"{nx} x {nx // 5}"))
    return found
