"""The numerical parameters of a scene, and the runs that show their errors.

The first parameter that a scene has is refined in a sequence: `cells`, with the steps in proportion, or else
`segments`, `mesh` or `step`: from coarse settings, where a run is cheap, to the scene's and on. Each of the others
changes once, on a coarse setting of the first.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from nervure.errors import InputError, SceneError
from nervure.library import check
from nervure.scene import Scene, text
from nervure.scene.solids import box_ends
from nervure.scene.types import FineBox, MiddleBox
from nervure.simulation.ranges import is_fast
from nervure.simulation.verified import free_axes, is_part, sizes, triangles_along

ROOT2 = math.sqrt(2)
LEVELS = (2 * ROOT2, 2.0, ROOT2)  # Sizes of the first parameter, relative to the scene, from the coarsest and cheapest
HALVES, MANY = (8.0, 4.0, 2.0), 64  # The same from so many segments on, for a scene without a fluid
FINEST = 0.5  # Size of the first parameter down to which two runs are sought where coarse ones are impossible
STRETCH = 0.25  # Part of the cells of an axis that a larger box has more at each end
NEAR = 0.15  # Largest relative distance of a number of cells from the wanted one
SMALL = (2, 3, 5, 7)  # Prime factors that are preferred
Changes = dict[str, Any]


@dataclass(frozen=True)
class Parameter:
    """A numerical parameter that a scene has."""

    name: str
    other: float  # Relative size of the run beside the scene's
    outward: float  # The same of a further run towards smaller errors


PARAMETERS = (
    Parameter("cells", 2.0, 1 / ROOT2),
    Parameter("segments", 2.0, 0.5),
    Parameter("mesh", 2.0, 0.5),
    Parameter("step", 2.0, 0.5),
    Parameter("c_eta", 2.0, 0.5),
    Parameter("box", 1 / (1 + 2 * STRETCH), 1 / (1 + 2 * STRETCH) ** 2),
    Parameter("ratio", 2.0, 0.5),
    Parameter("fine_box", 1 / (1 + STRETCH), 1 / (1 + STRETCH) ** 2),
)
"""In the order in which they are tried. Of a fluid, the step is halved: its coarsest run has the largest CFL number."""

Factors = Mapping[str, float]  # Wanted relative sizes by parameter; absent ones are 1


@dataclass(frozen=True)
class Setting:
    """A run of a verification."""

    name: str  # Folder
    scene: Scene
    factors: Factors  # Wanted
    sizes: Factors  # Reached: relative sizes by parameter, of those that a scene has
    work: float  # Unknowns times steps


class Plan:
    """The parameters of a scene and its settings. `left_out` says why a parameter is not varied."""

    def __init__(self, scene: Scene, only: Sequence[str] = ()):
        self.scene, self.sizes = scene, sizes(scene)
        self.left_out: dict[str, str] = {}
        known = [one.name for one in PARAMETERS]
        if wrong := [name for name in only if name not in known]:
            raise InputError(f"the parameter `{wrong[0]}` is unknown: there are {', '.join(known)}")
        self.parameters = [one for one in PARAMETERS if one.name in self.sizes and (not only or one.name in only)]
        if "cells" in self.sizes:
            self.parameters = [replace(p, other=0.5) if p.name == "step" else p for p in self.parameters]
        if not self.parameters:
            has = f"it has {', '.join(self.sizes)}" if self.sizes else "it has none"
            raise InputError(f"there is nothing to vary in {scene.name}: of the parameters {', '.join(known)} {has}")
        self._begin()

    def _begin(self) -> None:
        self.first, *self.others = self.parameters
        many = "cells" not in self.sizes and 1 / self.sizes.get(self.first.name, 1.0) >= MANY
        self.levels = HALVES if many else LEVELS
        self.ratio = self.levels[-2] / self.levels[-1]

    def skip_first(self) -> None:
        """Vary the next parameter in a sequence, as the first one cannot be; raise `InputError` after the last."""
        self.left_out[self.first.name] = "no two of its runs are possible"
        if not self.others:
            why = "; ".join(f"{name}: {own}" for name, own in self.left_out.items())
            raise InputError(f"no run beside {self.scene.name} is possible: {why}; `--parameters` chooses others")
        self.parameters = self.others
        self._begin()

    def setting(self, factors: Factors) -> Setting:
        """Return the run with the wanted relative sizes; raise `SceneError` where the scene cannot have them."""
        scene = self.scene
        for name, factor in factors.items():
            if factor != 1.0:
                scene = scene.copy(VARY[name](scene, factor))
        if faults := check(text(scene)):
            raise SceneError(faults[0].text, faults)
        reached = {name: size / self.sizes[name] for name, size in sizes(scene).items() if name in self.sizes}
        named = [f"{name}={factor:.3g}" for name, factor in factors.items() if factor != 1.0]
        return Setting(",".join(named) or "scene", scene, factors, reached, work(scene))

    def first_settings(self, top: float = 1.0) -> Iterator[Setting]:
        """Yield coarse settings of the first parameter, the finest `top` times as fine as those for the scene itself,
        and of the others on the coarsest. Where fewer than two are possible, finer ones follow. The step waits: it
        follows the cells, and only shows what part it has."""
        known: list[Factors] = []
        sizes = [top * level for level in self.levels]
        while sizes[-1] > FINEST * (1 + 1e-6):
            sizes.append(round(sizes[-1] / self.ratio, 6))
        for number, size in enumerate(sizes):
            if number >= len(self.levels) and len(known) > 1:
                break
            try:
                found = self.setting({self.first.name: size})
            except SceneError as error:
                if number > 0:
                    self.left_out[f"{self.first.name} x {size:.3g}"] = str(error)
                continue
            if found.sizes not in known:
                yield found
                if not known:
                    others = [one for one in self.others if not is_part(one.name, self.sizes)]
                    yield from self.beside(found, others)
                known.append(found.sizes)

    def beside(self, base: Setting, others: Iterable[Parameter]) -> Iterator[Setting]:
        """Yield the settings in which one of `others` differs from `base`, towards smaller errors where it cannot be
        the other way."""
        for other in others:
            for factor in (other.other, other.outward):
                try:
                    yield self.setting({**base.factors, other.name: factor})
                except SceneError as error:
                    self.left_out.setdefault(other.name, str(error))
                else:
                    self.left_out.pop(other.name, None)
                    break


def work(scene: Scene) -> float:
    """Return a number in proportion to the time of a run: unknowns times steps."""
    steps = scene.time.end / scene.time.communication_step
    unknowns = float(OVERHEAD)
    if fluid := scene.fluid:
        steps *= max(1.0, scene.time.communication_step / fluid.time_stepping.max_step)
        cells = float(math.prod(fluid.box.cells))
        large = cells
        smaller: tuple[FineBox | MiddleBox | None, ...] = (fluid.fine_box, fluid.middle_box)
        for own in smaller:
            if own is None:
                continue
            ends = [end for end in (own.x, own.y, own.z) if end]
            parts = ((b - a) / (d - c) for (a, b), (c, d) in zip(ends, box_ends(fluid), strict=True))
            cells += math.prod(parts) * large * own.ratio ** len(fluid.box.cells)
        unknowns += cells * len(fluid.box.cells) / 2
    unknowns += PER_SEGMENT * sum(own.beam.segments for own in scene.rods)
    unknowns += PER_SEGMENT * scene.beam.segments if scene.beam and scene.rod else 0
    unknowns += PER_TRIANGLE * (triangles_along(scene) or 0) ** 2
    return steps * unknowns


OVERHEAD, PER_SEGMENT, PER_TRIANGLE = 500, 20, 100  # Of a step, in cells of the plane


def _vary_cells(scene: Scene, factor: float) -> Changes:
    """Return the changes to cells of other length, and to steps in the same proportion."""
    assert scene.fluid, "cells are those of a fluid"
    cells = scaled(list(scene.fluid.box.cells), 1 / factor)
    reached = math.prod(old / new for old, new in zip(scene.fluid.box.cells, cells, strict=True)) ** (1 / len(cells))
    return {"fluid.box.cells": cells, **_vary_step(scene, reached)}


def scaled(cells: list[int], factor: float) -> list[int]:
    """Return numbers of cells near `factor` times `cells`, in the same proportions where these allow it, whose
    transforms are fast; even ones stay even, which keeps the place of a body in the middle between the points."""
    unit = math.gcd(*cells)
    even = [n % 2 == 0 for n in cells]
    wanted = factor * unit
    candidates = [[n // unit * k for n in cells] for k in _around(wanted)]
    good = [n for n in candidates if _suits(n, even) and abs(math.log(n[0] / (factor * cells[0]))) < NEAR]
    if good and (best := min(good, key=lambda found: _distance(found[0], factor * cells[0]))):
        return best
    return [
        min(
            (k for k in _around(factor * n) if _suits([k], [keep])),
            key=lambda k, n=n: _distance(k, factor * n),  # type: ignore[misc]
            default=max(8, round(factor * n)),
        )
        for n, keep in zip(cells, even, strict=True)
    ]


def _around(wanted: float) -> range:
    return range(max(1, math.floor(wanted * (1 - NEAR))), math.ceil(wanted * (1 + NEAR)) + 1)


def _suits(cells: list[int], even: list[bool]) -> bool:
    return all(is_fast(n) and (n % 2 == 0 or not keep) for n, keep in zip(cells, even, strict=True))


def _distance(cells: int, wanted: float) -> float:
    """Return the relative distance from a wanted number, larger for more cells and for less fast prime factors."""
    return abs(math.log(cells / wanted)) + 0.01 * (cells > wanted) + 0.02 * (not is_fast(cells, SMALL))


def _vary_step(scene: Scene, factor: float) -> Changes:
    changes: Changes = {"time.communication_step": scene.time.communication_step * factor}
    if scene.fluid:
        changes["fluid.time_stepping.max_step"] = scene.fluid.time_stepping.max_step * factor
    parts = [("rod", scene.rod), ("wing", scene.wing)]
    parts += [(f"rods.{i}.rod", own.rod) for i, own in enumerate(scene.rods)]
    parts += [(f"wings.{i}.wing", own.wing) for i, own in enumerate(scene.wings)]
    return changes | {f"{key}.max_step": part.max_step * factor for key, part in parts if part and part.max_step}


def _vary_segments(scene: Scene, factor: float) -> Changes:
    found = {"beam": scene.beam} if scene.beam and scene.rod else {}
    found |= {f"rods.{i}.beam": own.beam for i, own in enumerate(scene.rods)}
    return {
        f"{key}.segments": max(2, round(beam.segments / factor)) for key, beam in found.items() if not beam.rest_angles
    }


def _vary_mesh(scene: Scene, factor: float) -> Changes:
    assert scene.wing, "the mesh is that of a wing"
    (kind,) = scene.wing.mesh.document()
    return {f"wing.mesh.{kind}.along": max(2, round((triangles_along(scene) or 0) / factor))}


def _vary_c_eta(scene: Scene, factor: float) -> Changes:
    assert scene.fluid, "the mask is that of a fluid"
    ((kind, mask),) = scene.fluid.mask.document().items()
    return {f"fluid.mask.{kind}.c_eta": mask["c_eta"] * factor**2}


def _vary_box(scene: Scene, factor: float) -> Changes:
    """Return the changes to a box of more cells of the same size; zones at its ends move with them."""
    fluid = scene.fluid
    assert fluid, "the box is that of a fluid"
    changes: Changes = {"fluid.box.cells": list(fluid.box.cells)}
    for axis in free_axes(scene):
        low, high = box_ends(fluid)[axis]
        cells = fluid.box.cells[axis]
        wanted = cells / factor
        more = min(
            (n - cells for n in _around(wanted) if is_fast(n) and (n - cells) % 2 == 0 and n > cells),
            key=lambda more: abs(cells + more - wanted),
            default=2 * round((wanted - cells) / 2),
        )
        below = above = more * (high - low) / cells / 2
        if axis == 0 and (inflow := fluid.inflow):  # What lies before an inflow does not matter
            upstream = abs(inflow.x[0] - low) < abs(high - inflow.x[1])
            below, above = (0.0, 2 * above) if upstream else (2 * below, 0.0)
            if not upstream:
                changes["fluid.inflow.x"] = list(inflow.x)
        changes[f"fluid.box.{'xyz'[axis]}"] = [low - below, high + above]
        changes["fluid.box.cells"][axis] = cells + more
        if axis == 0 and (sponge := fluid.sponge):
            moved = above if abs(high - sponge.x[1]) < abs(sponge.x[0] - low) else -below
            changes["fluid.sponge.x"] = [end + moved for end in sponge.x]
    return changes


def _vary_ratio(scene: Scene, factor: float) -> Changes:
    """Return the changes to a coarser large grid around the same fine one."""
    assert scene.fluid and scene.fluid.fine_box, "the ratio is that of a fine box"
    ratio = max(1, round(scene.fluid.fine_box.ratio * factor))
    reached = ratio / scene.fluid.fine_box.ratio
    changes: Changes = {"fluid.fine_box.ratio": ratio}
    if middle := scene.fluid.middle_box:
        changes["fluid.middle_box.ratio"] = round(middle.ratio * reached)
    return changes | {"fluid.box.cells": [round(n / reached) for n in scene.fluid.box.cells]}


def _vary_fine_box(scene: Scene, factor: float) -> Changes:
    assert scene.fluid and scene.fluid.fine_box, "a scene has a fine box"
    changes = Changes()
    for axis, (low, high) in zip("xyz", box_ends(scene.fluid), strict=False):
        own = getattr(scene.fluid.fine_box, axis)
        more = (own[1] - own[0]) * (1 / factor - 1) / 2
        edge = (high - low) / 32
        for name in ("fine_box", "middle_box"):
            if ends := getattr(getattr(scene.fluid, name), axis, None):
                wider = [max(ends[0] - more, low + edge), min(ends[1] + more, high - edge)]
                changes[f"fluid.{name}.{axis}"] = wider
    return changes


VARY: dict[str, Callable[[Scene, float], Changes]] = {
    "cells": _vary_cells,
    "segments": _vary_segments,
    "mesh": _vary_mesh,
    "step": _vary_step,
    "c_eta": _vary_c_eta,
    "box": _vary_box,
    "ratio": _vary_ratio,
    "fine_box": _vary_fine_box,
}
"""Functions of a scene and a relative size: the changes to it."""
