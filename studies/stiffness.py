"""The wing: cost of a step by its nodes, and a hovering wing by its stiffness."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import nervure
from nervure.scene import validate
from studies import commands, simulate
from studies.engine import Case, Study
from studies.show import exponent
from studies.store import Data

HOVER = "wing-hover-64x64x84"
SOURCES = ("scene", "fluid", "wing", "coupling", "evaluation")
FACTORS = (0.25, 1.0, 4.0, 16.0)
"""Stiffness of membrane and veins by that of the scene."""
PERIOD = 10.0  # Of the hovering wing, s; the last one counts
POWERS = ("root_power", "load_power", "damping_power", "energy_elastic", "energy_kinetic", "wing_drag", "wing_lift",
          "wing_side")  # fmt: skip
COST = ["cargo", "run", "--release", "--quiet", "--locked", "-p", "nervure-wing", "--example", "cost"]


def stiffer(factor: float) -> dict[str, Any]:
    """Return the changes to a hovering wing with all stiffnesses times `factor`."""
    own, names = simulate.shipped(HOVER)["wing"], ("bending_stiffness", "axial_stiffness")
    changes = {f"wing.membrane.{name}": factor * own["membrane"][name] for name in ("stretching_stiffness", names[0])}
    for i, vein in enumerate(own["veins"]):
        changes |= {f"wing.veins.{i}.{name}": factor * vein[name] for name in names}
    return changes | {"fluid.threads": 1}


def hover(case: Case, folder: Path) -> dict[str, Any]:
    """Run a hovering wing; return its means."""
    done = nervure.run(validate(case.built()), folder, force=True, quiet=True)
    return {"values": means(done.series), "times": {"cpu_s": done.summary.cpu_s}}


def means(series: Any) -> dict[str, float]:
    """Return means of a hovering wing over its last period: lift, the force in the plane of the stroke, N, power of the
    drive, W, lift by power, N/W, and what is missing in the balance of energies, by the work of the drive."""
    time = np.asarray(series["time"])
    late = time > time[-1] - PERIOD
    column = {name: np.asarray(series[name])[late] for name in POWERS}
    # Work of the drive and of the fluid, less damping, is the change of the energy of the wing.
    works = {name: float(np.trapezoid(column[name], time[late])) for name in POWERS[:3]}
    stored = column["energy_elastic"] + column["energy_kinetic"]
    missing = works["root_power"] + works["load_power"] - works["damping_power"] - float(stored[-1] - stored[0])
    lift, power = float(column["wing_lift"].mean()), works["root_power"] / PERIOD
    drag = float(np.hypot(column["wing_drag"], column["wing_side"]).mean())
    return {
        "lift": lift,
        "drag": drag,
        "power": power,
        "by_power": lift / power,
        "missing": missing / works["root_power"],
    }


def cost(case: Case, folder: Path) -> dict[str, Any]:
    """Return the rows of the program that times a step."""
    return {"tables": {"cost": list(csv.DictReader(commands.output(COST).splitlines()))}}


def cases() -> Iterator[Case]:
    yield Case("cost/step", ("scene", "wing", "wing cost"), action=cost)
    for factor in FACTORS:
        yield Case(f"hover/{factor:g}", SOURCES, HOVER, stiffer(factor), action=hover)


def extract(case: Case, run: Any) -> dict[str, Any]:
    """Return what was found; the costs depend on the machine."""
    if case.name != "cost/step":
        return dict(run.found)
    rows = [{name: float(value) for name, value in row.items()} for row in run.found["tables"]["cost"]]
    return {"times": {"rows": rows}}


def costs(data: Data) -> list[dict[str, Any]]:
    """Return the costs by nodes, with the exponent from the row before."""
    rows = data["stiffness/cost/step"].times["rows"]
    found = [dict(row) for row in rows]
    for row, before in zip(found, [None, *rows]):
        nodes = [before["nodes"], row["nodes"]] if before else []
        for name in ("step_ms", "factorise_ms"):
            row[f"{name} exponent"] = exponent(nodes, [before[name], row[name]]) if before else None
    return found


STUDY = Study("stiffness", cases, extract, tables={"wing-cost": costs})
