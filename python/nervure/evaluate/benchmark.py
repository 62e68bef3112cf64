"""Changes of a benchmark after which its published values are those of another problem.

A scene is a benchmark if a shipped scene has the same `reference`, and a copy if one has the same `description`. Grid,
wall model, steps and schemes may differ: their effect is what a comparison shows.
"""

import json
import math
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, Literal

from nervure.resources import SCENES
from nervure.scene import Document, Scene
from nervure.scene.part import Part
from nervure.scene.types import Reference

NUMERICS = {
    "fluid": (
        *("box", "initial_velocity", "disturbance", "mask", "filter"),
        *("time_stepping", "probes", "precision", "threads"),
    ),
    "inflow": ("x", "c_eta"),
    "sponge": ("x", "c_eta"),
    "bodies": ("reference",),
    "beam": ("segments",),
    "rod": ("bending", "calibration", "clamp_compliance_length", "scheme", "max_step"),
    "wing": ("scheme", "max_step", "reference"),
    "rectangular": ("along",),
    "elliptical": ("along",),
    "insect": ("along",),
}
"""Keys of each part that are not physics."""

PARTS = ("fluid", "beam", "rod", "rods", "wing")


def changed(scene: Scene, part: Literal["reference", "description"] = "reference") -> list[str]:
    """Return the keys in which a scene differs from the most similar shipped scene with the same `part`; none where no
    shipped scene has it."""
    if not (given := scene.document().get(part)):
        return []
    mine, found = dict(physics(scene)), list[list[str]]()
    for path, document in _shipped().items():
        if document.get(part) == given:
            theirs = _physics_of(path)
            keys = dict.fromkeys([*mine, *theirs])
            found.append([key for key in keys if not _equal(mine.get(key), theirs.get(key))])
    return min(found, key=len, default=[])


@cache
def _shipped() -> dict[Path, Document]:
    return {path: json.loads(path.read_text(encoding="utf-8")) for path in sorted(SCENES.glob("*.json"))}


@cache
def _physics_of(path: Path) -> dict[str, Any]:
    return dict(physics(Scene.model_validate(_shipped()[path])))


def reference(scene: Scene) -> Reference | None:
    """Return the published values that are those of the scene: none of a benchmark with changes."""
    return None if changed(scene) else scene.reference


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, int | float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=1e-9)
    return bool(one == other)


def physics(scene: Scene) -> Iterator[tuple[str, Any]]:
    """Yield key and value of all that the final state depends on."""
    for name in PARTS:
        yield from _leaves(name, name, getattr(scene, name))
    if fluid := scene.fluid:
        # What lies upstream of an inflow or beyond walls does not matter.
        if fluid.inflow:
            yield "fluid.inflow.x[1]", fluid.inflow.x[1]
        else:
            yield "fluid.box.x[0]", fluid.box.x[0]
        yield "fluid.box.x[1]", fluid.box.x[1]
        if not (fluid.channel and fluid.channel.y):
            yield from ((f"fluid.box.y[{i}]", end) for i, end in enumerate(fluid.box.y))


def _leaves(key: str, name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield key and value of each number and word below `key`, whose last part is `name`; of a ramp its end."""
    if isinstance(value, Part):
        fields = {field: getattr(value, field) for field in type(value).model_fields}
        if fields.keys() == {"cosine_ramp"}:
            fields = {"constant": fields["cosine_ramp"].value}
        for field, inner in fields.items():
            if field not in NUMERICS.get(name, ()):
                yield from _leaves(f"{key}.{field}", field, inner)
    elif isinstance(value, list | tuple):
        for i, inner in enumerate(value):
            yield from _leaves(f"{key}[{i}]", name, inner)
    elif value is not None:
        yield key, value
