"""Bodies, flags, filaments and veins beside published values, on several grids and in several boxes.

Digitised curves are in studies/published, with their sources.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from math import cos, pi, sin
from pathlib import Path
from typing import Any

import h5py
import numpy as np

import nervure
from nervure.evaluate import flapping, statistics
from nervure.evaluate.statistics import Series, Window
from nervure.scene import validate
from nervure.simulation.results import FLUID_FIELDS
from studies import show, simulate
from studies.engine import COUPLED, FLUID, Case, Run, Study
from studies.simulate import on_grid
from studies.store import Data

PUBLISHED = Path(__file__).with_name("published")

KC5, HOVER, STREAM = "cylinder-kc5-600x360", "ellipse-hover-640x640", "cylinder-stream-384x512"
FLAG, FILAMENT, PASSIVE = "flag-stream-480x240", "filament-hanging-384x384", "vein-passive-240x240"
PERIOD = 5.0  # Of the oscillating cylinder, s
HOVER_PERIOD, HOVER_SPEED = 4.0, 1.4 * 2 * np.pi * 0.25  # Of the ellipse, s and m/s
LIFT, DRAG = 1.2, 1.4  # Divisors of the ellipse's coefficients in Wang et al. (2004)
SETTLED = {"flag": 10.0, "shedding": 70.0, "passive": 4.0}  # Begin of the evaluation, s
FILTER = 0.02  # Width of the box filter over the forces of the passive vein, s: a fiftieth of its period
TWIN_STEP = 20  # Steps of the passive vein between two points of the motion of its rigid twin
REVERSAL = 0.02  # Periods around a reversal of the stroke in which the digitised drag jumps from one sign to the other

PAIRS = {"pair-hover": "vein-pair-hover-256x288", "pair-forward": "vein-pair-forward-288x192"}
FILAMENTS, NAMES = "filament-pair-192x128", ("upper", "lower")
START = (0.1, 0.05)  # First directions of two filaments, as multiples of pi from the stream
WINDOWS = ((20.0, 30.0), (30.0, 40.0), (40.0, 50.0))  # Of the correlation of both tips, s

Changes = dict[str, Any]


def box(x: list[float], y: list[float]) -> Changes:
    return {"fluid.box.x": x, "fluid.box.y": y}


NARROW = box([-8.4, 15.6], [-8.0, 8.0]) | on_grid(384, 256, 0.02)
GUST = {"table": {"times": [0.0, 2.0, 4.0, 6.0], "values": [0.0, 0.2, 0.2, 0.0]}}
SHEDDING = {"fluid.kinematic_viscosity": 0.01, "fluid.mean_flow.y": GUST, "time.end": 100.0}
THICKNESS = "beam.thickness"


def two_filaments(apart: float, start: tuple[float, float] = START) -> Changes:
    """Return the changes to two filaments at a distance, with these first directions."""
    changes: Changes = {"time.end": 50.0}
    for i, (side, angle) in enumerate(zip((1, -1), start)):
        at = f"rods.{i}.beam.root.at"
        changes[f"{at}.position"] = [0.0, side * apart / 2]
        changes[f"{at}.direction"] = [cos(angle * pi), sin(angle * pi)]
    return changes


CASES: dict[str, tuple[str, Changes]] = {
    "oscillating/300x180": (KC5, on_grid(300, 180, 0.01)),
    "oscillating/600x360": (KC5, {}),
    "oscillating/600x360, 40 x 24": (KC5, box([-20.0, 20.0], [-12.0, 12.0]) | on_grid(600, 360, 0.01)),
    "hover/480x480": (HOVER, on_grid(480, 480, 0.01)),
    "hover/640x640": (HOVER, {}),
    "stream/384x256": (STREAM, NARROW),
    "stream/384x512": (STREAM, {}),
    "stream/384x256, Re 20": (STREAM, NARROW | {"fluid.kinematic_viscosity": 0.05}),
    "shedding/384x256": (STREAM, NARROW | SHEDDING),
    "shedding/384x512": (STREAM, SHEDDING),
    "flag/480x240, 0.03": (FLAG, {THICKNESS: 0.03}),
    "flag/480x240, 0.02": (FLAG, {}),
    "flag/960x480, 0.01": (FLAG, on_grid(960, 480, 0.00135) | {THICKNESS: 0.01}),
    "passive/240x240": (PASSIVE, {}),
    **{f"filaments/{apart}": (FILAMENTS, two_filaments(apart)) for apart in (0.2, 0.3, 0.5, 1.0)},
}  # fmt: skip


def curve(name: str) -> np.ndarray:
    """Return a published curve, `[2, n]`, sorted by its first row."""
    points = np.genfromtxt(PUBLISHED / f"{name}.csv", delimiter=",", comments="#", skip_header=3)
    ordered: np.ndarray = points[np.argsort(points[:, 0])].T
    return ordered


def off(found: np.ndarray, published: np.ndarray) -> float:
    """Return the root mean square of the difference by the peak of the published curve."""
    return float(np.sqrt(np.mean((found - published) ** 2)) / np.abs(published).max())


def oscillating(series: Series) -> dict[str, float]:
    """Return coefficients of the in-line force of the last period, 2 F/(rho U² D): Morison's coefficients by Fourier
    averages (Keulegan & Carpenter 1958) and by least squares, the peak, and the distance from Dütsch's digitised
    curve."""
    time, force = series["time"], series["body_1_drag"]
    window = Window(time[-1] - PERIOD, time[-1], 1)
    phase = 2 * np.pi * time / PERIOD
    cos, sin = -np.cos(phase), np.sin(phase)  # The velocity, and its rate by omega
    part = window.of(time)
    matrix = -np.column_stack([np.abs(cos) * cos / 2, np.pi / 4 * 2 * np.pi / PERIOD * sin])[part]
    (cd, ci), *_ = np.linalg.lstsq(matrix, force[part], rcond=None)
    share, published = curve("oscillating_cylinder_re100_kc5")
    return {
        "cd": -flapping.average(time, force * cos, window) * 3 * np.pi / 2,
        "ci": -flapping.average(time, force * sin, window) * 4 * PERIOD / np.pi**2,
        "cd_squares": float(cd),
        "ci_squares": float(ci),
        "peak": 2 * float(np.abs(force[part]).max()),
        "rms": off(np.interp(time[-1] - PERIOD + PERIOD * share, time, force), published),
    }


def hovering(series: Series) -> dict[str, np.ndarray]:
    """Return time in periods, and lift and drag in the scaling of Wang et al. (2004); drag is positive against the
    stroke."""
    time, pressure = series["time"] / HOVER_PERIOD, HOVER_SPEED**2 / 2
    against = np.where(time % 1 < 0.5, 1.0, -1.0)
    return {
        "time": time,
        "lift": series["body_1_lift"] / pressure / LIFT,
        "drag": against * series["body_1_drag"] / pressure / DRAG,
    }


def fourth_period(series: Series) -> dict[str, float]:
    """Return means of lift and drag, the largest lift, and the distances from Eldredge's digitised curves."""
    found = hovering(series)
    values = {}
    for name in ("lift", "drag"):
        share, published = curve(f"hovering_ellipse_re75_eldredge_{name}")
        there = (share > 3) & (share <= 4)
        if name == "drag":
            there &= np.abs((share + 0.25) % 0.5 - 0.25) > REVERSAL
        values[name] = flapping.average(found["time"], found[name], Window(3.0, 4.0, 1))
        values[f"{name}_rms"] = off(np.interp(share[there], found["time"], found[name]), published[there])
    last = found["time"] > 3
    return values | {"lift_max": float(found["lift"][last].max())}


