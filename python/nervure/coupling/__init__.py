"""How units are coupled: schemes, accelerators of the schemes that iterate, and guards (`docs/theory/coupling.md`)."""

from collections.abc import Collection

from nervure.coupling.acceleration import Aitken, IqnIls
from nervure.coupling.drive import Drive, Driver, Memory, read_drive, stand_still
from nervure.coupling.flight import Flight
from nervure.coupling.guards import CouplingError, EnergyGuard, takes_momentum
from nervure.coupling.schemes import (
    Choice,
    Explicit,
    Iterated,
    ParallelExplicit,
    Scheme,
    SingleUnit,
    connections,
    reason_of,
)
from nervure.resources import COUPLERS
from nervure.scene.types import Coupling, CouplingSchemeIterated, Guards, Iterated as Iteration
from nervure.units.fmu import Unit

__all__ = ["Aitken", "Choice", "CouplingError", "Drive", "Driver", "EnergyGuard", "Explicit", "IqnIls", "Iterated"]
__all__ += ["Memory", "ParallelExplicit", "Scheme", "SingleUnit", "connections", "couple", "read_drive", "stand_still"]


def couple(units: dict[str, Unit], coupling: Coupling | None, foreign: Collection[str] = ()) -> Scheme:
    """Connect the units of a scene under its `coupling`; `choice` of the scheme says what the scene left open.

    Guards that the scene does not set are on, unless a unit is `foreign`: its powers need not mean the same.

    Contact without a fluid couples as a fluid does. The load was chosen when the units were packed. The scheme follows
    from it: explicit under the momentum load, which is implicit by itself; iterated under the pressure jump, which is
    not.
    """
    coupler = next((units[kind] for kind in COUPLERS if kind in units), None)
    if "body" in units:
        guards = (coupling and coupling.guards) or (None if foreign else Guards())
        carried = {name: unit for name, unit in units.items() if name not in ("body", *COUPLERS)}
        return Flight(units["body"], carried, coupler, guards)
    if coupler is None or len(units) == 1:
        (unit,) = units.values()
        return SingleUnit(unit)
    fluid, rods = coupler, [unit for name, unit in units.items() if name not in COUPLERS]
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
        made, name = Iterated(rods, fluid, scheme.iterated), f"iterated, {scheme.iterated.acceleration}"
    else:
        made = (Explicit if scheme == "explicit" else ParallelExplicit)(rods, fluid, guards)
        name = scheme
    made.foreign = [unit for name, unit in units.items() if name in foreign]
    only = f"the {'wing' if 'wing' in units else 'rod'} has no other input"
    made.choice = Choice(load, reason_of(rods) or only, name, reason)
    return made
