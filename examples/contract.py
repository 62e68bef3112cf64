"""What every unit for our master needs beyond PythonFMU: units of the variables, arrays, the state as a whole.

PythonFMU knows neither units of variables nor arrays; the contract between rod and fluid (modelDescription/README.md)
asks for both. All its FMUs in a process share one Python: where our master, itself Python, loads them, its own. Modules
of different units therefore need different names.
"""

import json
import math
from collections.abc import Callable
from functools import partial, wraps
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from pythonfmu import Fmi2Slave, Real
from pythonfmu.enums import Fmi2Causality, Fmi2Initial, Fmi2Status, Fmi2Variability

BASE_UNITS = {
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "N/m": {"kg": 1, "s": -2},
    "kg/(m.s)": {"kg": 1, "m": -1, "s": -1},
    "kg/(m2.s)": {"kg": 1, "m": -2, "s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "kg/s": {"kg": 1, "s": -1},
    "rad/s": {"rad": 1, "s": -1},
    "1": {},
}
"""Powers of the SI units in each unit that the contract uses here."""


CALLS = (
    "setup_experiment",
    "enter_initialization_mode",
    "exit_initialization_mode",
    "do_step",
    "terminate",
    "_get_fmu_state",
    "_set_fmu_state",
)
"""Methods that FMI calls."""

Read = Callable[[], float]
Write = Callable[[float], None]


def telling(call: Callable[..., Any]) -> Callable[..., Any]:
    """Return a method that logs what it raises: PythonFMU passes on what is logged, not what is raised."""

    @wraps(call)
    def told(unit: Fmi2Slave, *arguments: Any) -> Any:
        try:
            return call(unit, *arguments)
        except Exception as error:
            unit.log(str(error) or type(error).__name__, Fmi2Status.error)
            raise

    return told


class ContractUnit(Fmi2Slave):
    """A unit of a scene: `resources` holds `scene.json`."""

    STATE: tuple[str, ...] = ()
    """Attributes that are the unit's whole state: arrays and numbers."""

    def __init__(self, **keywords: Any) -> None:
        super().__init__(**keywords)
        self.scene = json.loads(Path(self.resources, "scene.json").read_text(encoding="utf-8"))
        is_rod = "wing" not in self.scene and not self.scene.get("wings")
        if is_rod and (self.scene.get("coupling") or {}).get("load") != "momentum":
            raise ValueError("coupling.load of the scene must be `momentum`, the only load that this unit knows")
        self.units: dict[str, str] = {}

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        for name in CALLS:
            setattr(cls, name, telling(getattr(cls, name)))

    def register(self, name: str, unit: str, causality: Fmi2Causality, read: Read, write: Write | None = None) -> None:
        """Register a Real variable in `unit`."""
        parameter = causality == Fmi2Causality.parameter
        variable = Real(
            name,
            causality=causality,
            variability=Fmi2Variability.fixed if parameter else Fmi2Variability.continuous,
            initial=Fmi2Initial.exact if causality != Fmi2Causality.input else None,
            getter=read,
            setter=write,
        )
        self.register_variable(variable)
        self.units[name] = unit

    def register_array(self, name: str, unit: str, causality: Fmi2Causality, values: np.ndarray) -> None:
        """Register `name[1] … name[n]`, the elements of `values`: an array to write into, not to replace."""
        for k in range(values.size):
            self.register(
                f"{name}[{k + 1}]",
                unit,
                causality,
                partial(values.item, k),
                partial(values.__setitem__, k),
            )

    def to_xml(self, model_options: dict[str, str] | None = None) -> Element:
        """The model description, with units."""
        root: Element = super().to_xml(model_options or {})
        definitions = Element("UnitDefinitions")
        for name in sorted(set(self.units.values())):
            powers = {base: str(power) for base, power in BASE_UNITS[name].items()}
            SubElement(SubElement(definitions, "Unit", name=name), "BaseUnit", powers)
        places = [child.tag for child in root]
        root.insert(places.index("CoSimulation") + 1, definitions)
        for variable in root.iter("ScalarVariable"):
            for real in variable.iter("Real"):
                real.set("unit", self.units[variable.attrib["name"]])
        return root

    def _get_fmu_state(self) -> dict[str, Any]:
        return {name: np.array(getattr(self, name)).tolist() for name in self.STATE}

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            if isinstance(value, list):
                getattr(self, name)[:] = value
            else:
                setattr(self, name, value)


def backward_differences(h: float, before: float) -> tuple[float, float, float]:
    """(c0, c1, c2) of y' = c0 y(t + h) - c1 y(t) + c2 y(t - before), 1/s: two-step backward differences, of order two
    for any ratio of the steps; with `before` = 0, at the start, backward Euler."""
    if before == 0.0:
        return 1 / h, 1 / h, 0.0
    ratio = h / before
    return (1 + 2 * ratio) / (h * (1 + ratio)), (1 + ratio) / h, ratio**2 / (h * (1 + ratio))


def station_lengths(beam: dict[str, Any]) -> np.ndarray:
    """The length of the beam that each station stands for, m: half a segment at root and tip."""
    lengths = np.full(beam["segments"] + 1, beam["length"] / beam["segments"])
    lengths[[0, -1]] /= 2
    return lengths


def root_of(scene: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Position of the beam's root at rest, m, and its unit direction there."""
    root = scene["beam"]["root"]
    if "at" in root:
        direction = np.array(root["at"]["direction"])
        return np.array(root["at"]["position"]), direction / np.linalg.norm(direction)
    place = root["on_cylinder"]
    cylinder, angle = scene["fluid"]["cylinders"][place["cylinder"]], place.get("angle", 0.0)
    direction = np.array([math.cos(angle), math.sin(angle)])
    return np.array(cylinder["center"]) + cylinder["radius"] * direction, direction
