"""The summary of a run: each class has the keys of a part of summary.json, in order.

A field with the default None is left out of the file where it is None.
"""

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from nervure.coupling import Choice, Scheme
from nervure.coupling.guards import REST, WARN_RATIO
from nervure.evaluate import benchmark, bodies, coefficients, flapping, statistics
from nervure.evaluate.bodies import BodyCoefficients
from nervure.evaluate.rods import columns_of_units
from nervure.evaluate.statistics import Series
from nervure.files import json_numbers
from nervure.provenance import Machine, Revision, git_revision, machine, versions
from nervure.scene import Scene, column_names, wings
from nervure.scene.facts import Dimensionless, Facts
from nervure.scene.types import Reference
from nervure.simulation import ranges
from nervure.simulation.recorder import Recorder
from nervure.simulation.verified import Bar
from nervure.units.describe import unit_label
from nervure.units.fmu import Unit

Parts = dict[str, tuple[str, Series]]  # Of the units of wings and rods: the fluid's name, and the columns

TIP = ("tip_ux", "tip_uy", "tip_uz")
"""Evaluated outputs of a rod."""

PERIODIC = 0.1  # Largest `amplitude_drift` for a comparison with published values of a periodic state
STEADY = 0.05  # Largest amplitude by mean for a comparison with published values of a steady state

COMPARED_PERIODS = 4  # Fewest periods for a comparison with published values of a periodic state
MOTION = re.compile(r"(body_\d+)_(x|y|z|angle|angle_[xyz])")  # Columns of the motion of a rigid body
FORCES = flapping.FORCES  # Evaluated outputs of the fluid, under a box filter
SECTION = ("section_twist", "section_camber")  # Evaluated outputs of a wing


@dataclass(frozen=True)
class RunStatus:
    """The end of a run and the cost of its loop."""

    steps: int
    simulated: float  # Time reached, s
    wall: float  # Wall time, s
    cpu: float | None  # Processor time, s; None after a resumption
    completed: bool
    error: str | None

    @property
    def stopped(self) -> bool:
        """Whether the run was asked to stop."""
        return not self.completed and self.error is None


@dataclass(frozen=True)
class Published:
    """Published values of a quantity, in its unit; a value that the source lacks is None."""

    mean: float | None = None
    amplitude: float | None = None
    frequency_hz: float | None = None
    source: str = ""


