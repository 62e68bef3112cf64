"""The fluid's study: a list of cases, their runs, and the tables and figures of docs/fluid.

    python scripts/studies/fluid.py                    run what is missing, then write docs/fluid
    python scripts/studies/fluid.py --list             the cases, what is known of them and what the others will cost
    python scripts/studies/fluid.py --only 'dt/*'      run only those

Every case is a scene of its own, run by nervure in a process of one thread; the results are collected in
results/fluid-study/results.csv. A case is known there by its scene and the fluid's library, and is run again only when
one of them has changed. A case that failed stays in the list with its reason. Short cases of the groups that are drawn over
their time run several times.
"""

import csv
import hashlib
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field, fields
from fnmatch import fnmatch
from itertools import cycle
from pathlib import Path
from typing import Annotated

import matplotlib.pyplot as plt
import numpy as np
import typer
from matplotlib.lines import Line2D



from nervure.evaluate import coefficients, statistics
from nervure.pack import package
from nervure.files import write_csv, write_whole
from nervure.resources import ROOT
from nervure.scene import load, override, reference
from studies.tables import markdown, read

RESULTS = ROOT / "results" / "fluid-study"
DOCS = ROOT / "docs" / "fluid"
THREADS = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}

COST = {"sbdf2": 25e-9, "rk2": 50e-9}
"""Wall time for a step and a point, s: for the estimate in the list only."""

TIMED = ("grid", "thesis")
"""Groups whose cases run several times where they are short: five times up to 10 s, three times up to 20 s."""

LARGEST_CFL = {"sbdf2": 0.4, "rk2": 0.6}
"""That a scene may have."""

SCENES = {"2D-1": "cylinder-2d1-450x90", "2D-2": "cylinder-2d2-900x180"}
REFERENCE = {case: coefficients.published(reference(name)) for case, name in SCENES.items()}

STEP = {"2D-1": 2e-3 * 450, "2D-2": 2.5e-4 * 900}
"""Step times number of points along x: the same CFL number on each grid."""

GRIDS = {"2D-1": (300, 450, 600, 900), "2D-2": (300, 450, 600, 800, 900, 1100)}
"""Points along x; a fifth of them along y."""

COARSE = 600
"""Points along x up to which every mask is tried; the default and the cosine mask go on."""

THESIS_GRIDS = (400, 600, 800, 900, 1000, 1100)

THESIS_END = 8.0
"""Of the repeated runs, s; the thesis goes on to 15 s."""
THESIS_STEP = 2.2e-4 * 900
"""The thesis gives CFL = 0.25; its largest |u|/dx + |v|/dy of this flow is about 1.1e3 1/s on 900 x 180."""

THESIS_U_INF = 0.694444
"""Mean velocity over the box at the start (thesis table 3.2), m/s."""

THESIS_TABLE_3_3 = {
    900: {"u_max": 1.4997, "cd_mean": 3.383686, "cd_max": 3.475995, "cd_min": 3.096412, "cl_mean": -0.013952,
          "cl_max": 1.171720, "cl_min": -1.199907, "cl_peak_to_peak": 2.371627, "st": 0.2703},
    1000: {"u_max": 1.4994, "cd_mean": 3.256428, "cd_max": 3.336625, "cd_min": 3.002624, "cl_mean": -0.007580,
           "cl_max": 1.048816, "cl_min": -1.071858, "cl_peak_to_peak": 2.120674},
    1100: {"u_max": 1.5, "cd_mean": 3.270474, "cd_max": 3.349443, "cd_min": 3.021291, "cl_mean": -0.005982,
           "cl_max": 1.045971, "cl_min": -1.067240, "cl_peak_to_peak": 2.113211},
}  # fmt: skip
"""As printed; the Strouhal number is in the text, from peak to peak is max - min."""

THESIS_TABLE_3_4 = {400: 3.361607, 600: 3.468580, 800: 3.333011, 900: 3.383686, 1000: 3.256428, 1100: 3.270474}
"""Mean drag coefficient by points along x, averaged from t = 0.2 s."""


QUANTITIES = {"2D-1": ("cd_mean", "cl_mean", "dp_mean"), "2D-2": ("cd_max", "cl_peak_to_peak", "st")}
"""What the errors are taken of."""

