"""A step of the Navier–Stokes equations by fluidsim in a periodic box, for comparison only.

python fluidsim_step.py 144x96x96        points along each axis, two or three

Pseudo-spectral in double precision, transforms by pyFFTW, two thirds of the waves kept, vorticity and stream function
in the plane. Prints one JSON object: medians of the CPU times of a right-hand side and of a step of its second-order
Runge–Kutta scheme (two right-hand sides), ms.
"""

import json
import os
import sys
from collections.abc import Callable
from importlib import import_module
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time

WARM, TIMED = 3, 12  # Calls


def time_calls(call: Callable[[], object]) -> float:
    times = []
    for _ in range(WARM + TIMED):
        begin = process_time()
        call()
        times.append(process_time() - begin)
    return 1e3 * median(times[WARM:])


def main(points: list[int]) -> dict[str, float]:
    dimensions = len(points)
    simulation = import_module(f"fluidsim.solvers.ns{dimensions}d.solver").Simul
    parameters = simulation.create_default_params()
    for axis, n in zip("xyz", points):
        setattr(parameters.oper, f"n{axis}", n)
        setattr(parameters.oper, f"L{axis}", n / max(points))
    parameters.oper.type_fft = f"fft{dimensions}d.with_pyfftw"
    parameters.oper.coef_dealiasing = 2 / 3
    parameters.nu_2 = 1e-3
    parameters.init_fields.type = "noise"
    parameters.time_stepping.type_time_scheme = "RK2"
    parameters.time_stepping.USE_CFL = False
    parameters.time_stepping.deltat0 = 1e-5
    parameters.output.HAS_TO_SAVE = False
    made = simulation(parameters)
    state = made.state.state_spect
    return {
        "rhs_ms": time_calls(lambda: made.tendencies_nonlin(state)),
        "rk2_ms": time_calls(made.time_stepping.one_time_step_computation),
    }


if __name__ == "__main__":
    with TemporaryDirectory() as folder:
        os.environ["FLUIDSIM_PATH"] = folder  # Read when fluidsim is imported
        print(json.dumps(main([int(n) for n in sys.argv[1].split("x")])))
