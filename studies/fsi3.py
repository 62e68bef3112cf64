"""FSI3: its grids, what moves it, the bar held still, the thesis' own settings, iterations and the interface's exchange."""

from __future__ import annotations

import shutil
import textwrap
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from nervure.evaluate import statistics

from studies import show, simulate
from studies.engine import COUPLED, FLUID, Case, Run, Study
from studies.show import COLOURS, markdown
from studies.store import Data, Record

SIGNALS = ("tip_ux", "tip_uy", "drag", "lift")

COARSE, FINE, FINEST, STILL, THESIS = (
    "fsi3-325x72", "fsi3-650x144", "fsi3-1300x288", "cfd3-650x144", "fsi3-thesis-325x72"
)  # fmt: skip

Changes = dict[str, Any]


def on_grid(nx: int, ny: int, step: float) -> Changes:
    return {"fluid.box.cells": [nx, ny], "time.communication_step": step, "fluid.time_stepping.max_step": step}


NO_SHEAR = {"rod.material.plane_strain.shear_factor": None}
NO_SETBACK = {"rod.clamp_setback": 0}
PRESSURE_JUMP = {"coupling": {"load": "pressure_jump"}}
COSINE = {"fluid.mask": {"cosine": {"c_eta": 1e-4, "half_width": 1.0}}}
TWO_THIRDS = {"fluid.filter": "two_thirds"}
BARE = {"fluid.mask.log_linear.target": "none"}

GRIDS: dict[str, tuple[str, Changes]] = {
    "325x72": (COARSE, {}),
    "650x144": (FINE, {}),
    "960x216": (FINE, on_grid(960, 216, 1.3e-4)),
    "1300x288": (FINEST, {}),
}
"""Scene and changes of each grid."""
SHIPPED = ("325x72", "650x144", "1300x288")

VARIED: dict[str, tuple[str, list[Changes]]] = {
    "coarse": (COARSE, [
        {"time.communication_step": 2e-4},
        {"time.communication_step": 1e-4},
        {"beam.segments": 84},
        {"beam.segments": 21},
        NO_SHEAR | NO_SETBACK,
        {"rod.scheme": {"generalised_alpha": {"rho_inf": 0.5}}},
        PRESSURE_JUMP,
        TWO_THIRDS,
        BARE,
        COSINE,
        {"time.end": 30},
    ]),
    "fine": (FINE, [
        NO_SHEAR,
        NO_SETBACK,
        {"beam.segments": 21},
        {"beam.segments": 60},
        {"rod.material.plane_strain.density": 1050},
        {"fluid.mask.log_linear.c_eta": 1e-4},
        {"fluid.mask.log_linear.c_eta": 1e-6},
        {"fluid.inflow.c_eta": 1e-3},
        {"fluid.box.x": [-0.46538, 2.5], "fluid.box.cells": [720, 144], "fluid.inflow.x": [-0.46538, 0]},
        {"fluid.box.x": [-0.1771, 2.78828], "fluid.box.cells": [720, 144]},
        TWO_THIRDS,
        BARE,
        COSINE,
    ]),
}  # fmt: skip
"""One change at a time, by group."""

RAMP = "fluid.inflow.mean_velocity.cosine_ramp.duration"
RATIOS, ACCELERATIONS = (1, 0.1, 0.01), ("iqn_ils", "aitken")
EXCHANGE_STEPS = (4e-4, 2e-4, 1e-4)
EXCHANGE_WINDOWS = {"first": (0.0, 0.5), "swinging": (1.2, 1.6)}
"""Times over which both sides of the interface are compared, s."""

