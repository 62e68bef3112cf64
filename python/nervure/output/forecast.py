"""Forecast of a run: dimensionless numbers, resolution, steps, warnings, wall time and memory.

The first steps of the run measure the machine: only they have its mix of transforms, solves and Python.
`docs/guide/warnings.md` has the sources of the ranges.
"""

import os
from collections.abc import Iterator, Sequence
from itertools import count
from pathlib import Path

from nervure.errors import UnitError
from nervure.evaluate import benchmark
from nervure.scene import wings
from nervure.scene.facts import Body, Facts
from nervure.scene.solids import cell_lengths, counts_of
from nervure.simulation.loop import Observer, TimeGrid, TimeLoop
from nervure.simulation.places import counted
from nervure.simulation.session import Session

WARM_UP = 2  # Steps before the timing: the first has no history, the second no cached code
TIMED = 0.5  # Wall time of the timed steps, s
ROUNDING = 1e-9  # Relative tolerance of a limit

FACTORS = (2, 3, 5, 7, 11, 13)  # Prime factors with a transform of their own
OBLONG = 1.5  # Longest side of a cell by the shortest: with 2 the flow in a channel is 9 % off beside the wall
THICKNESS_CELLS, GOOD_CELLS = 2.5, 5  # Cells in a thickness: least, and for forces within some per cent
LINE_CELLS = 4  # Cells in a beam's thickness from which on its mask makes as little noise as a line, 2 %
LAYER_CELLS = 0.8  # Least cells in the boundary layer at the front of a cylinder
REYNOLDS = (20.0, 200.0)  # Range with published values
DENSITY_RATIO = (0.01, 1000.0)  # Range of the map of the coupling
SOFTNESS = 1e-3  # Largest C_eta U / L
SEGMENTS_PER_S, LONG_S = 3000, 5.0  # Segments whose FMU is packed and read in a second, and time to mention, s
SEGMENT = 0.25  # Least length of a segment, in thicknesses


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
        line = "; the fluid meets it as a line" if name in facts.lines else ""
        across = f"{body.thickness_cells:.3g} in the {_across(name)}" if body.thickness_cells else "no thickness"
        yield f"cells of {name}", f"{across}{layer}{line}"
    if numbers.cfl is not None:
        each, largest = facts.fluid_steps, scene.fluid.time_stepping.max_cfl
        divided = f", in which the fluid makes up to {each}" if each > 1 else ""
        steps += f"{divided}; CFL number about {min(numbers.cfl, largest):.2g}, at most {largest:g}"
    yield "steps", steps


def warnings(facts: Facts) -> Iterator[str]:
    """Yield what may be a mistake in a scene, where it is outside of the tested ranges of the method, or slower than it
    has to be; of many warnings of one kind one with their number."""
    yield from counted(_warnings(facts))


