"""Other masters run the units and agree with ours: libcosim, Ecos, fmpy's reader of SSP, a container FMU, and the crate
fmi; the last, and fmpy alone, under FMI 3.0 too.

They need packages of their own: `make masters-test`. libcosim, Ecos and fmpy let both units step from t and exchange
afterwards; the container, the crate fmi and our loop in fmpy let the rod step first. Each is compared with our units in
its own order.
The pair is that of the shipped FSI3 scene, as it is.
"""

import ctypes
import re
import subprocess
import sys
import zipfile
from collections import defaultdict
from pathlib import Path

import fmpy
import fmpy.ssp.simulation
import numpy as np
import pytest
from lxml import etree

from nervure import coupling
from nervure.resources import ROOT
from nervure.scene import validate
from nervure.units import package, ssp
from nervure.units.describe import describe
from nervure.units.fmu import ELEMENT, Unit
from tests.slaves import FMU3Unpacked

H, STEPS = 2.0**-9, 20
"""Communication step, s, and number of steps. The step is a whole number of libcosim's nanoseconds and has an exact
double, so that the times of all masters are the same."""

AGREEMENT = 1e-12
"""Largest difference by the largest value of the same quantity."""

FMI_MASTER = ROOT / "target" / "masters" / "fmi" / "debug" / "fmi-master"
"""Built from `tests/masters/fmi` by `make masters-test`."""


@pytest.fixture
def scene(request):
    """The shipped pair, or a scene of one unit, whose end has to be later than the last step."""
    if request.param == "pair":
        return request.getfixturevalue("fsi3")
    scene = request.getfixturevalue({"rod": "rod_only", "fluid": "fluid_only"}[request.param])
    scene["time"]["end"] = 1.0
    return scene


@pytest.fixture
def units_in(instantiate, tmp_path):
    """Function that packs the units of a scene into the test's folder, and returns them instantiated."""

    def make(scene: dict) -> dict[str, Unit]:
        units = instantiate(scene)
        for kind in units:
            package.pack(describe(kind, scene), tmp_path)
        return units

    return make


every_scene = pytest.mark.parametrize("scene", ["pair", "rod", "fluid"], indirect=True)


def ours(units: dict[str, Unit], order: type[coupling.Explicit] = coupling.ParallelExplicit) -> dict[str, np.ndarray]:
    """Real outputs by `unit.name` at the end of the run."""
    pair = len(units) == 2
    scheme = order([units["rod"]], units["fluid"]) if pair else coupling.SingleUnit(next(iter(units.values())))
    scheme.start()
    for i in range(STEPS):
        scheme.step(i * H, H)
    return {f"{kind}.{name}": unit.read(name) for kind, unit in units.items() for name in real_outputs(unit)}


def real_outputs(unit: Unit) -> list[str]:
    return [v.name for v in unit.variables.values() if v.causality == "output" and v.kind == "Real"]


def assert_agreement(theirs: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> None:
    assert theirs.keys() == expected.keys()
    # A component that is only rounding is measured by the largest of its kind.
    kinds = {name: re.sub(r"(lift|moment)$", "drag", name).rstrip("xy") for name in expected}
    for name, values in expected.items():
        scale = max(np.abs(expected[other]).max() for other in expected if kinds[other] == kinds[name])
        difference = np.abs(theirs[name] - values).max()
        assert difference <= AGREEMENT * scale, f"{name} differs by {difference:.3g} at a scale of {scale:.3g}"


def links(units: dict[str, Unit]) -> list[tuple[Unit, Unit, str, int]]:
    """Source, target, name and element of every connection."""
    if len(units) < 2:
        return []
    rod, fluid = units["rod"], units["fluid"]
    return [
        (source, target, name, element)
        for source, target in ((rod, fluid), (fluid, rod))
        for name in coupling.connections(source, target)
        for element in range(source.variables[name].size)
    ]


@every_scene
def test_libcosim_agrees(scene, units_in, tmp_path):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.FATAL)
    units = units_in(scene)
    execution = CosimExecution.from_step_size(step_size=round(H * 1e9))
    paths = {kind: tmp_path / f"{scene['name']}-{kind}.fmu" for kind in units}
    slaves = {kind: CosimLocalSlave(fmu_path=str(path), instance_name=kind) for kind, path in paths.items()}
    index = {kind: execution.add_local_slave(local_slave=slave) for kind, slave in slaves.items()}
    for source, target, name, element in links(units):
        begin, end = ((index[unit.name], unit.variables[name].references[element]) for unit in (source, target))
        assert execution.connect_real_variables(*begin, *end) == 0
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    assert execution.step(step_count=STEPS)
    expected = ours(units)
    theirs = {
        f"{kind}.{name}": np.array(
            observer.last_real_values(slave_index=index[kind], variable_references=unit.variables[name].references)
        )
        for kind, unit in units.items()
        for name in real_outputs(unit)
    }
    assert_agreement(theirs, expected)


