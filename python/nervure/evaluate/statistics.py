"""Mean, amplitude and frequency of periodic signals.

The benchmarks define them (Turek & Hron 2006): mean = (max + min) / 2, amplitude = (max - min) / 2, over whole periods
after the start-up. A least-squares fit of harmonics is evaluated too: noise widens the extremes, but not the fit.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

Series = Mapping[str, np.ndarray]  # Recorded values over time, by column

MIN_PERIODS = 5  # Periods in a window, if the signal has as many
DRIFT_PERIODS = 4  # Least number of periods for a drift of the amplitude
SETTLED = 0.02
"""Largest relative difference of the amplitude by which an earlier period still belongs to the window."""

HYSTERESIS = 0.5
"""Part of the amplitude by which a signal must fall below its mean before the next upward crossing counts."""

OSCILLATING = 1e-3
"""Amplitude at the end, relative to the largest magnitude of the record, below which a signal is steady."""

FORCE_FILTER = 5e-3  # Largest width of the box filter over forces, s
FORCE_FILTER_PERIODS = 1 / 50
"""Largest width of the box filter, in periods: at twice the frequency, an oscillation loses at most 0.3 %."""

HARMONICS = 6  # Number of fitted harmonics
FIT_ITERATIONS = 6  # Iterations of the fit for the fundamental frequency; it converges quadratically


@dataclass(frozen=True)
class Window:
    """Evaluated part of a record, s."""

    begin: float
    end: float
    periods: int  # Whole periods of the main signal; 0 if it does not oscillate

    def last(self, periods: int) -> "Window":
        """Return the last `periods` whole periods, or the whole window if it has no more."""
        if self.periods <= periods:
            return self
        return Window(self.end - periods * (self.end - self.begin) / self.periods, self.end, periods)

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
    """Return the times at which `values` rise through `mean`, interpolated linearly; noise around it counts once."""
    above = values > mean
    rising = np.flatnonzero(above[1:] & ~above[:-1])
    low = np.flatnonzero(values < mean - HYSTERESIS * amplitude)
    dips = np.searchsorted(low, rising, side="right")
    first = rising[np.diff(dips, prepend=0) > 0]
    share = (mean - values[first]) / (values[first + 1] - values[first])
    crossings: np.ndarray = time[first] + share * (time[first + 1] - time[first])
    return crossings


def find_window(time: np.ndarray, values: np.ndarray) -> Window:
    """Return the window of the main signal: the last five whole periods, or all of fewer, and earlier periods while
    they are as large. Without a whole period, or for a steady signal, it is the last third of the record."""
    last_third = Window(float(time[0] + (time[-1] - time[0]) * 2 / 3), float(time[-1]), 0)
    mean, amplitude = extent(values[last_third.of(time)])
    if amplitude <= OSCILLATING * np.abs(values).max():
        return last_third
    crossings = upward_crossings(time, values, mean, amplitude)
    if crossings.size < 2:
        return last_third

    edges = np.searchsorted(time, crossings)
    amplitudes = [extent(values[a : b + 1])[1] for a, b in pairwise(edges)]
    first = max(0, len(amplitudes) - MIN_PERIODS)
    settled = np.mean(amplitudes[first:])
    while first > 0 and abs(amplitudes[first - 1] - settled) < SETTLED * settled:
        first -= 1
    return Window(float(crossings[first]), float(crossings[-1]), len(amplitudes) - first)


def drift(time: np.ndarray, values: np.ndarray, window: Window) -> float | None:
    """Return the relative change of the amplitude between the halves of the window; None below `DRIFT_PERIODS`."""
    if window.periods < DRIFT_PERIODS:
        return None
    middle = window.begin + (window.end - window.begin) / 2
    halves = [Window(window.begin, middle, 0), Window(middle, window.end, 0)]
    early, late = (extent(values[half.of(time)])[1] for half in halves)
    return (late - early) / extent(values[window.of(time)])[1]


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


def fit(time: np.ndarray, values: np.ndarray, window: Window) -> Statistics:
    """Return the statistics of the harmonics that fit `values` best over `window`, which must hold a period.

    The fundamental frequency is an unknown too (the four-parameter sine fit of IEEE Std 1057, with harmonics). The
    frequency returned is the strongest harmonic's.
    """
    part = window.of(time)
    t, y = time[part] - (window.begin + window.end) / 2, values[part]
    order = np.arange(1, HARMONICS + 1)
    omega = 2 * np.pi * window.periods / (window.end - window.begin)
    derivative = np.zeros_like(t)
    for _ in range(FIT_ITERATIONS):
        phases = np.outer(t, order * omega)
        matrix = np.column_stack([np.ones_like(t), np.cos(phases), np.sin(phases), derivative])
        solution = np.linalg.lstsq(matrix, y, rcond=None)[0]
        constant, cosines, sines = solution[0], solution[1 : HARMONICS + 1], solution[HARMONICS + 1 : -1]
        omega += solution[-1]
        derivative = t * ((np.cos(phases) * sines - np.sin(phases) * cosines) @ order)
    one_period = np.outer(np.linspace(0, 2 * np.pi, 2000, endpoint=False), order)
    curve = constant + np.cos(one_period) @ cosines + np.sin(one_period) @ sines
    strongest = order[np.argmax(cosines**2 + sines**2)]
    return Statistics(*extent(curve), float(strongest * omega / (2 * np.pi)))


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
    """Return the width of the box filter over forces, s."""
    if window.periods == 0:
        return FORCE_FILTER
    return min(FORCE_FILTER, FORCE_FILTER_PERIODS * (window.end - window.begin) / window.periods)
