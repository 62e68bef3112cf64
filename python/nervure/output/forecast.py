"""Forecast of a run: dimensionless numbers, resolution, steps, wall time and memory.

The first steps of the run measure the machine: only they have its mix of transforms, solves and Python.
"""

import os
from collections.abc import Iterator
from pathlib import Path

from nervure.errors import UnitError
from nervure.scene import wings
from nervure.scene.facts import Facts
from nervure.simulation.loop import Observer, TimeGrid, TimeLoop
from nervure.simulation.ranges import across
from nervure.simulation.session import Session

WARM_UP = 2  # Steps before the timing: the first has no history, the second no cached code
TIMED = 0.5  # Wall time of the timed steps, s


def scheme_rows(session: Session) -> Iterator[tuple[str, str]]:
    """Yield load and scheme, by name."""
    if choice := session.scheme.choice:
        yield "load", f"{choice.load}: {choice.load_reason}"
        yield "scheme", f"{choice.scheme}: {choice.scheme_reason}"


def scene_rows(facts: Facts) -> Iterator[tuple[str, str]]:
    """Yield flow, beam, resolution and steps of a scene, by name."""
    scene, numbers = facts.scene, facts.numbers
    grid = TimeGrid(scene.time.end, scene.time.communication_step)
    steps = f"{grid.steps} of {grid.communication_step:g} s to {grid.end:g} s"
    if scene.fluid is None or numbers is None:
        yield "steps", steps
        return
    if numbers.velocity is None:
        yield "flow", "nothing drives it"
    else:
        parts = [f"U {numbers.velocity:.3g} m/s ({numbers.velocity_of})"]
        if numbers.reynolds is not None:
            parts = [f"Re {numbers.reynolds:.3g}", *parts, f"L {numbers.length:.3g} m ({numbers.length_of})"]
        if numbers.reduced_frequency is not None:
            parts.append(f"reduced frequency {numbers.reduced_frequency:.3g}")
        yield "flow", ", ".join(parts)
    if numbers.mass_ratio is not None:
        parts = [f"mass ratio {numbers.mass_ratio:.3g}"]
        if numbers.stiffness is not None:
            parts.append(f"stiffness number {numbers.stiffness:.3g}")
        weight = numbers.density_ratio and f"{numbers.density_ratio:.3g} of the mass of the fluid it displaces"
        of_rod = bool(wings(scene))  # The other numbers are then of the wing
        if weight and not of_rod:
            parts.append(weight)
        parts.append(f"added mass {numbers.added_mass_ratio:.3g} of its own")
        yield "wing" if of_rod else "beam", ", ".join(parts)
        if weight and of_rod:
            yield "rod", weight
    for name, mount in numbers.mounts.items():
        parts = [] if mount.mass_ratio is None else [f"mass ratio {mount.mass_ratio:.3g}"]
        for direction, support in mount.supports.items():
            frequency = support.natural_frequency
            own = f"{direction}: f_n {frequency:.3g} Hz" if frequency else f"{direction}: free"
            if support.damping_ratio is not None:
                own += f", damping ratio {support.damping_ratio:.3g}"
            if support.reduced_velocity is not None:
                own += f", reduced velocity {support.reduced_velocity:.3g}"
            parts.append(own)
        yield f"mount of {name}", "; ".join(parts)
    for name, body in numbers.bodies.items():
        layer = "" if body.layer_cells is None else f", {body.layer_cells:.2g} in the layer at the front"
        kind = "line" if scene.fluid.box.z is None or name.startswith("beam") else "surface"
        line = f"; the fluid meets it as a {kind}" if name in facts.lines else ""
        cells = ({across(name): body.thickness_cells} if body.thickness_cells else {}) | body.along
        shown = ", ".join(f"{count:.3g} in the {side}" for side, count in cells.items()) or "no thickness"
        yield f"cells of {name}", f"{shown}{layer}{line}"
    if numbers.cfl is not None:
        each, largest = facts.fluid_steps, scene.fluid.time_stepping.max_cfl
        divided = f", in which the fluid makes up to {each}" if each > 1 else ""
        steps += f"{divided}; CFL number about {min(numbers.cfl, largest):.2g}, at most {largest:g}"
    yield "steps", steps


class Pace(Observer):
    """Estimates the wall time of a whole run from its first steps.

    At the start the flow is slow: a step of the fluid that is expected to be divided later counts as often.
    """

    def __init__(self, session: Session):
        self.fluid, self.factor, self.steps = session.units.get("fluid"), session.facts.fluid_steps, session.grid.steps
        self.first: int | None = None
        self.begin: tuple[int, float, float] | None = None  # Steps, wall time, and the time of the fluid, s
        self.timed = 0.0  # Wall time of the steps that were timed, s
        self.total: float | None = None  # Wall time of the whole run, s; None while too few steps were timed

    def step(self, loop: TimeLoop) -> None:
        self.see(loop.steps, loop.wall)

    def see(self, done: int, wall: float) -> None:
        """Take the wall time (s) after `done` steps."""
        inside = self.fluid.seconds if self.fluid else 0.0
        if self.first is None:
            self.first = done
        if self.begin is None:
            if done - self.first >= WARM_UP:
                self.begin = done, wall, inside
            return
        made, self.timed = done - self.begin[0], wall - self.begin[1]
        self.total = (self.timed + (self.factor - 1) * (inside - self.begin[2])) / made * self.steps


def measured(session: Session, timed: float) -> float:
    """Return the wall time of a whole run, s, from first steps that take `timed` (s); raise `UnitError` where one of
    them fails."""
    pace = Pace(session)
    session.observers = [pace]
    status = session.run(stopping=lambda: pace.total is not None and session.wall > timed)
    if status.error is not None:
        raise UnitError(status.error)
    return status.wall if status.completed or pace.total is None else pace.total


def cost(wall: float) -> str:
    """Return wall time and memory in words."""
    memory = resident_memory()
    held = f", {memory / 1e6:.0f} MB of memory with Python and its packages" if memory else ""
    return f"about {duration(wall)} of wall time on this machine{held}"


def duration(seconds: float) -> str:
    """Return a time with two digits, in a fitting unit."""
    for limit, unit, name in ((120.0, 1.0, "s"), (7200.0, 60.0, "min"), (172800.0, 3600.0, "h")):
        if seconds < limit:
            return f"{seconds / unit:.2g} {name}" if seconds / unit < 99.5 else f"{seconds / unit:.0f} {name}"
    return f"{seconds / 86400:.0f} days"


def resident_memory() -> int:
    """Return the resident memory of this process, bytes; 0 on other systems than Linux."""
    pages = Path("/proc/self/statm")
    return int(pages.read_text(encoding="utf-8").split()[1]) * os.sysconf("SC_PAGE_SIZE") if pages.exists() else 0