@pytest.fixture
def ecospy():
    """The package, with the library that it needs and does not bring."""
    ctypes.CDLL(str(Path(sys.prefix, "lib", "libtbb.so.12")), mode=ctypes.RTLD_GLOBAL)
    import ecospy

    return ecospy


def element_name(unit: Unit, name: str, element: int) -> str:
    return f"{unit.name}::{name}" if unit.variables[name].size == 1 else f"{unit.name}::{name}[{element + 1}]"


def ecos_values(simulation, units: dict[str, Unit]) -> dict[str, np.ndarray]:
    simulation.init()
    simulation.step(STEPS)
    return {
        f"{kind}.{name}": np.array(
            [simulation.get_real(element_name(unit, name, k)) for k in range(unit.variables[name].size)]
        )
        for kind, unit in units.items()
        for name in real_outputs(unit)
    }


@every_scene
def test_ecos_agrees(scene, units_in, tmp_path, ecospy):
    units = units_in(scene)
    structure = ecospy.EcosSimulationStructure()
    for kind in units:
        structure.add_model(kind, str(tmp_path / f"{scene['name']}-{kind}.fmu"))
    for source, target, name, element in links(units):
        structure.make_real_connection(element_name(source, name, element), element_name(target, name, element))
    expected = ours(units)
    assert_agreement(ecos_values(ecospy.EcosSimulation(H, structure=structure), units), expected)


def test_ssp_follows_its_schema(fsi3, tmp_path):
    with zipfile.ZipFile(ssp.pack(validate(fsi3), tmp_path)) as archive:
        description = etree.fromstring(archive.read("SystemStructure.ssd"))
        assert {"resources/fsi3-325x72-rod.fmu", "resources/fsi3-325x72-fluid.fmu"} <= set(archive.namelist())
    folder = Path(fmpy.__file__).parent / "ssp" / "schema"
    etree.XMLSchema(file=str(folder / "SystemStructureDescription.xsd")).assertValid(description)


def test_ssp_runs_in_ecos(fsi3, units_in, tmp_path, ecospy):
    path, units = ssp.pack(validate(fsi3), tmp_path), units_in(fsi3)
    expected = ours(units)
    assert_agreement(ecos_values(ecospy.EcosSimulation(H, ssp_path=str(path)), units), expected)


def test_ssp_as_shipped_is_refused_by_name_in_fmpy(fsi3, tmp_path):
    """Its reader has 0 at every connector in the first step, whatever an SSP says. Messages go to C's output."""
    path = ssp.pack(validate(fsi3), tmp_path)
    program = f"from fmpy.ssp.simulation import simulate_ssp; simulate_ssp({str(path)!r}, stop_time={H}, step_size={H})"
    answer = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert answer.returncode == 1 and "fmi2DoStep failed with status 3" in answer.stderr, answer.stderr
    assert "fmi2DoStep: stations 1 and 2 of the beam coincide" in answer.stdout, answer.stdout


def test_ssp_runs_in_fmpy(fsi3, units_in, tmp_path, monkeypatch):
    def with_start_values(component, *arguments):
        """fmpy starts with 0 at every connector, which is no place for a beam; the standard with the start values."""
        instantiate_fmu(component, *arguments)
        for connector in component.connectors:
            if connector.kind == "input":
                connector.value = float(component.variables[connector.name].start)

    instantiate_fmu = fmpy.ssp.simulation.instantiate_fmu
    monkeypatch.setattr(fmpy.ssp.simulation, "instantiate_fmu", with_start_values)
    path, units = ssp.pack(validate(fsi3), tmp_path), units_in(fsi3)
    result = fmpy.ssp.simulation.simulate_ssp(str(path), stop_time=(STEPS - 0.5) * H, step_size=H)
    assert len(result) == STEPS
    expected = ours(units)
    theirs = {
        f"{kind}.{name}": np.array(
            [result[element_name(unit, name, k).replace("::", ".")][-1] for k in range(unit.variables[name].size)]
        )
        for kind, unit in units.items()
        for name in real_outputs(unit)
    }
    assert_agreement(theirs, expected)


