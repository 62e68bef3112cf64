"""The FMI glue through fmpy: its example FMU is packaged, validated, simulated and mistreated."""

import ctypes
import json
import math
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu
from lxml import etree

from tests.slaves import FMU2Unpacked

ROOT = Path(__file__).parents[2]
SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"


@pytest.fixture(scope="module")
def library():
    """The example's shared library."""
    packages = ["--workspace", "--exclude=nervure-cargo-fmu"]  # As the tests in Rust
    command = ["cargo", "build", "--release", "--locked", *packages, "--example", "damped_oscillator"]
    output = subprocess.run(
        [*command, "--message-format=json"], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True
    ).stdout
    artifacts = [json.loads(line) for line in output.splitlines()]
    return next(
        Path(artifact["filenames"][0])
        for artifact in artifacts
        if artifact["reason"] == "compiler-artifact" and artifact["target"]["name"] == "damped_oscillator"
    )


def model_description(library):
    """The modelDescription.xml that the library writes, as bytes."""
    describe = ctypes.CDLL(str(library)).fmu_model_description
    describe.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t, ctypes.POINTER(ctypes.c_size_t)]
    needed = ctypes.c_size_t()
    describe(None, None, 0, needed)
    buffer = ctypes.create_string_buffer(needed.value)
    assert describe(None, buffer, needed, needed) == 0, buffer.value.decode()
    return buffer.value


@pytest.fixture(scope="module")
def fmu(library, tmp_path_factory):
    """The packaged example."""
    path = tmp_path_factory.mktemp("fmu") / "damped_oscillator.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", model_description(library))
        archive.write(library, f"binaries/{fmpy.platform}/damped_oscillator{fmpy.sharedLibraryExtension}")
    return path


@pytest.fixture(scope="module")
def unpacked(fmu):
    return fmpy.extract(fmu)


class FMU2Oscillator(FMU2Unpacked):
    """An instance of the example, with its variables by name."""

    def __init__(self, unpacked, name="one", guid=None):
        super().__init__(unpacked, name, guid)
        self.references = {variable.name: variable.valueReference for variable in self.variables}
        self.instantiate(callbacks=self.log)

    def start(self, stop=None, **parameters):
        self.setupExperiment(startTime=0.0, stopTime=stop)
        self.enterInitializationMode()
        for name, value in parameters.items():
            self[name] = value
        self.exitInitializationMode()
        return self

    def __getitem__(self, name):
        return self.getReal([self.references[name]])[0]

    def __setitem__(self, name, value):
        self.setReal([self.references[name]], [value])

    def refuses(self, call, *parts):
        """The call fails, and its message has all the parts."""
        with pytest.raises(FMICallException):
            call()
        assert all(part in self.messages[-1] for part in parts), f"{parts} are not all in: {self.messages[-1]}"


@pytest.fixture
def oscillator(unpacked):
    instance = FMU2Oscillator(unpacked)
    yield instance
    instance.freeInstance()


def exact(t, m=1.0, c=0.5, k=10.0, x0=1.0):
    """Position at t, m: released at rest from x0, with no force."""
    a = c / (2 * m)
    w = math.sqrt(k / m - a * a)
    return x0 * np.exp(-a * t) * (np.cos(w * t) + a / w * np.sin(w * t))


def trajectory(instance, forces, step=0.1):
    """Positions after steps of 0.1 s under one force each, as a generator: it can run between others."""
    for i, force in enumerate(forces):
        instance["f"] = force
        instance.doStep(i * step, step)
        yield instance["x"]


def test_the_fmu_passes_fmpys_validation(fmu):
    assert validate_fmu(fmu) == []


def test_the_description_passes_the_schema_of_the_standard(library):
    schema = etree.XMLSchema(etree.parse(SCHEMA))
    schema.assertValid(etree.fromstring(model_description(library)))


def test_the_description_says_what_the_code_does(fmu):
    description = fmpy.read_model_description(fmu)
    cosimulation = description.coSimulation
    assert description.variableNamingConvention == "structured"
    assert cosimulation.canGetAndSetFMUstate and cosimulation.canSerializeFMUstate
    assert cosimulation.canHandleVariableCommunicationStepSize
    assert cosimulation.canNotUseMemoryManagementFunctions
    assert not cosimulation.canBeInstantiatedOnlyOncePerProcess
    assert not cosimulation.providesDirectionalDerivative and cosimulation.maxOutputDerivativeOrder == 0
    starts = {variable.name: variable.start for variable in description.modelVariables}
    assert starts == {"time": None, "m": "1.0", "c": "0.5", "k": "10.0", "x0": "1.0", "f": "0.0", "x": None, "v": None}


def test_all_functions_of_the_standard_are_exported(library):
    header = (Path(fmpy.__file__).parent / "c-code" / "fmi2Functions.h").read_text()
    sections = re.split(r"Functions for FMI2 for (?:Model Exchange|Co-Simulation)", header)
    common, _, cosimulation = sections[:3]
    names = re.findall(r"#define (fmi2\w+) +fmi2FullName", common + cosimulation)
    assert len(names) == 34, names
    loaded = ctypes.CDLL(str(library))
    assert [name for name in names if not hasattr(loaded, name)] == []


