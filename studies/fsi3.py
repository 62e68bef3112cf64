"""FSI3: grids, sensitivities, the bar held still, settings of the thesis, iterations, and the balance at the
interface."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from nervure.evaluate import statistics
from studies import show, simulate
from studies.engine import COUPLED, FLUID, Case, Run, Study
from studies.simulate import assignments, on_grid
from studies.store import Data

Changes = dict[str, Any]
Series = dict[str, np.ndarray]
View = dict[str, Any]

COARSE, FINE, FINEST, STILL, THESIS = (
    "fsi3-325x72", "fsi3-650x144", "fsi3-1300x288", "cfd3-650x144", "fsi3-thesis-325x72"
)  # fmt: skip
SIGNALS = {"tip_ux": "$u_x$ [mm]", "tip_uy": "$u_y$ [mm]", "drag": "drag [N/m]", "lift": "lift [N/m]"}
GRIDS = ("325x72", "650x144", "960x216", "1300x288")
SHIPPED = ("325x72", "650x144", "1300x288")

LISTED: dict[str, Any] = simulate.LISTED["fsi3"]
VARIED = ("coarse", "fine")  # Groups with one change at a time

RAMP = "fluid.inflow.mean_velocity.cosine_ramp.duration"
RATIOS, ACCELERATIONS = (1, 0.1, 0.01), ("iqn_ils", "aitken")
EXCHANGE_STEPS = (4e-4, 2e-4, 1e-4)
EXCHANGE_WINDOWS = {"first": (0.0, 0.5), "swinging": (1.2, 1.6)}
"""Intervals in which both sides of the interface are compared, s."""
THESIS_WINDOWS = ((1.1, 4.375), (3.5, 4.375))
"""Intervals of the thesis' extremes (table 4.2): all, and the part that it calls more accurate, s."""

PIECE, TREND = 0.02, 4
"""Length of the pieces that are searched for short waves, s, and the degree of the polynomial that is subtracted."""
LARGE = 1.0  # Velocity of the tip, m/s, up to which a wave grows exponentially
SAMPLES, SHOWN_PERIODS = 120, 2  # Recorded points of the series of each grid, and the periods that they span


def label(changes: Changes, without: str = "") -> str:
    """Return changes as text for a table."""
    return ", ".join(f"`{text}`" for text in assignments(changes) if not (without and text.startswith(without)))


def cases() -> Iterator[Case]:
    def case(name: str, scene: str, changes: Changes, said: str = "", **options: Any) -> Case:
        about = {"name": said or name.split("/")[1].replace("x", " x ")}
        about |= {"published": scene if name.startswith(("grid", "still", *VARIED)) else ""}
        return Case(name, FLUID if scene == STILL else COUPLED, scene, changes, options, about=about)

    yield case("grid/325x72", COARSE, {})
    yield case("grid/650x144", FINE, {}, pictures=True)
    yield case("grid/960x216", FINE, on_grid(960, 216, 1.3e-4))
    yield case("grid/1300x288", FINEST, {})
    yield case("still/650x144", STILL, {})
    yield case("still/1300x288", STILL, on_grid(1300, 288, 1.25e-4))
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
    for name, changes in LISTED["thesis"].items():
        yield case(f"thesis/{name}", THESIS, changes, label(changes) or "none")
    for name, changes in LISTED["waves"].items():
        said = label(changes, "time.end") or "none, with the scene's own `bdf2`"
        yield case(f"waves/{name}", THESIS, changes, "a ramp of 2 s" if name == "ramp" else said)


def extract(case: Case, run: Run) -> dict[str, Any]:
    summary, series, group = run.found, run.series, case.name.split("/")[0]
    values = simulate.quantities(summary) | {"periods": summary["periods"], "reached": summary["simulated_s"]}
    values |= {"iterations": summary["iterations_mean"], "cfl": series["cfl"].max()}
    values |= {name: value for part in FURTHER.get(group, ()) for name, value in part(series).items()}
    values = {name: float(value) for name, value in values.items() if value is not None and np.isfinite(value)}
    tables = {"periods": last_periods(series)} if group == "grid" else {}
    return {"values": values, "tables": tables, "times": simulate.times(summary)}


