"""An elastic rod and a penalized fluid as FMI units, and the tool that couples them. Everything is in SI units.

    import nervure
    scene = nervure.load("fsi3-325x72")            # a shipped scene, or a file
    scene.time.end = 10.0
    scene.fluid.kinematic_viscosity = 1.1e-3
    nervure.inspect(scene)                         # says what a run will do and take
    run = nervure.run(scene)                       # results/fsi3-325x72
    print(run.summary.quantities["tip_uy"].amplitude)
    run.series["tip_uy"]                           # a NumPy array, in run.units["tip_uy"]
    run.plot("tip_uy", "lift").savefig("tip.png")
    run.animate()                                  # vorticity.gif, if it was run with fields_every=0.01
    before = nervure.read("results/fsi3-325x72")   # an earlier run
    nervure.compare(before, run)                   # both over each other

`scene` has the scene, `pack` makes its FMUs, `unit` wraps one, `coupling` is what happens in a step, `master` is the
loop, `simulation` is a run from its scene to its results; `evaluate` and `show` are what comes after, `sweep` makes
many runs.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nervure.api import Run, RunError, compare, inspect, load, read, resume, run
    from nervure.errors import InputError
    from nervure.scene import Scene

__all__ = ["InputError", "Run", "RunError", "Scene", "compare", "inspect", "load", "read", "resume", "run"]


def __getattr__(name: str) -> Any:
    """The names above, found when they are first used: the command shows its help without them."""
    if name in __all__:
        from nervure import api, errors

        return getattr(errors if name == "InputError" else api, name)
    raise AttributeError(f"module `nervure` has no attribute `{name}`")
