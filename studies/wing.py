"""A wing: a square plate that vibrates as exact ones do, the limit of a rigid plate, a hovering wing by its stiffness,
the map of stability, and the cost of a step."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import nervure
from nervure.scene import validate
from nervure.scene.facts import Facts, WingMesh
from nervure.simulation.loop import Observer, TimeLoop
from nervure.simulation.session import Session
from studies import commands, flapping, simulate, space, thin
from studies.engine import COUPLED, Case, Study
from studies.show import exponent
from studies.store import Data

HOVER = "wing-hover-64x64x84"
FACTORS = (0.25, 1.0, 4.0, 16.0)
"""Stiffness of membrane and veins by that of the scene."""
STROKE = 10.0  # Period of the hovering wing, s; the last one counts
POWERS = ("root_power", "load_power", "damping_power", "energy_elastic", "energy_kinetic", "wing_drag", "wing_lift",
          "wing_side", "section_twist", "section_camber")  # fmt: skip
COST = ["cargo", "run", "--release", "--quiet", "--locked", "-p", "nervure-wing", "--example", "cost"]

LEISSA = 3.4917
"""First frequency of a square plate clamped at one side, ω L² √(ρ h/D), for Poisson's ratio 0.3 (Leissa 1973)."""
ELEMENTS = (4, 8, 16, 32)  # Along a side of the plate
PERIODS, STEPS = 12, 200  # Of the first mode, and communication steps in one
NUDGE = 1e-3  # m
PERIOD = 2 * np.pi / LEISSA  # s, with ρ h, D and L of one

PLATE: dict[str, Any] = {
    "name": "plate",
    "time": {"end": PERIODS * PERIOD, "communication_step": PERIOD / STEPS},
    "wing": {
        "membrane": {
            "areal_density": 1.0,
            "stretching_stiffness": 1e4,
            "bending_stiffness": 1.0,
            "poisson_ratio": 0.3,
        },
        "root": "root",
        "root_motion": {"z": {"table": {"times": [0.0, 0.5, 1.0], "values": [0.0, NUDGE, 0.0]}}},
    },
}

CELLS = 48  # Along a side of the box of the plate that heaves and pitches
HEAVE = {"sine": {"amplitude": 0.2, "frequency": 0.5, "ramp": 0.6}}
PITCH = {"sine": {"amplitude": 0.4, "frequency": 0.5, "phase": 1.0, "ramp": 0.6}}
ORIGIN, SPAN = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]  # Pivot and axis of the pitch
HEAVING: dict[str, Any] = {"z": HEAVE, "angle": PITCH, "axis": SPAN}
STIFF = (1e2, 1e3, 1e4, 1e5)
"""Stiffness of a plate that heaves and pitches: D/(rho U² c³) for chord and largest speed of the heave of about 1."""

PIVOT, UPWARDS = [-0.5, 0.0, 0.0], [0.0, 1.0, 0.0]
GYRATION = np.sqrt((2.5**3 - 0.5**3) / (3 * 2.0))  # Radius of the revolving plate, m
OMEGA = 1.0 / GYRATION  # rad/s
START, REVOLVED = 1.0, 5.5  # Time to full speed, and the end after half a turn, s
STARTS = np.linspace(0.0, START, 9)
REVOLUTION = {
    "table": {
        "times": [*STARTS.tolist(), REVOLVED],
        "values": [
            *(0.5 * OMEGA * (STARTS - START / np.pi * np.sin(np.pi * STARTS / START))).tolist(),
            OMEGA * (REVOLVED - 0.5 * START),
        ],
        "end_slopes": [0.0, OMEGA],
    }
}
"""Angle of the revolving plate, rad, whose speed begins by a cosine."""
EXPECTED: dict[str, dict[str, float]] = simulate.LISTED["wing"]
FLAG, SETTLED = "flag-square-144x96x96", 10.0  # Scene, and begin of the evaluated part, s
FLAGS = {24: "144x96x96", 36: "216x144x144", 48: "288x192x192"}
"""Grids of the square flag by the cells along its side."""
VARIED: dict[str, dict[str, Any]] = {
    "144x96x192, twice as high": {"fluid.box.z": [-4.0, 4.0], "fluid.box.cells": [144, 96, 192]},
    "144x96x96, to 30 s": {"time.end": 30.0},
    "48 fine cells": space.grid([144, 96, 96], 0.003125)
    | {
        "fluid.fine_box": {"x": [-0.5, 1.75], "y": [-1.0, 1.0], "z": [-1.0, 1.0], "ratio": 2},
        "wing.mesh.rectangular.along": 32,
    },
}
"""Changes to the square flag on the coarsest grid."""
FLEXIBLE = (3.0, 10.0, 30.0, 1000.0, None)
"""Stiffness of the revolving plate, D/(rho U² c³); none of a rigid one."""


