"""Estimates of errors from runs at several sizes h of a parameter, 1 in the finest of them.

Four expansions are fitted by least squares with the weights 1/h (Eça & Hoekstra 2014),

    phi = phi_0 + a h^p,   phi_0 + a h,   phi_0 + a h²,   phi_0 + a_1 h + a_2 h²

of which the one with the smallest standard deviation sigma counts. A free order p outside of `ORDERS` is that of noise,
or of sizes that are too large. The error of the finest value is epsilon = phi_1 − phi_0; the 95 % bar of phi_0 is

    U = SPREAD |epsilon| + sigma + |phi_1 − fit_1|    where sigma is below the mean distance of the values, Delta,
    U = SCATTER (the range of the values)             else, around the mean of both ends; then nothing converges

and with the statistical errors of the values, as the fit carries them to phi_0, in the square. Two values show no
order: the bar holds all errors of an order between `ORDERS`.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from nervure.evaluate import statistics
from nervure.evaluate.statistics import Series, Window
from nervure.extras import require
from nervure.simulation.verified import Share, is_part

ORDERS = (1.0, 2.0)  # Of the method: first at bodies, second elsewhere
LEAST, LARGEST = 0.5, 2.2  # Observed orders that count
SPREAD, SCATTER = 0.6, 1.5
COVERED = 0.975  # Quantile of a two-sided bar of 95 %
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


Terms = list[tuple[float, float]]


def _estimate(h: np.ndarray, phi: np.ndarray, noise: np.ndarray) -> tuple[Terms, float, float | None, str]:
    if phi.size == 1:
        return [], math.inf, None, "one run"
    extent = float(np.ptp(phi))
    if extent <= float(np.hypot(noise.min(), noise.max())):
        return [], float(extent + noise[0]), None, "noise"
    if phi.size == 2:
        return _of_two(h, phi, noise)
    steps = np.diff(phi)
    fits = [_fit(h, phi, exponents) for exponents in ((1.0,), (2.0,), *(((1.0, 2.0),) if phi.size > 3 else ()))]
    observed = _order(h, phi) if np.all(steps > 0) or np.all(steps < 0) else None
    if observed is not None and LEAST <= observed <= LARGEST:
        fits.append(_fit(h, phi, (observed,)))
    best = min(fits, key=lambda fit: fit[1])
    (limit, *coefficients), sigma, exponents, carried = best
    epsilon = float(sum(coefficients))
    if sigma < extent / (phi.size - 1):
        kind = "converging" if observed is not None else "oscillating"
        numerical = SPREAD * abs(epsilon) + sigma + abs(float(phi[0]) - limit - epsilon)
        statistical = float(np.linalg.norm(carried * noise))
        return list(zip(coefficients, exponents, strict=True)), math.hypot(numerical, statistical), observed, kind
    return [], math.hypot(SCATTER * extent, float(noise[0])), None, "scattered"


def _of_two(h: np.ndarray, phi: np.ndarray, noise: np.ndarray) -> tuple[Terms, float, float | None, str]:
    """Return the middle of the errors of the largest and the smallest order, and a bar that holds 0 and both."""
    ratio, difference = h[1], float(phi[1] - phi[0])
    errors = [difference / (ratio**order - 1) for order in ORDERS]
    middle = (ORDERS[0] + ORDERS[1]) / 2
    coefficient = sum(errors) / 2
    statistical = float(np.linalg.norm(noise)) / (ratio**middle - 1)
    return [(coefficient, middle)], math.hypot(abs(coefficient), statistical), None, "two runs"


def _fit(
    h: np.ndarray, phi: np.ndarray, exponents: Sequence[float]
) -> tuple[list[float], float, Sequence[float], np.ndarray]:
    """Return limit and coefficients of an expansion, its standard deviation, its exponents, and the weights with which
    the values make the limit."""
    weights = np.sqrt(1 / h / (1 / h).mean())
    matrix = np.column_stack([np.ones_like(h), *(h**exponent for exponent in exponents)])
    inverse = np.linalg.pinv(weights[:, None] * matrix) * weights
    found = inverse @ phi
    rest = weights * (phi - matrix @ found)
    sigma = math.sqrt(float(rest @ rest) / max(1, phi.size - matrix.shape[1]))
    return found.tolist(), sigma, exponents, inverse[0]


def _order(h: np.ndarray, phi: np.ndarray) -> float:
    """Return the order of the least squares of phi_0 + a h^p."""
    search = require("scipy.optimize", "a verification").minimize_scalar

    def distance(order: float) -> float:
        return _fit(h, phi, (order,))[1]

    return float(search(distance, bounds=(0.1, 8.0), method="bounded").x)


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
        return _of_mean(1 / lengths) if lengths.size > 1 else 0.0
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