@dataclass(frozen=True)
class Quantity(statistics.Statistics):
    """A recorded output over the window."""

    unit: str
    state: statistics.State
    drift: float | None  # Change of mean or amplitude over the window, relative to the amplitude; None without periods
    noise: (
        float | None
    )  # Rms above the own harmonics, before any filter, relative to the variation; None without periods
    fit: statistics.Statistics | None  # Statistics of the least-squares harmonics; None without an oscillation
    reference: Published | None = None


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of a still cylinder, and their published values."""

    values: dict[str, float]
    reference: dict[str, float]
    source: str | None


@dataclass(frozen=True)
class Method:
    """Method behind the numbers."""

    coupling: Choice | None
    communication_step_s: float
    statistics: str
    amplitude_drift: str


@dataclass(frozen=True)
class Interface:
    """Work across the interface, J, in the plane per metre of depth: from the powers on the rod and of the fluid."""

    work_on_rod: float
    work_by_fluid: float
    exchanged: float  # Sum of the magnitudes
    imbalance: float | None  # Difference of the two works, relative to `exchanged`; None where these are rounding


@dataclass(frozen=True)
class OfRod:
    """Results of one of several rods and wings."""

    flapping: flapping.Flapping | None  # None where no root is driven
    interface: Interface | None  # None where a unit has no output of its power


@dataclass(frozen=True)
class OfWing:
    """Averages of a wing, or sums of those of all, over the window; None for what the run does not have."""

    drag: float | None  # Force of the fluid along x, N
    lift: float | None  # Along y, N
    side: float | None  # Along z, N
    root_power: float | None  # Power of the drive at the root, W
    load_power: float | None  # Power of the loads on the wing, W
    damping_power: float | None  # Power lost in the wing, W


def of_wings(wings: Collection[Series], window: statistics.Window) -> OfWing | None:
    """Sum the averages over `window` of the outputs of wings and of the fluid around them; None without a wing."""

    def mean(name: str) -> float | None:
        known = [flapping.average(own["time"], own[name], window) for own in wings if name in own]
        return sum(known) if known else None

    forces = (mean(f"beam_{name}") for name in FORCES)
    return OfWing(*forces, *(mean(f"{name}_power") for name in ("root", "load", "damping"))) if wings else None


@dataclass(frozen=True)
class UnitInfo:
    """A unit, from its model description."""

    model: str
    version: str | None
    generation_tool: str | None
    guid: str


@dataclass(frozen=True)
class Summary:
    """Summary of a run."""

    scene: str
    completed: bool
    error: str | None
    quantities: dict[str, Quantity]
    dimensionless: Dimensionless | None  # None without a fluid
    bodies: dict[str, BodyCoefficients]  # Empty where nothing drives the flow
    coefficients: Coefficients | None  # None where the scene is not one still cylinder in an inflow
    flapping: flapping.Flapping | None  # None where no root is driven
    window_s: tuple[float, float] | None  # Evaluated window, s; None without a signal
    periods: int  # Whole periods in the window; 0 without an oscillation
    amplitude_drift: float | None
    not_compared: str | None  # Why published values do not apply; None where they do
    method: Method
    interface: Interface | None  # None where a unit has no output of its power
    simulated_s: float
    wall_s: float
    cpu_s: float | None  # None after a resumption
    wall_s_per_simulated_s: float | None
    steps: int
    iterations_mean: float | None
    phases_s: dict[str, float]  # Wall time by its use, s
    units: dict[str, UnitInfo]
    series: dict[str, str | None]  # Unit of each column of series.csv
    versions: dict[str, str]
    git: Revision | None
    machine: Machine
    warnings: list[str] | None = None  # What may be a mistake, before the run and in it; None without
    wing: OfWing | None = None  # None without a wing, and without a window
    wings: dict[str, OfRod] | None = None  # By name, as `rods`
    rods: dict[str, OfRod] | None = None  # By name; None for one rod or wing alone, of which `flapping` has the values
    verified: dict[str, Bar] | None = None  # By quantity, e.g. `lift_mean`; None where this physics was not verified

    @property
    def window(self) -> statistics.Window | None:
        """The evaluated window."""
        return statistics.Window(*self.window_s, self.periods) if self.window_s else None

    def document(self) -> dict[str, Any]:
        """Return the content of summary.json."""
        kept: dict[str, Any] = json_numbers(adapter().dump_python(self, exclude_defaults=True))
        return kept


@cache
def adapter() -> TypeAdapter[Summary]:
    """Return the reader and writer of summaries: to make it takes as long as a short run."""
    return TypeAdapter(Summary)


def quantities(facts: Facts) -> list[str]:
    """Return the columns that are evaluated, as far as a run has them."""
    prefixes = prefixes_of_tips(facts.scene) or [""]
    mounts = facts.numbers.mounts if facts.numbers else {}
    supports = [(body, *own) for body, mount in mounts.items() for own in mount.supports.items()]
    moved = [f"{body}_{direction}" for body, direction, _ in supports]
    # Where no spring holds a body, it may fall.
    moved += [f"{body}_v{direction}" for body, direction, support in supports if not support.natural_frequency]
    each = (f"{force}_{end}" for prefix, force in column_names(facts.scene).values() if prefix for end in FORCES)
    return [*(prefix + name for prefix in prefixes for name in (*TIP, *SECTION)), *moved, *each, *FORCES]


def prefixes_of_tips(scene: Scene) -> list[str]:
    """Return the beginnings of the columns of the tips that are evaluated: not of the wings that a flyer carries
    along."""
    carried = wings(scene) if scene.flyer else {}
    return [prefix for unit, (prefix, _) in column_names(scene).items() if not (prefix and unit in carried)]


def is_force(name: str) -> bool:
    """Return whether a column is a force of the fluid."""
    return name.rpartition("_")[2] in FORCES


@dataclass(frozen=True)
class MainSignal:
    """The signal that decides on the periods."""

    name: str
    values: np.ndarray
    drive: np.ndarray | None = None  # The prescribed motion that it follows; None without a drive
    smallest: float = 0.0  # Largest amplitude that is rounding


def main_signal(series: Series, rounding: float = statistics.ROUNDING["double"]) -> MainSignal | None:
    """Return the signal that decides on the periods, along its principal direction: the path of the tip, or without a
    rod that of a body on springs, or else the force. A driven root or a driven rigid body sets the period; `rounding`
    is the part of a signal's largest value that rounding may move."""
    time, forces = series["time"], _forces(series)
    tip, rigid = flapping.path(series, "tip"), flapping.path(series, "rigid_tip")
    if tip is not None:
        drive = _along(time, rigid) if rigid is not None and np.ptp(rigid) > 0 else None
        smallest = statistics.ROUNDING["double"] * float(np.abs(tip).max())
        return MainSignal("tip", _along(time, tip), drive, smallest)
    if forces is None:
        return None
    if (response := _motion(series, mounted=True)) is not None:
        smallest = rounding * float(np.abs(response).max())
        return MainSignal("displacement", response, _motion(series), smallest)
    smallest = rounding * float(np.linalg.norm(forces, axis=0)[statistics.last_third(time).of(time)].max())
    return MainSignal("force", _along(time, forces), _motion(series), smallest)


