"""Coefficients of each body in the flow, over the window of the run.

    c = 2 F / (rho U² A),   C_P = 2 P / (rho U³ A),   St = f L / U,   KC = U_m / (f L)

with the speed U, length L, area A and the directions of `scene.facts`, and the largest speed U_m of a body that
oscillates. In the plane F and P are per metre of depth, and L is in the place of A. Thrust and power are averages over
time; drag, lift and side have mean and amplitude from their extremes.

The force on a body that oscillates along a line in still fluid is split (Morison, O'Brien, Johnson & Schaaf 1950),

    F = −rho L c_d |V| V / 2 − rho pi L² c_i dV/dt / 4

with the velocity V of the body, by the Fourier averages of Keulegan & Carpenter (1958).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from nervure.evaluate import flapping, statistics
from nervure.evaluate.rods import columns_of_units
from nervure.evaluate.statistics import Series, Window
from nervure.scene.facts import Facts
from nervure.scene.solids import placed, pose_names
from nervure.scene.types import BodyMotion, Fluid, Motion, TimeLaw, TimeLawConstant, TimeLawSine


@dataclass(frozen=True)
class CycleMean:
    """Mean and standard deviation of the means over each cycle of the window; one cycle has no deviation."""

    mean: float
    scatter: float | None


@dataclass(frozen=True, kw_only=True)
class Morison:
    """Coefficients of a body that oscillates along a line in still fluid."""

    cd: float
    ci: float
    rest: float  # Root mean square of the residual, relative to the force


@dataclass(frozen=True, kw_only=True)
class ReferenceScales:
    """What the coefficients of a body refer to, and the unit vectors of its forces."""

    speed: float  # U, m/s
    speed_of: str  # The part of the scene that has this speed
    length: float  # L, m
    area: float | None  # A, m²; None in the plane
    drag: tuple[float, ...]
    lift: tuple[float, ...]
    side: tuple[float, ...] | None  # None in the plane


@dataclass(frozen=True, kw_only=True)
class BodyCoefficients:
    """Coefficients of one body along the directions of `reference`; thrust is against the drag."""

    reference: ReferenceScales | None = None  # None in results of earlier versions
    cd_mean: float
    cd_amplitude: float
    cl_mean: float
    cl_amplitude: float
    cs_mean: float | None = None  # Side; None in the plane
    cs_amplitude: float | None = None
    own_axes: tuple[float, ...] | None = None  # Means along the own, moving axes of a rigid body; None for others
    ct: float
    cp: float | None  # Of the power of the drive; None without a drive
    st: float | None  # From the frequency of the lift; None without an oscillation beyond rounding
    st_tip: float | None  # f A / U, with the width A of the path of the tip along its principal direction
    kc: float | None = None  # Keulegan–Carpenter number of a body that oscillates
    cycles: dict[str, CycleMean] | None = None  # By coefficient; None without a whole cycle
    morison: Morison | None = None


def evaluate(
    facts: Facts, series: Series, window: Window, width: float, rounding: float = statistics.ROUNDING["double"]
) -> dict[str, BodyCoefficients]:
    """Return the coefficients by body, with drag and lift filtered over `width` (s); none where nothing drives the
    flow. `rounding` is the part of the largest force on a body that rounding may move."""
    fluid, numbers = facts.scene.fluid, facts.numbers
    if fluid is None or numbers is None or not numbers.velocity:
        return {}
    time = series["time"]
    motions = dict(_motions(fluid))
    parts = dict(columns_of_units(series, facts.scene).values())
    found = {}
    for name in numbers.bodies:
        own = parts.get(name)
        force = flapping.forces(series, name)
        if force is None or len(force) < 2:
            continue
        scales = facts.scales[name]
        velocity = scales.speed or numbers.velocity
        pressure = fluid.density * velocity**2 * (scales.length if scales.area is None else scales.area) / 2
        directions = scales.directions(len(force))
        curves = dict(zip(("cd", "cl", "cs"), directions @ force / pressure, strict=False))
        if len(force) == 2:
            del curves["cs"]
        smallest = statistics.smallest_amplitude(time, np.array([*curves.values()]), rounding)
        drag, lift, *side = (statistics.of_force(time, curve, window, width) for curve in curves.values())
        power = power_in(name, series) if name in motions else own.get("root_power") if own else None
        if facts.stream is None and f"{name}_x" in series and name in motions:
            curves["cd_path"] = against_path(name, series) / pressure
        if power is not None:
            curves["cp"] = power / (pressure * velocity)
        laws = motions.get(name)
        oscillation = _oscillation(laws) if laws else None
        found[name] = BodyCoefficients(
            reference=ReferenceScales(
                speed=velocity,
                speed_of="reference" if scales.speed else numbers.velocity_of or "",
                length=scales.length,
                area=scales.area,
                drag=tuple(directions[0].tolist()),
                lift=tuple(directions[1].tolist()),
                side=tuple(directions[2].tolist()) if side else None,
            ),
            cd_mean=drag.mean,
            cd_amplitude=drag.amplitude,
            cl_mean=lift.mean,
            cl_amplitude=lift.amplitude,
            cs_mean=side[0].mean if side else None,
            cs_amplitude=side[0].amplitude if side else None,
            own_axes=_along_own_axes(name, fluid, series, window, force / pressure),
            ct=-flapping.average(time, curves["cd"], window),
            cp=flapping.average(time, curves["cp"], window) if power is not None else None,
            st=lift.frequency_hz * scales.length / velocity
            if lift.frequency_hz and window.periods and lift.amplitude > smallest
            else None,
            st_tip=_tip(own, window, velocity) if own else None,
            kc=oscillation.largest_speed / (oscillation.frequency * scales.length) if oscillation else None,
            cycles={key: cycle_mean(time, curve, window) for key, curve in curves.items()} if window.periods else None,
            morison=oscillation.morison(name, facts, series, window, scales.length)
            if oscillation and scales.area is None
            else None,
        )
    return found


def _along_own_axes(
    name: str, fluid: Fluid, series: Series, window: Window, force: np.ndarray
) -> tuple[float, ...] | None:
    """Return the means over time of a force, `[axes, samples]`, along the axes of a rigid body that may turn."""
    kind, _, number = name.partition("_")
    if kind != "body":
        return None
    body, time = fluid.bodies[int(number) - 1], series["time"]
    rest = np.full_like(time, body.angle if len(force) == 2 else 0.0)
    *place, angles = (series.get(f"{name}_{part}", rest) for part in pose_names(fluid, body))
    if len(force) == 3:
        axes = np.array([placed(body, pose)[0] for pose in zip(*place, angles, strict=True)])  # From the own axes
    else:
        axes = np.moveaxis(np.array([[np.cos(angles), -np.sin(angles)], [np.sin(angles), np.cos(angles)]]), 2, 0)
    own = np.einsum("tij,it->jt", axes, force)
    return tuple(flapping.average(time, values, window) for values in own)


def power_in(name: str, series: Series) -> np.ndarray | None:
    """Return the power that the drive of a rigid body puts into the fluid, W/m."""
    return -series[f"{name}_power"] if f"{name}_power" in series else None


def against_path(name: str, series: Series) -> np.ndarray:
    """Return the force on a body against its velocity, N, per metre of depth in the plane; 0 where its pivot rests."""
    places = [series[column] for axis in "xyz" if (column := f"{name}_{axis}") in series]
    velocity = np.array([np.gradient(place, series["time"]) for place in places])
    speed = np.linalg.norm(velocity, axis=0)
    forces = np.array([series[f"{name}_{end}"] for end in flapping.FORCES[: len(places)]])
    against: np.ndarray = -(forces * velocity).sum(0) / np.where(speed > 0, speed, 1.0)
    return against


def cycle_mean(time: np.ndarray, values: np.ndarray, window: Window) -> CycleMean:
    """Evaluate the means of `values` over the cycles of `window`."""
    edges = np.linspace(window.begin, window.end, window.periods + 1)
    means = [flapping.average(time, values, Window(begin, end, 1)) for begin, end in pairwise(edges)]
    return CycleMean(float(np.mean(means)), float(np.std(means, ddof=1)) if len(means) > 1 else None)


@dataclass(frozen=True)
class _Oscillation:
    """A motion along a line, by sines of one frequency and phase."""

    direction: np.ndarray  # Unit vector, for a positive sine
    law: TimeLawSine  # Of the axis with the largest amplitude
    largest_speed: float  # m/s
    still: bool  # Whether the body does not turn

    @property
    def frequency(self) -> float:
        return self.law.sine.frequency

    def morison(self, name: str, facts: Facts, series: Series, window: Window, length: float) -> Morison | None:
        """Split the force over `window`; None in a stream, while the motion grows, or where the body turns."""
        sine, part, fluid = self.law.sine, window.of(series["time"]), facts.scene.fluid
        if (
            fluid is None
            or facts.stream is not None
            or not self.still
            or window.periods == 0
            or sine.ramp > window.begin
        ):
            return None
        time, omega, speed = series["time"], 2 * np.pi * sine.frequency, self.largest_speed
        cos, sin = np.cos(omega * time + sine.phase), np.sin(omega * time + sine.phase)
        force = self.direction[:2] @ [series[f"{name}_drag"], series[f"{name}_lift"]]
        drag, inertia = fluid.density * length * speed**2 / 2, fluid.density * np.pi * length**2 * omega * speed / 4
        cd = -flapping.average(time, force * cos, window) / drag * 3 * np.pi / 4
        ci = flapping.average(time, force * sin, window) / inertia * 2
        rest = force + drag * cd * np.abs(cos) * cos - inertia * ci * sin
        return Morison(cd=cd, ci=ci, rest=float(np.std(rest[part]) / np.std(force[part])))


def _motions(fluid: Fluid) -> Iterator[tuple[str, Motion | BodyMotion | None]]:
    """Yield the prescribed motions of rigid bodies by the names of their forces; None for one by the master."""
    yield from ((f"cylinder_{i}", own.motion) for i, own in enumerate(fluid.cylinders, 1) if own.motion)
    for i, body in enumerate(fluid.bodies, 1):
        if body.motion:
            yield f"body_{i}", None if body.motion == "master" else body.motion


def _oscillation(motion: Motion | BodyMotion) -> _Oscillation | None:
    """Return an oscillation along a line; None for other motions."""
    laws = dict(enumerate((motion.x, motion.y, *((motion.z,) if isinstance(motion, BodyMotion) else ()))))
    sines = {axis: law for axis, law in laws.items() if isinstance(law, TimeLawSine)}
    moving = {axis: law for axis, law in sines.items() if law.sine.amplitude and law.sine.frequency}
    if not moving or not all(axis in sines or _rests(law) for axis, law in laws.items()):
        return None
    first = max(moving.values(), key=lambda law: abs(law.sine.amplitude))
    for law in moving.values():
        if any(getattr(law.sine, key) != getattr(first.sine, key) for key in ("frequency", "phase", "ramp")):
            return None
    amplitudes = np.array([moving[axis].sine.amplitude if axis in moving else 0.0 for axis in range(3)])
    amplitude = float(np.linalg.norm(amplitudes))
    speed = 2 * np.pi * first.sine.frequency * amplitude
    turns = isinstance(motion, BodyMotion) and (bool(motion.rotations) or not _rests(motion.angle))
    return _Oscillation(amplitudes / amplitude, first, speed, not turns)


def _rests(law: TimeLaw) -> bool:
    return isinstance(law, TimeLawConstant)


def _tip(series: Series, window: Window, velocity: float) -> float | None:
    """St of the tip's path along the direction in which the tip goes farthest."""
    time, tip = series["time"], flapping.path(series, "tip")
    if tip is None or window.periods == 0:
        return None
    along = statistics.evaluate(time, statistics.principal_direction(time, tip) @ tip, window)
    return along.frequency_hz * 2 * along.amplitude / velocity if along.frequency_hz else None