def stream(series: Series, folder: Path) -> dict[str, float | None]:
    """Return the drag coefficient at the end, and the length of the bubble behind the cylinder by D."""
    with h5py.File(folder / FLUID_FIELDS) as file:
        data: Any = file["VTKHDF"]
        u = np.array(data["PointData/velocity"][-1])[..., 0]
        (x0, y0, _), (dx, dy, _) = data.attrs["Origin"], data.attrs["Spacing"]
    along, row = x0 + dx * np.arange(u.shape[1]), u[round(-y0 / dy)]
    (ends,) = np.nonzero((along[:-1] > 0.5) & (row[:-1] < 0) & (row[1:] >= 0))
    end = ends[-1] if ends.size else None
    bubble = None if end is None else float(along[end] - dx * row[end] / (row[end + 1] - row[end]) - 0.5)
    return {"cd": 2 * float(series["body_1_drag"][-1]), "bubble": bubble}


def shedding(series: Series) -> dict[str, float]:
    """Return mean drag coefficient, amplitude of the lift coefficient and Strouhal number of a shedding cylinder."""
    lift = swing(series, "lift", SETTLED["shedding"])
    window = Window(SETTLED["shedding"], float(series["time"][-1]), 1)
    drag = flapping.average(series["time"], series["drag"], window)
    return {"cd": 2 * drag, "cl": 2 * lift["amplitude"], "st": lift["frequency"]}