LEVEL_2 = on_grid(650, 144, 7e-5) | {"beam.segments": 85}
LONG_RAMP = {"fluid.initial_velocity": [0, 0], "fluid.inflow.mean_velocity": {"cosine_ramp": {"value": 2.0, "duration": 2.0}}}
THESIS_RUNS: dict[str, Changes] = {
    "none": {},
    "mask": {"fluid.mask.cosine.displacement_corrected": True},
    "calibration": {"rod.calibration": "second_order"},
    "ramp": LONG_RAMP,
    "level 2": {"time.end": 4.375} | LEVEL_2,
}
TRAPEZOID = {"rod.scheme": "trapezoid"}
ITERATED = {"coupling.scheme": {"iterated": {"tolerance": 1e-2, "max_iterations": 100}}}
WAVES: dict[str, Changes] = {
    "none": TRAPEZOID,
    "invariant": TRAPEZOID | {"rod.bending": "invariant"},
    "second order": TRAPEZOID | {"rod.calibration": "second_order"},
    "ramp": TRAPEZOID | {"time.end": 2} | LONG_RAMP,
    "half step": TRAPEZOID | {"time.communication_step": 4.375e-5},
    "iterated": TRAPEZOID | ITERATED,
    "level 2": TRAPEZOID | LEVEL_2,
    "generalised-alpha": {"time.end": 2, "rod.scheme": {"generalised_alpha": {"rho_inf": 0.8}}},
    "bdf2": {"time.end": 2},
    "bdf2, iterated": {"time.end": 0.2} | ITERATED,
}
"""Short waves on the rod under the pressure jump. Without a scheme in it: the scene's own, bdf2."""

THESIS_WINDOWS = ((1.1, 4.375), (3.5, 4.375))
"""Over which the thesis takes its extremes (table 4.2), and the part that it calls more accurate, s."""
THESIS_TABLE_4_2 = {
    "level 1": {"drag": (1107, 430), "lift": (506, -543), "tip_uy": (32.2e-3, -14.1e-3)},
    "level 2": {"drag": (719, 356), "lift": (276, -330), "tip_uy": (39.9e-3, -34.4e-3)},
}
"""Largest and smallest values from t = 1.1 to 4.375 s, N/m and m."""
THESIS_FREQUENCY = {"level 2": 5.555}
"""In its text, Hz."""

PIECE, TREND = 0.02, 4
"""Length of the pieces in which short waves are looked for, s, and the degree of the polynomial that is not a wave."""
LARGE = 1.0
"""Velocity of the tip, m/s, up to which a wave grows exponentially."""
SAMPLES, SHOWN_PERIODS = 120, 2
"""Points of the series that are kept of each grid, and the periods that they span."""


# Cases


def label_of(changes: Changes) -> str:
    return ", ".join(simulate.assignments(changes))


def cases() -> Iterator[Case]:
    def case(name: str, scene: str, changes: Changes, published: str = "", **options: Any) -> Case:
        rooms = FLUID if scene == STILL else COUPLED
        return Case(name, rooms, scene, changes, options, about={"published": published, "changes": label_of(changes)})

    for grid, (scene, changes) in GRIDS.items():
        yield case(f"grid/{grid}", scene, changes, scene, pictures=grid == "650x144")
    yield case("still/650x144", STILL, {}, STILL)
    yield case("still/1300x288", STILL, on_grid(1300, 288, 1.25e-4), STILL)
    for group, (scene, varied) in VARIED.items():
        for changes in varied:
            yield case(f"{group}/{label_of(changes)}", scene, changes, scene)
    for ratio in RATIOS:
        for name in ACCELERATIONS:
            scheme = {"load": "pressure_jump", "scheme": {"iterated": {"acceleration": name}}}
            density = {"rod.material.plane_strain.density": 1000 * ratio}
            changes = {"time.end": 0.15, RAMP: 0.5, "coupling": scheme} | density
            yield case(f"iterations/{ratio:g}, {name}", COARSE, changes)
    for segments in (30, 42):
        for step in EXCHANGE_STEPS:
            # The shipped number of segments is sampled from the start only, the smallest step as well.
            end = 0.5 if segments == 42 or step == EXCHANGE_STEPS[-1] else 1.6
            changes = {RAMP: 0.2, "time.end": end, "beam.segments": segments, "time.communication_step": step}
            yield case(f"exchange/{segments}, {step:g}", COARSE, changes)
    for name, changes in THESIS_RUNS.items():
        yield case(f"thesis/{name}", THESIS, changes)
    for name, changes in WAVES.items():
        yield case(f"waves/{name}", THESIS, changes)


# What is kept of a run


