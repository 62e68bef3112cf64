"""What a scene leaves out: parts that the shipped scenes do not have, put in so that they have no effect."""

from collections.abc import Iterator
from typing import Any

from nervure.resources import SCENES as FOLDER
from studies import simulate
from studies.engine import COUPLED, FLUID, ROD, Case, Run, Study
from studies.show import form, markdown
from studies.store import Data, Record

SCENES = sorted(path.stem for path in FOLDER.glob("*.json"))

STEPS = {"rod": 400, "fluid": 60}
"""Communication steps of a run, of scenes without and with a fluid."""
REPEATS = 3
WEAK = 1e9
"""Relaxation time of a sponge that does nothing, s."""
COLUMNS = ("tip_ux", "tip_uy", "tip_vx", "tip_vy", "drag", "lift")

Scene = dict[str, Any]

NO_SHEAR = {"rod.material.plane_strain.shear_factor": "absent"}
SPACE = "third dimension (without shear)"


def parts(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """What can be added to `scene` without an effect: what it is called, and the changes that do it."""
    fluid, rod = scene.get("fluid"), scene.get("rod")
    if rod and "root_motion" not in rod:
        yield "root in prescribed motion, standing still", {"rod.root_motion": {"laws": {}}}
        if not fluid:
            yield "root driven by the master, standing still", {"rod.root_motion": "master"}
    if rod and not fluid and len(scene["beam"]["root"]["at"]["direction"]) == 2:
        at = {f"beam.root.at.{key}": [*scene["beam"]["root"]["at"][key], 0.0] for key in ("position", "direction")}
        yield SPACE, NO_SHEAR | at | {"rod.gravity": [*rod["gravity"], 0.0]}
    if fluid:
        end, (low, high) = fluid["box"]["x"][1], fluid["box"]["y"]
        if "sponge" not in fluid:
            sponge = {"x": [end - 0.2, end], "mean_velocity": {"steady": 0.0}, "c_eta": WEAK}
            yield f"sponge of C_eta = {WEAK:g} s", {"fluid.sponge": sponge}
        # A beam stands on a still one.
        if fluid.get("cylinders") and not scene.get("beam") and "motion" not in fluid["cylinders"][0]:
            yield "cylinder in motion, standing still", {"fluid.cylinders.0.motion": {}}
        probes = [{"name": f"unused{i}", "position": [end - 0.1 * (i + 1), (low + high) / 2]} for i in range(4)]
        yield "four probes, read at every step", {"fluid.probes": fluid.get("probes", []) + probes}


def absent(scene: Scene) -> list[str]:
    """Parts that a scene can have and this one has not."""
    fluid, rod, beam = (scene.get(name) or {} for name in ("fluid", "rod", "beam"))
    material = next(iter(rod.get("material", {"": {}}).values()))
    there = {"fluid": fluid}
    there |= {
        key.replace("_", " "): fluid.get(key)
        for key in ("channel", "inflow", "mean_flow", "sponge", "cylinders", "probes")
    }
    there |= {"beam": beam, "rod": rod, "root motion": rod.get("root_motion")}
    there |= {"third dimension": len(beam.get("root", {}).get("at", {}).get("direction", [0.0, 0.0])) == 3}
    there |= {key: rod.get(key) for key in ("gravity", "damping")}
    there |= {"shear": material.get("shear_factor") or material.get("shear_stiffness")}
    there |= {"rest shape": beam.get("rest_angles"), "coupling": fluid and rod}
    return [name for name, part in there.items() if not part]


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
            rooms = COUPLED if fluid and rod else FLUID if fluid else ROD
            yield Case(f"{name}/{variant}", rooms, name, short | changes, {"repeats": REPEATS}, about={"scene": name})


def keep(case: Case, run: Run) -> dict[str, Any]:
    xml, variables = simulate.sizes(case.built())
    last = {f"last {name}": run.found["last"][name] for name in COLUMNS if name in run.found["last"]}
    times = simulate.times(run.found) | {"memory_mb": run.found["memory_mb"], "steps": run.found["steps"]}
    return {"values": {"xml": xml, "variables": variables} | last, "times": times}


def lacking(data: Data) -> list[str]:
    return markdown(["scene", "has not"], [[name, ", ".join(absent(simulate.changed(name, {})))] for name in SCENES])


def added(data: Data) -> list[str]:
    """What a part adds to the scene without it."""
    first = {
        "XML": "{xml:.1f} kB",
        "variables": "{variables:d}",
        "memory": "{memory:.1f} MB",
        "CPU a step": "{cpu:.1f} µs",
    }
    more = {name: text.replace(":", ":+") for name, text in first.items()} | {"CPU a step": "{cpu:+.0%}"}
    more |= {"change of the result": "{change:.0e}"}
    rows = []
    for name in SCENES:
        shipped = size_of(data[f"leave-out/{name}/as shipped"])
        rows.append([name, "as shipped", *(form(text, shipped) for text in first.values()), ""])
        for record in data.of(f"leave-out/{name}/*"):
            if record.label in ("as shipped", "without shear"):
                continue
            plain = data.get(f"leave-out/{name}/without shear") if record.label == SPACE else None
            own, base = size_of(record), size_of(plain) if plain else shipped
            added = {key: own[key] - base[key] for key in ("xml", "variables", "memory")} | {
                "cpu": own["cpu"] / base["cpu"] - 1
            }
            added["change"] = max(abs(own[q] - base[q]) / (abs(base[q]) or 1.0) for q in base if q.startswith("last"))
            rows.append([name, record.label, *(form(text, added) for text in more.values())])
    return markdown(["scene", "part", *more], rows)


def size_of(record: Record) -> dict[str, Any]:
    """XML (kB), variables, memory (MB), CPU time a step (µs), and tip and forces at the end."""
    cpu = 1e6 * (record.clock("cpu_s") or 0.0) / record.times["steps"]
    return record.values | {"xml": record["xml"] / 1e3, "memory": record.times["memory_mb"], "cpu": cpu}


STUDY = Study("leave-out", cases, keep)
