"""Bodies in a fluid of three dimensions beside published values, on several grids and in several boxes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import atan2, degrees, hypot, pi, radians
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

import nervure
from nervure.evaluate.statistics import Series
from nervure.output.forecast import resident_memory
from nervure.scene import validate
from nervure.simulation.session import Session
from studies.engine import FLUID, Case, Study
from studies.flapping import curve, off

SPHERE, STREAM, PLATE = "sphere-oscillating-64x64x64", "sphere-stream-144x96x96", "plate-stream-96x72x72"
HANGING, ROLLING = "rod-hanging-160x160x48", "plate-rolling-96x80x80"
SPEED = pi / 4  # Largest of the oscillating sphere, m/s
AREA = pi / 4  # Of a section of a sphere of diameter 1, m²
SCALE = pi / 4
"""Factor to the published curve of the oscillating sphere, whose peak of 20.2 is no 2 F/(rho U² A): `drag_in_shell` is
17.8 in the shell inside the cube and 15.1 in the shell of the same volume."""
DRAG = {50: 1.581, 100: 1.102}  # Drag coefficients of a sphere by Re (Johnson & Patel 1999)
PLATES = {90: (1.527, 0.069), 60: (1.145, 0.588), 30: (0.639, 0.758)}
"""Coefficients of drag and lift of a plate of aspect 2 by its angle, ° (Taira et al. 2007, digitised)."""
THRUST = {"ct": 1.04, "cl_rms": 2.817, "cs_rms": 1.600, "efficiency": 0.173}
"""Of the plate that rolls and pitches, over its fifth period: the thrust extrapolated from PetIBM on up to 200 cells
(1.02 to 1.06), the others on 200 (Mesnard & Barba 2021)."""
SPEEDS = {0.6: (8e-5, 0.08), 1.1: (4e-5, 0.05), 1.6: (2.5e-5, 0.045), 2.1: (1.6e-5, 0.04)}
"""Step and end of a run with a hanging rod, s, by the speed of the stream, m/s. A wave of the wave number k grows in
steps above (4 ν/(3 k² U⁴))^(1/3): waves of two cells do in steps of 2.4e-5 s at 2.1 m/s, and bend the rod by 3° after
0.036 s."""
STEPS = 12  # Timed steps

Changes = dict[str, Any]


def grid(cells: list[int], step: float) -> Changes:
    """Return the changes to another grid and step."""
    return {"fluid.box.cells": cells, "time.communication_step": step, "fluid.time_stepping.max_step": step}


def turned(angle: float) -> Changes:
    """Return the changes to another angle of the plate, °."""
    return {"fluid.bodies.0.turn.angle": radians(angle)}


def stream(speed: float) -> Changes:
    """Return the changes to another speed of the stream around the hanging rod, m/s."""
    step, end = SPEEDS[speed]
    laws = ("fluid.initial_velocity.0", "fluid.mean_flow.x.constant", "fluid.sponge.mean_velocity.constant")
    steps = ("time.communication_step", "fluid.time_stepping.max_step")
    return dict.fromkeys(laws, speed) | dict.fromkeys(steps, step) | {"time.end": end}


def fine(ratio: int, step: float) -> Changes:
    """Return the changes to 6 coarse cells a chord, finer ones around the plate, and a step, s."""
    c_eta = 1e-4 * (4 / ratio) ** 2  # As that of 24 cells a chord on one grid
    box = {"fluid.fine_box": FINE_BOX | {"ratio": ratio}, "fluid.mask.log_linear.c_eta": c_eta}
    return grid([96, 72, 72], step) | box


SLOW, DISTANCE = 0.02, 6.0  # Reynolds number of thin bodies in slow flow, and distance of their images, lengths
DISKS = {"broadside": (16.0, {"axis": [0.0, 0.0, 1.0], "angle": pi / 2}), "edgewise": (32 / 3, {})}
"""Drag of a disk in slow flow by viscosity, radius and speed (Oberbeck 1876), and its turn from the normal y."""
ELLIPSE = (0.5, 0.125)  # Half axes
ELLIPSES = {"broadside": ("y", "z"), "lengthwise": ("x", "z"), "sideways": ("z", "x")}
"""Directions of the long and of the short axis; the stream is along x."""
RINGS = 32  # Of the triangles of an ellipse


def disk(attitude: str, cells: int) -> Changes:
    """Return the changes to a disk in slow flow with `cells` across it."""
    turn = DISKS[attitude][1]
    return in_slow_flow({"shape": {"disk": {"radius": 0.5}}} | ({"turn": turn} if turn else {}), cells)


def ellipse(attitude: str, cells: int) -> Changes:
    """Return the changes to an ellipse of no thickness in slow flow with `cells` along it."""
    nodes, triangles = [[0.0, 0.0, 0.0]], []
    for k in range(1, RINGS + 1):
        first = len(nodes)
        for turn in np.arange(6 * k) * pi / (3 * k):
            node = dict(zip(ELLIPSES[attitude], (ELLIPSE[0] * np.cos(turn), ELLIPSE[1] * np.sin(turn))))
            nodes.append([round(k / RINGS * node.get(axis, 0.0), 12) for axis in "xyz"])
        inner = first - max(6 * (k - 1), 1)
        for j in range(6 * k):
            side, along = divmod(j, k)
            low, high = ((side * (k - 1) + i) % max(6 * (k - 1), 1) + inner for i in (along, along + 1))
            triangles.append([first + j, first + (j + 1) % (6 * k), low])
            if along < k - 1:
                triangles.append([first + (j + 1) % (6 * k), high, low])
    return in_slow_flow({"shape": {"triangulation": {"nodes": nodes, "triangles": triangles}}}, cells)


def drag_of_ellipse(attitude: str) -> float:
    """Return the drag of the ellipse in slow flow by viscosity, half its length and speed (Oberbeck 1876)."""
    halves = dict(zip(ELLIPSES[attitude], ELLIPSE))
    a = [halves.get(axis, 0.0) for axis in "xyz"]
    # λ = tan² takes the root at 0, where the body has no thickness, and the end.
    turns = (np.arange(20_000) + 0.5) * pi / 40_000
    at = np.tan(turns) ** 2
    area = np.sqrt(np.prod([own**2 + at for own in a], axis=0))
    weights = 2 * np.tan(turns) / np.cos(turns) ** 2 * pi / 40_000 / area
    chi, alpha = weights.sum(), (weights / (a[0] ** 2 + at)).sum()
    return float(16 * pi / (chi + alpha * a[0] ** 2) / ELLIPSE[0])


def in_slow_flow(body: Changes, cells: int) -> Changes:
    """Return the changes to a body of length 1 in slow flow, among its periodic images, with `cells` along it."""
    ratio, half = (2, 1.5) if cells >= 16 else (1, 0.0)
    changes: Changes = dict.fromkeys(("fluid.sponge", "fluid.fine_box"), "absent")
    if ratio > 1:
        changes["fluid.fine_box"] = {axis: [-half, half] for axis in "xyz"} | {"ratio": ratio}
    box = {axis: [-DISTANCE / 2, DISTANCE / 2] for axis in "xyz"} | {"cells": [int(DISTANCE) * cells // ratio] * 3}
    # Finer cells need shorter steps: the splitting of drag and viscosity decays in a number of steps.
    step = 10 * SLOW / (50 * cells // 3)
    steps = dict.fromkeys(("time.communication_step", "fluid.time_stepping.max_step"), step)
    return changes | steps | {
        "time.end": 10 * SLOW,
        "fluid.kinematic_viscosity": 1 / SLOW,
        "fluid.box": box,
        "fluid.bodies": [body | {"position": [0.013, 0.007, 0.011]}],
        "fluid.mask.log_linear.c_eta": 1e-8,
        "fluid.precision": "double",
        "fluid.threads": 1,
    }  # fmt: skip


def drag_among_images(alone: float) -> float:
    """Return the drag of a body in a cubic array, whose drag alone is `alone` times viscosity, radius and speed, as a
    coefficient (Hasimoto 1959, for a sphere of the same drag)."""
    share = alone * 0.5 / (6 * pi) / DISTANCE
    return alone * 0.5 / SLOW / (1 - 2.8373 * share + 4.19 * share**3)


SHEET = {"fluid.bodies.0.shape": {"plate": {"length": 1.0, "width": 2.0}}}
WIDE = {"fluid.box.y": [-6.0, 6.0], "fluid.box.z": [-6.0, 6.0]}
LONG = {"fluid.box.x": [-8.03, 9.97], "fluid.sponge.x": [7.97, 9.97]}
FAR = {"fluid.box.x": [-5.0, 11.0], "fluid.sponge.x": [9.5, 11.0], "time.end": 16.0} | WIDE
FINE_BOX = {"x": [-1.5, 2.5], "y": [-1.5, 1.5], "z": [-2.0, 2.0]}
SINGLE = {"fluid.precision": "single", "time.end": 2.0}

CASES: dict[str, tuple[str, Changes]] = {
    "oscillating/32x32x32": (SPHERE, grid([32] * 3, 1e-2)),
    "oscillating/64x64x64": (SPHERE, {}),
    "oscillating/128x128x128": (SPHERE, grid([128] * 3, 2.5e-3) | SINGLE),
    "sphere/96x64x64": (STREAM, grid([96, 64, 64], 0.03)),
    "sphere/96x96x96, box 12 x 12 x 12": (STREAM, grid([96, 96, 96], 0.03) | WIDE),
    "sphere/144x64x64, box 18 x 8 x 8": (STREAM, grid([144, 64, 64], 0.03) | LONG),
    "sphere/144x96x96": (STREAM, {}),
    "sphere/144x96x96, Re 50": (STREAM, {"fluid.kinematic_viscosity": 0.02}),
    "plate/90°": (PLATE, {}),
    **{f"sheet/{angle}°": (PLATE, SHEET | turned(angle)) for angle in PLATES},
    "sheet/30°, 192x144x144": (PLATE, SHEET | turned(30) | grid([192, 144, 144], 0.0125)),
    **{f"sheet/{angle}°, 12 fine cells": (PLATE, SHEET | FAR | turned(angle) | fine(2, 0.017)) for angle in PLATES},
    **{f"sheet/{angle}°, 24 fine cells": (PLATE, SHEET | FAR | turned(angle) | fine(4, 0.0085)) for angle in PLATES},
    **{
        f"sheet/{angle}°, 12 fine cells, box 8 x 6 x 6": (
            PLATE,
            SHEET | turned(angle) | fine(2, 0.017) | {"fluid.box.cells": [48, 36, 36]},
        )
        for angle in PLATES
    },
    "rolling/16 fine cells": (ROLLING, {"fluid.fine_box.ratio": 2, "fluid.mask.log_linear.c_eta": 2.2e-4}),
    "rolling/32 fine cells": (ROLLING, {}),
    **{f"hanging/160x160x48, U {speed}": (HANGING, stream(speed)) for speed in SPEEDS},
    **{
        f"hanging/{n}x{n}x{3 * n // 10}, U {speed}": (HANGING, stream(speed) | grid([n, n, 3 * n // 10], 160 / n * h))
        for n in (40, 80)
        for speed, (h, _) in SPEEDS.items()
        if speed in (1.1, 2.1)
    },
    "plate/90°, 64x48x48": (PLATE, grid([64, 48, 48], 0.04)),
    "plate/90°, 128x96x96": (PLATE, grid([128, 96, 96], 0.02)),
    "plate/90°, box 8 x 9 x 9": (
        PLATE,
        {f"fluid.box.{axis}": [-4.5, 4.5] for axis in "yz"} | grid([96, 108, 108], 0.025),
    ),
    **{f"disk/{name}, {n} cells": (STREAM, disk(name, n)) for name in DISKS for n in (8, 12, 16, 24)},
    **{f"ellipse/{name}, {n} cells": (STREAM, ellipse(name, n)) for name in ELLIPSES for n in (12, 24)},
}


def oscillating(series: Series, begin: float = 1.0) -> dict[str, float]:
    """Return smallest and largest drag coefficient of an oscillating sphere from `begin` (periods) on, and the distance
    from the published curve."""
    time, drag = series["time"], series["body_1_drag"] / (SPEED**2 * AREA / 2)
    at, published = curve("oscillating_sphere_re20")
    part = (at > begin) & (at <= time[-1])
    late = drag[time > begin]
    rms = off(np.interp(at[part], time, drag), SCALE * published[part])
    return {"low": float(late.min()), "high": float(late.max()), "rms": rms}


def drag_in_shell(radius: float) -> float:
    """Return the largest drag coefficient of the sphere in small oscillations amid a still spherical shell (m).

    Stokes (1851): a stream function f(r) sin²θ, f = A r² + B/r + C exp(-λr)(1 + 1/(λr)) + D exp(λr)(1 - 1/(λr)) with
    λ² = -iω/ν, without slip at both surfaces; A and B have the pressure.
    """
    a, nu, omega = 0.5, pi / 80, 2 * pi
    decay = np.sqrt(1j * omega / nu).conjugate()

    def parts(r: float) -> np.ndarray:
        """Return f and its first two derivatives for each constant, `[3, 4]`."""
        rows = [[r * r, 1 / r], [2 * r, -1 / r**2], [2.0, 2 / r**3]]
        for sign, origin in ((-1, a), (1, radius)):
            k = sign * decay
            grown = np.exp(k * (r - origin))
            f = grown * (1 - 1 / (k * r))
            slope = k * f + grown / (k * r * r)
            rows[0].append(f)
            rows[1].append(slope)
            rows[2].append(k * slope + k * grown / (k * r * r) - 2 * grown / (k * r**3))
        return np.array(rows)

    walls = np.concatenate([parts(a)[:2], parts(radius)[:2]])
    constants = np.linalg.solve(walls, SPEED * np.array([a * a / 2, a, 0, 0]))
    bend = parts(a)[2] @ constants
    pressure = 1j * omega * (2 * constants[0] * a - constants[1] / a**2)
    shear = nu * (SPEED / a - bend / a)
    force = -4 * pi * a * a / 3 * (pressure + 2 * shear)
    return float(abs(force)) / (SPEED**2 * AREA / 2)


def angle(series: Series, length: float) -> float:
    """Return the angle of the line from root to tip with the stream at the end, °, of a rod that hangs along -y."""
    return degrees(atan2(length - series["tip_uy"][-1], series["tip_ux"][-1]))


def rolling(done: nervure.Run) -> dict[str, float]:
    """Return mean thrust, root mean squares of lift and side force, and efficiency over the last period."""
    time, scales = done.series["time"], done.summary.bodies["body_1"].reference
    late = time >= time[-1] * (1 - 1 / 5) - 1e-9
    length = time[late][-1] - time[late][0]

    def mean(values: np.ndarray) -> float:
        return float(np.trapezoid(values[late], time[late]) / length)

    assert scales and scales.area
    q = 0.5 * scales.area
    ct, cp = -mean(done.series["drag"]) / q, -mean(done.series["body_1_power"]) / q
    rms = {f"c{name[0]}_rms": mean((done.series[name] / q) ** 2) ** 0.5 for name in ("lift", "side")}
    return {"ct": ct, **rms, "efficiency": ct / cp}


def law(speed: float, diameter: float) -> float:
    """Return that angle of the rod of the scene in a stream (m/s) by the law of its experiment, °, with the drag of a
    cylinder of a diameter (m)."""
    cd = (1.13 + 11.4 * (speed * diameter / 1.51e-5) ** -0.808) ** 0.952
    drag_by_weight = 2 / pi * cd * 1.21 / (1000 - 1.21) * speed**2 * diameter / (9.81 * 4e-4**2)
    return float(90 / (1 + 3.32 * drag_by_weight**1.33) ** 0.407)


def run(case: Case, folder: Path) -> dict[str, Any]:
    """Run a scene; return its values."""
    scene = validate(case.built())
    done = nervure.run(scene, folder, force=True, quiet=True)
    if case.scene == SPHERE:
        values = oscillating(done.series)
    elif case.scene == HANGING:
        assert scene.beam
        found, half = angle(done.series, scene.beam.length), len(done.series["time"]) * 4 // 5
        ux, uy = (done.series[f"tip_{name}"] for name in ("ux", "uy"))
        speed = hypot(ux[-1] - ux[half], uy[-1] - uy[half]) / (done.series["time"][-1] - done.series["time"][half])
        values = {"angle": found, "tip_speed": speed}
    elif case.scene == ROLLING:
        values = rolling(done)
    elif case.name.startswith(("disk", "ellipse")):
        values = {"drag": float(done.series["drag"][-1])}
    elif case.scene == PLATE:
        values = {"cd": float(done.series["drag"][-1]), "cl": float(done.series["lift"][-1])}
    else:
        values = {"cd": float(done.series["drag"][-1]) / (AREA / 2)}
    return {"values": values, "times": {"cpu_s": done.summary.cpu_s}}


def time_steps(case: Case, folder: Path) -> dict[str, Any]:
    """Return processor and wall time of a step, ms, as medians over some steps, and the memory that the unit takes, MB.
    Wall times need a machine without other work."""
    before, times = resident_memory(), []
    with Session(validate(case.built()), folder) as session:
        session.start()
        for _ in range(STEPS):
            begin, wall = process_time(), perf_counter()
            session.step()
            times.append((process_time() - begin, perf_counter() - wall))
        memory = (resident_memory() - before) / 1e6
    step, wall = np.median(times, axis=0)
    points = float(np.prod(case.changes["fluid.box.cells"]))
    return {
        "times": {"step_ms": 1e3 * step, "wall_ms": 1e3 * wall, "point_ns": 1e9 * step / points, "memory_mb": memory}
    }


def expected(name: str) -> dict[str, float]:
    """Return the published values of a case."""
    group, said = name.split("/")
    if group == "hanging":
        return {"angle": law(float(said.split()[-1]), 4e-4)}
    if group == "rolling":
        return THRUST
    if group == "disk":
        return {"drag": drag_among_images(DISKS[said.split(",")[0]][0])}
    if group == "ellipse":
        return {"drag": drag_among_images(drag_of_ellipse(said.split(",")[0]))}
    if group in ("plate", "sheet"):
        angle = int(said.split("°")[0])
        return dict(zip(("cd", "cl") if angle < 90 else ("cd",), PLATES[angle]))
    return {"cd": DRAG[50 if "Re 50" in said else 100]} if group == "sphere" else {"rms": 0.0}


def cases() -> Iterator[Case]:
    for name, (scene, changes) in CASES.items():
        about = {"expected": expected(name), "grid": re.sub(r"(?<=\d)x(?=\d)", " x ", name.split("/")[1])}
        yield Case(name, FLUID, scene, changes, action=run, about=about)
    for n, precision in ((128, "single"), (128, "double"), (192, "single")):
        box = {f"fluid.box.{axis}": [-4.0, 4.0] for axis in "xyz"} | {"fluid.sponge.x": [3.0, 4.0]}
        changes = box | grid([n] * 3, 0.5 / n) | {"fluid.precision": precision}
        for threads in (1, 2):
            label = f"{n}x{n}x{n}, {precision}, {threads} thread{'s' * (threads > 1)}"
            yield Case(f"step/{label}", FLUID, STREAM, changes | {"fluid.threads": threads}, action=time_steps)


STUDY = Study("space", cases, lambda case, run: run.found)