def _forces(series: Series) -> np.ndarray | None:
    """Return drag, lift and in space side, `[axes, samples]`; None without a fluid."""
    found = [series[name] for name in FORCES if name in series]
    return np.array(found) if len(found) > 1 else None


def _along(time: np.ndarray, path: np.ndarray) -> np.ndarray:
    """Return the component of a path along its principal direction."""
    component: np.ndarray = statistics.principal_direction(time, path) @ path
    return component


def _motion(series: Series, mounted: bool = False) -> np.ndarray | None:
    """Return the prescribed motion of the first rigid body that moves at the end: of its pivot, or else its angle. With
    `mounted` it is that of a body on springs, whose velocity is recorded too."""
    moving: dict[str, list[str]] = {}
    tail = statistics.last_third(series["time"]).of(series["time"])
    for column in series:
        found = MOTION.fullmatch(column)
        if found and (f"{found[1]}_vx" in series) == mounted and np.ptp(series[column][tail]) > 0:
            moving.setdefault(found[1], []).append(column)
    for columns in moving.values():
        places = [name for name in columns if "_angle" not in name] or columns
        return _along(series["time"], np.array([series[name] for name in places]))
    return None


def _quantity(
    name: str,
    unit: str | None,
    series: Series,
    published: Reference | None,
    window: statistics.Window,
    width: float,
    smallest: float,
) -> Quantity:
    """Evaluate the output `name` over `window`; forces are filtered over `width` (s), and an amplitude of at most
    `smallest` is rounding."""
    time, values, reference = series["time"], series[name], None
    found = statistics.character(time, values, window, smallest)
    if is_force(name):
        extremes, values = statistics.of_force(time, values, window, width), statistics.box_filter(time, values, width)
    else:
        extremes = statistics.evaluate(time, values, window)
    if found.state == "rounding" or extremes.amplitude <= smallest:
        extremes = replace(extremes, frequency_hz=None)
    fit = statistics.fit(time, values, window) if extremes.frequency_hz is not None else None
    if published and (known := published.quantities.get(name)):
        reference = Published(known.mean, known.amplitude, known.frequency_hz, published.source)
    return Quantity(**asdict(extremes), unit=unit or "", **asdict(found), fit=fit, reference=reference)


def smallest_amplitudes(names: Sequence[str], series: Series, rounding: float) -> dict[str, float]:
    """Return the amplitude of each column up to which it is rounding: a part of the largest force or displacement."""
    tail = statistics.last_third(series["time"]).of(series["time"])
    largest = {
        kind: max((float(np.abs(series[name][tail]).max()) for name in names if is_force(name) == kind), default=0.0)
        for kind in (False, True)
    }
    return {
        name: (rounding if is_force(name) else statistics.ROUNDING["double"]) * largest[is_force(name)]
        for name in names
    }


def _main_signal(scene: Scene, series: Series, parts: Parts, rounding: float) -> MainSignal | None:
    """Return the main signal of a run; of several rods and wings the signal of the first, or where they are of both
    kinds that of the first with a driven root."""
    if len(parts) < 2:
        return main_signal(series, rounding)
    signals = [main_signal({**series, **columns}, rounding) for _, columns in parts.values()]
    driven = (signal for signal in signals if signal and signal.drive is not None)
    is_mixed = bool(wings(scene) and (scene.beam or scene.rods))
    return next(driven, signals[0]) if is_mixed else signals[0]


