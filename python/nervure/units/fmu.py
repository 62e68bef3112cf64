"""An FMU as the master uses it: named arrays in, a step, named arrays out."""

import ctypes
import math
import re
import shutil
import tempfile
import zipfile
from collections import defaultdict
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException

from nervure.errors import UnitError, UnitFailure
from nervure.units.fmi import FMI, FMI_FATAL, FMI_WARNING, errors, warnings

ERROR_CATEGORIES = ("logStatusError", "logStatusFatal")  # Of the standard; some units log errors only in these
LARGEST = 1e12  # Magnitude of an exchanged place, angle or velocity, in SI units, that no unit may give
HEAVIEST = 1e30  # The same of a load or an impedance, whose numbers differ more with the size of a scene
LOAD = re.compile("N|Pa|kg")  # In the unit of such
KINDS = {"Float64": "Real", "Int32": "Integer"}  # Types of FMI 3.0 with their names in FMI 2.0
ELEMENT = re.compile(r"(.+)\[(\d+)\]")
OUTSIDE = re.compile(r"^[/\\]|^\w:|(^|[/\\])\.\.([/\\]|$)")  # Paths that leave the folder of an archive
DESCRIPTION = "modelDescription.xml"
MOST_FILES, MOST_BYTES, MOST_DESCRIPTION = 10_000, 2 << 30, 256 << 20  # Of an unpacked FMU


@dataclass
class Variable:
    """A scalar variable, or an array: `name[1] … name[n]` in FMI 2.0, one variable of `n` values in FMI 3.0."""

    name: str
    kind: str  # FMI type, by its name in FMI 2.0 if it has one: Real, Integer, Boolean or String
    causality: str
    unit: str | None
    references: list[int]
    start: list[str | None]  # Start values as text in the model description

    @property
    def size(self) -> int:
        return len(self.start)


