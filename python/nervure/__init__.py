"""An elastic rod and a penalized fluid as FMI units, and the tool that couples them. Everything is in SI units.

    import nervure
    scene = nervure.load("fsi3-325x72")            # a shipped scene, or a file
    scene.time.end = 10.0
    scene.fluid.kinematic_viscosity = 1.1e-3
    nervure.inspect(scene)                         # prints size, numbers and duration
    run = nervure.run(scene)                       # results/fsi3-325x72
    print(run.summary.quantities["tip_uy"].amplitude)
    run.series["tip_uy"]                           # a NumPy array, in run.units["tip_uy"]
    run.plot("tip_uy", "lift").savefig("tip.png")
    run.animate()                                  # vorticity.gif, of a run with fields_every=0.01
    earlier = nervure.read("results/fsi3-325x72")
    nervure.compare(earlier, run)                  # both over each other

The packages, from below: `scene`; `units` describes, packs and loads the FMUs of a scene; `coupling` makes a step of
them; `evaluate` has the numbers, `simulation` a run and sweeps of runs, `output` pictures, fields and tables; `api` and
`cli` are the interfaces.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nervure.api import Run, RunError, compare, inspect, load, read, resume, run
    from nervure.errors import InputError
    from nervure.scene import Scene

__all__ = ["InputError", "Run", "RunError", "Scene", "compare", "inspect", "load", "read", "resume", "run"]


def __getattr__(name: str) -> Any:
    """Import the names above when they are first used: the help of the command does not need them."""
    if name == "__version__":
        from importlib.metadata import version

        return version("nervure")
    if name in __all__:
        from nervure import api, errors

        return getattr(errors if name == "InputError" else api, name)
    raise AttributeError(f"module `nervure` has no attribute `{name}`")
