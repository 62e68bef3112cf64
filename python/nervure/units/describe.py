"""Descriptions of the units of a scene, which their libraries make: each unit is described once, then packed."""

from dataclasses import dataclass

from nervure import library
from nervure.library import kind_of
from nervure.scene import Document, Scene, document, kinds, scene_of_unit


@dataclass(frozen=True)
class Description:
    """A unit of a scene for one version of FMI."""

    unit: str  # `rod`, `fluid`, or the name of one of several rods
    kind: str  # `rod` or `fluid`
    version: int  # Of FMI, 2 or 3
    scene_name: str
    scene: str  # Text of the scene that the unit carries
    xml: str  # modelDescription.xml

    @property
    def model(self) -> str:
        """Name of the model."""
        return f"{self.scene_name}.{self.unit}"


def describe(unit: str, scene: Scene | Document, version: int = 2) -> Description:
    """Describe one unit of a scene; raise `SceneError` with the unit's words where it refuses the scene."""
    kind, text = kind_of(unit), scene_of_unit(scene, unit)
    return Description(unit, kind, version, document(scene)["name"], text, library.describe(kind, text, version))


def describe_all(scene: Scene | Document, version: int = 2) -> dict[str, Description]:
    """Describe the units of a scene by name, in the order in which they step."""
    return {unit: describe(unit, scene, version) for unit in kinds(scene)}