class Unit:
    """A co-simulation FMU of FMI 2.0 or 3.0, packed or as a folder, instantiated and in initialization mode.

    After `connect`, `inputs` and `outputs` are plain arrays, and `step` moves each with one call. A status worse than a
    warning raises `UnitError` with the errors that the unit logged.
    """

    def __init__(self, path: Path, name: str, stop_time: float | None):
        self.name, self.stop_time = name, stop_time
        self.seconds = 0.0  # Wall time spent on steps, rollback and answers that are worked out when they are read
        self.fmu: Any = None
        self._folder: str | None = None
        self._step: tuple[float, float] | None = None  # The last step: its time and its length, s
        self.state = ctypes.c_void_p()  # Handle of the state that `save` keeps
        self.kept: list[ctypes.c_void_p] = []  # Those of `keep`
        self._references: list[np.ndarray] = []  # Whose addresses are arguments of calls
        errors[name].clear()
        warnings[name].clear()
        self.description = read_description(path)
        version = version_of(self.description)
        if version is None or self.description.coSimulation is None:
            raise UnitError(f"{path} is not a co-simulation unit of FMI 2.0 or 3.0")
        self.variables = variables_of(self.description)
        self.can_roll_back = bool(self.description.coSimulation.canGetAndSetFMUstate)
        self.can_serialize = self.can_roll_back and bool(self.description.coSimulation.canSerializeFMUstate)
        try:
            if not path.is_dir():
                self._folder = tempfile.mkdtemp()
                unpack(path, self._folder)
            guid, model = self.description.guid, self.description.coSimulation.modelIdentifier
            place = {"unzipDirectory": self._folder or str(path), "instanceName": name}
            try:
                self.fmi = FMI[version](guid=guid, modelIdentifier=model, **place)
            except Exception as error:  # fmpy raises plain exceptions where a library is missing or lacks a function
                raise UnitError(f"the library of {path} cannot be used: {error}") from error
            self.fmu = self.fmi.fmu
            categories = [c.name for c in self.description.logCategories if c.name in ERROR_CATEGORIES]
            self.fmi.initialize(self._call, categories, stop_time)
        except BaseException:
            self.close()
            raise
        self.connect([], [])

    def connect(self, inputs: list[str], outputs: list[str], watched: Sequence[str] = ()) -> None:
        """Choose the Real variables that `step` sets and gets, in this order.

        The array `outputs` holds the chosen outputs (`exchanged`), the `watched` outputs, and the scalar outputs, which
        every step fetches only if `all_in_step`. `integers` holds the scalar Integer outputs, `slices` the place of
        each output, `input_slices` that of each input.
        """
        scalars = self.scalars("Real")
        front = [*outputs, *watched]
        self.inputs, self._set_arguments = self._buffer(inputs, ctypes.c_double)
        self.input_slices = self._slices(inputs)
        self.outputs, self._get_arguments = self._buffer([*front, *scalars], ctypes.c_double)
        part = self.outputs[: self.outputs.size - len(scalars)]
        self._get_part_arguments = self._arguments(front, part)
        self.all_in_step, self.stale = True, False
        self._fetching: dict[str, tuple[Any, ...]] = {}  # Arguments of the call for one scalar
        self.integers, self._get_integer_arguments = self._buffer(self.scalars("Integer"), ctypes.c_int)
        self.slices = self._slices([*front, *scalars])
        exchanged = sum(self.variables[name].size for name in outputs)
        self.exchanged, self.reals = self.outputs[:exchanged], self.outputs[self.outputs.size - len(scalars) :]

    def _slices(self, names: list[str]) -> dict[str, slice]:
        """Return the place of each of `names` in a buffer; of one that is there twice the first, which every step
        fetches."""
        ends = np.cumsum([self.variables[name].size for name in names], dtype=int).tolist()
        places = [(name, slice(begin, end)) for name, begin, end in zip(names, [0, *ends], ends, strict=False)]
        return dict(reversed(places))

    def scalars(self, kind: str) -> list[str]:
        """Return the names of the scalar outputs of FMI type `kind`."""
        return [v.name for v in self.variables.values() if v.causality == "output" and v.kind == kind and v.size == 1]

    def _buffer(self, names: list[str], c_type: Any) -> tuple[np.ndarray, tuple[Any, ...]]:
        """Return the start values of `names`, and the arguments of the C function that sets or gets them."""
        starts = [start for name in names for start in self.variables[name].start]
        values = np.array([float(start or 0) for start in starts]).astype(c_type)
        return values, self._arguments(names, values)

    def _arguments(self, names: list[str], values: np.ndarray) -> tuple[Any, ...]:
        """Return the arguments of the C function that sets or gets `names`, from or into `values`, which the caller
        keeps. The methods of fmpy take lists, which are copied element by element."""
        references = np.array([reference for name in names for reference in self.variables[name].references], np.uintc)
        self._references.append(references)
        return self.fmi.arguments(references, values)

    def set(self) -> None:
        """Set `inputs` in the unit."""
        self._check(self.fmi.set_reals(*self._set_arguments), "refused its inputs")

    def get_exchanged(self) -> None:
        """Fetch the exchanged and watched `outputs` only: a scalar may cost as much as half a step."""
        self._check(self.fmi.get_reals(*self._get_part_arguments), "gave no outputs")

    def fetch(self, name: str) -> None:
        """Fetch one scalar output into its place, of an Integer all."""
        if name not in self._fetching:
            if self.variables[name].kind != "Real":
                return self.get()
            place = self.scalars("Real").index(name)
            self._fetching[name] = self._arguments([name], self.reals[place : place + 1])
        return self._check(self.fmi.get_reals(*self._fetching[name]), "gave no outputs")

    def get(self) -> None:
        """Fetch all `outputs` and `integers`."""
        self.stale = False
        status = self.fmi.get_reals(*self._get_arguments)
        if self.integers.size and status <= FMI_WARNING:
            status = self.fmi.get_integers(*self._get_integer_arguments)
        self._check(status, "gave no outputs")

    def _check(self, status: int, what: str) -> None:
        if status > FMI_WARNING:
            raise self._error(what, status, self._step)

    def start(self) -> None:
        """Leave initialization mode."""
        self._call(self.fmu.exitInitializationMode)

    def step(self, t: float, h: float) -> None:
        """Set the inputs, step from `t` to `t + h` (s), and fetch the outputs, all or only those for the next step."""
        self._step = t, h
        if (status := self.fmi.set_reals(*self._set_arguments)) > FMI_WARNING:
            self._check(status, "refused its inputs")
        start = perf_counter()
        status = self.fmi.do_step(self.fmu.component, t, h, 1, *self.fmi.step_results)
        self.seconds += perf_counter() - start
        if status > FMI_WARNING:
            raise self._error("failed", status, (t, h))
        if self.fmi.flags and any(flag.value for flag in self.fmi.flags):
            raise self._error("wants an event, an early return or the end", None, (t, h))
        if self.all_in_step:
            self.get()
        else:
            if (status := self.fmi.get_reals(*self._get_part_arguments)) > FMI_WARNING:
                self._check(status, "gave no outputs")
            self.stale = True
        if not self.outputs.dot(self.outputs) < LARGEST**2:
            self.check_outputs(t + h)

    def check_outputs(self, t: float) -> None:
        """Raise `UnitFailure` where an output at `t` (s) is no finite number, or one that is exchanged is absurd."""
        if self.outputs.dot(self.outputs) < LARGEST**2:
            return
        limits = np.full(self.outputs.size, np.finfo(float).max)
        for name, where in self.slices.items():
            if where.stop <= self.exchanged.size:
                limits[where] = HEAVIEST if LOAD.search(self.variables[name].unit or "") else LARGEST
        for place in np.flatnonzero(~(np.abs(self.outputs) <= limits))[:1].tolist():
            name, where = next((name, s) for name, s in self.slices.items() if s.start <= place < s.stop)
            variable = self.variables[name]
            shown = f"{name}[{place - where.start + 1}]" if variable.size > 1 else name
            value = f"{self.outputs[place]:g} {variable.unit or ''}".rstrip()
            raise UnitFailure(f"{self.name}: its output {shown} is {value} at t = {t:g} s")

    def terminate(self) -> None:
        """End the simulation; values can still be read."""
        self._call(self.fmu.terminate)

    def save(self) -> None:
        """Save the state of the unit, in place of the saved one."""
        self._timed(self.fmi.get_state, self.fmu.component, ctypes.byref(self.state))

    def keep(self) -> ctypes.c_void_p:
        """Return the state of the unit, kept until it is closed."""
        kept = ctypes.c_void_p()
        self._timed(self.fmi.get_state, self.fmu.component, ctypes.byref(kept))
        self.kept.append(kept)
        return kept

    def restore(self, state: ctypes.c_void_p | None = None) -> None:
        """Restore the saved state, or one that is kept."""
        self._timed(self.fmu.setFMUState, state or self.state)

    def serialize(self) -> bytes:
        """Return the state of the unit as bytes, and save it."""
        self.save()
        return bytes(self._call(self.fmu.serializeFMUState, self.state))

    def deserialize(self, state: bytes) -> None:
        """Restore a state from the bytes of `serialize`."""
        self._call(self.fmu.deserializeFMUState, state, self.state)
        self.restore()

    def read(self, name: str) -> np.ndarray:
        """Return the values of any Real or Integer variable."""
        variable = self.variables[name]
        reader = self.fmi.reader(variable.kind == "Integer", variable.references, variable.size)
        return np.array(self._call(reader))

    def reader(self, names: Sequence[str]) -> Callable[[], np.ndarray]:
        """Return a function that reads Real variables of one size, `[size, len(names)]`; those that the last step
        fetched cost nothing."""
        places = [self.slices[name] for name in names if name in self.slices]
        has_all, fetched = len(places) == len(names), self.outputs.size - self.reals.size
        has_scalar = any(place.stop > fetched for place in places)
        values, arguments = self._buffer([*names], ctypes.c_double)

        def read() -> np.ndarray:
            if has_all and not (has_scalar and self.stale):
                return np.column_stack([self.outputs[place] for place in places])
            start = perf_counter()
            self._check(self.fmi.get_reals(*arguments), "gave no outputs")
            self.seconds += perf_counter() - start
            return values.reshape(len(names), -1).T.copy()

        return read

    def scalars_reader(self, names: Sequence[str]) -> Callable[[], np.ndarray]:
        """Return a function that reads scalar Real variables into an array, the same one at each call."""
        values, arguments = self._buffer([*names], ctypes.c_double)

        def read() -> np.ndarray:
            if (status := self.fmi.get_reals(*arguments)) > FMI_WARNING:
                self._check(status, "gave no outputs")
            return values

        return read

    def field(self, name: str) -> np.ndarray:
        """Return a field of the unit, `[nx, ny]` or `[nx, ny, nz]`; raise `UnitError` if the unit does not show it."""
        values = self.shown_field(name)
        if values is None:
            raise UnitError(f"{self.name}: there is no field `{name}`")
        return values

    def shown_field(self, name: str) -> np.ndarray | None:
        """Return a field of the unit, `[nx, ny]` or `[nx, ny, nz]`, by a function beside FMI; None if the unit does not
        show it."""
        function = getattr(self.fmu.dll, "fmu_field", None)
        if function is None:
            return None
        size, pointer = ctypes.c_size_t, ctypes.c_void_p
        function.argtypes = [pointer, ctypes.c_char_p, pointer, size, pointer]
        shape = (size * 3)()
        if function(self.fmu.component, name.encode(), None, 0, shape) != 0:
            return None
        values = np.empty([n for n in shape if n])
        function(self.fmu.component, name.encode(), values.ctypes.data, values.size, shape)
        return values

    def take_warnings(self) -> list[str]:
        """Return what the unit has warned of since the last call."""
        taken, warnings[self.name] = warnings[self.name], []
        return taken

    def close(self) -> None:
        """Free the instance, unload the library and remove the unpacked files."""
        if self.fmu is not None and self.fmu.component is not None:
            with suppress(Exception):  # a unit that refuses this has nothing left to say
                for state in (self.state, *self.kept):
                    if state:
                        self.fmu.freeFMUState(state)
            self.fmu.freeInstance()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)

    def _timed(self, function: Callable[..., Any], *arguments: Any) -> None:
        start = perf_counter()
        self._call(function, *arguments)
        self.seconds += perf_counter() - start

    def _call(self, function: Callable[..., Any], *arguments: Any, **keywords: Any) -> Any:
        try:
            return function(*arguments, **keywords)
        except FMICallException as error:
            raise self._error(f"failed: {error}", error.status) from error
        except Exception as error:  # fmpy raises plain exceptions where a library or an instance cannot be made
            raise self._error(str(error)) from error

    def _error(self, what: str, status: int | None = None, step: tuple[float, float] | None = None) -> UnitFailure:
        """Return a failure in the unit's own words, or else as `what`, with the time (s) and length (s) of `step`."""
        if status == FMI_FATAL:
            self.fmu.component = None  # no function may be called for it any more, not even to free it
        reason = "; ".join(dict.fromkeys(errors[self.name])) or what
        if step and "t = " not in reason:
            reason += f" in the step from t = {step[0]:g} s to {sum(step):g} s"
        return UnitFailure(f"{self.name}: {reason}")


