"""The fluid alone: cylinders over grid, step, mask and filter, settings of the thesis, exact solutions and
stability."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from studies import commands, show, simulate
from studies.engine import FLUID, Case, Run, Study
from studies.store import Data

SCENES = {"2D-1": "cylinder-2d1-450x90", "2D-2": "cylinder-2d2-900x180"}

STEP = {"2D-1": 3.2e-3 * 450, "2D-2": 3.5e-4 * 900}
"""Step times number of points along x: the CFL number is the same on each grid."""
GRIDS = {"2D-1": (300, 600, 900), "2D-2": (450, 600, 1600)}
"""Points along x; the grid has a fifth of them along y. The shipped scenes are on 450 and 900 points."""
MASKS = {"none": 1e-5, "cosine": 1e-4, "sharp": 1e-4}
"""C_eta of the other masks of 2D-2, s."""


def cylinder(
    flow: str, nx: int, name: str, dt: float | None = None, mask: str = "curvature", c_eta: float = 1e-5,
    offset: tuple[float, float] = (0.0, 0.0),
) -> Case:  # fmt: skip
    """A cylinder of Schäfer and Turek on `nx` points; `offset` shifts the grid by parts of a cell. `curvature` and
    `none` are wall corrections of the log-linear mask; the first has the deep core of the shipped scenes."""
    dt, ny = dt or STEP[flow] / nx, nx // 5
    shape: dict[str, Any] = {"c_eta": c_eta} | ({"half_width": 1.0} if mask == "cosine" else {})
    core = {"core_depth": 2.0} if mask == "curvature" else {}
    target = {"log_linear": {"c_eta": c_eta, "wall_correction": mask} | core}
    changes: dict[str, Any] = simulate.shifted_grid(SCENES[flow], nx, ny, offset) | {
        "name": f"cylinder-{flow.lower().replace('-', '')}-{name.replace('/', '-')}",
        "time.communication_step": dt,
        "fluid.time_stepping.max_step": dt,
        "fluid.mask": {mask: shape} if mask in ("cosine", "sharp") else target,
        "fluid.filter": "smooth",
    }
    about = {"published": SCENES[flow], "flow": flow, "nx": nx, "ny": ny, "mask": mask, "grid": f"{nx} x {ny}"}
    return Case(name, FLUID, SCENES[flow], changes, {"repeats": 3}, about=about, quick=nx < 900)


def cases() -> Iterator[Case]:
    """Yield all cases; the group of a case stands before the slash."""
    for flow, grids in GRIDS.items():
        for nx in grids:
            yield cylinder(flow, nx, f"grid/{flow}-curvature-{nx}")
    for mask, c_eta in MASKS.items():
        for nx in (450, 600) if mask == "sharp" else (450, 600, 900):
            yield cylinder("2D-2", nx, f"grid/2D-2-{mask}-{nx}", mask=mask, c_eta=c_eta)


def extract(case: Case, run: Run) -> dict[str, Any]:
    """Return coefficients, mean flow rate (m²/s) and largest CFL number."""
    summary, series = run.found, run.series
    if summary["coefficients"] is None:
        return {}
    flow_rate = series["flow_rate"][simulate.window(summary).of(series["time"])].mean()
    values = {"flow_rate": float(flow_rate), "cfl": float(series["cfl"].max())}
    return {"values": summary["coefficients"]["values"] | values, "times": simulate.times(summary)}


STUDY = Study("fluid", cases, extract)


# Exact solutions, invariants and the map of stability, by the crate's own examples


def measure_cases() -> Iterator[Case]:
    for name in ("measures", "stability"):
        command = commands.cargo("fluid-bench", f"{{folder}}/{name}.csv", binary=name)
        sources = ("scene", "fluid", "fluid measures")
        yield Case(f"crate/{name}", sources, options={"command": command}, action=commands.tables)


def measures(data: Data, walls: bool) -> list[dict[str, Any]]:
    """Return weights of the wall target by the decay length, or exact solutions and invariants."""
    rows = data["fluid-measures/crate/measures"].tables["measures"]
    if not walls:
        return [row for row in rows if row["measure"] != "wall target"]
    table = []
    for setting, part in show.grouped((row for row in rows if row["measure"] == "wall target"), "setting").items():
        name = re.sub(r"^(e-fold|decay length) |, curvature$", "", setting).replace("shear", "`shear`")
        table.append({"name": name} | {row["quantity"]: row["value"] for row in part})
    return table


MEASURE_TABLES: dict[str, Callable[[Data], Any]] = {
    "wall-target": partial(measures, walls=True),
    "fluid-measures": partial(measures, walls=False),
}
MEASURES = Study("fluid-measures", measure_cases, lambda case, run: {"tables": run.found["tables"]}, MEASURE_TABLES)