def keep(case: Case, run: Run) -> dict[str, Any]:
    summary, series, group = run.found, run.series, case.name.split("/")[0]
    values = simulate.quantities(summary) | {"periods": summary["periods"], "reached": summary["simulated_s"]}
    values |= {"amplitude_drift": summary["amplitude_drift"], "iterations": summary["iterations_mean"]}
    if summary["window_s"]:
        values["window.begin"], values["window.end"] = summary["window_s"]
    values["cfl"] = series["cfl"].max()
    if summary["interface"]:
        gave = series["beam_power"]
        values["imbalance"] = summary["interface"]["imbalance"]
        values["powers"] = np.abs(series["load_power"] - gave).mean() / np.abs(gave).mean()
    values |= {name: value for part in FURTHER.get(group, ()) for name, value in part(series).items()}
    values = {name: float(value) for name, value in values.items() if value is not None and np.isfinite(value)}
    tables = {"periods": last_periods(series)} if group == "grid" else {}
    return {"values": values, "tables": tables, "times": simulate.times(summary)}


def extremes(series: dict[str, np.ndarray]) -> dict[str, float]:
    """Largest and smallest drag, lift (N/m) and deflection (m) over the thesis' windows, unfiltered."""
    found = {}
    for begin, end in THESIS_WINDOWS:
        part = (series["time"] >= begin) & (series["time"] <= end)
        if part.any():
            for name in ("drag", "lift", "tip_uy"):
                found[f"{name}.max, from {begin:g} s"] = series[name][part].max()
                found[f"{name}.min, from {begin:g} s"] = series[name][part].min()
    return found


def waves(series: dict[str, np.ndarray]) -> dict[str, float]:
    """Waves in the tip's velocity that are shorter than a piece: rate at which they grow or decay, 1/s, to which time, s,
    their size there, m/s, and their frequency, Hz."""
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


def exchange(series: dict[str, np.ndarray]) -> dict[str, float]:
    """Differences of what the rod took and the fluid exerted: rms of the lift's by that of the lift; sum of the magnitudes
    of the work's, step by step, by that of the work exchanged; net work by the same."""
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


def last_periods(series: dict[str, np.ndarray]) -> list[dict[str, float]]:
    """The last whole periods, from an upward crossing of uy on, by the fundamental frequency."""
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


FURTHER: dict[str, tuple[Callable[[dict[str, np.ndarray]], dict[str, float]], ...]] = {
    "grid": (extremes, waves),
    "thesis": (extremes,),
    "waves": (waves,),
    "exchange": (exchange,),
}
"""What is made of the series of a group's runs, besides the summary."""


# Tables


def published(scene: str = COARSE) -> dict[str, float]:
    return {quantity: value for quantity, (value, _) in simulate.published(scene).items()}


def pair(found: Any, name: str, digits: int, amplitude_digits: int | None = None) -> str:
    """Mean ± amplitude, mm or N/m."""
    scale = 1e3 if name.startswith("tip") else 1.0
    mean, amplitude = (scale * found[f"{name}.{what}"] for what in ("mean", "amplitude"))
    return f"{mean:.{digits}f} ± {amplitude:.{digits if amplitude_digits is None else amplitude_digits}f}"


def cells(found: Any, digits: int = 1) -> list[str]:
    """ux, uy, drag and lift with the frequencies of the tip."""
    tip = [f"{pair(found, q, 2)} [{found[f'{q}.frequency_hz']:.2f}]" for q in ("tip_ux", "tip_uy")]
    return [*tip, pair(found, "drag", 1, digits), pair(found, "lift", digits)]


def cells_with_fits(found: Any) -> list[str]:
    """ux, uy, its frequency, drag and lift with the amplitude of the fit."""
    forces = [f"{pair(found, q, 1)} ({found[f'{q}.fit']:.1f})" for q in ("drag", "lift")]
    return [pair(found, "tip_ux", 2), pair(found, "tip_uy", 2), f"{found['tip_uy.frequency_hz']:.2f}", *forces]


def readme(data: Data) -> list[str]:
    table = [["reference (FeatFlow, level 4)", *cells(published(), 2)]]
    for grid in reversed(SHIPPED):
        command = "`make fsi3` (325 x 72)" if grid == "325x72" else f"`make fsi3 GRID={grid}`"
        table.append([command, *cells(data[f"fsi3/grid/{grid}"])])
    return markdown(["", "ux", "uy", "drag", "lift"], table)