def prefixes(rods: int, wings: int = 0) -> list[str]:
    """Return the prefix of the variables of each rod, then of each wing at the fluid: none for a single rod, else
    `beam[1].`, `beam[2].`, …; of a single wing `wing.`, else `wing[1].`, ….

    >>> prefixes(2), prefixes(1, 2)
    (['beam[1].', 'beam[2].'], ['', 'wing[1].', 'wing[2].'])
    """
    beams = [""] if rods == 1 else [f"beam[{i}]." for i in range(1, rods + 1)]
    return beams + (["wing."] if wings == 1 else [f"wing[{i}]." for i in range(1, wings + 1)])


WING = re.compile(r"wing(\[\d+\])?\.x")  # At the fluid


def read_description(path: Path) -> Any:
    """Read the model description of an FMU with fmpy."""
    try:
        fault = None
        if not path.is_dir():
            with zipfile.ZipFile(path) as archive:
                fault = _archive_fault(archive)
        if fault is None:
            return fmpy.read_model_description(str(path), validate=False)
    except Exception as error:  # fmpy raises whatever zip and XML readers raise
        fault = str(error)
    raise UnitError(f"{path} cannot be read as an FMU: {fault}")


def unpack(path: Path, folder: str) -> None:
    """Unpack an FMU of bounded size into `folder`, and nothing outside of it."""
    try:
        with zipfile.ZipFile(path) as archive:
            fault = _archive_fault(archive)
            if fault is None:
                archive.extractall(folder)
    except Exception as error:  # whatever a damaged, encrypted or unknown archive raises, or a full disk
        fault = str(error)
    if fault is not None:
        raise UnitError(f"{path} cannot be unpacked into {tempfile.gettempdir()}: {fault}")


