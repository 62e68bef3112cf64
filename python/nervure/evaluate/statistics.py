"""Mean, amplitude and frequency of periodic signals.

The benchmarks define them (Turek & Hron 2006): mean = (max + min) / 2, amplitude = (max - min) / 2, over whole periods
after the start-up. A least-squares fit of harmonics is evaluated too: noise widens the extremes, but not the fit.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal

import numpy as np

Series = Mapping[str, np.ndarray]  # Recorded values over time, by column

MIN_PERIODS = 5  # Periods in a window, if the signal has as many
EQUAL_LENGTH = 0.1  # Largest difference of a period's length from the median of the last three, relative
EQUAL_SIZE = 0.25  # Largest difference of a period's amplitude from the median of the last three, relative
SETTLED = 0.02
"""A period before the last `MIN_PERIODS` belongs to the window while its amplitude differs from their mean by less than
this part of it."""

OVER = 2.0  # Time after the last period, in periods, from which on a signal does not oscillate any more

HYSTERESIS = 0.5
"""Part of the amplitude by which a signal must fall below its mean before the next upward crossing counts."""

OSCILLATING = 1e-3
"""Amplitude at the end, relative to the largest magnitude of the record, below which a signal is steady."""

ROUNDING = {"double": 1e-10, "single": 1e-5}
"""Amplitude relative to the largest comparable signal below which a signal is rounding, by the fluid's precision."""

DRIFTING = 0.05
"""Change of mean or amplitude over the window, relative to the amplitude, from which on a signal drifts."""

IRREGULAR = 0.15
"""Difference between the periods of a window, rms relative to the signal's own, from which on it is irregular."""

NOISY = 0.1  # Noise of a force, relative to its variation, from which on a result is marked

State = Literal["steady", "changing", "periodic", "drifting", "irregular", "rounding"]

ON_AXIS = 0.01  # Angle from a coordinate axis up to which a direction counts as the axis, rad

FORCE_FILTER = 5e-3  # Largest width of the box filter over forces, s
FORCE_FILTER_PERIODS = 1 / 50
"""Largest width of the box filter, in periods: at twice the frequency, an oscillation loses at most 0.3 %."""

OF_DRIVE = 0.5
"""Part of the variance of a force on a driven body from which on its harmonics of the drive count."""

HARMONICS = 6  # Number of fitted harmonics
FIT_ITERATIONS = 6  # Iterations of the fit for the fundamental frequency; it converges quadratically


@dataclass(frozen=True)
class Window:
    """Evaluated part of a record, s."""

    begin: float
    end: float
    periods: int  # Whole periods of the main signal; 0 if it does not oscillate
    driven: bool = False  # Whether a prescribed motion of a body sets the periods

    def last(self, periods: int) -> "Window":
        """Return the last `periods` whole periods, or the whole window if it has no more."""
        if self.periods <= periods:
            return self
        return replace(self, begin=self.end - periods * (self.end - self.begin) / self.periods, periods=periods)

    def of(self, time: np.ndarray) -> slice:
        """Return the samples in the window."""
        return slice(np.searchsorted(time, self.begin), np.searchsorted(time, self.end, side="right"))


@dataclass(frozen=True)
class Statistics:
    """Mean and amplitude in the unit of the signal, and frequency (Hz; None without an oscillation)."""

    mean: float
    amplitude: float
    frequency_hz: float | None


def extent(values: np.ndarray) -> tuple[float, float]:
    """Return mean and amplitude of `values` from their maximum and minimum."""
    high, low = float(values.max()), float(values.min())
    return (high + low) / 2, (high - low) / 2


def upward_crossings(time: np.ndarray, values: np.ndarray, mean: float, amplitude: float) -> np.ndarray:
    """Return the times at which `values` rise through `mean`, interpolated linearly; noise around it counts once. A
    record that ends where it reaches the mean, to rounding, ends with a crossing."""
    above = values > mean
    if values.size > 1 and values[-1] > values[-2] and values[-1] > mean - 1e-6 * amplitude:
        above[-1] = True
    rising = np.flatnonzero(above[1:] & ~above[:-1])
    low = np.flatnonzero(values < mean - HYSTERESIS * amplitude)
    dips = np.searchsorted(low, rising, side="right")
    first = rising[np.diff(dips, prepend=0) > 0]
    share = np.minimum((mean - values[first]) / (values[first + 1] - values[first]), 1.0)
    crossings: np.ndarray = time[first] + share * (time[first + 1] - time[first])
    return crossings