def summarize(
    facts: Facts,
    units: dict[str, Unit],
    scheme: Scheme,
    recorder: Recorder,
    status: RunStatus,
    warnings: Sequence[str] = (),
) -> Summary:
    """Evaluate a run that gave `warnings`, besides those of its scene."""
    scene, series = facts.scene, recorder.series
    time, iterations = series["time"], series["iterations"][1:]
    rounding = statistics.ROUNDING[scene.fluid.precision] if scene.fluid else statistics.ROUNDING["double"]
    parts = columns_of_units(series, scene)
    main = _main_signal(scene, series, parts, rounding) if time.size > 2 else None
    window, settled = None, None
    if main and main.drive is not None:
        window = statistics.driven_window(time, main.values, main.drive)
        if scene.beam or scene.rods or wings(scene):  # What bends in the flow has motions of its own
            window = replace(window, driven=False)
    elif main:
        window = statistics.find_window(time, main.values, main.smallest)
    if main and window:
        settled = statistics.character(time, main.values, window, main.smallest)
    width = statistics.force_filter_width(window) if window else 0.0
    inside = {name: unit.seconds for name, unit in units.items()}
    about = {name: unit.description for name, unit in units.items()}
    changed, known = benchmark.changed(scene), dict[str, Quantity]()
    published = None if changed else scene.reference
    if window:
        names = [name for name in quantities(facts) if name in series]
        resting = [prefix for unit, (prefix, _) in column_names(scene).items() if _rests(parts[unit][1], facts)]
        at_rest = [prefix + name for prefix in resting for name in TIP]
        for name, smallest in smallest_amplitudes(names, series, rounding).items():
            smallest = max(smallest, _smallest_way(facts)) if name in at_rest else smallest
            known[name] = _quantity(name, recorder.units[name], series, published, window, width, smallest)
    reasons = (
        f"changed: {', '.join(changed)}" if changed else "",
        _not_final(scene, status, known, main, window, settled),
    )
    on_fluid, alone = next(iter(parts.values())) if len(parts) == 1 else (None, series)
    return Summary(
        scene=scene.name,
        completed=status.completed,
        error=status.error,
        quantities=known,
        dimensionless=facts.numbers,
        bodies=bodies.evaluate(facts, series, window, width, rounding) if window else {},
        coefficients=_coefficients(facts, published, series, window, width, rounding) if window else None,
        flapping=flapping.evaluate(facts, facts.scales.get(on_fluid), alone, window) if window and on_fluid else None,
        window_s=(window.begin, window.end) if window else None,
        periods=window.periods if window else 0,
        amplitude_drift=settled.drift if settled else None,
        not_compared="; ".join(filter(None, reasons)) or None,
        method=Method(
            coupling=scheme.choice,
            communication_step_s=scene.time.communication_step,
            statistics="mean = (max + min) / 2 and amplitude = (max - min) / 2 over the window, frequency by upward "
            f"crossings of the mean; forces under a box filter of {width * 1e3:.3g} ms; `fit`: the same of the "
            f"least-squares fit of {statistics.HARMONICS} harmonics",
            amplitude_drift=f"change of mean or amplitude of the {main.name if main else 'signal'} along its principal "
            "direction over the window, relative to its amplitude",
        ),
        interface=interface(alone, facts),
        simulated_s=status.simulated,
        wall_s=status.wall,
        cpu_s=status.cpu,
        wall_s_per_simulated_s=status.wall / status.simulated if status.simulated else None,
        steps=status.steps,
        iterations_mean=float(iterations.mean()) if iterations.size else None,
        phases_s=inside | {"exchange_and_python": status.wall - sum(inside.values())},
        units={kind: UnitInfo(d.modelName, d.version, d.generationTool, d.guid) for kind, d in about.items()},
        series=recorder.units,
        versions=versions(),
        git=git_revision(),
        machine=machine(),
        warnings=[*dict.fromkeys([*ranges.warnings(facts), *warnings, *_imbalances(parts, facts)])] or None,
        wing=of_wings([own for name, own in parts.values() if name.startswith("wing")], window) if window else None,
        wings=_of_several(facts, parts, [name for name in parts if name in wings(scene)], window),
        rods=_of_several(facts, parts, [name for name in parts if name not in wings(scene)], window),
    )