def swing(series: Series, column: str, begin: float) -> dict[str, float]:
    """Return the amplitude (half the distance of the extremes of a cycle) as a mean from `begin` on, its relative
    scatter over the cycles, and the frequency, Hz."""
    part = series["time"] >= begin
    time, values = series["time"][part], series[column][part]
    middle, half = statistics.extent(values)
    starts = statistics.upward_crossings(time, values, middle, half)
    cycles = [np.ptp(values[(time >= a) & (time <= b)]) / 2 for a, b in pairwise(starts)]
    return {
        "amplitude": float(np.mean(cycles)),
        "scatter": float(np.std(cycles) / np.mean(cycles)),
        "frequency": (len(starts) - 1) / float(starts[-1] - starts[0]),
    }


def unlike(series: Series) -> float:
    """Return the largest distance of the tip of the upper vein from the mirror image of the lower tip at y = 0, m."""
    (ux, uy), (image_ux, image_uy) = ([series[f"{name}_tip_u{axis}"] for axis in "xy"] for name in ("upper", "lower"))
    return float(max(np.abs(ux - image_ux).max(), np.abs(uy + image_uy).max()))


def pair(done: nervure.Run) -> dict[str, float]:
    """Return means over both veins of a pair, and their distance from mirror images."""
    summary, rods = done.summary, (done.summary.rods or {}).values()
    beams = [summary.bodies[f"beam_{i}"] for i in (1, 2)]
    averages = [rod.flapping for rod in rods if rod.flapping]
    ct, cp = (float(np.mean([getattr(beam, name) for beam in beams])) for name in ("ct", "cp"))
    tip = float(np.mean([of.tip_by_rigid_tip for of in averages]))
    lag = float(np.mean([of.phase_lag_deg for of in averages]))
    return {"ct": ct, "cp": cp, "ct_by_cp": ct / cp, "tip": tip, "lag_deg": lag, "unlike": unlike(done.series)}


def twin(done: nervure.Run) -> dict[str, Any]:
    """Return the scene of a passive vein with a rigid plate in place of the vein, which repeats the motion of the
    vein."""
    scene, series = done.scene.document(), done.series
    beam, rod = scene.pop("beam"), scene.pop("rod")
    position, at = beam["root"]["at"]["position"], slice(None, None, TWIN_STEP)
    turn = {"table": {"times": series["time"][at].tolist(), "values": series["hinge_angle"][at].tolist()}}
    scene["fluid"]["bodies"] = [{
        "shape": {"rectangle": {"length": beam["length"], "thickness": beam["thickness"], "ends": "square"}},
        "position": position, "pivot": [-beam["length"] / 2, 0.0],
        "motion": {"y": rod["root_motion"]["laws"]["y"], "angle": turn},
    }]  # fmt: skip
    return scene | {"name": f"{scene['name']}-twin"}


def moments(done: nervure.Run, rigid: Series) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time, the moment about its root that a stiff vein on a spring needs from the fluid, M = I angle'' + m x_c
    y'' cos(angle) + k angle with a root driven by y, and the moment on its rigid twin, both under a box filter."""
    series, scene = done.series, done.scene.document()
    time, angle = series["time"], series["hinge_angle"]
    length = scene["beam"]["length"]
    mass = scene["rod"]["material"]["section"]["line_density"] * length
    spring = scene["rod"]["root"]["torsion_spring"]["stiffness"]
    turning = np.gradient(series["hinge_omega"], time)
    rising = np.gradient(np.gradient(series["rigid_tip_uy"], time), time)
    asked = mass * length**2 / 3 * turning + mass * length / 2 * rising * np.cos(angle) + spring * angle
    asked, given = (statistics.box_filter(time, moment, FILTER) for moment in (asked, rigid["body_1_moment"]))
    return time, asked, given


def passive(done: nervure.Run, rigid: Series) -> dict[str, float]:
    """Return the pitching amplitude of a stiff vein on a spring, its energy balance, and the rms difference of the
    moment on its rigid twin from the moment that the vein needs, by the largest of the latter."""
    time, asked, given = moments(done, rigid)
    part = (time >= SETTLED["passive"]) & (time <= time[-1] - FILTER)
    averages = done.summary.flapping
    assert averages and averages.thrust is not None
    return {
        "amplitude_deg": float(np.degrees(swing(done.series, "hinge_angle", SETTLED["passive"])["amplitude"])),
        "missing": averages.energy_balance["missing"] or 0.0,
        "thrust": averages.thrust,
        "moment_rms": off(given[part], asked[part]),
        "moment": float(np.abs(asked[part]).max()),
    }


def correlation(series: Series, begin: float, end: float) -> float:
    """Return the correlation of both tips' motion across the stream: 1 in phase, −1 in opposite phase."""
    part = (series["time"] > begin) & (series["time"] <= end)
    return float(np.corrcoef([series[f"{name}_tip_uy"][part] for name in NAMES])[0, 1])


