"""Observed order and Richardson's extrapolation of a sequence, and whether it may be believed."""

from dataclasses import dataclass

MOST_ORDER, LEAST_ORDER = 2.75, 0.75
"""What is believed of methods of first and second order."""
ALIKE = 0.5
"""Largest difference of the orders of the last three values and of the three before the last."""


@dataclass(frozen=True)
class Limit:
    """Of the last three values of a sequence."""

    order: float | None
    value: float | None
    verdict: str


def limit(sizes: list[float], values: list[float], most: float = MOST_ORDER) -> Limit:
    """What the last values say, with an order of at most `most`; with four values or more the order must have
    settled."""
    last = through(sizes, values)
    if last.order is None:
        return last
    if not LEAST_ORDER <= last.order <= most:
        return Limit(last.order, None, f"not asymptotic: the order would be {last.order:.1f}")
    if len(values) == 3:
        return Limit(last.order, last.value, "three values only: the order is not confirmed")
    before = through(sizes[:-1], values[:-1])
    if before.order is None or abs(before.order - last.order) > ALIKE:
        return Limit(last.order, None, "not asymptotic: the order has not settled")
    return last


def through(sizes: list[float], values: list[float]) -> Limit:
    """f(h) = f0 + c h^p through the last three values, p by bisection; `sizes` are numbers of cells, ascending."""
    h = [1 / size for size in sizes[-3:]]
    a, b, c = values[-3:]
    first, second = b - a, c - b
    if second == 0 or first / second <= 0:
        return Limit(None, None, "not asymptotic: the differences change sign")

    def excess(p: float) -> float:
        return float((h[0] ** p - h[1] ** p) / (h[1] ** p - h[2] ** p) - first / second)

    low, high = 0.01, 20.0
    if excess(low) * excess(high) > 0:
        return Limit(None, None, "not asymptotic: the differences do not fall like a power of the cell")
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if excess(low) * excess(middle) > 0 else (low, middle)
    return Limit(low, c + second / (h[1] ** low - h[2] ** low) * h[2] ** low, "asymptotic")


def front(points: list[tuple[float, float]]) -> list[int]:
    """Indices of the points (cost, error) that no other one beats in both, by cost."""
    best, chosen = float("inf"), []
    for i in sorted(range(len(points)), key=lambda i: points[i]):
        if points[i][1] < best:
            best = points[i][1]
            chosen.append(i)
    return chosen