def _of_several(
    facts: Facts, parts: Parts, names: Sequence[str], window: statistics.Window | None
) -> dict[str, OfRod] | None:
    """Evaluate those of several rods and wings that have these names; None without them."""
    found = {}
    for name, (on_fluid, series) in ((name, parts[name]) for name in names if len(parts) > 1):
        driven = flapping.evaluate(facts, facts.scales.get(on_fluid), series, window) if window else None
        found[name] = OfRod(driven, interface(series, facts))
    return found or None


def _rests(columns: Series, facts: Facts) -> bool:
    """Return whether the tip of a body in a fluid never moves by more than rounding in a step: so are its works."""
    speeds = [float(np.abs(columns[name]).max()) for name in columns if name.startswith("tip_v")]
    return bool(speeds) and max(speeds) * facts.scene.time.communication_step < _smallest_way(facts)


def _smallest_way(facts: Facts) -> float:
    """Return the way up to which a body in a fluid rests, m; 0 without a fluid."""
    return REST * float(np.ptp(facts.scene.fluid.box.x)) if facts.scene.fluid else 0.0


def _imbalances(parts: Parts, facts: Facts) -> Iterator[str]:
    """Yield that the works on rods and by the fluid, or by contact without one, differ over the whole run."""
    other = "the fluid" if facts.scene.fluid else "contact"
    for name, (on_fluid, columns) in parts.items():
        work, kind = interface(columns, facts), "wing" if on_fluid.startswith("wing") else "rod"
        if work and work.imbalance and abs(work.imbalance) > WARN_RATIO:
            share = f"{work.imbalance:+.0%} of the exchanged work"
            yield f"over the run the works on the {unit_label(name, kind)} and by {other} differ by {share}"


def _not_final(
    scene: Scene,
    status: RunStatus,
    quantities: dict[str, Quantity],
    main: MainSignal | None,
    window: statistics.Window | None,
    settled: statistics.Character | None,
) -> str | None:
    """Return why a run cannot be compared with the published final state of its scene; None where it can."""
    reference = scene.reference
    if reference is None:
        return None
    if not status.completed:
        return f"the run ended at t = {status.simulated:g} of {scene.time.end:g} s"
    given = reference.coefficients
    if any(q.amplitude or q.frequency_hz for q in reference.quantities.values()) or (given and given.st is not None):
        if main is None or window is None or window.periods < COMPARED_PERIODS:
            periods, signal = window.periods if window else 0, main.name if main else "signal"
            return f"the run has {periods} whole periods of the {signal}, and {COMPARED_PERIODS} is the least"
        if settled and settled.drift is not None and abs(settled.drift) > PERIODIC:
            return f"the {main.name} still drifts by {settled.drift:+.0%} of its amplitude over the window"
        return None
    shown = list(reference.quantities) or ["drag"]
    for name in shown:
        found = quantities.get(name)
        if found and found.amplitude > STEADY * abs(found.mean):
            return f"{name} still changes by {2 * found.amplitude:.2g} {found.unit} around {found.mean:.2g}"
    return None


def _coefficients(
    facts: Facts,
    reference: Reference | None,
    series: Series,
    window: statistics.Window,
    width: float,
    rounding: float,
) -> Coefficients | None:
    scale = coefficients.scale(facts)
    values = coefficients.evaluate(scale, series, window, width, rounding) if scale else {}
    source = reference.source if reference else None
    return Coefficients(values, coefficients.published(reference), source) if values else None


def interface(series: Series, facts: Facts) -> Interface | None:
    """Return the work across the interface; None where a unit has no output of its power."""
    if not {"load_work", "beam_work"} <= series.keys():
        return None
    on_rod, by_fluid = (series[name] for name in ("load_work", "beam_work"))
    exchanged = float(np.abs(np.diff(by_fluid)).sum())
    return Interface(
        work_on_rod=float(on_rod[-1]),
        work_by_fluid=float(by_fluid[-1]),
        exchanged=exchanged,
        imbalance=float(on_rod[-1] - by_fluid[-1]) / exchanged if exchanged and not _rests(series, facts) else None,
    )