LABELS = {"cd_mean": "$c_D$", "cl_mean": "$c_L$", "dp_mean": "$\\Delta p$", "cd_max": "$c_D$ max",
          "cl_peak_to_peak": "$c_L$ peak to peak", "st": "St"}  # fmt: skip

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")
"""Colours that colour-blind readers tell apart (Okabe & Ito 2008)."""

MARKERS = "osv^Dp*"
"""One less than the colours, so that pairs do not repeat soon; x is for what failed."""


@dataclass(frozen=True)
class Case:
    """One run. What is None is as in the scene that ships."""

    name: str
    flow: str
    nx: int
    dt: float
    mask: str = "curvature"
    """`curvature`, `shear` and `none` are wall targets of the log-linear profile."""
    c_eta: float = 1e-5
    filter: str = "smooth"
    scheme: str = "sbdf2"
    """`rk2` has C_eta in the inflow zone as well."""
    offset_x: float = 0.0
    """Shift of the grid against the cylinder in cells."""
    offset_y: float = 0.0
    end: float | None = None
    max_cfl: float | None = None
    thesis: bool = False
    """With an impulsive start, and fields at the end."""

    @property
    def ny(self) -> int:
        return self.nx // 5

    def scene(self) -> dict:
        """The scene of this case."""
        scene = load(ROOT / "scenes" / f"{SCENES[self.flow]}.json")
        box, inflow = scene["fluid"]["box"], scene["fluid"]["inflow"]
        for axis, cells, offset in (("x", self.nx, self.offset_x), ("y", self.ny, self.offset_y)):
            low, high = box[axis]
            shift = offset * (high - low) / cells
            box[axis] = [low + shift, high + shift]
        inflow["x"][0] = box["x"][0]
        changes = {
            "name": f"cylinder-{self.flow.lower().replace('-', '')}-{self.name.replace('/', '-')}",
            "fluid.box.cells": [self.nx, self.ny],
            "time.communication_step": self.dt,
            "fluid.time_stepping.max_step": self.dt,
            "fluid.mask": self.mask_of_scene(),
            "fluid.filter": self.filter,
        }
        if self.scheme != "sbdf2":
            changes["fluid.time_stepping.scheme"] = self.scheme
        if self.end is not None:
            changes["time.end"] = self.end
        if self.max_cfl is not None:
            changes["fluid.time_stepping.max_cfl"] = self.max_cfl
        if self.scheme == "rk2":  # else the inflow zone would decide on its step
            changes["fluid.inflow.c_eta"] = self.c_eta
        if self.thesis:
            changes |= {"fluid.inflow.mean_velocity": {"steady": 1.0}, "fluid.initial_velocity": [THESIS_U_INF, 0.0]}
        for key, value in changes.items():
            override(scene, f"{key}={json.dumps(value)}")
        return scene

    def mask_of_scene(self) -> dict:
        kind, _, variant = self.mask.partition(", ")
        uncorrected = {"displacement_corrected": False} if variant == "uncorrected" else {}
        if kind == "sharp":
            return {"sharp": {"c_eta": self.c_eta} | uncorrected}
        if kind == "cosine":
            return {"cosine": {"c_eta": self.c_eta, "half_width": 1.0} | uncorrected}
        return {"log_linear": {"c_eta": self.c_eta, "target": kind}}

    @property
    def key(self) -> str:
        """What decides whether a known result still holds: the scene and the fluid's library."""
        text = package.scene_text(self.scene()).encode() + package.library("fluid").read_bytes()
        return hashlib.sha256(text).hexdigest()[:16]

    @property
    def cost(self) -> float:
        """Estimated wall time, s."""
        steps = self.scene()["time"]["end"] / self.dt
        if self.scheme == "rk2":
            steps *= max(1.0, self.dt / self.c_eta)
        return steps * self.nx * self.ny * COST[self.scheme]


