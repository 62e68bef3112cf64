"""Hostile inputs, parameters and steps."""

import ctypes
import math
import random
import time

from .unit import OK, REAL, STEP, Library, Unit


HOSTILE = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1e200, 1e100, -1e50, 1e20, -1e10, 1e6, 1e3, -1.0, 5e-324, 0.0)
STEPS = (math.nan, math.inf, -math.inf, 1e308, 1e100, 1e20, 1e9, 1e6, -1.0, 0.0, 5e-324, 1e-300, 1e-100, 1e-20)


def hostile(library: Library, count: int) -> str:
    """NaN, infinite and huge inputs, parameters and steps: an error or finite outputs, each in under 1 s."""
    chance = random.Random(1)
    unit = Unit(library)
    saved, rest = unit.state(), list(unit.rest)
    everything = [v.valueReference for v in library.description.modelVariables if v.type == "Real"]
    inputs = list(library.array("input")[0])
    parameters = list(library.array("parameter")[0])
    refused = failed = finite = 0
    slowest = 0.0

    def timed(function, *arguments) -> int:
        nonlocal slowest
        begin = time.perf_counter()
        status = function(unit.component, *arguments)
        slowest = max(slowest, time.perf_counter() - begin)
        return status

    for case in range(count):
        step = STEP
        if case % 5 == 4:  # a new instance, for parameters
            unit.close()
            unit = Unit(library, start=False)
            unit.do("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)
            unit.do("EnterInitializationMode")
            reference = (ctypes.c_uint * 1)(chance.choice(parameters))
            set_status = timed(library.SetReal, reference, 1, (REAL * 1)(chance.choice(HOSTILE)))
            status = max(set_status, timed(library.ExitInitializationMode))
        else:
            unit.do("SetFMUstate", saved)
            if case % 5 == 3:
                step, status = chance.choice(STEPS), OK
            else:
                chosen = chance.sample(inputs, chance.choice([1, 2, len(inputs)]))
                value = chance.choice(HOSTILE)
                values = (REAL * len(chosen))(*[value] * len(chosen))
                status = timed(library.SetReal, (ctypes.c_uint * len(chosen))(*chosen), len(chosen), values)
        if status != OK:
            refused += 1
        elif timed(library.DoStep, 0.0, step, 1) != OK:
            failed += 1
        else:
            values = (REAL * len(everything))(*[math.nan] * len(everything))
            status = timed(library.GetReal, (ctypes.c_uint * len(everything))(*everything), len(everything), values)
            wrong = [everything[k] for k, value in enumerate(values) if not math.isfinite(value)]
            assert status != OK or not wrong, f"case {case}: {wrong} are not finite after a step of {step} with status OK"
            finite += 1
        if case % 5 == 4:
            unit.close()
            unit = Unit(library)
            saved = unit.state()
    assert slowest < 1.0, f"a call took {slowest} s"
    assert list(unit.rest) == rest
    unit.do("SetFMUstate", saved)
    unit.steps = 0
    fresh = Unit(library)
    assert unit.run(3) == fresh.run(3), "the instance is not what it was"
    return f"{refused} refused, {failed} steps failed, {finite} finite; slowest call {slowest:.2g} s"