def heaving(stiffness: float, cells: int = CELLS) -> dict[str, Any]:
    """Return the scene of a square wing that heaves and pitches at its root, of the bending stiffness D, N m."""
    step = 0.64 / cells
    return {
        "name": "heaving",
        "time": {"end": 2.0, "communication_step": step},
        "fluid": {
            "density": 1.0,
            "kinematic_viscosity": 0.02,
            "box": {"x": [-1.5, 2.5], "y": [-2.0, 2.0], "z": [-2.0, 2.0], "cells": 3 * [cells]},
            "mask": {"log_linear": {"c_eta": 1e-3}},
            "time_stepping": {"max_step": step, "max_cfl": 0.4},
        },
        "wing": {
            "mesh": {"rectangular": {"length": 1.0, "width": 1.0, "along": 4}},
            "membrane": {
                "areal_density": 0.5,
                "stretching_stiffness": 400.0 * stiffness,
                "bending_stiffness": stiffness,
            },
            "root": "root",
            "root_motion": {"z": HEAVE, "rotations": [{"angle": PITCH, "axis": SPAN}]},
        },
    }


def mesh_of(scene: dict[str, Any]) -> WingMesh:
    """Return the mesh of the wing of a scene."""
    mesh = Facts(validate(scene)).wing
    assert mesh is not None
    return mesh


def rigid(scene: dict[str, Any], motion: dict[str, Any] = HEAVING, pivot: list[float] = ORIGIN) -> dict[str, Any]:
    """Return the scene of the triangles of a wing as a rigid body that moves."""
    mesh = mesh_of(scene)
    body = {
        "shape": {"triangulation": {"nodes": mesh.nodes.tolist(), "triangles": mesh.triangles.tolist()}},
        "position": pivot,
        "pivot": pivot,
        "motion": motion,
    }
    rest = {key: part for key, part in scene.items() if key not in ("wing", "fluid")}
    return rest | {"fluid": scene["fluid"] | {"bodies": [body]}}


def forces(scene: dict[str, Any], body: str, folder: Path) -> np.ndarray:
    """Return the forces of the fluid on a body over time, `[3, times]`, N."""
    series = nervure.run(validate(scene), folder, force=True, quiet=True).series
    return np.array([series[f"{body}_{name}"] for name in ("drag", "lift", "side")])


def differences(scene: dict[str, Any], folder: Path, rigid_forces: np.ndarray) -> dict[str, float]:
    """Return the difference of the forces on a wing from those on a rigid plate: root mean square by root mean square,
    and largest by largest."""
    off = np.linalg.norm(forces(scene, "wing", folder) - rigid_forces, axis=0)
    size = np.linalg.norm(rigid_forces, axis=0)
    return {"mean": float(np.sqrt((off**2).mean() / (size**2).mean())), "largest": float(off.max() / size.max())}


def of_rigid(case: Case, folder: Path) -> dict[str, Any]:
    """Return the differences of a wing from the rigid plate of its triangles and motion."""
    scene = heaving(**case.options)
    found = differences(scene, folder / "wing", forces(rigid(scene), "body_1", folder / "rigid"))
    return {"values": found}


def revolving(stiffness: float | None, cells: int) -> dict[str, Any]:
    """Return the scene of a plate of aspect 2, 45° to its path, that revolves about an axis half a chord off its root,
    at Re 100 by its radius of gyration, of the bending stiffness D, N m, or rigid; `cells` are those of a chord."""
    box = {"x": [-4.0, 4.0], "y": [-2.5, 2.5], "z": [-4.0, 4.0]}
    scene: dict[str, Any] = {"name": "revolving", "time": {"end": REVOLVED, "communication_step": 0.25 / cells}}
    scene["wing"] = {
        "mesh": {"rectangular": {"length": 2.0, "width": 1.0, "along": 12}},
        "membrane": {
            "areal_density": 1.0,
            "stretching_stiffness": 400.0 * (stiffness or 1.0),
            "bending_stiffness": stiffness or 1.0,
        },
        "root": "root",
    }
    flat = mesh_of(scene)
    x, y, _ = flat.nodes.T
    nodes = np.sqrt(0.5) * np.transpose([np.sqrt(2.0) * x, y, -y])
    chain = {"name": "root", "nodes": flat.roots[0].tolist()}
    mesh = {"nodes": nodes.tolist(), "triangles": flat.triangles.tolist(), "chains": [chain]}
    motion = {"rotations": [{"angle": REVOLUTION, "axis": UPWARDS}]}
    scene["wing"] |= {"mesh": {"triangles": mesh}, "pivot": PIVOT, "root_motion": motion}
    scene["fluid"] = {
        "density": 1.0,
        "kinematic_viscosity": 0.01,
        "box": box | {"cells": [round(cells * (high - low)) for low, high in box.values()]},
        "mask": {"log_linear": {"c_eta": 1e-3}},
        "time_stepping": {"max_step": 0.25 / cells, "max_cfl": 0.4},
        "precision": "single",
    }
    return scene if stiffness else rigid(scene, {"angle": REVOLUTION, "axis": UPWARDS}, PIVOT)


