"""FMI 2.0 and FMI 3.0 for a master, behind the same names, and what instances log."""

import ctypes
from collections import defaultdict
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Slave, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave
from fmpy.logging import addLoggerProxy

FMI_WARNING, FMI_FATAL = 1, 4

errors: dict[str, list[str]] = defaultdict(list)
"""Logged errors by instance name: the proxy of fmpy has one logger for the whole process."""

warnings: dict[str, list[str]] = defaultdict(list)
"""Logged warnings by instance name."""


def _log(_environment: Any, instance: bytes | None, status: int, _category: Any, message: bytes | None) -> None:
    _note((instance or b"").decode("utf-8", "replace"), None, status, None, message)


def _note(instance: str, _environment: Any, status: int, _category: Any, message: bytes | None) -> None:
    if status >= FMI_WARNING:
        kept = errors if status > FMI_WARNING else warnings
        kept[instance].append((message or b"").decode("utf-8", "replace"))


_callbacks = fmi2CallbackFunctions(
    logger=fmi2CallbackLoggerTYPE(_log),
    allocateMemory=defaultCallbacks.allocateMemory,
    freeMemory=defaultCallbacks.freeMemory,
)
addLoggerProxy(ctypes.byref(_callbacks))


class Fmi:
    """An instance of a library, whose calls of the loop are bound without the wrappers of fmpy: they double the cost of
    the exchange, and to check their types of arguments takes longer than to take addresses."""

    slave: type  # Wrapper of fmpy
    exchange: Any  # Type of the functions that set or get values
    functions: tuple[str, str, str, str, str]  # They set and get reals, get integers, step, and get a state
    counts_values: bool  # Whether setting and getting takes the number of values as well
    flags: list[ctypes.c_bool]  # By which a step asks for more than the next step
    step_results: tuple[Any, ...]  # Further arguments of the function that steps

    def __init__(self, **instance: Any):
        self.fmu = self.slave(**instance)
        set_reals, get_reals, get_integers, do_step, get_state = self.functions
        self.set_reals, self.get_reals, self.get_integers = map(self._bound, (set_reals, get_reals, get_integers))
        self.do_step = getattr(self.fmu.dll, do_step)
        self.get_state = getattr(self.fmu, get_state)
        self.flags, self.step_results = [], ()

    def _bound(self, name: str) -> Callable[..., int]:
        found: Callable[..., int] = self.exchange(ctypes.cast(getattr(self.fmu.dll, name), ctypes.c_void_p).value or 0)
        return found

    def arguments(self, references: np.ndarray, values: np.ndarray) -> tuple[Any, ...]:
        """Return the arguments of a function that sets or gets; the caller keeps both arrays."""
        found = (self.fmu.component, references.ctypes.data, references.size, values.ctypes.data)
        return (*found, values.size) if self.counts_values else found


class Fmi2(Fmi):
    """FMI 2.0."""

    slave = FMU2Slave
    exchange = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)
    functions = "fmi2SetReal", "fmi2GetReal", "fmi2GetInteger", "fmi2DoStep", "fmi2GetFMUstate"
    counts_values = False

    def initialize(self, call: Callable[..., Any], categories: list[str], stop_time: float | None) -> None:
        """Make an instance that logs, in initialization mode; `call` calls a method of fmpy."""
        call(self.fmu.instantiate, callbacks=_callbacks)
        if categories:
            call(self.fmu.setDebugLogging, True, categories)
        call(self.fmu.setupExperiment, startTime=0.0, stopTime=stop_time)
        call(self.fmu.enterInitializationMode)

    def reader(self, is_integer: bool, references: list[int], _size: int) -> partial[list[float]]:
        """Return the call that reads values of a variable."""
        return partial(self.fmu.getInteger if is_integer else self.fmu.getReal, references)


class Fmi3(Fmi):
    """FMI 3.0."""

    slave = FMU3Slave
    exchange = ctypes.CFUNCTYPE(
        ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_size_t
    )
    functions = "fmi3SetFloat64", "fmi3GetFloat64", "fmi3GetInt32", "fmi3DoStep", "fmi3GetFMUState"
    counts_values = True

    def __init__(self, **instance: Any):
        super().__init__(**instance)
        self.flags = [ctypes.c_bool() for _ in ("event", "end", "early return")]
        self.step_results = (*map(ctypes.byref, self.flags), ctypes.byref(ctypes.c_double()))  # The last: time reached

    def initialize(self, call: Callable[..., Any], categories: list[str], stop_time: float | None) -> None:
        """Make an instance that logs, in initialization mode; `call` calls a method of fmpy."""
        note = partial(_note, self.fmu.instanceName)
        call(self.fmu.instantiate, loggingOn=True, logMessage=note)  # Where logging is off, nothing is logged
        if categories:
            call(self.fmu.setDebugLogging, False, [])
            call(self.fmu.setDebugLogging, True, categories)
        call(self.fmu.enterInitializationMode, startTime=0.0, stopTime=stop_time)

    def reader(self, is_integer: bool, references: list[int], size: int) -> partial[list[float]]:
        """Return the call that reads values of a variable."""
        return partial(self.fmu.getInt32 if is_integer else self.fmu.getFloat64, references, size)


FMI: dict[int, type[Fmi2] | type[Fmi3]] = {2: Fmi2, 3: Fmi3}
