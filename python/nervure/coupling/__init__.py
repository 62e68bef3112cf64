"""How units are coupled: schemes, what accelerates those that iterate, and guards (`docs/theory/coupling.md`)."""

from nervure.coupling.acceleration import Aitken, IqnIls
from nervure.coupling.schemes import (
    Choice,
    Drive,
    Explicit,
    Iterated,
    ParallelExplicit,
    Single,
    connections,
    reason_of,
)
from nervure.coupling.watch import CouplingError, Watch, takes_momentum
from nervure.scene.types import Coupling, CouplingSchemeIterated, Guards, Iterated as Iteration
from nervure.units.fmu import Unit

__all__ = ["Aitken", "Choice", "CouplingError", "Drive", "Explicit", "IqnIls", "Iterated", "ParallelExplicit", "Single"]
__all__ += ["Watch", "connections", "couple"]


def couple(
    units: dict[str, Unit], coupling: Coupling | None, drive: Drive | None = None, foreign: bool = False
) -> Single:
    """The units of a scene under its `coupling`; `choice` of what is returned says what was chosen where it does not
    say. `drive` moves the roots that the scene leaves to the master: it gives what one rod takes after that of the
    other. Guards that the scene does not give are on unless one of the units is `foreign`, whose powers need not mean
    the same.

    The load is chosen by the units, when they are packed. The scheme follows from it: explicit under the momentum load,
    which is implicit by itself; iterated under the pressure jump, which is not.
    """
    if len(units) == 1:
        (unit,) = units.values()
        return Single(unit, drive)
    fluid, rods = units["fluid"], [unit for name, unit in units.items() if name != "fluid"]
    load = "momentum" if any(map(takes_momentum, rods)) else "pressure_jump"
    coupling = coupling or Coupling()
    guards = coupling.guards or (None if foreign else Guards())
    scheme, reason = coupling.scheme, "the scene says so"
    if scheme is None and load == "momentum":
        scheme, reason = "explicit", "the momentum load with its impedance is implicit by itself"
    elif scheme is None:
        scheme = CouplingSchemeIterated(iterated=Iteration())
        reason = "the pressure jump holds the added mass, which an explicit scheme leaves a step late"
    made: Explicit
    if isinstance(scheme, CouplingSchemeIterated):
        made, name = Iterated(rods, fluid, scheme.iterated, drive), f"iterated, {scheme.iterated.acceleration}"
    else:
        made = (Explicit if scheme == "explicit" else ParallelExplicit)(rods, fluid, drive, guards)
        name = scheme
    made.choice = Choice(load, reason_of(rods) or "the rod has no other input", name, reason)
    return made
