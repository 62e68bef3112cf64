"""FSI3: grids, sensitivities, iterations, and the balance at the interface."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from nervure.evaluate import statistics
from studies import show, simulate
from studies.engine import COUPLED, Case, Run, Study
from studies.simulate import assignments, on_grid
from studies.store import Data

Changes = dict[str, Any]
Series = dict[str, np.ndarray]
View = dict[str, Any]

COARSE, FINE, FINEST = "fsi3-325x72", "fsi3-650x144", "fsi3-1300x288"
SIGNALS = {"tip_ux": "$u_x$ [mm]", "tip_uy": "$u_y$ [mm]", "drag": "drag [N/m]", "lift": "lift [N/m]"}
GRIDS = ("325x72", "650x144", "960x216", "1300x288")
SHIPPED = ("325x72", "650x144", "1300x288")

LISTED: dict[str, Any] = simulate.LISTED["fsi3"]
ONLY = ("tip_uy.amplitude", "tip_uy.frequency_hz", "drag.mean", "drag.amplitude", "lift.amplitude")
"""Compared quantities."""
VARIED = ("coarse", "fine")  # Groups with one change at a time

RAMP = "fluid.inflow.mean_velocity.cosine_ramp.duration"
RATIOS, ACCELERATIONS = (1, 0.1, 0.01), ("iqn_ils", "aitken")
EXCHANGE_STEPS = (4e-4, 2e-4, 1e-4)
EXCHANGE_WINDOWS = {"first": (0.0, 0.5), "swinging": (1.2, 1.6)}
"""Intervals in which both sides of the interface are compared, s."""

SAMPLES, SHOWN_PERIODS = 120, 2  # Recorded points of the series of each grid, and the periods that they span


def label(changes: Changes) -> str:
    """Return changes as text for a table."""
    return ", ".join(f"`{text}`" for text in assignments(changes))


def cases() -> Iterator[Case]:
    def case(name: str, scene: str, changes: Changes, said: str = "", **options: Any) -> Case:
        about: dict[str, Any] = {"name": said or name.split("/")[1].replace("x", " x "), "only": ONLY}
        about |= {"published": scene if name.startswith(("grid", *VARIED)) else "", "grid": about["name"]}
        return Case(name, COUPLED, scene, changes, options, about=about, quick=scene == COARSE)

    yield case("grid/325x72", COARSE, {})
    yield case("grid/650x144", FINE, {}, pictures=True)
    yield case("grid/960x216", FINE, on_grid(960, 216, 1.3e-4))
    yield case("grid/1300x288", FINEST, {})
    for group in VARIED:
        for changes in LISTED[group]["changes"]:
            yield case(f"{group}/{', '.join(assignments(changes))}", LISTED[group]["scene"], changes, label(changes))
    for ratio in RATIOS:
        for name in ACCELERATIONS:
            scheme = {"load": "pressure_jump", "scheme": {"iterated": {"acceleration": name}}}
            light = {"rod.material.plane_strain.density": 1000 * ratio, "coupling": scheme}
            yield case(f"iterations/{ratio:g}, {name}", COARSE, {"time.end": 0.15, RAMP: 0.5} | light)
    for step in EXCHANGE_STEPS:
        end = 0.5 if step == EXCHANGE_STEPS[-1] else 1.6
        yield case(f"exchange/{step:g}", COARSE, {RAMP: 0.2, "time.end": end, "time.communication_step": step})


def extract(case: Case, run: Run) -> dict[str, Any]:
    summary, series, group = run.found, run.series, case.name.split("/")[0]
    values = simulate.quantities(summary) | {"periods": summary["periods"], "reached": summary["simulated_s"]}
    values |= {"iterations": summary["iterations_mean"], "cfl": series["cfl"].max()}
    values |= exchange(series) if group == "exchange" else {}
    values = {name: float(value) for name, value in values.items() if value is not None and np.isfinite(value)}
    tables = {"periods": last_periods(series)} if group == "grid" else {}
    return {"values": values, "tables": tables, "times": simulate.times(summary)}


def exchange(series: Series) -> dict[str, float]:
    """Return differences between the load on the rod and the force of the fluid: rms of the lift by the rms of the
    lift; sum of the magnitudes of the work of each step by the exchanged work; net work by the exchanged work."""
    found = {}
    for name, (begin, end) in EXCHANGE_WINDOWS.items():
        inside = (series["time"] > begin) & (series["time"] <= end)
        if series["time"][-1] < end - 1e-9:
            continue
        part = {key: values[inside] for key, values in series.items()}
        took, gave = np.diff(part["load_work"]), np.diff(part["beam_work"])
        exchanged = np.abs(gave).sum()
        found[f"{name}.lift"] = np.std(part["load_y"] - part["beam_load_y"]) / np.std(part["beam_load_y"])
        found[f"{name}.work"] = np.abs(took - gave).sum() / exchanged
        found[f"{name}.net"] = (took - gave).sum() / exchanged
        found[f"{name}.tip"] = np.ptp(part["tip_uy"]) / 2
    return found


def last_periods(series: Series) -> list[dict[str, float]]:
    """Return the last whole periods, from an upward crossing of uy on, by the fundamental frequency."""
    time = series["time"]
    window = statistics.find_window(time, series["tip_uy"])
    period = (window.end - window.begin) / window.periods
    at = np.linspace(window.end - SHOWN_PERIODS * period, window.end, SAMPLES)
    width = statistics.force_filter_width(window)
    columns = {"phase": (at - at[0]) / period}
    for name in SIGNALS:
        values = statistics.box_filter(time, series[name], width) if name in ("drag", "lift") else series[name]
        columns[name] = np.interp(at, time, values)
    return [dict(zip(columns, map(float, row))) for row in zip(*columns.values())]


def published(scene: str, name: str) -> View:
    return {"name": name} | {quantity: value for quantity, (value, _) in simulate.published(scene).items()}


def level_4() -> View:
    return published(COARSE, "FeatFlow, level 4")


def of(data: Data, pattern: str) -> list[View]:
    return [record.view for record in data.of(f"fsi3/{pattern}")]


def readme(data: Data) -> list[View]:
    whole = [data[f"fsi3/grid/{grid}"].view | {"name": f"`make fsi3 GRID={grid}`"} for grid in reversed(SHIPPED)]
    first = data["turek-hron/fsi3/648x108"].view | {"name": "`make fsi3` (648 x 108)"}
    return [level_4() | {"name": "reference (FeatFlow, level 4)"}, first, *whole]


def costs(data: Data) -> list[View]:
    """Return the processor time and the shares of the units by grid."""
    rows = []
    for record in data.of("fsi3/grid/*"):
        phases = record.times["phases_s"]
        shares = {kind: phases[kind] / record["wall_s"] for kind in ("rod", "fluid")}
        more = {"exchange": 1 - sum(shares.values()), "spent": record["cpu_s"] / record["reached"]}
        rows.append(record.view | shares | more)
    return rows


def varied(group: str, data: Data) -> list[View]:
    """Return the effect of each change on the grid of a group."""
    return [data[f"fsi3/grid/{LISTED[group]['grid']}"].view | {"name": "none"}, *of(data, f"{group}/*")]


def iterations(data: Data) -> list[str]:
    """Return a table of mean iterations a step, by density ratio and acceleration."""

    def cell(ratio: float, name: str) -> str:
        record = data[f"fsi3/iterations/{ratio:g}, {name}"]
        return f"stops at t = {1e3 * record['reached']:.0f} ms" if record.error else f"{record['iterations']:.1f}"

    ratios, names = {f"{ratio:g}": ratio for ratio in RATIOS}, {f"`{name}`": name for name in ACCELERATIONS}
    return show.matrix("density ratio", ratios, names, cell)


def exchanged(data: Data) -> list[View]:
    """Return differences between both sides of the interface, over window and step."""
    rows = []
    for window, (begin, end) in EXCHANGE_WINDOWS.items():
        for step in EXCHANGE_STEPS:
            found = data[f"fsi3/exchange/{step:g}"]
            row = {name: found.get(f"{window}.{name}") for name in ("lift", "work", "net", "tip")}
            if row["tip"] is not None:
                moved = row["tip"] if row["tip"] > 1e-3 else None
                rows.append(row | {"begin": begin, "end": end, "step": step, "moved": moved})
    return rows


TABLES: dict[str, Callable[[Data], Any]] = {
    "fsi3": readme,
    "fsi3-costs": costs,
    "fsi3-fine": partial(varied, "fine"),
    "coupling-iterations": iterations,
    "coupling-exchange": exchanged,
}
STUDY = Study("fsi3", cases, extract, TABLES)
