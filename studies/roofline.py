"""Shares of the machine's bandwidth and arithmetic that a part of a program reaches."""

from collections.abc import Mapping
from typing import Any


def reached(part: Mapping[str, Any], bandwidth: float, peak: float) -> dict[str, float]:
    """Return GB/s and Gflop/s of a part from its `µs`, `MB` and `Mflop`, their shares of the machine's peaks, and the
    times at these peaks, µs."""
    rates = {"GB/s": 1e3 * part["MB"] / part["µs"], "Gflop/s": 1e3 * part["Mflop"] / part["µs"]}
    shares = {"of bandwidth": rates["GB/s"] / bandwidth, "of peak": rates["Gflop/s"] / peak}
    floors = {"by bytes": 1e3 * part["MB"] / bandwidth, "by operations": 1e3 * part["Mflop"] / peak}
    return rates | shares | floors