def spread() -> list[str]:
    q = simulate.reference(COARSE)["spread"]["quantities"]

    def between(name: str, what: str, scale: float = 1.0) -> str:
        low, high = q[name][what]
        return f"{scale * low:g} to {scale * high:g}"

    tip = [between("tip_ux", "amplitude", 1e3), between("tip_uy", "amplitude", 1e3), between("tip_uy", "frequency_hz")]
    return [*tip, f"{between('drag', 'mean')}, {between('drag', 'amplitude')}", between("lift", "amplitude")]


def reference_with_fits() -> list[str]:
    q = published()
    forces = [pair(q, "drag", 1, 2), pair(q, "lift", 2)]
    return [pair(q, "tip_ux", 2), pair(q, "tip_uy", 2), f"{q['tip_uy.frequency_hz']:.2f}", *forces]


HEADER = ["", "ux", "uy", "f", "drag", "lift"]


def grids(data: Data) -> list[str]:
    table = [[grid.replace("x", " x "), *cells_with_fits(data[f"fsi3/grid/{grid}"])] for grid in GRIDS]
    return markdown(HEADER, [*table, ["FeatFlow, level 4", *reference_with_fits()], ["published spread", *spread()]])


def errors(data: Data) -> list[str]:
    """Distance from FeatFlow's level 4, by grid."""
    names = [f"{q}.{what}" for q in ("tip_ux", "tip_uy", "drag", "lift") for what in ("mean", "amplitude")]
    names = [n for n in names if n not in ("tip_uy.mean", "lift.mean")] + ["tip_uy.frequency_hz"]
    rows = [[g.replace("x", " x "), *(show.percent(data[f"fsi3/grid/{g}"].off(n), "+.1f") for n in names)] for g in GRIDS]
    return markdown(["grid", *map(show.label, names)], rows)


def costs(data: Data) -> list[str]:
    """Processor time and its shares by grid."""
    table = []
    for grid in GRIDS:
        record = data[f"fsi3/grid/{grid}"]
        phases, wall = record.times["phases_s"], record.clock("wall_s")
        shares = [phases["rod"] / wall, phases["fluid"] / wall]
        cells = [f"{record.clock('cpu_s') / record['reached']:.1f}", *(f"{100 * s:.1f} %" for s in (*shares, 1 - sum(shares)))]
        table.append([grid.replace("x", " x "), *cells, f"{record['cfl']:.2f}", f"{record['periods']:.0f}"])
    return markdown(["grid", "CPU, s a simulated s", "rod", "fluid", "exchange", "largest CFL", "periods averaged"], table)


def still(data: Data) -> list[str]:
    table = []
    for grid in ("650x144", "1300x288"):
        q = data[f"fsi3/still/{grid}"]
        drag, lift = (f"{pair(q, n, 1, d)} ({q[f'{n}.fit']:.{d}f})" for n, d in (("drag", 2), ("lift", 1)))
        table.append([grid.replace("x", " x "), drag, lift, f"{q['lift.frequency_hz']:.3f}"])
    p = published(STILL)
    drag, lift = (f"{p[f'{n}.mean']:g} ± {p[f'{n}.amplitude']:g}" for n in ("drag", "lift"))
    table.append(["Turek & Hron", drag, lift, f"{p['lift.frequency_hz']:.3f}"])
    return markdown(["", "drag [N/m]", "lift [N/m]", "f [Hz]"], table)


def varied(group: str, data: Data) -> list[str]:
    """What one change does, on the grid of a group."""
    base = {"coarse": "325x72", "fine": "650x144"}[group]
    table = [["none", *cells_with_fits(data[f"fsi3/grid/{base}"])]]
    for record in data.of(f"fsi3/{group}/*"):
        changes = ", ".join(f"`{change}`" for change in simulate.assignments(record.case.changes))
        table.append([changes, *cells_with_fits(record)])
    return markdown(["change", *HEADER[1:]], table)


