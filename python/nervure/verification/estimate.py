"""Estimates of errors from runs at several sizes h of a parameter, after Eça & Hoekstra (2014).

Expansions are fitted by least squares to the values phi, with the weights h^-3, as fine runs are nearer to the limit,

    phi = phi_0 + a h^p,  1 <= p <= 2      from four runs on also      phi = phi_0 + a_1 h + a_2 h²

of which the one with the smallest standard deviation sigma counts. It says that the finest value is off by
epsilon = phi_1 − phi_0. Three runs do not show whether that is so: where the grid's place makes some per cent, their
order is chance. So the limit is corrected by a half of it, and the 95 % bar of the limit is

    U = epsilon + sigma + |phi_1 − fit_1| + SCATTER (the range of the values)

with the statistical errors of the values, as they reach the limit, added in squares. Where four runs follow the
expansion (sigma < CLEAR of the range), the whole epsilon is corrected, and U has a half of it; where they do not, the
coarsest one is left out. Two runs are corrected by a half of the mean error of orders 1 and 2, and U is that error.
`studies/coverage.py` shows what these bars hold.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from nervure.evaluate import statistics
from nervure.evaluate.statistics import Series, Window
from nervure.extras import require
from nervure.simulation.verified import Share, is_part

ORDERS = (1.0, 2.0)  # Of the method: first at bodies, second elsewhere
WEIGHT = 3.0  # Exponent of the weights
HALF = 0.5  # Part of an estimated error that is corrected
SCATTER = 0.15
CLEAR = 0.02
COVERED = 0.975  # Quantile of a two-sided bar of 95 %
SEARCHED = (0.1, 6.0)  # Observed orders
PARTS = 3  # Of the window of a signal without periods


def estimate(sizes: Sequence[float], values: Sequence[float], noise: Sequence[float]) -> Share:
    """Return the error from `values` with statistical errors `noise` (95 %) at relative `sizes`."""
    order = np.argsort(sizes)
    h, phi, bars = (np.array(part, float)[order] for part in (sizes, values, noise))
    terms, uncertainty, observed, kind = _estimate(h / h[0], phi, bars)
    scaled = [(coefficient / h[0] ** exponent, exponent) for coefficient, exponent in terms]
    return Share(scaled, uncertainty, observed, kind, h.tolist(), phi.tolist(), bars.tolist())


def combine(shares: Mapping[str, Share]) -> tuple[float, float, float]:
    """Return the value of the finest run of the first parameter, its limit as the sizes of all parameters vanish, and
    the 95 % bar of the limit. The others were varied beside the scene's own size, 1."""
    first = next(iter(shares.values()))
    counted = {name: share for name, share in shares.items() if not is_part(name, shares)}
    error = sum(share.error(first.sizes[0] if share is first else 1.0) for share in counted.values())
    return first.values[0], first.values[0] - error, math.hypot(*(share.uncertainty for share in counted.values()))


@dataclass(frozen=True)
class _Fit:
    """An expansion."""

    limit: float
    coefficients: list[float]
    exponents: Sequence[float]
    sigma: float  # Standard deviation
    carried: np.ndarray  # Weights with which the values make the limit

    @property
    def error(self) -> float:
        """Return the error of the finest value."""
        return sum(self.coefficients)


Terms = list[tuple[float, float]]


def _estimate(h: np.ndarray, phi: np.ndarray, noise: np.ndarray) -> tuple[Terms, float, float | None, str]:
    """Return the terms of the error, with the part that is not corrected as a constant; the bar, the observed order
    and how the values behave."""
    if phi.size == 1:
        return [], math.inf, None, "one run"
    extent = float(np.ptp(phi))
    if extent <= float(np.hypot(noise.min(), noise.max())):
        return [], float(extent + noise[0]), None, "noise"
    if phi.size == 2:
        coefficient = float(np.mean([(phi[1] - phi[0]) / (h[1] ** order - 1) for order in ORDERS]))
        middle = sum(ORDERS) / 2
        statistical = HALF * float(np.linalg.norm(noise)) / (h[1] ** middle - 1)
        return _terms([coefficient], [middle], HALF), math.hypot(coefficient, statistical), None, "two runs"
    fits = [_fit(h, phi, (_order(h, phi, ORDERS),)), *([_fit(h, phi, ORDERS)] if phi.size > 3 else [])]
    best = min(fits, key=lambda fit: fit.sigma)
    clear = phi.size > 3 and best.sigma < CLEAR * extent
    if phi.size > 3 and not clear:
        return _estimate(h[:-1], phi[:-1], noise[:-1])
    steps = np.diff(phi)
    monotone = bool(np.all(steps > 0) or np.all(steps < 0))
    corrected = 1.0 if clear else HALF
    missed = abs(float(phi[0]) - best.limit - best.error)
    numerical = (1.5 - corrected) * abs(best.error) + best.sigma + missed + SCATTER * extent * (not clear)
    to_limit = corrected * best.carried
    to_limit[0] += 1 - corrected
    bar = math.hypot(numerical, float(np.linalg.norm(to_limit * noise)))
    terms = _terms(best.coefficients, best.exponents, corrected)
    return terms, bar, _order(h, phi, SEARCHED) if monotone else None, "converging" if monotone else "oscillating"


