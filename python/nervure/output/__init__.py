"""Output for people: pictures, fields, animations, tables, progress."""

import os
import re
from importlib.util import find_spec
from textwrap import shorten

import numpy as np

from nervure.evaluate import benchmark
from nervure.scene import Scene, beams
from nervure.scene.facts import Facts
from nervure.scene.solids import box_ends
from nervure.scene.types import Display
from nervure.terminal import legible

READ_IN = {"m": ("mm", 1e3)}  # Units that are shown in another scale
LONGEST_IN_MM = 10.0  # Longest length that a picture shows in mm, m
LARGE = 1.0  # Size of a scene in numbers of order 1, whose pictures have no mm, m
TIP = re.compile(r"(?:(.+)_)?tip_u([xyz])")  # Columns of the motion of a tip; several rods have names
CLAUSE = re.compile(r"[,;]|\.(?:\s|$)")  # End of the first clause of a description

NOTEBOOK = "module://"  # Beginning of a backend that a notebook hands on to the programs that it starts
_backend = os.environ.get("MPLBACKEND", "")
if _backend.startswith(NOTEBOOK) and not find_spec(_backend.removeprefix(NOTEBOOK).partition(".")[0]):
    del os.environ["MPLBACKEND"]  # matplotlib could not even be imported


def displayed_unit(unit: str | None, display: Display | None = None) -> tuple[str, float]:
    """Return the unit in which values in `unit` are shown, and the factor to it. With `display`, lengths and times are
    in a scene's own scales, and forces and energies have no unit."""
    if display is None:
        return READ_IN.get(unit or "", (unit or "", 1.0))
    time = f"({display.time})" if "/" in display.time else display.time
    own = {
        "m": display.length,
        "s": display.time,
        "1/s": f"1/{time}",
        "m/s": f"{display.length}/{time}",
        "rad": "rad",
        "deg": "deg",
    }
    return own.get(unit or "", ""), 1.0


def lengths_in(scene: Scene, longest: float) -> tuple[str, float]:
    """Return the unit of lengths in a picture of lengths up to `longest` (m), and the factor from m to it: metres also
    where the scene is `LARGE`."""
    if scene.display is None and (longest > LONGEST_IN_MM or _size(scene) >= LARGE):
        return "m", 1.0
    return displayed_unit("m", scene.display)


def _size(scene: Scene) -> float:
    """Return the shortest side of the box, without a fluid the length of the longest rod or of the wing, m."""
    if scene.fluid:
        return min(high - low for low, high in box_ends(scene.fluid))
    mesh = Facts(scene).wing
    wing = [float(np.ptp(mesh.nodes, axis=0).max())] if mesh else []
    return max([*wing, *(own.beam.length for own in beams(scene))], default=0.0)


def unit_in(scene: Scene, unit: str | None, longest: float) -> tuple[str, float]:
    """Return the unit in which a picture of values up to `longest` shows values in `unit`, and the factor to it."""
    return lengths_in(scene, longest) if unit == "m" else displayed_unit(unit, scene.display)


def axis_label(name: str, unit: str) -> str:
    """Return the label of an axis."""
    return f"{name} [{unit}]" if unit else name


def title(scene: Scene, inches: float) -> str:
    """Return the first clause of the scene's description, cut to `inches` of small text, or to nothing; the
    name in words where there is none, or where it describes a shipped scene of other physics."""
    described = "" if benchmark.changed(scene, "description") else CLAUSE.split(scene.description or "")[0]
    words = described or re.sub(r"[-_]", " ", scene.name)
    letters = round(14.5 * inches)
    return shorten(legible(words), letters, placeholder=" …") if letters > 2 else ""


def in_words(column: str, scene: Scene) -> str:
    """Return the words for a column of the series; a tip moves along and across the stream, or along an axis."""
    found = TIP.fullmatch(column)
    if not found:
        return column.replace("_", " ")
    rod, axis = found.groups()
    streams = scene.fluid is not None and scene.fluid.inflow is not None
    place = {"x": "along", "y": "across"}[axis] if streams else f"along {axis}"
    return f"{rod.replace('_', ' ')}: tip, {place}" if rod else f"tip, {place}"