def pairs(numbers: dict[str, tuple[float, float]]) -> list[str]:
    """Largest / smallest drag, lift and uy (mm)."""
    digits = {name: (1e3, 1) if name == "tip_uy" else (1.0, 0) for name in numbers}
    return [" / ".join(f"{digits[name][0] * v:.{digits[name][1]}f}" for v in both) for name, both in numbers.items()]


def extremes_of(record: Record, begin: float) -> list[str]:
    names = ("drag", "lift", "tip_uy")
    return pairs({n: (record[f"{n}.max, from {begin:g} s"], record[f"{n}.min, from {begin:g} s"]) for n in names})


def published_extremes() -> list[str]:
    q = published()
    names = ("drag", "lift", "tip_uy")
    return pairs({n: (q[f"{n}.mean"] + q[f"{n}.amplitude"], q[f"{n}.mean"] - q[f"{n}.amplitude"]) for n in names})


def thesis_extremes(data: Data) -> list[str]:
    """Largest and smallest values over the thesis' window, printed and here."""
    table = []
    for level, name in (("level 1", "none"), ("level 2", "level 2")):
        record = data[f"fsi3/thesis/{name}"]
        frequency = f"{record['tip_uy.frequency_hz']:.2f}"
        table.append([f"thesis, {level}", *pairs(THESIS_TABLE_4_2[level]), THESIS_FREQUENCY.get(level, "")])
        table.append([f"here, {level}", *extremes_of(record, 1.1), frequency])
    table.append(["here, level 2, from 3.5 s on", *extremes_of(record, 3.5), frequency])
    table.append(["reference", *published_extremes(), f"{published()['tip_uy.frequency_hz']:.2f}"])
    return markdown(["", "drag [N/m]", "lift [N/m]", "uy [mm]", "f [Hz]"], table)


def thesis_changes(data: Data) -> list[str]:
    """One change of the thesis' settings at a time: extremes, and the settled motion."""

    def settled(q: Any) -> list[str]:
        return [f"{pair(q, 'tip_uy', 1)} [{q['tip_uy.frequency_hz']:.2f}]", pair(q, "drag", 0), pair(q, "lift", 0)]

    table = []
    for name, changes in THESIS_RUNS.items():
        if name != "level 2":
            record = data[f"fsi3/thesis/{name}"]
            label = ", ".join(f"`{change}`" for change in simulate.assignments(changes)) or "none"
            table.append([label, *extremes_of(record, 1.1), *settled(record)])
    record = data["fsi3/grid/325x72"]
    table.append(["the shipped `scenes/fsi3-325x72.json`", *extremes_of(record, 1.1), *settled(record)])
    table.append(["reference", *published_extremes(), *settled(published())])
    return markdown(["change", "drag", "lift", "uy", "settled uy", "drag", "lift"], table)


def thesis_waves(data: Data) -> list[str]:
    """Growth of short waves, and how the runs end."""
    kinds = {"singular": "a projected angle is singular", "converge": "no convergence", "unstable": "the load is unstable"}
    table = []
    for name, changes in WAVES.items():
        if name == "bdf2, iterated":
            continue
        record = data[f"fsi3/waves/{name}"]
        rate, there = "too fast for a rate", ""
        if "growth" in record.values:
            rate = f"{record['growth']:.1f} /s to {record['growth.to']:.2f} s"
            there = f"{1e3 * record['growth.size']:.1f} mm/s at {record['growth.frequency_hz']:.0f} Hz"
        told = [f"`{change}`" for change in simulate.assignments(changes) if not change.startswith("time.end")]
        label = "a ramp of 2 s" if name == "ramp" else ", ".join(told)
        outcome = f"holds (to {record['reached']:g} s)"
        if record.error:
            reason = next((said for word, said in kinds.items() if word in record.error), record.error[:60])
            outcome = f"{record['reached']:.3f} s: {reason}"
        table.append([label or "none, with the scene's own `bdf2`", rate, there, outcome])
    return markdown(["change", "growth", "what is there then", "the run ends"], table)


def thesis_error(data: Data) -> list[str]:
    told = data["fsi3/waves/none"].error or ""
    return ["", *textwrap.wrap(told, 96, initial_indent="    ", subsequent_indent="    "), ""]