def of_revolving(case: Case, folder: Path) -> dict[str, Any]:
    """Return the mean coefficients of a revolving plate over its last quarter of a turn, and the mean twist, rad."""
    scene = revolving(**case.options)
    done = nervure.run(validate(scene), folder, force=True, quiet=True)
    series, body = done.series, "wing" if "wing" in scene else "body_1"
    late = np.asarray(series["time"]) > REVOLVED - 0.25 * 2 * np.pi / OMEGA
    time, drag, lift, side = (np.asarray(series[name])[late] for name in
                              ("time", f"{body}_drag", f"{body}_lift", f"{body}_side"))  # fmt: skip
    angle = OMEGA * (time - 0.5 * START)
    back = drag * np.sin(angle) + side * np.cos(angle)
    values = {"lift": lift, "drag": back}  # By rho U² S/2, which is 1
    if "section_twist" in series:
        values["twist"] = np.abs(np.asarray(series["section_twist"])[late])
    means = {name: float(column.mean()) for name, column in values.items()}
    return {"values": means, "times": {"cpu_s": done.summary.cpu_s}}


class Middle(Observer):
    """Records the height of the middle of the free edge of a flag of unit sides."""

    def __init__(self, session: Session):
        self.wing = session.units["wing"]
        assert session.facts.wing
        self.node = int(np.argmin(np.linalg.norm(session.facts.wing.nodes - [1.0, 0.0, 0.0], axis=1)))
        self.rows: list[tuple[float, float]] = []

    def step(self, loop: TimeLoop) -> None:
        self.rows.append((loop.time, float(self.wing.outputs[self.wing.slices["z"]][self.node])))


def of_flag(case: Case, folder: Path) -> dict[str, Any]:
    """Return amplitude and frequency of the middle of the free edge of a flag."""
    with simulate.session(case.built(), folder) as session:
        session.observers.append(middle := Middle(session))
        status = session.run()
    assert status.error is None, status.error
    time, z = np.transpose(middle.rows)
    found = flapping.swing({"time": time, "z": z}, "z", SETTLED)
    values = {"height": found["amplitude"], "frequency": found["frequency"]}
    return {"values": values, "times": {"cpu_s": status.cpu}}


def vibrating(case: Case, folder: Path) -> dict[str, Any]:
    """Return the frequency of the tip of a plate, nudged at its root, as `LEISSA` has it."""
    mesh = {"rectangular": {"length": 1.0, "width": 1.0, "along": case.options["along"]}}
    scene = PLATE | {"wing": PLATE["wing"] | {"mesh": mesh}}
    done = nervure.run(validate(scene), folder, force=True, quiet=True)
    frequency = flapping.swing(done.series, "tip_uz", 2.0)["frequency"]
    return {"values": {"frequency": 2 * np.pi * frequency}, "times": {"cpu_s": done.summary.cpu_s}}


def hovering(case: Case, folder: Path) -> dict[str, Any]:
    """Return mean forces of a hovering wing, N, the mean power of its drive, W, and the imbalance of the works."""
    done = nervure.run(validate(case.built()), folder, force=True, quiet=True)
    wing, work = done.summary.wing, done.summary.interface
    assert wing and work
    values = {"drag": wing.drag, "lift": wing.lift, "side": wing.side, "root_power": wing.root_power}
    return {"values": values | {"imbalance": work.imbalance}, "times": {"cpu_s": done.summary.cpu_s}}


def stiffer(factor: float) -> dict[str, Any]:
    """Return the changes to a hovering wing with all stiffnesses times `factor`."""
    own, names = simulate.shipped(HOVER)["wing"], ("bending_stiffness", "axial_stiffness")
    changes = {f"wing.membrane.{name}": factor * own["membrane"][name] for name in ("stretching_stiffness", names[0])}
    for i, vein in enumerate(own["veins"]):
        changes |= {f"wing.veins.{i}.{name}": factor * vein[name] for name in names}
    return changes | {"fluid.threads": 1}


