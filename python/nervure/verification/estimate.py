"""Estimates of errors from runs at several sizes h of a parameter, after Eça & Hoekstra (2014).

Expansions are fitted by least squares, with the weights h^-3, to the values phi of the three finest runs: the limit is
nearer to them, and coarser ones are often of another flow. Of five and more runs that follow it to `CLEAR` all count:

    phi = phi_0 + a h^p,  1 <= p <= 2      of five runs also      phi = phi_0 + a_1 h + a_2 h²,  a_1 a_2 > 0

The one with the smallest standard deviation sigma says that the finest value is off by epsilon = phi_1 − phi_0. Three
runs do not show whether it is: where the place of the grid makes some per cent, their order is chance. So the limit is
corrected by a half of epsilon, and its 95 % bar is

    U = 3/4 epsilon + sigma + |phi_1 − fit_1| + 1/2 max_i |phi_i − phi_1| / ((h_i/h_1)² − 1)

The last term, over all runs, is the error if the method has its largest order, and guards against values that agree by
chance. Where five runs follow the expansion, the whole epsilon is corrected, and U is a half of it. Two runs are
corrected by a half of the mean error of orders 1 and 2, and U is that error. Statistical errors of the values, as they
reach the limit, are added in squares. `studies/coverage.py` shows what these bars hold.
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
FACTORS = 0.75, 1.0, 0.5  # Of the three terms of U
FITTED, MANY = 3, 5  # Finest runs that are fitted, and runs that may all be
CLEAR = 0.01  # Largest sigma of many runs, relative to the range of their values
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
    its 95 % bar. The other parameters were varied on coarse runs: their errors widen the bar, and correct nothing."""
    first = next(iter(shares.values()))
    limit = first.values[0] - first.error(first.sizes[0])
    return first.values[0], limit, math.hypot(*bars(shares).values())


def bars(shares: Mapping[str, Share]) -> dict[str, float]:
    """Return the bars of a quantity by parameter: of the limit by the first one, by the others at the size 1."""
    first, *_ = shares
    return {
        name: share.uncertainty if name == first else share.bar()
        for name, share in shares.items()
        if not is_part(name, shares)
    }


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
    extent, scatter = float(np.ptp(phi[:FITTED])), noise[:FITTED]
    if extent <= math.hypot(scatter.min(), scatter.max()):
        return [], float(extent + noise[0]), None, "noise"
    if phi.size == 2:
        coefficient = float(np.mean([(phi[1] - phi[0]) / (h[1] ** order - 1) for order in ORDERS]))
        middle = sum(ORDERS) / 2
        statistical = HALF * float(np.linalg.norm(noise)) / (h[1] ** middle - 1)
        return _terms([coefficient], [middle], HALF), math.hypot(coefficient, statistical), None, "two runs"
    steps, reach = np.diff(phi), h[1:] ** ORDERS[1] - 1
    kind = "converging" if abs(np.sign(steps[: FITTED - 1]).sum()) == FITTED - 1 else "oscillating"
    observed = _order(h, phi, SEARCHED) if kind == "converging" else None
    if (clear := _clear(h, phi)) is not None:
        bar = math.hypot(HALF * clear.error, float(np.linalg.norm(clear.carried * noise)))
        return _terms(clear.coefficients, clear.exponents, 1.0), bar, observed, kind
    near, values = h[:FITTED], phi[:FITTED]
    best = _fit(near, values, (_order(near, values, ORDERS),))
    missed = best.sigma + abs(float(phi[0]) - best.limit - best.error)
    agreed = float(np.max(np.abs(phi[1:] - phi[0]) / reach))
    numerical = float(np.dot(FACTORS, (abs(best.error), missed, agreed)))
    to_limit = HALF * best.carried
    to_limit[0] += 1 - HALF
    statistical = float(np.linalg.norm(to_limit * noise[:FITTED]))
    return _terms(best.coefficients, best.exponents, HALF), math.hypot(numerical, statistical), observed, kind


def _clear(h: np.ndarray, phi: np.ndarray) -> _Fit | None:
    """Return the expansion that many runs follow; None where there is none."""
    if phi.size < MANY:
        return None
    mixed = _fit(h, phi, ORDERS)
    fits = [_fit(h, phi, (_order(h, phi, ORDERS),)), *([mixed] if np.prod(mixed.coefficients) > 0 else [])]
    best = min(fits, key=lambda fit: fit.sigma)
    return best if best.sigma < CLEAR * float(np.ptp(phi)) else None


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
    scatter of its periods, as batches; of one period from the one that begins half of it earlier; without periods from
    the drift between the parts of the window."""
    half = (window.end - window.begin) / 2
    if window.periods == 1 and what != "frequency_hz" and window.begin - half >= time[0]:
        last, before = (values[own.of(time)] for own in (window, Window(window.begin - half, window.end - half, 1)))
        pair = (last.mean(), before.mean()) if what == "mean" else (np.ptp(last) / 2, np.ptp(before) / 2)
        return float(abs(pair[0] - pair[1]))
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
    """Return the 95 % error of the mean of `batches` by Student's distribution; of two, whose scatter says nothing, as
    of three."""
    quantile = require("scipy.stats", "a verification").t.ppf(COVERED, max(2, batches.size - 1))
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