def last_third(time: np.ndarray) -> Window:
    """Return the window of a signal without periods."""
    return Window(float(time[0] + (time[-1] - time[0]) * 2 / 3), float(time[-1]), 0)


def smallest_amplitude(time: np.ndarray, forces: np.ndarray, rounding: float) -> float:
    """Return the amplitude up to which one of `forces`, `[components, samples]`, is rounding: of the largest one at the
    end the part `rounding`."""
    return rounding * float(np.abs(forces[:, last_third(time).of(time)]).max())


def find_window(time: np.ndarray, values: np.ndarray, smallest: float = 0.0) -> Window:
    """Return the window of the main signal: its last five whole periods, and those before while they are as large.

    The periods of a window agree in length (`EQUAL_LENGTH`) and size (`EQUAL_SIZE`), so that the start-up stays out.
    Where fewer than three do, the last ones of the last two thirds of the record are taken as they are, and `character`
    says that they differ. A signal whose amplitude at the end is at most `smallest`, that is steady there, that never
    completes a period there, or whose last one is long over, is evaluated over the last third of the record.
    """
    edges = _edges(time, values, smallest)
    first = _first_settled(time, values, edges) if edges.size else 0
    if first >= edges.size - 1:
        return last_third(time)
    return Window(float(edges[first]), float(edges[-1]), edges.size - 1 - first)


def _edges(time: np.ndarray, values: np.ndarray, smallest: float = 0.0) -> np.ndarray:
    """Return the times between whole periods of a signal, s: none where its amplitude at the end is at most `smallest`,
    where it is steady there, never completes a period, or the last one is long over."""
    mean, amplitude = extent(values[last_third(time).of(time)])
    if amplitude <= max(smallest, OSCILLATING * np.abs(values).max()):
        return np.empty(0)
    edges = upward_crossings(time, values, mean, amplitude)
    return edges if edges.size > 1 and time[-1] - edges[-1] <= OVER * (edges[-1] - edges[-2]) else np.empty(0)


def driven_window(time: np.ndarray, values: np.ndarray, drive: np.ndarray) -> Window:
    """Return the window of a signal that a prescribed one drives: whole periods of `drive`, counted from the end of the
    record, as many as `values` are settled for; that of `values` alone if the drive has no periods."""
    found = next((edges for sign in (1, -1) if (edges := _edges(time, sign * drive)).size), None)
    if found is None:
        return find_window(time, values)
    found = found[min(_first_settled(time, drive, found), found.size - 2) :]
    period = (found[-1] - found[0]) / (found.size - 1)
    count = int((time[-1] - found[0]) / period + 1e-6)
    edges = time[-1] - period * np.arange(count, -1, -1)
    first = min(_first_settled(time, values, edges), count - 1)
    if first == 0 and count > 2 and edges[0] - time[0] < period / 2:
        first = 1  # The start-up, even where the signal is as large in it
    return Window(float(edges[first]), float(edges[-1]), count - first, driven=True)


def _first_settled(time: np.ndarray, values: np.ndarray, edges: np.ndarray) -> int:
    """Return the number of the first period between `edges` (s) that belongs to the window; that of the last edge where
    none does."""
    places = np.searchsorted(time, edges)
    amplitudes = np.array([extent(values[a : b + 1])[1] for a, b in pairwise(places)])
    equal = [
        np.abs(sizes - np.median(sizes[-3:])) <= part * np.median(sizes[-3:])
        for sizes, part in ((np.diff(edges), EQUAL_LENGTH), (amplitudes, EQUAL_SIZE))
    ]
    differ = np.flatnonzero(~(equal[0] & equal[1]))
    earliest = int(differ[-1]) + 1 if differ.size else 0
    first = max(0, amplitudes.size - MIN_PERIODS)
    if amplitudes.size - earliest >= min(3, max(amplitudes.size, 2)):
        first = max(first, earliest)
        settled = np.mean(amplitudes[first:])
        while first > earliest and abs(amplitudes[first - 1] - settled) < SETTLED * settled:
            first -= 1
        return first
    start_up = int(np.searchsorted(edges, time[0] + (time[-1] - time[0]) / 3))
    return min(max(first, start_up), amplitudes.size)