def of_stiffness(case: Case, folder: Path) -> dict[str, Any]:
    """Return the means of a hovering wing over its last period."""
    done = nervure.run(validate(case.built()), folder, force=True, quiet=True)
    return {"values": means(done.series), "times": {"cpu_s": done.summary.cpu_s}}


def means(series: Any) -> dict[str, float]:
    """Return means of a hovering wing over its last period: lift, the force in the plane of the stroke, N, power of the
    drive, W, lift by power, N/W, what is missing in the balance of energies, by the work of the drive, and the
    largest twist, rad, and camber."""
    time = np.asarray(series["time"])
    late = time > time[-1] - STROKE
    column = {name: np.asarray(series[name])[late] for name in POWERS}
    # Work of the drive and of the fluid, less damping, is the change of the energy of the wing.
    works = {name: float(np.trapezoid(column[name], time[late])) for name in POWERS[:3]}
    stored = column["energy_elastic"] + column["energy_kinetic"]
    missing = works["root_power"] + works["load_power"] - works["damping_power"] - float(stored[-1] - stored[0])
    lift, power = float(column["wing_lift"].mean()), works["root_power"] / STROKE
    drag = float(np.hypot(column["wing_drag"], column["wing_side"]).mean())
    return {
        "lift_force": lift,
        "drag_force": drag,
        "power": power,
        "by_power": lift / power,
        "missing": missing / works["root_power"],
        "twist": float(np.abs(column["section_twist"]).max()),
        "camber": float(np.abs(column["section_camber"]).max()),
    }


MEMBRANES = {"limp": (1e2, 1e-6), "film": (1e3, 1e-3), "plate": (1e6, 1e2)}
"""Stretching stiffness, N/m, and bending stiffness, N m, by rho U² c and rho U² c³ of the stream."""
MASSES = (1.0, 1e-3, 1e-6)  # Of the wing by rho c³
MAPS = {"falls, alone": (5e-3, 5e-2), "in a stream": (1.25e-2, 5e-2)}  # Communication steps, s
GAIN = 0.02  # Energy that a wing alone may gain by the energy of its fall; the scheme takes energy
STREAM: dict[str, Any] = {
    "density": 1.0,
    "kinematic_viscosity": 0.01,
    "box": {"x": [-1.5, 4.5], "y": [-2.0, 2.0], "z": [-2.0, 2.0], "cells": [48, 32, 32]},
    "initial_velocity": [1.0, 0.0, 0.0],
    "mean_flow": {
        "x": {"constant": 1.0},
        "z": {"table": {"times": [0.0, 0.5, 1.0, 1.5], "values": [0.0, 0.3, 0.3, 0.0]}},
    },
    "sponge": {"x": [3.5, 4.5], "mean_velocity": {"constant": 1.0}, "c_eta": 0.08},
    "mask": {"log_linear": {"c_eta": 1e-3}},
    "precision": "single",
}
"""A stream with a gust across it."""


def square(membrane: str, mass: float, step: float, stream: bool) -> dict[str, Any]:
    """Return the scene of a square wing that hangs on its root under gravity, or meets a stream."""
    stretching, bending = MEMBRANES[membrane]
    wing: dict[str, Any] = {
        "mesh": {"rectangular": {"length": 1.0, "width": 1.0, "along": 8}},
        "membrane": {"areal_density": mass, "stretching_stiffness": stretching, "bending_stiffness": bending},
        "root": "root",
    }
    scene = {"name": "map", "time": {"end": 4.0, "communication_step": step}, "wing": wing}
    if stream:
        return scene | {"fluid": STREAM | {"time_stepping": {"max_step": step, "max_cfl": 0.4}}}
    return scene | {"wing": wing | {"gravity": [0.0, 0.0, -1.0]}}


def fallen(scene: dict[str, Any], folder: Path) -> tuple[str, float]:
    """Return the outcome of a wing alone as `thin.outcome` does, and the energy that it gained by that of its fall."""
    with simulate.session(scene, folder) as session:
        status, columns = session.run(), session.recorder.series
        warnings = session.warnings
    if status.error:
        return thin.failed(status.error), np.inf
    energy = columns["energy_elastic"] + columns["energy_kinetic"] + columns["energy_gravity"]
    gain = float(energy.max() - energy[0]) / float(-columns["energy_gravity"].min())
    sound = all(np.isfinite(column).all() for column in columns.values()) and gain < GAIN
    return "told" if warnings else "ok" if sound else "bad", gain


