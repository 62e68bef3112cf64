"""The fluid alone: cylinders over grid, step, mask and filter, settings of the thesis, exact solutions and
stability."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from studies import commands, show, simulate
from studies.engine import FLUID, Case, Run, Study
from studies.show import markdown
from studies.store import Data

SCENES = {"2D-1": "cylinder-2d1-450x90", "2D-2": "cylinder-2d2-900x180"}

STEP = {"2D-1": 3.2e-3 * 450, "2D-2": 3.5e-4 * 900}
"""Step times number of points along x: the CFL number is the same on each grid."""
GRIDS = {"2D-1": (300, 450, 600, 900), "2D-2": (300, 450, 600, 800, 900, 1100, 1600)}
"""Points along x; the grid has a fifth of them along y."""
BETWEEN = (650, 660, 700, 720, 750, 780)  # Grids between two of these, for jumps of the error from grid to grid
COARSE = 600  # Points along x up to which all masks run; the default and the cosine mask run on finer grids
LARGEST_CFL = {"sbdf2": 0.4, "rk2": 0.6}  # Largest CFL number of a scene

THESIS_GRIDS = (400, 600, 800, 900, 1000, 1100)
THESIS_END = 8.0  # Of the repeated runs, s; the thesis goes on to 15 s
THESIS_STEP = 2.2e-4 * 900
"""The thesis gives CFL = 0.25; the largest |u|/dx + |v|/dy of this flow is about 1.1e3 1/s on 900 x 180."""
THESIS_U_INF = 0.694444  # Mean velocity over the box at the start (thesis table 3.2), m/s

QUANTITIES = ("cd_max", "cl_peak_to_peak", "st")  # Compared quantities of 2D-2


def cylinder(
    flow: str, nx: int, name: str, dt: float | None = None, mask: str = "curvature", c_eta: float = 1e-5,
    filter: str = "smooth", scheme: str = "sbdf2", offset: tuple[float, float] = (0.0, 0.0), free: bool = False,
    thesis: bool = False,
) -> Case:  # fmt: skip
    """A cylinder of Schäfer and Turek on `nx` points; `offset` shifts the grid by parts of a cell, `free` lets the unit
    take steps up to its CFL limit, `thesis` starts by a jump. The masks `curvature`, `shear` and `none` are wall
    targets of the log-linear profile; the first has the deep core of the shipped scenes unless it is "shallow"."""
    dt, ny = dt or STEP[flow] / nx, nx // 5
    kind, _, variant = mask.partition(", ")
    shape: dict[str, Any] = {"c_eta": c_eta}
    if variant == "uncorrected":
        shape["displacement_corrected"] = False
    if kind == "cosine":
        shape["half_width"] = 1.0
    core = {"core_depth": 2.0} if mask == "curvature" else {}
    target = {"log_linear": {"c_eta": c_eta, "wall_correction": kind} | core}
    changes: dict[str, Any] = simulate.shifted_grid(SCENES[flow], nx, ny, offset) | {
        "name": f"cylinder-{flow.lower().replace('-', '')}-{name.replace('/', '-')}",
        "time.communication_step": dt,
        "fluid.time_stepping.max_step": dt,
        "fluid.mask": {kind: shape} if kind in ("cosine", "sharp") else target,
        "fluid.filter": filter,
    }
    if free:
        changes["fluid.time_stepping.max_cfl"] = LARGEST_CFL[scheme]
    if scheme == "rk2":  # otherwise the inflow zone would limit the step
        changes |= {"fluid.time_stepping.scheme": scheme, "fluid.inflow.c_eta": c_eta}
    options: dict[str, Any] = {"repeats": 3 if name.startswith("grid/") else 0}
    if thesis:
        changes |= {"fluid.inflow.mean_velocity": {"constant": 1.0}, "fluid.initial_velocity": [THESIS_U_INF, 0.0]}
        changes["time.end"] = THESIS_END
    about = {"published": SCENES[flow], "flow": flow, "nx": nx, "ny": ny, "dt": dt, "mask": mask, "c_eta": c_eta,
             "filter": filter, "scheme": scheme, "aside": "{:g}, {:g}".format(*offset)}  # fmt: skip
    return Case(name, FLUID, SCENES[flow], changes, options, about=about)


def cases() -> Iterator[Case]:
    """Yield all cases; the group of a case stands before the slash."""
    for flow, grids in GRIDS.items():
        for nx in grids:
            yield cylinder(flow, nx, f"grid/{flow}-curvature-{nx}")
            for mask, c_eta in (("shear", 1e-5), ("none", 1e-5), ("cosine", 1e-4), ("sharp", 1e-4)):
                if nx <= COARSE or (mask != "sharp" and nx == 900 and flow == "2D-2"):
                    yield cylinder(flow, nx, f"grid/{flow}-{mask}-{nx}", mask=mask, c_eta=c_eta)
    at = partial(cylinder, "2D-2")
    for nx in BETWEEN:
        yield at(nx, f"between/2D-2-{nx}")
    for nx in (300, 450, 600, 900):
        yield at(nx, f"grid/2D-2-shallow-{nx}", mask="curvature, shallow")
    for nx in (300, 450, 600):
        for mask in ("cosine, uncorrected", "sharp, uncorrected"):
            yield at(nx, f"grid/2D-2-{mask.replace(', ', '-')}-{nx}", mask=mask, c_eta=1e-4)
        yield at(nx, f"grid/2D-2-cosine-rk2-{nx}", mask="cosine", c_eta=1e-3, scheme="rk2")
    for dt in (8e-4, 7e-4, 5e-4, 2.5e-4, 1.25e-4):  # the largest is one that the unit just does not divide
        yield at(450, f"dt/sbdf2-{dt:g}", dt, free=True)
        yield at(450, f"dt/sbdf2-cosine-{dt:g}", dt, mask="cosine", c_eta=1e-3, free=True)
    for dt in (1e-3, 7.5e-4, 5e-4, 2.5e-4, 1.25e-4):
        yield at(450, f"dt/rk2-cosine-{dt:g}", dt, mask="cosine", c_eta=1e-3, scheme="rk2", free=True)
    for c_eta in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
        for mask in ("curvature", "curvature, shallow", "cosine", "cosine, uncorrected", "sharp"):
            yield at(450, f"c_eta/{mask.replace(', ', '-')}-{c_eta:g}", mask=mask, c_eta=c_eta)
    for c_eta in (1e-4, 1e-6):
        for nx in (600, 900):
            yield at(nx, f"hard/curvature-{nx}-{c_eta:g}", c_eta=c_eta)
        yield at(600, f"hard/shallow-600-{c_eta:g}", mask="curvature, shallow", c_eta=c_eta)
    for truncation in ("none", "two_thirds"):
        for nx in (450, 600):
            yield at(nx, f"filter/{truncation}-{nx}", filter=truncation)
    for x, y in ((0.25, 0.25), (0.5, 0.0), (0.0, 0.5)):
        for mask, c_eta in (("curvature", 1e-5), ("none", 1e-5), ("cosine", 1e-4), ("sharp", 1e-4)):
            yield cylinder("2D-1", 450, f"offset/2D-1-{mask}-{x:g}-{y:g}", mask=mask, c_eta=c_eta, offset=(x, y))
        yield at(600, f"offset/2D-2-curvature-{x:g}-{y:g}", offset=(x, y))
    yield at(900, "offset/2D-2-curvature-900", offset=(0.5, 0.5))
    for nx in THESIS_GRIDS:
        yield at(nx, f"thesis/{nx}", THESIS_STEP / nx, "sharp, uncorrected", 1e-3, "two_thirds", "rk2", thesis=True)


def extract(case: Case, run: Run) -> dict[str, Any]:
    """Return coefficients, mean flow rate (m²/s) and largest CFL number."""
    summary, series = run.found, run.series
    if summary["coefficients"] is None:
        return {}
    flow_rate = series["flow_rate"][simulate.window(summary).of(series["time"])].mean()
    values = {"flow_rate": float(flow_rate), "cfl": float(series["cfl"].max())}
    return {"values": summary["coefficients"]["values"] | values, "times": simulate.times(summary)}


def thesis(data: Data) -> list[str]:
    """Return a table of the mean drag coefficient: of the thesis (table 3.4), of its settings run again, and ours."""
    printed = {int(nx): row for nx, row in simulate.LISTED["thesis"]["table_3_4"].items()}
    again, ours = ({r["nx"]: r.view for r in data.of(f"fluid/{of}")} for of in ("thesis/*", "grid/2D-2-curvature-*"))
    who = {"thesis": printed, "repeated": again, "ours": ours}
    expected = f"{simulate.published(SCENES['2D-2'])['cd_mean'][0]:.6g}"
    rows = [[on(nx), *(show.form("{cd_mean:.4f}", of.get(nx, {})) for of in who.values()), expected] for nx in printed]
    return markdown(["grid", *who, "reference"], rows)


def on(nx: int) -> str:
    return f"{nx} x {nx // 5}"


def errors(data: Data, name: str) -> str:
    """Return errors of cD max, cL from peak to peak and St of a case of 2D-2 in per cent, or nothing without a
    result."""
    record = data.get(f"fluid/{name}")
    if record is None or record.error:
        return ""
    found = [record[f"{quantity}.error"] for quantity in QUANTITIES]
    return " / ".join(f"{100 * error:.{1 if abs(error) >= 0.1 else 2}f}" for error in found)


def hardness(data: Data) -> list[str]:
    """Return a table of errors of 2D-2 with the wall target by core, C_eta and grid."""

    def cell(row: tuple[str, str], nx: int) -> str:
        core, c_eta = row
        if c_eta == "1e-05":
            return errors(data, f"grid/2D-2-{core}-{nx}")
        if nx == 450:
            return errors(data, f"c_eta/{'curvature-' * (core == 'shallow')}{core}-{c_eta}")
        return errors(data, f"hard/{core}-{nx}-{c_eta}")

    cores = {"2 cells deep": "curvature", "by default": "shallow"}
    c_etas = {"1e-4": "0.0001", "1e-5": "1e-05", "1e-6": "1e-06"}
    rows = {f"{core}, {said}": (name, value) for core, name in cores.items() for said, value in c_etas.items()}
    return show.matrix("core, C_eta (s)", rows, {on(nx): nx for nx in (450, 600, 900)}, cell)


def between(data: Data) -> list[str]:
    """Return a table of errors of 2D-2 on grids that differ little."""
    here = {nx: f"between/2D-2-{nx}" for nx in BETWEEN}
    names = {600: "grid/2D-2-curvature-600", **here, 800: "grid/2D-2-curvature-800"}
    return markdown([on(nx) for nx in names], [[errors(data, name) for name in names.values()]])


TABLES: dict[str, Callable[[Data], Any]] = {
    "cylinder-2d2-between": between,
    "cylinder-2d2-c_eta": hardness,
    "thesis-3-4": thesis,
}
STUDY = Study("fluid", cases, extract, TABLES)


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