def principal_direction(time: np.ndarray, path: np.ndarray) -> np.ndarray:
    """Return the unit vector along which a path `[axes, samples]` goes farthest in the last third of the record. Its
    largest component is positive, and within `ON_AXIS` of a coordinate axis it is that axis, as in the benchmarks."""
    part = path[:, last_third(time).of(time)]
    directions = np.linalg.svd(part - part.mean(axis=1, keepdims=True), full_matrices=False)[0]
    first: np.ndarray = directions[:, 0] * np.sign(directions[np.argmax(np.abs(directions[:, 0])), 0])
    return np.where(first == first.max(), 1.0, 0.0) if np.linalg.norm(first) - first.max() < ON_AXIS**2 / 2 else first


@dataclass(frozen=True)
class Character:
    """Kind of the signal in a window."""

    state: State
    drift: float | None  # Change of mean or amplitude over the window, relative to the amplitude; None without periods
    noise: float | None  # Rms above the signal's own harmonics, relative to its variation; None without periods

    def remark(self) -> str:
        """Return the remark of a table, empty for a periodic or a steady signal."""
        words = {"changing": "still changes", "irregular": "not periodic", "rounding": "rounding only"}
        kind = f"drifts {self.drift:+.0%}" if self.state == "drifting" and self.drift else words.get(self.state, "")
        noisy = f"noise {self.noise:.0%}" if self.noise and self.noise > NOISY and self.state != "rounding" else ""
        return ", ".join(filter(None, (kind, noisy)))


def folded(time: np.ndarray, values: np.ndarray, window: Window, samples: int = 256) -> np.ndarray:
    """Return the whole periods of `window` at equal phases, `[periods, samples]`."""
    share = np.arange(window.periods * samples) / (window.periods * samples)
    at = window.begin + share * (window.end - window.begin)
    sampled: np.ndarray = np.interp(at, time, values).reshape(window.periods, samples)
    return sampled


def character(time: np.ndarray, values: np.ndarray, window: Window, smallest: float = 0.0) -> Character:
    """Return state, drift and noise of `values` over `window`; an amplitude of at most `smallest` is rounding."""
    mean, amplitude = extent(values[window.of(time)])
    if amplitude <= smallest:
        return Character("steady" if abs(mean) > smallest else "rounding", None, None)
    if window.periods == 0:
        return Character("steady" if amplitude <= OSCILLATING * abs(mean) else "changing", None, None)
    if window.periods == 1:
        return Character("changing", None, None)
    periods = folded(time, values, window)
    trend = _trend(periods.mean(axis=1)), _trend(np.ptp(periods, axis=1) / 2)
    drift = max(trend, key=abs) / amplitude
    cycle = periods.mean(axis=0)
    variation = float(np.sqrt(np.mean((periods - periods.mean()) ** 2)))
    noise = _noise(time, values, window)
    apart = np.sqrt(max(np.mean((periods - cycle) ** 2) / variation**2 - noise**2, 0.0))
    state: State = "drifting" if abs(drift) > DRIFTING else "irregular" if apart > IRREGULAR else "periodic"
    return Character(state, float(drift), noise)


def _trend(values: np.ndarray) -> float:
    """Return the change from the first to the last of `values` by a straight line of least squares."""
    return float(np.polyfit(np.arange(values.size), values, 1)[0] * (values.size - 1))


