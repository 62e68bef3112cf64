"""Costs of parts that a shipped scene lacks: each is added so that it has no effect on the result."""

from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import Any

from studies import simulate
from studies.engine import COUPLED, FLUID, ROD, Case, Run, Study
from studies.store import Data

SCENES = ("csm3", "cylinder-2d1-450x90", "fsi3-325x72", "flag-line-480x240", "sphere-oscillating-64x64x64",
          "cylinder-settling-140x392", "sphere-settling-80x80x120")  # fmt: skip
"""A rod, a fluid, both, a line, a fluid in space, and bodies on a mount."""

STEPS = {"rod": 400, "fluid": 60}  # Communication steps of a run, of scenes without and with a fluid
TIMED = 200  # Steps of each scene in turns
WEAK = 1e9  # Relaxation time of a sponge without an effect, s
COLUMNS = ("tip_ux", "tip_uy", "tip_vx", "tip_vy", "drag", "lift")

Scene = dict[str, Any]

NO_SHEAR = {"rod.material.plane_strain.shear_factor": "absent"}
SPACE, CONTACT = "third dimension (without shear)", "contact out of reach"


def parts(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """Yield names of parts that can be added to `scene` without an effect, and the changes that add them."""
    fluid, rod = scene.get("fluid"), scene.get("rod")
    mounted = any("mount" in body for body in (fluid or {}).get("bodies", []))
    if rod or mounted:
        yield CONTACT, {"contact": {}}
    if mounted:
        return  # Other scenes show the rest
    if rod and "root_motion" not in rod:
        yield "root in prescribed motion, standing still", {"rod.root_motion": {"laws": {}}}
        if not fluid:
            yield "root driven by the master, standing still", {"rod.root_motion": "master"}
    if rod and not fluid and len(scene["beam"]["root"]["at"]["direction"]) == 2:
        at = {f"beam.root.at.{key}": [*scene["beam"]["root"]["at"][key], 0.0] for key in ("position", "direction")}
        yield SPACE, NO_SHEAR | at | {"rod.gravity": [*rod["gravity"], 0.0]}
    if fluid:
        end = fluid["box"]["x"][1]
        if "sponge" not in fluid:
            sponge = {"x": [end - 0.2, end], "mean_velocity": {"constant": 0.0}, "c_eta": WEAK}
            yield f"sponge of C_eta = {WEAK:g} s", {"fluid.sponge": sponge}
        # A beam needs a still cylinder.
        if fluid.get("cylinders") and not scene.get("beam") and "motion" not in fluid["cylinders"][0]:
            yield "cylinder in motion, standing still", {"fluid.cylinders.0.motion": {}}
        middle = [sum(fluid["box"][axis]) / 2 for axis in "yz" if axis in fluid["box"]]
        probes = [{"name": f"unused{i}", "position": [end - 0.1 * (i + 1), *middle]} for i in range(4)]
        yield "four probes, read at every step", {"fluid.probes": fluid.get("probes", []) + probes}


def cases() -> Iterator[Case]:
    for name in SCENES:
        scene = simulate.changed(name, {})
        fluid, rod = scene.get("fluid"), scene.get("rod")
        short = {"time.end": STEPS["fluid" if fluid else "rod"] * scene["time"]["communication_step"]}
        variants: dict[str, Scene] = {"as shipped": {}}
        for part, changes in parts(scene):
            if part == SPACE and scene["rod"]["material"].get("plane_strain", {}).get("shear_factor"):
                variants["without shear"] = NO_SHEAR
            variants[part] = changes
        for variant, changes in variants.items():
            sources = COUPLED if fluid and rod else FLUID if fluid else ROD
            base = variants.get("without shear" if variant == SPACE else "as shipped", {})
            of_contact = ("contact",) if variant == CONTACT else ()
            about = {"scene": name, "base": base}
            yield Case(
                f"{name}/{variant}", (*sources, *of_contact), name, short | changes, about=about, action=measured
            )


def measured(case: Case, folder: Path) -> dict[str, Any]:
    """Run a scene, and then step it in turns with the one that lacks the part."""
    found = simulate.run(case.built(), folder)
    long = {key: value for key, value in case.changes.items() if key != "time.end"}
    scenes = [simulate.changed(case.scene, changes) for changes in (long, case.about["base"])]
    step, bare = simulate.in_turns(scenes, folder, TIMED, lambda _: perf_counter())
    return found | {"step_ms": step, "ratio": step / bare}


def extract(case: Case, run: Run) -> dict[str, Any]:
    xml, variables = simulate.sizes(case.built())
    last = {f"last {name}": run.found["last"][name] for name in COLUMNS if name in run.found["last"]}
    times = {name: run.found[name] for name in ("step_ms", "ratio", "memory")}
    return {"values": {"xml": xml, "variables": variables} | last, "times": times}


def added(data: Data) -> list[dict[str, Any]]:
    """Return scalar variables, memory (MB) and time of a step (ms) of each scene, and what each unused part adds."""
    rows: list[dict[str, Any]] = []
    for record in data.of("leave-out/*"):
        scene, part = record.name.split("/")[1:]
        found = {"variables": record["variables"], "memory": record.get("memory"), "step": record["step_ms"]}
        if part in ("as shipped", "without shear"):
            base = found
            rows.append(found | {"scene": scene, "part": part})
            continue
        known = [name for name in found if found[name] is not None and base[name] is not None]
        more = {f"more {name}": found[name] - base[name] for name in known}
        rows.append(more | {"scene": scene, "part": part, "ratio": record["ratio"]})
    return rows


STUDY = Study("leave-out", cases, extract, {"leave-out": added})