def cases() -> Iterator[Case]:
    """All of them, group by group; what stands before the slash is the group."""

    def at(flow: str, nx: int, name: str, **changes) -> Case:
        return Case(name, flow, nx, changes.pop("dt", STEP[flow] / nx), **changes)

    for flow, grids in GRIDS.items():
        for nx in grids:
            yield at(flow, nx, f"grid/{flow}-curvature-{nx}")
            for mask, c_eta in (("shear", 1e-5), ("none", 1e-5), ("cosine", 1e-4), ("sharp", 1e-4)):
                if nx <= COARSE or (mask != "sharp" and nx == 900 and flow == "2D-2"):
                    yield at(flow, nx, f"grid/{flow}-{mask}-{nx}", mask=mask, c_eta=c_eta)
    for nx in (300, 450, 600):
        for mask in ("cosine, uncorrected", "sharp, uncorrected"):
            yield at("2D-2", nx, f"grid/2D-2-{mask.replace(', ', '-')}-{nx}", mask=mask, c_eta=1e-4)
        yield at("2D-2", nx, f"grid/2D-2-cosine-rk2-{nx}", mask="cosine", c_eta=1e-3, scheme="rk2")
    for dt in (6.25e-4, 5e-4, 2.5e-4, 1.25e-4):  # from the largest that the unit does not divide
        free = {"dt": dt, "max_cfl": LARGEST_CFL["sbdf2"]}
        yield at("2D-2", 450, f"dt/sbdf2-{dt:g}", **free)
        yield at("2D-2", 450, f"dt/sbdf2-cosine-{dt:g}", mask="cosine", c_eta=1e-3, **free)
    for dt in (1e-3, 7.5e-4, 5e-4, 2.5e-4, 1.25e-4):
        free = {"dt": dt, "max_cfl": LARGEST_CFL["rk2"]}
        yield at("2D-2", 450, f"dt/rk2-cosine-{dt:g}", mask="cosine", c_eta=1e-3, scheme="rk2", **free)
    for c_eta in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6):
        for mask in ("curvature", "cosine", "cosine, uncorrected", "sharp"):
            yield at("2D-2", 450, f"c_eta/{mask.replace(', ', '-')}-{c_eta:g}", mask=mask, c_eta=c_eta)
    for nx in (600, 900):
        yield at("2D-2", nx, f"hard/curvature-{nx}-1e-06", c_eta=1e-6)
    yield at("2D-2", 600, "hard/curvature-600-0.0001", c_eta=1e-4)
    for truncation in ("none", "two_thirds"):
        for nx in (450, 600):
            yield at("2D-2", nx, f"filter/{truncation}-{nx}", filter=truncation)
    for x, y in ((0.25, 0.25), (0.5, 0.0), (0.0, 0.5)):
        for mask, c_eta in (("curvature", 1e-5), ("none", 1e-5), ("cosine", 1e-4), ("sharp", 1e-4)):
            yield at("2D-1", 450, f"offset/2D-1-{mask}-{x:g}-{y:g}", mask=mask, c_eta=c_eta, offset_x=x, offset_y=y)
        yield at("2D-2", 600, f"offset/2D-2-curvature-{x:g}-{y:g}", offset_x=x, offset_y=y)
    yield at("2D-2", 900, "offset/2D-2-curvature-900", offset_x=0.5, offset_y=0.5)
    for nx in THESIS_GRIDS:
        settings = {"mask": "sharp, uncorrected", "c_eta": 1e-3, "filter": "two_thirds", "scheme": "rk2", "end": THESIS_END}
        yield at("2D-2", nx, f"thesis/{nx}", dt=THESIS_STEP / nx, thesis=True, **settings)


@dataclass
class Row:
    """A case and what came out of it, as it stands in results.csv."""

    case: str
    key: str
    flow: str
    nx: int
    ny: int
    dt: float
    mask: str
    c_eta: float
    filter: str
    scheme: str
    offset_x: float
    offset_y: float
    result: str
    """`ok`, or why it failed."""
    periods: int | None = None
    flow_rate: float | None = None
    """Mean over the window, m²/s."""
    u_max: float | None = None
    """Largest velocity along x at the end of the inflow zone, m/s; where there are fields."""
    cfl: float | None = None
    """Largest CFL number of a step: half of what it would be where the unit has divided a step in two."""
    wall_s: float | None = None
    """Median over the repeats of the wall time of the loop over steps, s, and its quartiles."""
    wall_q1: float | None = None
    wall_q3: float | None = None
    cpu_s: float | None = None
    """The same of the processor time."""
    cpu_q1: float | None = None
    cpu_q3: float | None = None
    repeats: int | None = None
    values: dict[str, float] = field(default_factory=dict)
    """Of `coefficients.NAMES`; columns of their own in the file."""

    @classmethod
    def of(cls, case: Case, **result) -> "Row":
        shared = {f.name for f in fields(cls)} & {f.name for f in fields(case)}
        return cls(case.name, case.key, ny=case.ny, **{name: getattr(case, name) for name in shared}, **result)