def _warnings(facts: Facts) -> Iterator[str]:
    yield from facts.warnings
    for own in facts.beams:
        if (seconds := own.beam.segments / SEGMENTS_PER_S) > LONG_S:
            yield f"{own.beam.segments} segments take about {seconds:.0f} s to pack and to load, before the first step"
    scene, numbers = facts.scene, facts.numbers
    if scene.fluid is None:
        return
    grids: list[tuple[str, int, Sequence[int]]] = [("", 1, scene.fluid.box.cells)]
    if middle := scene.fluid.middle_box:
        grids.append((" of the middle box", middle.ratio, counts_of(middle, scene.fluid)))
    if fine := scene.fluid.fine_box:
        grids.append((" of the fine box", fine.ratio, counts_of(fine, scene.fluid)))
    for whose, unit, counts in grids:
        for axis, cells in zip("xyz", counts, strict=False):
            if not is_fast(cells):
                below, above = (next(filter(is_fast, count(cells, step))) for step in (-unit, unit))
                cause = f"{cells} cells{whose} along {axis} have a prime factor above {FACTORS[-1]}"
                yield f"{cause}, with which transforms take about three times as long; {below} and {above} have none"
    # A run of a benchmark shows the errors that these ranges are about.
    is_compared = scene.reference is not None and not benchmark.changed(scene)
    sides = dict(zip("xyz", cell_lengths(scene.fluid), strict=False))
    long, short = (pick(sides, key=lambda axis: sides[axis]) for pick in (max, min))
    solids = {f"body_{i + 1}" for i in range(len(scene.fluid.bodies))} | {own.force for own in facts.beams}
    is_masked = bool(scene.fluid.channel or scene.fluid.cylinders or solids - facts.lines)
    if is_masked and not is_compared and sides[long] > OBLONG * sides[short]:
        times = f"{sides[long] / sides[short]:.3g} times as long along {long} as along {short}"
        yield f"cells are {times}; a mask is blurred over the longer side: finer cells along {long} help"
    if numbers is None:
        return
    lines = facts.lines
    for name, body in numbers.bodies.items():
        if name not in lines and not is_compared:
            yield from _unresolved(name, body)
    if numbers.reynolds is not None and not _within(numbers.reynolds, REYNOLDS):
        low, high = REYNOLDS
        yield f"Re is {numbers.reynolds:.3g}; forces were compared with published ones from {low:g} to {high:g}"
    low, high = DENSITY_RATIO
    bear_any = lines.issuperset(own.force for own in facts.beams)  # A line bears a rod of any mass
    ratio = None if bear_any else numbers.density_ratio
    if ratio is not None and not _within(ratio, DENSITY_RATIO):
        yield f"the rod weighs {ratio:.3g} of the fluid it displaces; the coupling was tried from {low:g} to {high:g}"
    elif ratio is not None and ratio < 1 and scene.fluid.precision == "single":
        yield f"the rod weighs {ratio:.3g} of the fluid it displaces, which wants `precision` double to converge"
    if numbers.velocity and numbers.length and not wings(scene):
        (mask,) = scene.fluid.mask.document().values()
        softness = mask["c_eta"] * numbers.velocity / numbers.length
        if softness > SOFTNESS * (1 + ROUNDING):
            yield f"the mask is soft: C_eta U/L is {softness:.2g}; above {SOFTNESS:g} forces can be off by 10 %"
    for own in facts.beams:
        ratio = own.beam.length / own.beam.segments / facts.thickness[own.force].max()
        if own.force not in lines and ratio < SEGMENT * (1 - ROUNDING):
            whose = f"segments of the rod {own.unit}" if own.prefix else "segments"
            yield f"{whose} are {ratio:.2g} thicknesses long; a run of less than {SEGMENT:g} can end in an error"


def is_fast(cells: int, factors: Sequence[int] = FACTORS) -> bool:
    """Return whether a number of cells has only the prime `factors`."""
    for factor in factors:
        while cells % factor == 0:
            cells //= factor
    return cells == 1


def _unresolved(name: str, body: Body) -> Iterator[str]:
    is_beam = name.startswith("beam")
    if body.thickness_cells < (LINE_CELLS if is_beam else THICKNESS_CELLS):
        across = f"{body.thickness_cells:.3g} cells in the {_across(name)} of {name}"
        line = "; `surface: line` is steadier if it stands for a thin sheet" if is_beam else ""
        wanted = f"a first look wants {THICKNESS_CELLS:g}, forces within some per cent {GOOD_CELLS}"
        if body.thickness_cells >= THICKNESS_CELLS:
            wanted = f"forces within some per cent want {GOOD_CELLS}"
        yield f"{across} are few: {wanted}{line}"
    if not is_beam and body.layer_cells is not None and body.layer_cells < LAYER_CELLS:
        layer = f"the boundary layer at the front of {name} has {body.layer_cells:.3g} cells"
        yield f"{layer}; with less than {LAYER_CELLS:g} drag can be off by some per cent and lift by ten"


def _across(name: str) -> str:
    return "diameter" if name.startswith("cylinder") else "thickness"


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] * (1 - ROUNDING) <= value <= limits[1] * (1 + ROUNDING)


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