def test_container_of_array_ports_agrees_with_the_explicit_scheme(fsi3, units_in, tmp_path):
    units = units_in(fsi3)
    files = {kind: f"{fsi3['name']}-{kind}.fmu" for kind in units}
    table = ["rule;from_fmu;from_port;to_fmu;to_port", *(f"FMU;{file};;;" for file in files.values())]
    places: dict[str, list[str]] = {}
    for source, target, name, element in links(units):
        if element == 0:  # each array is one port
            table.append(f"LINK;{files[source.name]};{name};{files[target.name]};{name}")
        column = f"{Path(files[source.name]).stem}.{name}[{element + 1}]"
        places.setdefault(f"{source.name}.{name}", []).append(column)
    (tmp_path / "pair.csv").write_text("\n".join(table) + "\n", encoding="utf-8")
    command = [str(Path(sys.executable).parent / "fmucontainer"), "-container", f"pair.csv:{H}", "-sequential"]
    command += ["-no-auto-link", "-no-auto-input", "-no-auto-output"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, timeout=60)

    columns = [column for group in places.values() for column in group]
    container = str(tmp_path / "pair.fmu")
    last = fmpy.simulate_fmu(container, stop_time=STEPS * H, output_interval=H, output=columns)[-1]
    expected = ours(units, coupling.Explicit)
    theirs = {name: np.array([last[column] for column in group]) for name, group in places.items()}
    assert_agreement(theirs, {name: expected[name] for name in places})


every_version = pytest.mark.parametrize("version", [2, 3], ids=["fmi2", "fmi3"])


@every_scene
@every_version
def test_crate_fmi_agrees_with_the_explicit_scheme(version, scene, units_in, tmp_path):
    units = units_in(scene)
    paths = [package.pack(describe(kind, scene, version), tmp_path / "theirs") for kind in units]
    answer = subprocess.run(
        [FMI_MASTER, repr(H), str(STEPS), *paths], check=True, capture_output=True, text=True, timeout=60
    )
    values = defaultdict(list)
    for line in answer.stdout.splitlines():
        unit, name, value = line.split()
        element = ELEMENT.fullmatch(name)
        values[f"{list(units)[int(unit)]}.{element[1] if element else name}"].append(float(value))
    assert_agreement({name: np.array(elements) for name, elements in values.items()}, ours(units, coupling.Explicit))


class FMU3Unit(FMU3Unpacked):
    """A unit of FMI 3.0 in fmpy, in initialization mode."""

    def __init__(self, path: Path, folder: Path):
        super().__init__(fmpy.extract(str(path), str(folder)))
        self.known = {v.name: v for v in self.variables}
        self.begin()
        self.enterInitializationMode()

    def names(self, causality: str) -> list[str]:
        return [name for name, v in self.known.items() if v.causality == causality and v.type == "Float64"]

    def get(self, name: str) -> list[float]:
        variable = self.known[name]
        return self.getFloat64([variable.valueReference], int(np.prod(variable.shape)))


@every_scene
def test_fmpy_agrees_with_the_explicit_scheme_under_fmi_3(scene, units_in, tmp_path):
    units = units_in(scene)
    paths = {kind: package.pack(describe(kind, scene, 3), tmp_path / "theirs") for kind in units}
    theirs = {kind: FMU3Unit(path, tmp_path / kind) for kind, path in paths.items()}

    def exchange(target: FMU3Unit) -> None:
        for source in theirs.values():
            for name in set(source.names("output")) & set(target.names("input")) if source is not target else ():
                target.setFloat64([target.known[name].valueReference], source.get(name))

    for unit in theirs.values():
        exchange(unit)
    for unit in theirs.values():
        unit.exitInitializationMode()
    for i in range(STEPS):
        for unit in theirs.values():
            exchange(unit)
            assert unit.doStep(i * H, H) == (False, False, False, (i + 1) * H)
    values = {
        f"{kind}.{name}": np.array(unit.get(name)) for kind, unit in theirs.items() for name in unit.names("output")
    }
    assert_agreement(values, ours(units, coupling.Explicit))
    for unit in theirs.values():
        unit.terminate()
        unit.freeInstance()