def extremes(series: Series) -> dict[str, float]:
    """Return the largest and smallest drag, lift (N/m) and deflection (m) over the thesis' windows, unfiltered."""
    found = {}
    for begin, end in THESIS_WINDOWS:
        part = (series["time"] >= begin) & (series["time"] <= end)
        if part.any():
            for name in ("drag", "lift", "tip_uy"):
                found[f"{name}.max, from {begin:g} s"] = series[name][part].max()
                found[f"{name}.min, from {begin:g} s"] = series[name][part].min()
    return found


def waves(series: Series) -> dict[str, float]:
    """Return properties of the waves in the tip's velocity that are shorter than a piece: growth rate, 1/s, the time up
    to which it is fitted, s, and the size there, m/s, and frequency, Hz."""
    time, sizes = series["time"], []
    starts = np.arange(2 * PIECE, time[-1] - PIECE, PIECE)
    for start in starts:
        part = (time >= start) & (time < start + PIECE)
        t, v = time[part] - start, series["tip_vy"][part]
        rest = v - np.polyval(np.polyfit(t, v, TREND), t)
        if rest.std() > LARGE:
            break
        sizes.append(rest.std())
        strongest = np.abs(np.fft.rfft(rest * np.hanning(rest.size))).argmax() / PIECE
    if len(sizes) < 3:
        return {}
    rate = np.polyfit(starts[: len(sizes)], np.log(sizes), 1)[0]
    reached = starts[len(sizes) - 1] + PIECE
    return {"growth": rate, "growth.to": reached, "growth.size": sizes[-1], "growth.frequency_hz": strongest}


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


FURTHER: dict[str, tuple[Callable[[Series], dict[str, float]], ...]]
FURTHER = {"grid": (extremes,), "thesis": (extremes,), "waves": (waves,), "exchange": (exchange,)}
"""Functions of the series that add values to those of the summary, by group."""


def published(scene: str, name: str) -> View:
    return {"name": name} | {quantity: value for quantity, (value, _) in simulate.published(scene).items()}


def level_4() -> View:
    return published(COARSE, "FeatFlow, level 4")


def of(data: Data, pattern: str) -> list[View]:
    return [record.view for record in data.of(f"fsi3/{pattern}")]


def readme(data: Data) -> list[View]:
    names = ["`make fsi3` (325 x 72)", "`make fsi3 GRID=650x144`", "`make fsi3 GRID=1300x288`"]
    rows = [data[f"fsi3/grid/{grid}"].view | {"name": name} for grid, name in zip(SHIPPED, names)]
    return [level_4() | {"name": "reference (FeatFlow, level 4)"}, *reversed(rows)]


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


def extremes_of(found: View, name: str, begin: float | None = None) -> View:
    """Return `QUANTITY.max` and `.min` over a window, of uy in mm; without a window from means and amplitudes."""
    view = found | {"name": name}
    for q, scale in (("drag", 1.0), ("lift", 1.0), ("tip_uy", 1e3)):
        for what, sign in (("max", 1), ("min", -1)):
            at = f"{q}.{what}, from {begin:g} s" if begin else ""
            view[f"{q}.{what}"] = scale * (found[at] if begin else found[f"{q}.mean"] + sign * found[f"{q}.amplitude"])
    return view


def thesis_extremes(data: Data) -> list[View]:
    """Return largest and smallest values over the thesis' window, printed and computed."""
    rows, printed = [], simulate.LISTED["thesis"]["table_4_2"]
    for level, name in (("level 1", "none"), ("level 2", "level 2")):
        here = data[f"fsi3/thesis/{name}"].view
        rows += [printed[level] | {"name": f"thesis, {level}"}, extremes_of(here, f"here, {level}", 1.1)]
    return [*rows, extremes_of(here, "here, level 2, from 3.5 s on", 3.5), extremes_of(level_4(), "reference")]


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
    "thesis-extremes": thesis_extremes,
    "coupling-iterations": iterations,
    "coupling-exchange": exchanged,
}
STUDY = Study("fsi3", cases, extract, TABLES)
