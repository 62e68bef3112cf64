"""What a scene leaves out: parts that the shipped scenes do not have, put in so that they have no effect."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from fnmatch import fnmatch

from nervure.pack import package
from nervure.errors import Refusal
from nervure.resources import ROOT, SCENES
from nervure.scene import load

from .measure import THREADS, quartiles
from .store import Row

CASE = "leave-out"

STEPS = {"rod": 400, "fluid": 60}
"""Communication steps of a run, of scenes without and with a fluid."""

REPEATS = 3

WEAK = 1e9
"""Relaxation time of a sponge that does nothing, s."""

ROD_COLUMNS = ("tip_ux", "tip_uy", "tip_vx", "tip_vy")
FLUID_COLUMNS = ("drag", "lift")


def parts(scene: dict) -> Iterator[tuple[str, dict]]:
    """What can be added to `scene` without an effect: what it is called and the scene that has it."""
    fluid, rod = scene.get("fluid"), scene.get("rod")

    def changed() -> dict:
        return json.loads(json.dumps(scene))

    if rod and "root_motion" not in rod:
        added = changed()
        added["rod"]["root_motion"] = {"laws": {}}
        yield "root in prescribed motion, standing still", added
        if not fluid:
            added = changed()
            added["rod"]["root_motion"] = "master"
            yield "root driven by the master, standing still", added
    if rod and not fluid and len(scene["beam"]["root"]["at"]["direction"]) == 2:
        added = without_shear(scene)
        for vector in (
            *(added["beam"]["root"]["at"][key] for key in ("position", "direction")),
            added["rod"]["gravity"],
        ):
            vector.append(0.0)
        yield "third dimension (without shear)", added
    if fluid:
        end, low = fluid["box"]["x"][1], fluid["box"]["y"][0]
        if "sponge" not in fluid:
            added = changed()
            added["fluid"]["sponge"] = {"x": [end - 0.2, end], "mean_velocity": {"steady": 0.0}, "c_eta": WEAK}
            yield f"sponge of C_eta = {WEAK:g} s", added
        # A beam stands on a still one.
        if fluid.get("cylinders") and not scene.get("beam") and "motion" not in fluid["cylinders"][0]:
            added = changed()
            added["fluid"]["cylinders"][0]["motion"] = {}
            yield "cylinder in motion, standing still", added
        added = changed()
        middle = (low + fluid["box"]["y"][1]) / 2
        added["fluid"].setdefault("probes", []).extend(
            {"name": f"unused{i}", "position": [end - 0.1 * (i + 1), middle]} for i in range(4)
        )
        yield "four probes, read at every step", added


def without_shear(scene: dict) -> dict:
    """A copy of `scene` whose rod has no shear: in space it has none."""
    scene = json.loads(json.dumps(scene))
    scene["rod"]["material"].get("plane_strain", {}).pop("shear_factor", None)
    return scene


def base_of(name: str, scene: dict) -> dict:
    """What a part is compared with."""
    return without_shear(scene) if "without shear" in name else scene


def absent(scene: dict) -> list[str]:
    """Parts that a scene can have and this one has not."""
    fluid, rod, beam = (scene.get(name) or {} for name in ("fluid", "rod", "beam"))
    root = beam.get("root", {}).get("at", {}).get("direction", [0.0, 0.0])
    material = next(iter(rod.get("material", {"": {}}).values()))
    shear = material.get("shear_factor") or material.get("shear_stiffness")
    there = {
        "fluid": fluid,
        "channel": fluid.get("channel"),
        "inflow": fluid.get("inflow"),
        "mean flow": fluid.get("mean_flow"),
        "sponge": fluid.get("sponge"),
        "cylinders": fluid.get("cylinders"),
        "probes": fluid.get("probes"),
        "beam": beam,
        "rod": rod,
        "root motion": rod.get("root_motion"),
        "third dimension": len(root) == 3,
        "gravity": rod.get("gravity"),
        "damping": rod.get("damping"),
        "shear": shear,
        "rest shape": beam.get("rest_angles"),
        "coupling": fluid and rod,
    }
    return [name for name, part in there.items() if not part]


def sizes(scene: dict) -> tuple[int, int]:
    """Bytes of the XML descriptions and scalar variables of a scene's FMUs."""
    texts = [package.describe(kind, scene) for kind in package.kinds(scene)]
    return sum(len(text.encode()) for text in texts), sum(text.count("<ScalarVariable") for text in texts)


def run(scene: dict) -> dict:
    """What worker.py says of a scene, with the median and quartiles of its CPU time."""
    command = [sys.executable, ROOT / "scripts" / "report" / "worker.py", str(REPEATS)]
    done = subprocess.run(
        command, input=json.dumps(scene), env=os.environ | THREADS, capture_output=True, text=True, check=True
    )
    found = json.loads(done.stdout)
    if found["error"]:
        raise Refusal(found["error"])
    return found | {"cpu": quartiles([cpu for _, cpu in found["runs"]])}


def measure(only: str) -> list[Row]:
    """Rows of the shipped scenes whose names match: their own numbers, and for each part what it adds."""
    rows = []
    for path in sorted(SCENES.glob("*.json")):
        if path.name == "references.json" or not fnmatch(path.stem, only):
            continue
        scene = load(path)
        steps = STEPS["fluid" if scene.get("fluid") else "rod"]
        scene["time"]["end"] = steps * scene["time"]["communication_step"]
        command = "python scripts/report leave-out"

        def row(setting: str, quantity: str, value: float, unit: str, **more) -> None:
            rows.append(Row(CASE, path.stem, setting, quantity, value, unit, command=command, **more))

        missing = absent(scene)
        row("as shipped", "absent parts", len(missing), "1", reason=", ".join(missing))
        known = {}

        def base(of: dict) -> tuple[dict, tuple[int, int]]:
            text = json.dumps(of)
            if text not in known:
                known[text] = run(of), sizes(of)
            return known[text]

        found, (xml, variables) = base(scene)
        for quantity, value, unit in (
            ("xml", xml, "B"),
            ("variables", variables, "1"),
            ("memory", found["memory_mb"], "MB"),
            ("cpu per step", found["cpu"][1] / steps * 1e6, "µs"),
        ):
            row("as shipped", quantity, value, unit, repeats=REPEATS)
        for name, added in parts(scene):
            try:
                without, (xml, variables) = base(base_of(name, scene))
                with_it, (more_xml, more_variables) = run(added), sizes(added)
            except Refusal as error:
                rows.append(Row(CASE, path.stem, name, "all", outcome="error", reason=str(error), command=command))
                continue
            columns = [c for c in ROD_COLUMNS + FLUID_COLUMNS if c in without["last"]]
            change = max(
                abs(with_it["last"][c] - without["last"][c]) / (abs(without["last"][c]) or 1.0) for c in columns
            )
            row(name, "xml", more_xml - xml, "B more")
            row(name, "variables", more_variables - variables, "more")
            row(name, "memory", with_it["memory_mb"] - without["memory_mb"], "MB more")
            row(name, "cpu per step", with_it["cpu"][1] / without["cpu"][1] - 1, "relative", repeats=REPEATS)
            row(name, "change of the result", change, "relative, largest of tip and forces at the end")
        print(f"{path.stem}: {len(rows)} rows", flush=True)
    return rows
