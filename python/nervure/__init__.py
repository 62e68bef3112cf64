"""An elastic rod and a penalized fluid as FMI units, and the tool that couples them. Everything is in SI units.

    import nervure
    scene = nervure.load("fsi3-325x72")            # a shipped scene, or a file
    scene = scene.copy({"time.end": 10.0, "fluid.kinematic_viscosity": 1.1e-3})
    nervure.inspect(scene)                         # prints size, numbers and duration
    run = nervure.run(scene, fields_every=0.01)    # results/fsi3-325x72
    print(run.summary.quantities["tip_uy"].amplitude)
    run.series["tip_uy"]                           # a NumPy array, in run.units["tip_uy"]
    run.to_pandas()                                # all series as a table, where pandas is installed
    run.fields()                                   # velocity, vorticity and pressure as an xarray Dataset
    run.plot("tip_uy", "lift").savefig("tip.png")
    run.plot_field("vorticity", 9.5)
    run.animate()                                  # vorticity.gif
    earlier = nervure.read("results/fsi3-325x72")
    nervure.compare(earlier, run)                  # both over each other
    rows = nervure.sweep("csm3", {"beam.segments": [8, 16, 32]})
    found = nervure.verify("csm3", within=0.01)    # error bars, and the cheapest setting within them

The packages, from below: `scene`; `units` describes, packs and loads the FMUs of a scene; `coupling` makes a step of
them; `evaluate` has the numbers, `simulation` a run and sweeps of runs, `output` pictures, fields and tables,
`verification` the error bars of a scene; `api` and `cli` are the interfaces.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nervure.api import Run, RunError, compare, inspect, load, read, resume, run, sweep, verify
    from nervure.errors import InputError
    from nervure.scene import Scene

__all__ = [
    "InputError", "Run", "RunError", "Scene", "compare", "inspect", "load", "read", "resume", "run", "sweep", "verify",
]  # fmt: skip


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__", *(name for name in globals() if name.startswith("__"))])


def __getattr__(name: str) -> Any:
    """Import the names above when they are first used: the help of the command does not need them."""
    if name == "__version__":
        from importlib.metadata import version

        return version("nervure")
    if name in __all__:
        from nervure import api, errors

        return getattr(errors if name == "InputError" else api, name)
    raise AttributeError(f"module `nervure` has no attribute `{name}`")