def iterations(data: Data) -> list[str]:
    """Mean iterations a step, by density ratio and acceleration."""

    def cell(ratio: float, name: str) -> str:
        record = data[f"fsi3/iterations/{ratio:g}, {name}"]
        return f"stops at t = {1e3 * record['reached']:.0f} ms" if record.error else f"{record['iterations']:.1f}"

    header = ["density ratio", *(f"`{name}`" for name in ACCELERATIONS)]
    return markdown(header, [[f"{ratio:g}", *(cell(ratio, name) for name in ACCELERATIONS)] for ratio in RATIOS])


def exchange_table(data: Data) -> list[str]:
    """Differences of both sides of the interface, over window and step."""
    table = []
    for window, (begin, end) in EXCHANGE_WINDOWS.items():
        for step in EXCHANGE_STEPS:
            found = data[f"fsi3/exchange/30, {step:g}"]
            if f"{window}.lift" not in found.values:
                continue
            tip = 1e3 * found[f"{window}.tip"]
            where = f"{begin:g} to {end:g} s" + (f", tip ± {tip:.0f} mm" if tip > 1 else "")
            parts = (f"{100 * found[f'{window}.{name}']:.2f} %" for name in ("lift", "work"))
            table.append([where, f"{step:g}", *parts, f"{100 * found[f'{window}.net']:+.2f} %"])
    return markdown(["", "H [s]", "lift", "work, magnitudes", "work, net"], table)


# Figures


def bands(data: Data) -> None:
    """Two periods of FSI3 on each grid, in the band of the published amplitudes around the published mean."""
    titles = {"tip_ux": "$u_x$ [mm]", "tip_uy": "$u_y$ [mm]", "drag": "drag [N/m]", "lift": "lift [N/m]"}
    figure, axes = show.panel(2, 2, (9.5, 6), sharex=True)
    reference, others = published(), simulate.reference(COARSE)["spread"]["quantities"]
    for axis, (name, title) in zip(axes.flat, titles.items()):
        factor = 1e3 if name.startswith("tip") else 1.0
        mean, amplitude = reference[f"{name}.mean"], reference[f"{name}.amplitude"]
        low, high = others[name]["amplitude"]
        for sign in (-1, 1):
            edges = sorted((mean + sign * low, mean + sign * high))
            axis.axhspan(edges[0] * factor, edges[1] * factor, color="#999999", alpha=0.35, linewidth=0)
            axis.axhline((mean + sign * amplitude) * factor, color="#000000", linewidth=0.8, linestyle=":")
        for grid, colour, style in zip(SHIPPED, COLOURS, ("-", "--", "-.")):
            rows = data[f"fsi3/grid/{grid}"].tables.get("periods", [])
            x, y = [row["phase"] for row in rows], [factor * row[name] for row in rows]
            axis.plot(x, y, style, color=colour, linewidth=1.3, label=grid.replace("x", " x "))
        axis.set_ylabel(title)
    for axis in axes[1]:
        axis.set_xlabel("periods of $u_y$")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    handles += [Line2D([], [], color="#999999", alpha=0.5, linewidth=6), Line2D([], [], color="#000000", linestyle=":")]
    labels += ["published spread of the extremes", "FeatFlow, level 4"]
    figure.legend(handles, labels, loc="outside lower center", ncols=6, fontsize=8)
    show.save(figure, "report/fsi3_bands")


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    bands(data)
    if run := runs("fsi3/grid/650x144"):
        for name in ("tip", "drag", "lift", "vorticity"):
            shutil.copy(run.folder / f"{name}.png", show.DOCS / "fsi3")


TABLES = {
    "fsi3": readme,
    "fsi3-grids": grids,
    "fsi3-errors": errors,
    "fsi3-costs": costs,
    "cfd3": still,
    "fsi3-coarse": partial(varied, "coarse"),
    "fsi3-fine": partial(varied, "fine"),
    "thesis-extremes": thesis_extremes,
    "thesis-changes": thesis_changes,
    "thesis-waves": thesis_waves,
    "thesis-error": thesis_error,
    "coupling-iterations": iterations,
    "coupling-exchange": exchange_table,
}

STUDY = Study("fsi3", cases, keep, TABLES, draw=draw)