def _terms(coefficients: Sequence[float], exponents: Sequence[float], corrected: float) -> Terms:
    constant = (-(1 - corrected) * sum(coefficients), 0.0)
    return [*zip(coefficients, exponents, strict=True), *([constant] if constant[0] else [])]


def _fit(h: np.ndarray, phi: np.ndarray, exponents: Sequence[float]) -> _Fit:
    weights = h ** (-WEIGHT / 2)
    weights /= math.sqrt(float(np.mean(weights**2)))
    matrix = np.column_stack([np.ones_like(h), *(h**exponent for exponent in exponents)])
    inverse = np.linalg.pinv(weights[:, None] * matrix) * weights
    limit, *coefficients = (inverse @ phi).tolist()
    rest = weights * (phi - matrix @ [limit, *coefficients])
    sigma = math.sqrt(float(rest @ rest) / max(1, phi.size - matrix.shape[1]))
    return _Fit(limit, coefficients, exponents, sigma, inverse[0])


def _order(h: np.ndarray, phi: np.ndarray, bounds: Sequence[float]) -> float:
    """Return the order within `bounds` whose expansion is nearest to the values."""
    search = require("scipy.optimize", "a verification").minimize_scalar
    return float(search(lambda order: _fit(h, phi, (order,)).sigma, bounds=bounds, method="bounded").x)


def statistical_error(time: np.ndarray, values: np.ndarray, window: Window, what: str) -> float:
    """Return the 95 % error of the `mean`, the `amplitude` or the `frequency_hz` of a signal over `window`: from the
    scatter of its periods, as batches; without periods from the drift between the parts of the window."""
    if window.periods < 2:
        edges = np.linspace(window.begin, window.end, PARTS + 1)
        parts = [values[Window(begin, end, 0).of(time)] for begin, end in pairwise(edges)]
        return float(np.ptp([part.mean() for part in parts if part.size])) if what == "mean" else 0.0
    if what == "frequency_hz":
        mean, amplitude = statistics.extent(values[window.of(time)])
        crossings = statistics.upward_crossings(time, values, mean, amplitude)
        lengths = np.diff(crossings[(crossings >= window.begin - 1e-9) & (crossings <= window.end + 1e-9)])
        whole = lengths[lengths > HALF * np.median(lengths)] if lengths.size else lengths
        return _of_mean(whole) / float(np.mean(whole)) ** 2 if whole.size > 1 else 0.0
    periods = statistics.folded(time, values, window)
    high, low = periods.max(axis=1), periods.min(axis=1)
    return _of_mean((high + low) / 2 if what == "mean" else (high - low) / 2)


def _of_mean(batches: np.ndarray) -> float:
    """Return the 95 % error of the mean of `batches` by Student's distribution."""
    quantile = require("scipy.stats", "a verification").t.ppf(COVERED, batches.size - 1)
    return float(quantile * batches.std(ddof=1) / math.sqrt(batches.size))


def noise_of(name: str, series: Series, window: Window | None, width: float) -> float:
    """Return the statistical error of a column of the table of runs, e.g. `lift_mean`; 0 where it is not that of a
    recorded output."""
    column, _, what = name.removesuffix("_hz").rpartition("_")
    if window is None or column not in series or what not in ("mean", "amplitude", "frequency"):
        return 0.0
    values = series[column]
    if column.endswith(("drag", "lift", "side")):
        values = statistics.box_filter(series["time"], values, width)
    return statistical_error(series["time"], values, window, "frequency_hz" if what == "frequency" else what)