def _archive_fault(archive: zipfile.ZipFile) -> str | None:
    """Return why an archive must not be unpacked; None for one that may be."""
    entries = archive.infolist()
    size = sum(entry.file_size for entry in entries)
    if len(entries) > MOST_FILES or size > MOST_BYTES:
        return (
            f"it has {len(entries)} files of {size / 1e6:.0f} MB, but at most {MOST_FILES} files of "
            f"{MOST_BYTES / 1e6:.0f} MB are allowed"
        )
    for entry in entries:
        if entry.filename == DESCRIPTION and entry.file_size > MOST_DESCRIPTION:
            return f"its {DESCRIPTION} has {entry.file_size / 1e6:.0f} MB, but at most {MOST_DESCRIPTION / 1e6:.0f}"
        if OUTSIDE.search(entry.orig_filename):
            return f"its entry `{entry.orig_filename}` lies outside of it"
    return None


def version_of(description: Any) -> int | None:
    """Return the version of FMI of a model description, 2 or 3; None for another."""
    return 2 if description.fmiVersion == "2.0" else 3 if description.fmiVersion.startswith("3.") else None


def variables_of(description: Any) -> dict[str, Variable]:
    """Return the variables of a model description by name; the elements of an array are one variable."""
    try:
        return _variables_of(description)
    except (AttributeError, OverflowError, TypeError, ValueError) as error:
        raise UnitError(f"the model description of {description.modelName} cannot be used: {error}") from error