def known() -> dict[str, dict]:
    """Rows of results.csv by case."""
    return {row["case"]: row for row in read(RESULTS, "results")} if (RESULTS / "results.csv").is_file() else {}


def keep(row: Row) -> None:
    """Put a row into results.csv, in place of an older one of the same case."""
    rows = {}
    if (RESULTS / "results.csv").is_file():
        with open(RESULTS / "results.csv", encoding="utf-8", newline="") as file:
            rows = {before["case"]: before for before in csv.DictReader(file)}
    cells = asdict(row)
    values = cells.pop("values")
    rows[row.case] = cells | {name: values.get(name) for name in coefficients.NAMES}
    write_csv(RESULTS / "results.csv", list(rows.values()))


def folder_of(case: Case) -> Path:
    return RESULTS / case.name.replace("/", "-")


def simulate(case: Case) -> dict | str:
    """Run a case in a process of its own: its summary, or why it failed."""
    folder = folder_of(case)
    folder.mkdir(parents=True, exist_ok=True)
    scene = case.scene()
    path = folder / "case.json"
    path.write_text(package.scene_text(scene), encoding="utf-8")
    command = [sys.executable, ROOT / "scripts" / "fsi.py", "run", path, "--output", folder, "--quiet"]
    if case.thesis:
        command += ["--fields-every", str(scene["time"]["end"])]
    done = subprocess.run(command, env=os.environ | THREADS, capture_output=True, text=True)
    for fmu in folder.glob("*.fmu"):
        fmu.unlink()
    if done.returncode == 130:
        raise KeyboardInterrupt
    if done.returncode != 0:
        return done.stderr.strip().splitlines()[-1].removeprefix("error: ")
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return summary if summary["coefficients"] is not None else "no coefficients"


def repeats(case: Case, cpu: float) -> int:
    """How often a case runs that takes `cpu` seconds."""
    if case.name.partition("/")[0] not in TIMED or cpu > 20:
        return 1
    return 5 if cpu <= 10 else 3


def run(case: Case) -> Row:
    """Run a case, short ones several times."""
    runs = [simulate(case)]
    if isinstance(runs[0], str):
        return Row.of(case, result=runs[0])
    runs += [simulate(case) for _ in range(repeats(case, runs[0]["cpu_s"]) - 1)]
    summary = runs[0]
    if any(again["coefficients"] != summary["coefficients"] for again in runs):
        return Row.of(case, result="another run of it gave other numbers")
    series = np.genfromtxt(folder_of(case) / "series.csv", delimiter=",", names=True)
    window = statistics.Window(*summary["window_s"], summary["periods"])
    times = {}
    for clock in ("wall", "cpu"):
        quartiles = np.percentile([run[f"{clock}_s"] for run in runs], [25, 50, 75]).tolist()
        times |= dict(zip((f"{clock}_q1", f"{clock}_s", f"{clock}_q3"), quartiles))
    return Row.of(
        case,
        result="ok",
        periods=summary["periods"],
        flow_rate=float(series["flow_rate"][window.of(series["time"])].mean()),
        u_max=float(inlet_profile(case)[1].max()) if case.thesis else None,
        cfl=float(series["cfl"].max()),
        repeats=len(runs),
        values=summary["coefficients"]["values"],
        **times,
    )


