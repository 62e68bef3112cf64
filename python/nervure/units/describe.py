"""The units of a scene, described by their libraries: each unit is described once, then packed."""

from dataclasses import dataclass

from nervure import library
from nervure.library import kind_of
from nervure.resources import KINDS
from nervure.scene import Document, Scene, document, text


@dataclass(frozen=True)
class Description:
    """A unit of a scene for one version of FMI."""

    unit: str  # `rod`, `fluid`, `wing`, or the name of one of several rods
    kind: str  # `rod`, `fluid` or `wing`
    version: int  # Of FMI, 2 or 3
    scene_name: str
    scene: str  # Text of the scene that the unit carries; of several rods it has the key `this_rod`
    xml: str  # modelDescription.xml

    @property
    def model(self) -> str:
        """Name of the model."""
        return f"{self.scene_name}.{self.unit}"


def describe(unit: str, scene: Scene | Document, version: int = 2) -> Description:
    """Describe one unit of a scene; raise `SceneError` with the unit's words where it refuses the scene."""
    given, kind = document(scene), kind_of(unit)
    carried = text(given if unit in KINDS else given | {"this_rod": unit})
    return Description(unit, kind, version, given["name"], carried, library.describe(kind, carried, version))


def describe_all(scene: Scene | Document, version: int = 2) -> dict[str, Description]:
    """Describe the units of a scene by name, in the order in which they step."""
    return {unit: describe(unit, scene, version) for unit in unit_names(scene)}


def unit_names(scene: Scene | Document) -> list[str]:
    """Return the units of a scene, which may be unchecked, in the order of their steps: the rod, or several by name,
    then a wing, then the fluid. A scene without units is for the fluid, which refuses it."""
    given = document(scene)
    rods = given.get("rods")
    each = [own.get("name") for own in rods if isinstance(own, dict)] if isinstance(rods, list) else []
    names = [name for name in each if isinstance(name, str)]
    return [*names, *(kind for kind in KINDS if given.get(kind) is not None)] or ["fluid"]


def unit_label(unit: str) -> str:
    """Return the name of a unit in messages: `rod`, `fluid`, `wing`, or `rod NAME`."""
    return unit if unit in KINDS else f"rod {unit}"