def mapped(case: Case, folder: Path) -> dict[str, Any]:
    """Run square wings over membranes, masses and steps."""
    rows, stream = [], case.options["map"] == "in a stream"
    with TemporaryDirectory(dir=folder) as place:
        for membrane, mass, step in product(MEMBRANES, MASSES, MAPS[case.options["map"]]):
            scene = square(membrane, mass, step, stream)
            said, off = thin.outcome(scene, Path(place), "wing") if stream else fallen(scene, Path(place))
            off = off if said == "ok" else 0.0
            rows.append({"membrane": membrane, "mass": mass, "step": step, "outcome": said, "off": off})
    return {"tables": {"map": rows}}


def counts(data: Data) -> list[dict[str, Any]]:
    """Return how many cells of each map came out how, and the largest error of those that ran without a word."""
    rows = []
    for record in data.of("wing/map/*"):
        cells = record.tables["map"]
        count = Counter(row["outcome"] for row in cells)
        named = {name: count[name] for name in ("ok", "told", "error", "bad")}
        largest = max(row["off"] for row in cells)
        rows.append({"label": record["label"], "largest": largest} | named)
    return rows


def cost(case: Case, folder: Path) -> dict[str, Any]:
    """Return the rows of the program that times a step, with CHOLMOD's factors of its matrices; they depend on the
    machine."""
    with TemporaryDirectory() as matrices:
        rows = list(csv.DictReader(commands.output([*COST, "--", matrices]).splitlines()))
        cholmod = commands.peer("cholmod_factor.py", matrices)
    timed = [row | {"cholmod_ms": cholmod[row["nodes"]]} for row in rows]
    return {"times": {"rows": [{name: float(value) for name, value in row.items()} for row in timed]}}


def flag(name: str, grid: str, changes: dict[str, Any], quick: bool = True) -> Case:
    """Return a case of the square flag with changes."""
    about = {"expected": EXPECTED["flag"], "grid": grid}
    return Case(name, (*COUPLED, "wing"), FLAG, changes, action=of_flag, about=about, quick=quick)


def cases() -> Iterator[Case]:
    about: dict[str, Any]
    for n in ELEMENTS:
        about = {"expected": {"frequency": LEISSA}, "grid": f"{n} a side"}
        yield Case(f"plate/{n}", ("scene", "wing"), options={"along": n}, action=vibrating, about=about)
    for stiffness in STIFF:
        about = {"expected": {"mean": 0.0}, "grid": f"{CELLS}^3"}
        options = {"stiffness": stiffness}
        yield Case(f"rigid/{stiffness:g}", (*COUPLED, "wing"), options=options, action=of_rigid, about=about)
    for cells, step in (([48, 48, 63], 0.00833333), ([64, 64, 84], 0.00625)):
        said = "x".join(map(str, cells))
        about = {"expected": {"imbalance": 0.0}, "grid": said}
        changes = {"time.end": 10.0, "fluid.threads": 1} | space.grid(cells, step)
        yield Case(f"hover/{said}", (*COUPLED, "wing"), HOVER, changes, action=hovering, about=about)
    for points, said in FLAGS.items():
        changes = space.grid([int(n) for n in said.split("x")], round(0.15 / points, 9))
        changes |= {"wing.mesh.rectangular.along": 2 * points // 3}
        yield flag(f"flag/{said}", said, changes, quick=points < 48)
    for said, changes in VARIED.items():
        yield flag(f"flag-varied/{said}", said, changes)
    for bending in FLEXIBLE:
        label = f"{bending:g}" if bending else "rigid"
        plate: dict[str, Any] = {"stiffness": bending, "cells": 16}
        yield Case(f"revolving/{label}", (*COUPLED, "wing"), options=plate, action=of_revolving)
    for factor in FACTORS:
        yield Case(f"stiffness/{factor:g}", (*COUPLED, "wing"), HOVER, stiffer(factor), action=of_stiffness)
    for name in MAPS:
        yield Case(f"map/{name}", (*COUPLED, "wing"), options={"map": name}, action=mapped)
    yield Case("cost/step", ("scene", "wing", "wing cost"), action=cost)


def costs(data: Data) -> list[dict[str, Any]]:
    """Return the costs by nodes, with the exponent from the row before."""
    rows = data["wing/cost/step"].times["rows"]
    found = [dict(row) for row in rows]
    for row, before in zip(found, [None, *rows]):
        nodes = [before["nodes"], row["nodes"]] if before else []
        for name in ("step_ms", "factorise_ms"):
            row[f"{name} exponent"] = exponent(nodes, [before[name], row[name]]) if before else None
    return found


STUDY = Study("wing", cases, lambda case, run: run.found, tables={"wing-cost": costs, "wing-map": counts})
