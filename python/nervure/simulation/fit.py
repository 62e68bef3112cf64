"""Whether units from elsewhere are of the scene that they are to run."""

from collections.abc import Collection, Mapping
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from nervure.coupling.drive import master_inputs
from nervure.errors import InputError
from nervure.resources import COUPLERS
from nervure.scene import Scene, beams, wings
from nervure.units import package
from nervure.units.describe import describe, unit_label
from nervure.units.fmu import Unit, Variable, prefixes, read_description, variables_of

STATION_TOLERANCE = 1e-4  # Largest distance of a station from its place in the scene, in lengths of the beam
PARAMETER_TOLERANCE = 1e-3  # Largest relative difference of a parameter that the other unit has too
Variables = Mapping[str, Variable]


def check_fit(scene: Scene, units: Mapping[str, Unit], foreign: Collection[str]) -> None:
    """Compare the units `foreign`, at their start, with our units of `scene`; raise `InputError` where the stations
    differ, or the density of the fluid that rod and fluid assume."""
    for name in foreign:
        given = units[name]
        with TemporaryDirectory() as place:
            own = package.lay_out(describe(name, scene), Path(place))
            flying = len(wings(scene))
            bodies = prefixes(len(beams(scene)) or int(not flying), flying)
            fault = _fluid_fault(own, given, bodies) if name in COUPLERS else _rod_fault(own, given)
        if fault:
            raise InputError(
                f"the FMU of the {unit_label(name)}, {given.description.modelName}, is of another scene than "
                f"{scene.name}: {fault}"
            )


def _rod_fault(path: Path, given: Unit) -> str | None:
    """Return how a rod differs from our rod in the folder `path`."""
    with closing(Unit(path, "rod of the scene", given.stop_time)) as own:
        names = [axis for axis in "xyz" if axis in own.variables and axis in given.variables]
        roots = [name for name in master_inputs(own) if name in given.input_slices]
        own.connect(roots, [])
        for name in roots:
            own.inputs[own.input_slices[name]] = given.inputs[given.input_slices[name]]
        own.set()
        here, there = ([unit.read(name) for name in names] for unit in (own, given))
        return _different_parameter("displaced_line_density", own.variables, given.variables) or _moved(here, there)


def _fluid_fault(path: Path, given: Unit, bodies: list[str]) -> str | None:
    """Return how a fluid differs from our fluid in the folder `path`; stations that coincide are no beam."""
    own = variables_of(read_description(path))
    fault = _different_parameter("density", own, given.variables)
    for prefix in bodies:
        names = [name for axis in "xyz" if (name := prefix + axis) in own and name in given.variables]
        here, there = ([_starts(variables[name]) for name in names] for variables in (own, given.variables))
        fault = fault or (_moved(here, there) if any(np.ptp(values) > 0.0 for values in there) else None)
    return fault


def _starts(variable: Variable) -> np.ndarray:
    return np.array([float(start or 0.0) for start in variable.start])


def _different_parameter(name: str, own: Variables, given: Variables) -> str | None:
    """Return how the parameter `name` differs; None where it does not, or where a unit lacks it."""
    if name not in own or name not in given:
        return None
    here, there, unit = float(_starts(own[name])[0]), float(_starts(given[name])[0]), own[name].unit
    if abs(there - here) <= PARAMETER_TOLERANCE * abs(here):
        return None
    return f"its `{name}` is {there:g} {unit}, but {here:g} {unit} in the scene"


def _moved(own: list[np.ndarray], given: list[np.ndarray]) -> str | None:
    """Return how the stations, one array for each axis, differ; None where they do not."""
    if [values.size for values in own] != [values.size for values in given]:
        return f"it has {given[0].size} stations, but the scene {own[0].size}"
    here, there = np.array(own), np.array(given)
    if not np.isfinite(there).all():
        return None  # the first step says so
    length = float(np.linalg.norm(np.diff(here), axis=0).sum()) if own else 0.0
    away = np.linalg.norm(there - here, axis=0) if own else np.zeros(1)
    worst = int(np.argmax(away))
    if away[worst] <= STATION_TOLERANCE * length:
        return None
    places = [", ".join(f"{place:g}" for place in each[:, worst]) for each in (there, here)]
    return f"its station {worst + 1} is at ({places[0]}) m at the start, but at ({places[1]}) m in the scene"