def last_field(case: Case, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y (m) and a field of the last frame of a case, `[ny, nx, …]`."""
    import h5py

    with h5py.File(folder_of(case) / "fields.vtkhdf") as file:
        root = file["VTKHDF"]
        values = root[f"PointData/{name}"][root["Steps"].attrs["NSteps"] - 1]
        origin, spacing = root.attrs["Origin"], root.attrs["Spacing"]
    x, y = (origin[axis] + spacing[axis] * np.arange(values.shape[1 - axis]) for axis in (0, 1))
    return x, y, values


def inlet_profile(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """y (m) and the velocity along x (m/s) at the end of the inflow zone, across the channel."""
    x, y, velocity = last_field(case, "velocity")
    inside = (y >= 0) & (y <= 0.41)
    return y[inside], velocity[inside, np.searchsorted(x, 0.0), 0]


def error(row: dict, quantity: str) -> float:
    """Relative error of a quantity; not a number where the run failed."""
    value, expected = row.get(quantity), REFERENCE[row["flow"]][quantity]
    return abs(value / expected - 1) if value is not None else np.nan


def group(rows: dict[str, dict], name: str, flow: str | None = None) -> list[dict]:
    return [row for case, row in rows.items() if case.startswith(f"{name}/") and flow in (None, row["flow"])]


def series_of(rows: list[dict], *keys: str) -> dict[str, list[dict]]:
    """Rows that differ in nothing else but `keys`' values, by a label made of those."""
    found = {}
    for row in rows:
        found.setdefault(", ".join(str(row[key]) for key in keys), []).append(row)
    return found


def panels(name: str, rows: list[dict], flow: str, along: str, label: str, keys: tuple[str, ...]) -> None:
    """Figure NAME.png: the errors of the three quantities over column `along`, a line for each value of `keys`; what
    failed stands at the upper edge."""
    if not rows:
        return
    figure, axes = plt.subplots(1, 3, figsize=(13, 4.6), layout="constrained")
    looks = dict(zip(series_of(rows, *keys), zip(cycle(COLOURS), cycle(MARKERS))))
    for axis, quantity in zip(axes, QUANTITIES[flow]):
        for key, part in series_of(rows, *keys).items():
            colour, marker = looks[key]
            good = sorted((row[along], error(row, quantity)) for row in part if row.get(quantity))
            if good:
                axis.plot(
                    *zip(*good), marker + ("" if along == "cpu_s" else "-"), color=colour, markersize=4, linewidth=1
                )
            for row in part:
                if row["result"] != "ok" and row[along]:
                    axis.plot(row[along], 0.97, "x", color=colour, transform=axis.get_xaxis_transform())
        if any(row.get(quantity) for row in rows):
            axis.set(xscale="log", yscale="log")
        axis.set(xlabel=label, title=LABELS[quantity])
        axis.grid(True, which="major", linewidth=0.4, alpha=0.6)
    axes[0].set_ylabel("relative error (x at the top: failed)")
    lines = [
        Line2D([], [], color=colour, marker=marker, markersize=4, linewidth=1) for colour, marker in looks.values()
    ]
    figure.legend(lines, looks, loc="outside lower center", ncols=4, fontsize=8)
    save(figure, name)


def save(figure, name: str) -> None:
    figure.savefig(DOCS / f"{name}.png", dpi=110, metadata={"Software": None})
    plt.close(figure)


def page(title: str, header: list[str], cells: list[list[str]], note: str = "") -> str:
    """A page with one table."""
    head = [f"# {title}", "", *([note, ""] if note else [])]
    return "\n".join(head + markdown(header, cells)) + "\n"


def error_tables(name: str, title: str, rows: list[dict], note: str) -> dict[str, str]:
    """Pages of cases with their values and errors, one for each flow."""

    def shown(row: dict, quantity: str) -> str:
        if row.get(quantity) is None:
            return ""
        return f"{row[quantity]:.5g} ({(row[quantity] / REFERENCE[row['flow']][quantity] - 1) * 100:+.2f} %)"

    def number(value: float | None, form: str) -> str:
        return "" if value is None else format(value, form)

    pages = {}
    flows = dict.fromkeys(row["flow"] for row in rows)
    for flow in flows:
        cells = []
        for row in (row for row in rows if row["flow"] == flow):
            offset = f"{row['offset_x']:g}, {row['offset_y']:g}"
            settings = [f"{row['nx']:.0f} x {row['ny']:.0f}", f"{row['dt']:.3g}", row["mask"], f"{row['c_eta']:.0e}",
                        row["filter"], row["scheme"], offset]  # fmt: skip
            rest = [
                number(row["flow_rate"], ".4f"),
                number(row["cfl"], ".2f"),
                number(row["cpu_s"], ".3g"),
                number(row["wall_s"], ".3g"),
                number(row["repeats"], ".0f"),
            ]
            cells.append([*settings, *(shown(row, quantity) for quantity in QUANTITIES[flow]), *rest, row["result"]])
        header = ["grid", "dt, s", "mask", "C_eta, s", "filter", "scheme", "offset, cells", *QUANTITIES[flow],
                  "flow rate, m²/s", "largest CFL", "CPU, s", "wall, s", "runs", "result"]  # fmt: skip
        suffix = f"_{flow.lower().replace('-', '')}" if len(flows) > 1 else ""
        expected = ", ".join(f"{q} {REFERENCE[flow][q]:.6g}" for q in QUANTITIES[flow])
        about = f"{note} In brackets the error against {expected}. Times are medians over the runs."
        pages[f"{name}{suffix}"] = page(f"{title}, {flow}", header, cells, about)
    return pages


def thesis_tables(rows: dict[str, dict]) -> dict[str, str]:
    """Tables 3.3 and 3.4 of the thesis, its settings run again, and ours."""
    again = {row["nx"]: row for row in group(rows, "thesis")}
    ours = {row["nx"]: row for row in group(rows, "grid", "2D-2") if row["mask"] == "curvature"}

    def number(row: dict | None, quantity: str) -> str:
        value = (row or {}).get(quantity)
        return f"{value:.4f}" if isinstance(value, float) else (row or {}).get("result", "").removeprefix("ok")

    header, levels = ["quantity"], tuple(THESIS_TABLE_3_3)
    for nx in levels:
        header += [f"{nx} x {nx // 5}: thesis", "repeated", "ours"]
    lines = []
    for quantity in ("u_max", "cd_mean", "cd_max", "cd_min", "cl_mean", "cl_max", "cl_min", "cl_peak_to_peak", "st"):
        cells = [quantity]
        for nx in levels:
            cells += [number(source.get(nx), quantity) for source in (THESIS_TABLE_3_3, again, ours)]
        expected = REFERENCE["2D-2"].get(quantity)
        lines.append([*cells, f"{expected:.6g}" if expected else ""])
    note = (
        "Repeated: the thesis' settings (Heun, sharp mask where the cylinder is, C_eta = 1e-3 s, two-thirds rule, "
        f"{THESIS_END:g} s) over the last five periods, means as (max + min) / 2; the thesis averages from t = 0.2 s. Ours: "
        "the shipped scene on that grid. Forces are coefficient / 20, N per metre."
    )
    means = [
        [f"{nx} x {nx // 5}", f"{printed:.4f}", number(again.get(nx), "cd_mean"), number(ours.get(nx), "cd_mean"),
         f"{REFERENCE['2D-2']['cd_mean']:.4f}"]
        for nx, printed in THESIS_TABLE_3_4.items()
    ]  # fmt: skip
    title, drag = "Flow past the cylinder (thesis table 3.3)", "Mean drag coefficient over grids (thesis table 3.4)"
    return {
        "thesis_3_3": page(title, [*header, "reference"], lines, note),
        "thesis_3_4": page(drag, ["grid", "thesis", "repeated", "ours", "reference"], means),
    }


def thesis_figures() -> None:
    """What figures 3.3 to 3.6 of the thesis and the unnumbered ones before them show, of the runs with its settings:
    coefficients over time, the vorticity at the end, the profile behind the inflow zone."""
    runs = [case for case in cases() if case.thesis and case.nx in THESIS_TABLE_3_3]
    runs = [case for case in runs if (folder_of(case) / "fields.vtkhdf").is_file()]
    if not runs:
        return
    figure, axes = plt.subplots(2, sharex=True, figsize=(10, 6), layout="constrained")
    for case, colour in zip(runs, COLOURS):
        series = np.genfromtxt(folder_of(case) / "series.csv", delimiter=",", names=True)
        force = coefficients.scale(case.scene()).force
        for axis, name, label in zip(axes, ("drag", "lift"), ("$c_D$", "$c_L$")):
            axis.plot(series["time"], series[name] / force, color=colour, linewidth=0.6, label=f"{case.nx} x {case.ny}")
            axis.set_ylabel(label)
    axes[0].set(ylim=(2.5, 4.0), xlim=(0, runs[0].end))
    axes[0].legend(fontsize=8)
    axes[1].set_xlabel("time [s]")
    save(figure, "thesis_coefficients")

    figure, axes = plt.subplots(len(runs), figsize=(10, 2.2 * len(runs)), layout="constrained", squeeze=False)
    for axis, case in zip(axes[:, 0], runs):
        x, y, vorticity = last_field(case, "vorticity")
        picture = axis.imshow(vorticity, origin="lower", extent=(x[0], x[-1], y[0], y[-1]), cmap="RdBu_r", vmin=-60,
                              vmax=60, interpolation="bilinear")  # fmt: skip
        axis.add_patch(plt.Circle((0.2, 0.2), 0.05, color="0.55"))
        axis.set(ylim=(0, 0.41), ylabel="y [m]", title=f"{case.nx} x {case.ny}, t = {case.end:g} s")
    axes[-1, 0].set_xlabel("x [m]")
    figure.colorbar(picture, ax=axes, label="vorticity [1/s]", extend="both", pad=0.01)
    save(figure, "thesis_vorticity")

    figure, axis = plt.subplots(figsize=(6, 4.4), layout="constrained")
    for case, colour in zip(runs, COLOURS):
        y, u = inlet_profile(case)
        axis.plot(u, y, color=colour, linewidth=1, label=f"{case.nx} x {case.ny}: largest {u.max():.4f} m/s")
    y = np.linspace(0, 0.41, 200)
    axis.plot(6 * y * (0.41 - y) / 0.41**2, y, "k--", linewidth=0.8, label="parabola, 1.5 m/s")
    axis.set(xlabel="u at the end of the inflow zone [m/s]", ylabel="y [m]")
    axis.legend(fontsize=8)
    save(figure, "thesis_profile")


GROUPS = (
    ("grid", "Convergence in the grid", "The step is proportional to the cell."),
    ("dt", "Convergence in the step", "`max_cfl` is the largest that the scheme allows, and divides no step."),
    ("c_eta", "Convergence in C_eta", "One grid, one step."),
    ("hard", "C_eta on finer grids", "The default mask."),
    ("filter", "The filter", "The default mask."),
    ("offset", "The grid's place", "The box is shifted by parts of a cell against the cylinder."),
)


def rows_of_cases() -> dict[str, dict]:
    """Rows of docs/fluid/results.csv by case, as `cases` has them."""
    found = {row["case"]: row for row in read(DOCS, "results")}
    return {case.name: found[case.name] for case in cases() if case.name in found}


def tables() -> dict[Path, str]:
    """The pages of results.csv."""
    rows = rows_of_cases()
    made = thesis_tables(rows)
    for name, title, note in GROUPS:
        made |= error_tables(name, title, group(rows, name), note)
    return {DOCS / f"{name}.md": text for name, text in made.items()}


STABILITY = """# Stability of the fluid

Written by `make fluid-measures` into stability.csv.

The cylinder in a channel of Schäfer and Turek on 200 x 40 points, density 1, mean inflow 1 m/s that starts by a jump at
t = 0, up to t = 2 s, in steps of at most 0.01 s and the given CFL number. Each cell: the largest speed in m/s at the end of
any communication step of 0.01 s where the run went through with everything finite (the peak of the inflow is 1.5 m/s), or the
letter of the error, below. What is 10 m/s or more, or not finite, would be **bad**. A CFL number of 1 is above the limit of both
schemes ([fluid.md](../fluid.md)).
"""


def stability(rows: list[dict]) -> str:
    """The page of the map of stability."""
    letters: dict[str, tuple[str, str]] = {}

    def cell(row: dict) -> str:
        if row["outcome"] == "ok":
            return f"{row['speed']:.1f}"
        if row["outcome"] == "bad":
            return f"**bad** {row['message']}" + (f", {row['speed']:.0f}" if row["speed"] else "")
        # One letter for each kind of message, with the numbers of its first case.
        kind = re.sub(r"[-+\d.e]+", "", row["message"])
        letter, _ = letters.setdefault(kind, (chr(ord("A") + len(letters)), row["message"]))
        return letter if row["time"] is None else f"{letter} at {row['time']:.2f} s"

    text = [STABILITY]
    maps = [row for row in rows if row["scene"] is None]
    for name in dict.fromkeys(row["group"] for row in maps):
        part = [row for row in maps if row["group"] == name]
        c_etas = list(dict.fromkeys(row["c_eta"] for row in part))
        lines: dict[tuple, dict] = {}
        for row in part:
            lines.setdefault((row["reynolds"], row["cfl"]), {})[row["c_eta"]] = cell(row)
        header = ["Re", "CFL", *(f"C_eta {c_eta:.0e}" for c_eta in c_etas)]
        cells = [[f"{re_:g}", f"{cfl:g}", *(found[c_eta] for c_eta in c_etas)] for (re_, cfl), found in lines.items()]
        text += [f"## {name}", "", *markdown(header, cells), ""]
    hard: dict[str, dict] = {}
    for row in rows:
        if row["scene"] is not None:
            hard.setdefault(row["scene"], {})[row["reynolds"]] = cell(row)
    text += ["## Hard scenes", "", "The same channel, log-linear mask, C_eta = 1e-5 s, CFL 0.4.", ""]
    text += [*markdown(["scene", "Re 20", "Re 1e4"], [[name, found[20.0], found[1e4]] for name, found in hard.items()]), ""]
    counts = {what: sum(row["outcome"] == what for row in rows) for what in ("ok", "error", "bad")}
    text += [f"{counts['ok']} runs went through, {counts['error']} ended in an error, {counts['bad']} were bad."]
    for letter, message in letters.values():
        text += ["", f"{letter} (first case): {message}"]
    return "\n".join(text) + "\n"


def pages() -> dict[Path, str]:
    """All pages of docs/fluid, of results.csv and stability.csv."""
    return tables() | {DOCS / "stability.md": stability(read(DOCS, "stability"))}


def document() -> None:
    """Write docs/fluid anew from the results."""
    DOCS.mkdir(parents=True, exist_ok=True)
    write_whole(DOCS / "results.csv", lambda path: path.write_bytes((RESULTS / "results.csv").read_bytes()))
    for path, text in tables().items():
        write_whole(path, lambda new: new.write_text(text, encoding="utf-8"))
    thesis_figures()
    rows = rows_of_cases()
    for flow in SCENES:
        part = group(rows, "grid", flow)
        suffix = flow.lower().replace("-", "")
        panels(f"grid_{suffix}", part, flow, "nx", "points along x", ("mask", "scheme"))
        panels(
            f"work_{suffix}", part + group(rows, "thesis", flow), flow, "cpu_s", "processor time [s]", ("mask", "scheme")
        )
    panels("dt", group(rows, "dt"), "2D-2", "dt", "dt [s]", ("scheme", "mask"))
    panels("c_eta", group(rows, "c_eta"), "2D-2", "c_eta", "$C_\\eta$ [s]", ("mask",))


def main(
    only: Annotated[str, typer.Option(metavar="PATTERN", help="Run only cases of this name, e.g. 'dt/*'.")] = "*",
    jobs: Annotated[int, typer.Option(min=1, help="Runs at a time.")] = 1,
    listing: Annotated[bool, typer.Option("--list", help="Only list the cases.")] = False,
) -> None:
    """Run the cases that are missing, then write docs/fluid."""
    rows = known()
    chosen = [case for case in cases() if fnmatch(case.name, only)]
    missing = [case for case in chosen if rows.get(case.name, {}).get("key") != case.key]
    if listing:
        for case in chosen:
            state = f"about {case.cost:.0f} s" if case in missing else rows[case.name]["result"]
            print(
                f"{case.name:44}{case.nx:5} x {case.ny:<4} dt {case.dt:<10.3g}{case.mask:22}{case.c_eta:<8.0e}{state}"
            )
        print(
            f"{len(missing)} of {len(chosen)} to run, about {sum(case.cost for case in missing) / 3600:.1f} h of a core"
        )
        return
    with ThreadPoolExecutor(jobs) as pool:
        try:
            for i, done in enumerate(as_completed([pool.submit(run, case) for case in missing])):
                row = done.result()
                keep(row)
                print(f"{i + 1} of {len(missing)}: {row.case}, {row.wall_s or 0:.0f} s, {row.result}", flush=True)
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)
            raise typer.Exit(130) from None
    if known():
        document()


if __name__ == "__main__":
    typer.run(main)