def filaments(done: nervure.Run) -> dict[str, float | None]:
    """Return correlations of both tips over the windows, their amplitudes, and the frequency."""
    tips = [done.summary.quantities[f"{name}_tip_uy"] for name in NAMES]
    found = {f"from_{begin:g}": correlation(done.series, begin, end) for begin, end in WINDOWS}
    return found | dict(zip(NAMES, (tip.amplitude for tip in tips))) | {"frequency": tips[0].frequency_hz}


def twin_folder(folder: Path) -> Path:
    return folder / "twin"


def measured(group: str, done: nervure.Run) -> dict[str, Any]:
    """Return the values that the tables show of a run."""
    if group == "flag":
        return swing(done.series, "tip_uy", SETTLED[group]) | {"drag": done.summary.quantities["drag"].mean}
    if group == "filaments":
        return filaments(done)
    if group == "shedding":
        return shedding(done.series)
    if group == "passive":
        rigid = nervure.run(validate(twin(done)), twin_folder(done.folder), force=True, quiet=True)
        return passive(done, rigid.series)
    if group == "oscillating":
        return oscillating(done.series)
    return fourth_period(done.series) if group == "hover" else stream(done.series, done.folder)


def run(case: Case, folder: Path) -> dict[str, Any]:
    """Run a scene, and a rigid twin of a passive vein; return their values. A steady stream needs its last field."""
    scene = validate(case.built())
    every = scene.time.end if case.scene == STREAM else None
    done = nervure.run(scene, folder, fields_every=every, force=True, quiet=True)
    return {"values": measured(case.name.split("/")[0], done), "times": {"cpu_s": done.summary.cpu_s}}


EXPECTED: dict[str, dict[str, float]] = simulate.LISTED["flapping"]
"""Published values by group, and of single cases."""


def cases() -> Iterator[Case]:
    for name, (scene, changes) in CASES.items():
        group, grid = name.split("/")
        about = {"expected": EXPECTED.get(name, EXPECTED.get(group, {})), "grid": grid.replace("x", " x ")}
        yield Case(name, FLUID if scene in (KC5, HOVER, STREAM) else COUPLED, scene, changes, action=run, about=about)


def draw_oscillating(done: nervure.Run) -> None:
    """Draw the force of the oscillating cylinder over the published curve."""
    time, force = done.series["time"], done.series["body_1_drag"]
    share = (time - (time[-1] - PERIOD)) / PERIOD
    published = curve("oscillating_cylinder_re100_kc5")
    show.curves("pictures/oscillating-cylinder", ("t/T", "F / (rho U² D)"), [
        {"x": share[share >= 0], "y": force[share >= 0], "label": "600 x 360"},
        {"x": published[0], "y": published[1], "marker": "o", "linestyle": "", "markersize": 3,
         "label": "Dütsch et al. 1998, digitised"},
    ])  # fmt: skip


def draw_hover(done: nervure.Run) -> None:
    """Draw lift and drag of the ellipse over the published curves."""
    figure, axes = show.panel(2, 1, (9.0, 6.0), sharex=True)
    found = hovering(done.series)
    for axis, name in zip(axes[:, 0], ("lift", "drag"), strict=True):
        axis.plot(found["time"], found[name], linewidth=1.0, label="640x640")
        for source, label in (("eldredge", "Eldredge 2007"), ("wang_experiment", "experiment, Wang et al. 2004")):
            axis.plot(*curve(f"hovering_ellipse_re75_{source}_{name}"), "o", markersize=2, label=f"{label}, digitised")
        axis.set(ylabel={"lift": "$c_L$ / 1.2", "drag": "$c_D$ / 1.4"}[name], ylim=(-1.0, 2.0), xlim=(0, 4))
    axes[1, 0].set_xlabel("t/T")
    axes[0, 0].legend(fontsize=8, ncols=3)
    show.save(figure, "pictures/hovering-ellipse", 110)


def draw(data: Data, runs: Callable[[str], Run | None]) -> None:
    for name, drawn in (("oscillating/600x360", draw_oscillating), ("hover/640x640", draw_hover)):
        if found := runs(f"flapping/{name}"):
            drawn(nervure.read(found.folder))


STUDY = Study("flapping", cases, lambda case, run: run.found, draw=draw)
