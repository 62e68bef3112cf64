"""The benchmarks of Turek and Hron as one set, CSM1-3, CFD1-3 and FSI1-3, on the grids of a trimmed box."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nervure.evaluate import statistics
from studies import fsi3, show, simulate
from studies.driven_bar import harmonics
from studies.engine import COUPLED, FLUID, ROD, Case, Run, Study
from studies.show import COLOURS
from studies.simulate import SHALLOW, on_grid, shifted_grid
from studies.store import Data

Series = Mapping[str, np.ndarray]

FEATFLOW = Path(__file__).with_name("featflow_fsi3.csv")
SOLIDS = ("csm1", "csm2", "csm3")
FLOWS = {"cfd1": 2e-3, "cfd2": 4e-4, "cfd3": 2e-4, "fsi1": 2e-3, "fsi2": 4e-4, "fsi3": 2e-4}  # Steps on 648 x 108, s
GRIDS = ("324x54", "648x108", "1296x216")
SHIPPED = "648x108"
WALLS = {"324x54": SHALLOW}  # Other wall models than that of the shipped scenes, by grid
SWINGING = fsi3.ONLY
QUANTITIES: dict[str, tuple[str, ...]] = {
    "csm1": ("tip_ux.mean", "tip_uy.mean"),
    "csm2": ("tip_ux.mean", "tip_uy.mean"),
    "csm3": ("tip_uy.mean", "tip_uy.amplitude", "tip_uy.frequency_hz"),
    "cfd1": ("drag.mean", "lift.mean"),
    "cfd2": ("drag.mean", "lift.mean"),
    "cfd3": ("drag.mean", "drag.amplitude", "lift.amplitude", "lift.frequency_hz"),
    "fsi1": ("tip_ux.mean", "tip_uy.mean", "drag.mean", "lift.mean"),
    "fsi2": SWINGING,
    "fsi3": SWINGING,
}
"""Compared quantities of each benchmark; means near zero of swinging quantities are left out."""

PLACES = ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (0.25, 0.25), (0.37, 0.5))
"""Shifts of the grid, in parts of a cell."""
PLACED = {"324x54": PLACES, "648x108": PLACES[:5:2]}  # By grid
PLACED_CASES = {"cfd2": ("lift.mean",), "fsi3": ("tip_uy.amplitude", "lift.amplitude")}
"""Quantities that are compared over the shifts."""


def scene_of(name: str) -> str:
    """Return the shipped scene of a benchmark."""
    return name if name in SOLIDS else f"{name}-{SHIPPED}"


def cases() -> Iterator[Case]:
    for name in SOLIDS:
        yield Case(f"{name}/rod", ROD, name, about={"published": name, "only": QUANTITIES[name], "grid": name.upper()})
    for grid in GRIDS:
        nx, ny = map(int, grid.split("x"))
        for name, step in FLOWS.items():
            sources = FLUID if name.startswith("cfd") else COUPLED
            changes = {} if grid == SHIPPED else on_grid(nx, ny, step * 648 / nx) | WALLS.get(grid, {})
            about = {"published": scene_of(name), "only": QUANTITIES[name], "grid": grid.replace("x", " x ")}
            yield Case(f"{name}/{grid}", sources, scene_of(name), changes, about=about, quick=grid == GRIDS[0])
    for grid, places in PLACED.items():
        nx, ny = map(int, grid.split("x"))
        for name in PLACED_CASES:
            sources, step = COUPLED if name == "fsi3" else FLUID, FLOWS[name] * 648 / nx
            for x, y in places:
                if (x, y) != (0.0, 0.0):
                    moved = on_grid(nx, ny, step) | shifted_grid(scene_of(name), nx, ny, (x, y)) | WALLS.get(grid, {})
                    yield Case(f"place/{name}, {grid}, {x:g} {y:g}", sources, scene_of(name), moved, quick=False)


def extract(case: Case, run: Run) -> dict[str, Any]:
    swings = case.name.startswith("fsi3/")
    tables = {"periods": fsi3.last_periods(run.series), "phases": settled_phases(run.series)} if swings else {}
    return {"values": simulate.quantities(run.found), "tables": tables, "times": simulate.times(run.found)}


def settled_phases(series: Series) -> list[dict[str, Any]]:
    """Return `phases` over the last whole periods of uy, at the frequency of the best fit."""
    window = statistics.find_window(series["time"], series["tip_uy"])
    part, frequency = window.of(series["time"]), statistics.fit(series["time"], series["tip_uy"], window).frequency_hz
    assert frequency is not None, "uy does not swing"
    return phases({name: series[name][part] for name in ("time", *fsi3.SIGNALS)}, frequency)


def phases(series: Series, frequency: float) -> list[dict[str, Any]]:
    """Return the amplitude, m and N/m, of the strongest harmonic of each signal, and its phase, degrees, against the
    multiple of uy's fundamental of the same frequency."""
    found = {name: harmonics(series["time"], series[name], frequency)[0] for name in fsi3.SIGNALS}
    lead, rows = np.angle(found["tip_uy"][1]), []
    for name, order in (("tip_uy", 1), ("lift", 1), ("tip_ux", 2), ("drag", 2)):
        angle = np.degrees(np.angle(found[name][order]) - order * lead)
        rows.append({"signal": name, "order": order, "amplitude": abs(found[name][order]), "phase": angle % 360})
    return rows


