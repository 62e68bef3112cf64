"""The units of a scene, described by their libraries: each unit is described once, then packed."""

from dataclasses import dataclass

from nervure import library
from nervure.resources import KINDS, SCENE_KEYS
from nervure.scene import Document, Scene, document, text


@dataclass(frozen=True)
class Description:
    """A unit of a scene for one version of FMI."""

    unit: str  # `rod`, `fluid`, `contact`, `wing`, `body`, or the name of one of several rods or wings
    kind: str  # `rod`, `wing`, `body`, `fluid` or `contact`
    version: int  # Of FMI, 2 or 3
    scene_name: str
    scene: (
        str  # Text of the scene that the unit carries; of several rods it has the key `this_rod`, of wings `this_wing`
    )
    xml: str  # modelDescription.xml

    @property
    def model(self) -> str:
        """Name of the model."""
        return f"{self.scene_name}.{self.unit}"


def describe(unit: str, scene: Scene | Document, version: int = 2) -> Description:
    """Describe one unit of a scene; raise `SceneError` with the unit's words where it refuses the scene."""
    given = document(scene)
    kind = unit_kinds(given).get(unit, unit if unit in KINDS else "rod")
    carried = text(given if unit in KINDS else given | {f"this_{kind}": unit})
    return Description(unit, kind, version, given["name"], carried, library.describe(kind, carried, version))


def describe_all(scene: Scene | Document, version: int = 2) -> dict[str, Description]:
    """Describe the units of a scene by name, in the order in which they step."""
    return {unit: describe(unit, scene, version) for unit in unit_names(scene)}


def unit_kinds(scene: Scene | Document) -> dict[str, str]:
    """Return the kinds of the units of a scene, which may be unchecked, by name in the order of their steps: the rod,
    or several by name, then the wings, then a free body, then the fluid, or what finds their contact without one. A
    scene without units is for the fluid, which refuses it."""
    given, kinds = document(scene), dict[str, str]()
    for kind in KINDS:
        several = given.get(f"{kind}s")
        each = [own.get("name") for own in several if isinstance(own, dict)] if isinstance(several, list) else []
        kinds |= {name: kind for name in each if isinstance(name, str)}
        flexible = [*kinds.values()].count("rod") + [*kinds.values()].count("wing")
        is_coupled = "fluid" in kinds or flexible < 2
        if given.get(SCENE_KEYS.get(kind, kind)) is not None and not (kind == "contact" and is_coupled):
            kinds[kind] = kind
    return kinds or {"fluid": "fluid"}


def unit_names(scene: Scene | Document) -> list[str]:
    """Return the names of the units of a scene, as `unit_kinds`."""
    return [*unit_kinds(scene)]


def unit_label(unit: str, kind: str = "rod") -> str:
    """Return the name of a unit in messages: `rod`, `fluid`, `contact`, `wing`, `body`, or `rod NAME`."""
    return unit if unit in KINDS else f"{kind} {unit}"
