"""Warnings about a scene before its run: doubtful input, numbers outside of tested ranges, and what is slow.

`docs/guide/warnings.md` has the sources of the ranges.
"""

from collections.abc import Iterator, Sequence
from itertools import count

from nervure.evaluate import benchmark
from nervure.scene import wings
from nervure.scene.facts import Body, Facts
from nervure.scene.solids import cell_lengths, counts_of
from nervure.simulation.places import counted

ROUNDING = 1e-9  # Relative tolerance of a limit

FACTORS = (2, 3, 5, 7, 11, 13)  # Prime factors with a transform of their own
OBLONG = 1.5  # Longest side of a cell by the shortest: with 2 the flow in a channel is 9 % off beside the wall
THICKNESS_CELLS, GOOD_CELLS = 2.5, 5  # Cells in a thickness: least, and for forces within some per cent
LINE_CELLS = 4  # Cells in a beam's thickness from which on its mask makes as little noise as a line, 2 %
LARGE_CELLS, SHEDS = 6, 47.0  # Least large cells across what sheds vortices, at a larger Re
LAYER_CELLS = 0.8  # Least cells in the boundary layer at the front of a cylinder
REYNOLDS = (20.0, 200.0)  # Range with published values
DENSITY_RATIO = (0.01, 1000.0)  # Range of the map of the coupling
SOFTNESS = 1e-3  # Largest C_eta U / L
SEGMENTS_PER_S, LONG_S = 3000, 5.0  # Segments whose FMU is packed and read in a second, and time to mention, s
SEGMENT = 0.25  # Least length of a segment, in thicknesses


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
    if fine and is_masked and numbers.length and len(sides) == 2 and (numbers.reynolds or 0.0) > SHEDS:
        cell = sides[long] / (middle.ratio if middle else 1)
        if numbers.length < LARGE_CELLS * cell * (1 - ROUNDING):
            off = f"with 4 swings of lift were 4 to 12 % off, with {LARGE_CELLS} within 1 %; a smaller `ratio` helps"
            yield f"the wake has {numbers.length / cell:.3g} large cells to the length of what sheds it: {off}"
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
        few = f"{body.thickness_cells:.3g} cells in the {across(name)} of {name}"
        line = "; `surface: line` is steadier if it stands for a thin sheet" if is_beam else ""
        wanted = f"a first look wants {THICKNESS_CELLS:g}, forces within some per cent {GOOD_CELLS}"
        if body.thickness_cells >= THICKNESS_CELLS:
            wanted = f"forces within some per cent want {GOOD_CELLS}"
        yield f"{few} are few: {wanted}{line}"
    if not is_beam and body.layer_cells is not None and body.layer_cells < LAYER_CELLS:
        layer = f"the boundary layer at the front of {name} has {body.layer_cells:.3g} cells"
        yield f"{layer}; with less than {LAYER_CELLS:g} drag can be off by some per cent and lift by ten"


def across(name: str) -> str:
    """Return the word for the thickness of a body of this name."""
    return "diameter" if name.startswith("cylinder") else "thickness"


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] * (1 - ROUNDING) <= value <= limits[1] * (1 + ROUNDING)