@pytest.mark.parametrize("step", [0.1, 0.037])
def test_a_simulation_follows_the_exact_solution(fmu, step):
    result = fmpy.simulate_fmu(fmu, stop_time=5.0, output_interval=step, output=["x", "time"])
    error = np.abs(result["x"] - exact(result["time"])).max()
    assert error < 1e-12, error


def test_start_values_reach_the_model(fmu):
    parameters = {"m": 2.0, "c": 0.1, "k": 50.0, "x0": -0.3}
    result = fmpy.simulate_fmu(fmu, stop_time=5.0, output_interval=0.1, start_values=parameters)
    error = np.abs(result["x"] - exact(result["time"], **parameters)).max()
    assert error < 1e-12, error


def test_a_rollback_repeats_bit_by_bit(oscillator):
    oscillator.start()
    list(trajectory(oscillator, [1.0, -2.0, 0.5]))
    state = oscillator.getFMUstate()
    first = [oscillator.doStep(0.3, 0.1), oscillator["x"], oscillator["v"], oscillator["time"]]
    oscillator["f"] = 100.0
    oscillator.doStep(0.4, 0.1)
    oscillator.setFMUstate(state)
    assert [oscillator.doStep(0.3, 0.1), oscillator["x"], oscillator["v"], oscillator["time"]] == first
    oscillator.freeFMUstate(state)


def test_serialized_bytes_continue_in_another_process(oscillator, unpacked, tmp_path):
    oscillator.start(m=2.5)
    list(trajectory(oscillator, [1.0, -2.0, 0.5]))
    serialized = oscillator.serializeFMUstate(oscillator.getFMUstate())
    (tmp_path / "state").write_bytes(serialized)
    oscillator.doStep(0.3, 0.1)
    program = f"""
from pathlib import Path
from tests.units.test_glue import FMU2Oscillator
other = FMU2Oscillator({str(unpacked)!r})
other.setFMUstate(other.deSerializeFMUstate(Path({str(tmp_path / "state")!r}).read_bytes()))
other.doStep(0.3, 0.1)
print(other["x"].hex())
"""
    output = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True
    ).stdout
    assert output.strip() == oscillator["x"].hex()


def test_a_damaged_state_is_refused_and_harms_nothing(oscillator):
    oscillator.start()
    serialized = bytearray(oscillator.serializeFMUstate(oscillator.getFMUstate()))
    serialized[-1] ^= 1
    oscillator.refuses(lambda: oscillator.deSerializeFMUstate(bytes(serialized)), "damaged")
    oscillator.doStep(0.0, 0.1)
    assert oscillator["x"] == pytest.approx(exact(0.1), abs=1e-14)


def test_a_wrong_guid_is_refused(unpacked):
    with pytest.raises(Exception, match="instantiate"):
        FMU2Oscillator(unpacked, guid="{00000000-0000-0000-0000-000000000000}")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_an_input_that_is_not_finite_is_refused(oscillator, value):
    oscillator.start()
    oscillator.refuses(lambda: oscillator.__setitem__("f", value), "f = ", "must be finite")
    assert oscillator["f"] == 0.0


def test_a_parameter_outside_its_limits_is_refused(oscillator):
    oscillator.refuses(lambda: oscillator.start(m=0.0), "m = 0.000e0 must be finite and > 0")


@pytest.mark.parametrize("step", [0.0, -0.1, math.nan])
def test_a_step_that_is_not_positive_is_refused(oscillator, step):
    oscillator.start()
    oscillator.refuses(lambda: oscillator.doStep(0.0, step), "communicationStepSize", "> 0")


def test_a_step_past_the_stop_time_is_refused(oscillator):
    oscillator.start(stop=0.25)
    list(trajectory(oscillator, [0.0, 0.0]))
    oscillator.refuses(lambda: oscillator.doStep(0.2, 0.1), "stopTime = 2.500e-1")
    oscillator.doStep(0.2, 0.05)


def test_interleaved_instances_equal_serial_ones(unpacked):
    forces = [[1.0, 0.0, 3.0, -1.0], [-2.0, 2.0, 0.5, 0.25]]
    pair = [FMU2Oscillator(unpacked, "one").start(), FMU2Oscillator(unpacked, "two").start(m=3.0)]
    interleaved = list(zip(*map(trajectory, pair, forces), strict=True))
    serial = [FMU2Oscillator(unpacked, "one").start(), FMU2Oscillator(unpacked, "two").start(m=3.0)]
    assert interleaved == list(zip(*(list(trajectory(*case)) for case in zip(serial, forces)), strict=True))


def test_the_library_can_be_unloaded(library, unpacked):
    """Nothing of it stays in the process: no thread, no thread-local destructor."""
    program = f"""
from tests.units.test_glue import FMU2Oscillator
instance = FMU2Oscillator({str(unpacked)!r}).start()
instance.doStep(0.0, 0.1)
try:
    instance.doStep(0.0, -1.0)
except Exception:
    pass
instance.freeInstance()
print("damped_oscillator" in open("/proc/self/maps").read())
"""
    output = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True
    ).stdout
    assert output.strip() == "False"