def _variables_of(description: Any) -> dict[str, Variable]:
    arrays: dict[str, dict[int, Any]] = defaultdict(dict)
    for scalar in description.modelVariables:
        element = ELEMENT.fullmatch(scalar.name)
        name, index = (element[1], int(element[2])) if element else (scalar.name, 1)
        arrays[name][index] = scalar
    variables = {}
    for name, elements in arrays.items():
        if sorted(elements) != list(range(1, len(elements) + 1)):
            raise UnitError(f"the array `{name}` of {description.modelName} is not counted from 1 to {len(elements)}")
        ordered = [elements[index] for index in sorted(elements)]
        first = ordered[0]
        unit = first.unit or (first.declaredType.unit if first.declaredType else None)
        references = np.array([scalar.valueReference for scalar in ordered], np.uintc).tolist()
        start = [value for scalar in ordered for value in _starts(scalar)]
        kind = KINDS.get(first.type, first.type)
        if kind in ("Real", "Integer"):
            for value in filter(None, start):
                float(value)  # refuses a start value that is no number
        variables[name] = Variable(name, kind, first.causality, unit, references, start)
    return variables


def _starts(variable: Any) -> list[str | None]:
    """Return the start values of a variable; an array of FMI 3.0 has them in one text."""
    size = math.prod(variable.shape or ())
    if variable.start is None or variable.type == "String":  # fmpy reads the first of several texts only
        return [variable.start] * size
    values = variable.start.split()
    if len(values) != size:
        raise UnitError(f"the variable `{variable.name}` has {size} values, but {len(values)} start values")
    return list(values)