def featflow() -> Series:
    """Return FeatFlow's FSI3 over a period and a third, by the names of our series, in SI units."""
    values = np.loadtxt(FEATFLOW, delimiter=",", skiprows=3, unpack=True)
    return dict(zip(("time", "drag", "lift", "tip_ux", "tip_uy"), values))


def quantity(name: str) -> tuple[str, float]:
    """Return the heading of a quantity with its unit, and the factor to that unit."""
    signal, what = name.split(".")
    if what == "frequency_hz":
        return "f, Hz", 1.0
    if signal in ("drag", "lift"):
        return f"{signal} {what}, N/m", 1.0
    return f"{signal.removeprefix('tip_')} {what}, mm", 1e3


def over_places(data: Data, name: str, grid: str, what: str) -> list[float]:
    """Return relative differences of a quantity from FeatFlow over the shifts of a grid."""
    records = [data.get(f"turek-hron/{name}/{grid}"), *data.of(f"turek-hron/place/{name}, {grid}, *")]
    number = simulate.published(scene_of(name))[what][0]
    return [record[what] / number - 1 for record in records if record and record.get(what) is not None]


def placed(data: Data) -> list[str]:
    """Return the smallest and largest difference from FeatFlow (%) over the positions of the grid."""
    rows = []
    for name, quantities in PLACED_CASES.items():
        for grid in PLACED:
            for what in quantities:
                found = over_places(data, name, grid, what)
                if len(found) > 1:
                    ends = (f"{100 * end:+.1f}" for end in (min(found), max(found)))
                    rows.append(
                        [name.upper(), quantity(what)[0].split(",")[0], grid.replace("x", " x "), len(found), *ends]
                    )
    return show.markdown(["", "quantity", "grid", "positions", "lowest, %", "highest, %"], rows)


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    """Draw two periods of FSI3 on each grid over FeatFlow's."""
    theirs, lines = featflow(), {}
    (begin,) = statistics.upward_crossings(theirs["time"], theirs["tip_uy"], *statistics.extent(theirs["tip_uy"]))
    frequency = simulate.published(scene_of("fsi3"))["tip_uy.frequency_hz"][0]
    for grid in GRIDS:
        record = data.get(f"turek-hron/fsi3/{grid}")
        if record and "periods" in record.tables:
            lines[grid.replace("x", " x ")] = record.tables["periods"]
    figure, axes = show.panel(2, 2, (9.5, 6), sharex=True)
    for axis, (name, title) in zip(axes.flat, fsi3.SIGNALS.items()):
        factor = 1e3 if name.startswith("tip") else 1.0
        axis.plot(frequency * (theirs["time"] - begin), factor * theirs[name], ".k", label="FeatFlow, level 4")
        for (label, rows), colour, style in zip(lines.items(), COLOURS, ("-", "--", "-.")):
            x, y = [row["phase"] for row in rows], [factor * row[name] for row in rows]
            axis.plot(x, y, style, color=colour, linewidth=1.3, label=label)
        axis.set_ylabel(title)
    for axis in axes[1]:
        axis.set_xlabel("periods of $u_y$")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8)
    show.save(figure, "pictures/fsi3-featflow")


TABLES: dict[str, Callable[[Data], Any]] = {"turek-hron-places": placed}
STUDY = Study("turek-hron", cases, extract, TABLES, draw)
