"""What a part of a program reaches of the machine's bandwidth and arithmetic."""

from collections.abc import Mapping
from typing import Any


def reached(part: Mapping[str, Any], bandwidth: float, peak: float) -> dict[str, float]:
    """GB/s and Gflop/s of a part by its `µs`, `MB` and `Mflop`, their shares of what the machine does, and the µs that
    either would take at that."""
    rates = {"GB/s": 1e3 * part["MB"] / part["µs"], "Gflop/s": 1e3 * part["Mflop"] / part["µs"]}
    shares = {"of bandwidth": rates["GB/s"] / bandwidth, "of peak": rates["Gflop/s"] / peak}
    floors = {"by bytes": 1e3 * part["MB"] / bandwidth, "by operations": 1e3 * part["Mflop"] / peak}
    return rates | shares | floors