def _noise(time: np.ndarray, values: np.ndarray, window: Window) -> float:
    """Return the rms of `values` above `HARMONICS` times their own frequency, relative to the rms of the variation."""
    part = values[window.of(time)]
    power = np.abs(np.fft.rfft((part - part.mean()) * np.hanning(part.size))) ** 2
    own = window.periods * max(1, round(np.argmax(power) / window.periods))
    varying = power[max(1, window.periods // 2) :].sum()
    return float(np.sqrt(power[int((HARMONICS + 0.5) * own) :].sum() / varying)) if varying else 0.0


def evaluate(time: np.ndarray, values: np.ndarray, window: Window) -> Statistics:
    """Return the statistics of `values` over `window` from extremes and crossings."""
    part = window.of(time)
    mean, amplitude = extent(values[part])
    if window.periods == 0:
        return Statistics(mean, amplitude, None)
    # A quarter of a period more on either side includes the crossings at the edges of the window.
    margin = (window.end - window.begin) / window.periods / 4
    wide = Window(window.begin - margin, window.end + margin, 0).of(time)
    crossings = upward_crossings(time[wide], values[wide], mean, amplitude)
    if crossings.size < 2:
        return Statistics(mean, amplitude, None)
    return Statistics(mean, amplitude, float((crossings.size - 1) / (crossings[-1] - crossings[0])))


def of_force(time: np.ndarray, values: np.ndarray, window: Window, width: float) -> Statistics:
    """Return the statistics of a force over `window`, under a box filter of `width` (s). The force on a driven body is
    that of the harmonics of the drive, as long as they make most of it."""
    if window.driven:
        found, share = _harmonics(time, values, window, 1)
        if share > OF_DRIVE:
            return found
    return evaluate(time, box_filter(time, values, width), window)


def fit(time: np.ndarray, values: np.ndarray, window: Window) -> Statistics:
    """Return the statistics of the harmonics that fit `values` best over `window`, which must hold a period.

    The fundamental frequency is an unknown too (the four-parameter sine fit of IEEE Std 1057, with harmonics). The
    frequency returned is the strongest harmonic's.
    """
    return _harmonics(time, values, window, FIT_ITERATIONS)[0]


def _harmonics(time: np.ndarray, values: np.ndarray, window: Window, iterations: int) -> tuple[Statistics, float]:
    """Return the statistics of the fitted harmonics, and their part of the variance; a single iteration keeps the
    frequency of the window."""
    part = window.of(time)
    t, y = time[part] - (window.begin + window.end) / 2, values[part]
    order = np.arange(1, HARMONICS + 1)
    omega = 2 * np.pi * window.periods / (window.end - window.begin)
    derivative = np.zeros_like(t)
    for _ in range(iterations):
        phases = np.outer(t, order * omega)
        matrix = np.column_stack([np.ones_like(t), np.cos(phases), np.sin(phases), derivative])
        solution = np.linalg.lstsq(matrix, y, rcond=None)[0]
        constant, cosines, sines = solution[0], solution[1 : HARMONICS + 1], solution[HARMONICS + 1 : -1]
        omega += solution[-1] if iterations > 1 else 0.0
        derivative = t * ((np.cos(phases) * sines - np.sin(phases) * cosines) @ order)
    one_period = np.outer(np.linspace(0, 2 * np.pi, 2000, endpoint=False), order)
    curve = constant + np.cos(one_period) @ cosines + np.sin(one_period) @ sines
    strongest = order[np.argmax(cosines**2 + sines**2)]
    rest, total = (float(np.var(signal)) for signal in (y - matrix @ solution, y))
    return Statistics(*extent(curve), float(strongest * omega / (2 * np.pi))), 1 - rest / total if total else 0.0


def box_filter(time: np.ndarray, values: np.ndarray, width: float) -> np.ndarray:
    """Return the moving average of `values` over `width` (s), narrower towards the ends of the record."""
    integral = np.r_[0.0, np.cumsum((values[1:] + values[:-1]) / 2 * np.diff(time))]
    half = np.minimum(width / 2, np.minimum(time - time[0], time[-1] - time))
    begin, end = time - half, time + half
    filtered = values.copy()
    wide = end > begin
    difference = np.interp(end, time, integral) - np.interp(begin, time, integral)
    filtered[wide] = difference[wide] / (end - begin)[wide]
    return filtered


def force_filter_width(window: Window) -> float:
    """Return the width of the box filter over forces, s; without periods the window counts as one."""
    return min(FORCE_FILTER, FORCE_FILTER_PERIODS * (window.end - window.begin) / max(window.periods, 1))
