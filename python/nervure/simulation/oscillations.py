"""Detect grid-scale oscillations, which extrapolated advection amplifies at large time steps.

In a stream U, SBDF2 with three terms of extrapolation amplifies waves of the wave number k where k U dt > 0.67. Heun's
method amplifies all with the rate 1/8 (k U)⁴ dt³, the first term of its amplification factor, while they decay with
ν k². Results hardly show it: such waves cancel in forces.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from nervure.coupling.guards import below
from nervure.scene.solids import cell_lengths
from nervure.scene.types import Fluid
from nervure.simulation.loop import TimeGrid
from nervure.units.fmu import Unit

LEFT = 0.8  # Of the highest wave number: above, the filter damps
NEUTRAL = 0.67  # k U dt up to which SBDF2 amplifies no wave
SHORT, LONGER = (0.7, 0.85), (0.5, 0.65)  # Bands of waves, parts of the highest wave number; in flows the first is less
LEAST = 0.005  # Part of the enstrophy in short waves above which the run warns
CHECKS = 8  # In a run


class GridOscillationMonitor:
    """Checks whether the vorticity about z, in space in the middle of the box, has more waves of two to three cells
    than of three to four."""

    def __init__(self, flow: Fluid, fluid: Unit, grid: TimeGrid):
        self.flow, self.fluid = flow, fluid
        self.longest = min(grid.communication_step, flow.time_stepping.max_step)
        """Longest step of the fluid, s."""
        self.checks = {round(grid.steps * i / CHECKS) for i in range(1, CHECKS + 1)}
        """Steps of the run after which it checks."""
        self.seen: set[str] = set()
        """Axes along which the last check found some; the start of a flow may have them for a while."""

    def check(self, step: int, time: float, warned: Sequence[str]) -> list[str]:
        """Return warnings about what two checks in turn have found, the second after `step`, and no one `warned` of."""
        if step not in self.checks:
            return []
        known = {text.partition(":")[0] for text in warned}
        found = {axis: text for axis, text in self._found(time) if text.partition(":")[0] not in known}
        again = [text for axis, text in found.items() if axis in self.seen]
        self.seen = set(found)
        return again

    def _found(self, time: float) -> Iterator[tuple[str, str]]:
        vorticity, cells = _plane(self.fluid, "vorticity"), cell_lengths(self.flow)
        if not vorticity.any():
            return
        speeds = [float(np.abs(_plane(self.fluid, name)).max(initial=0.0)) for name in "uvw"[: len(cells)]]
        rate = sum(speed / cell for speed, cell in zip(speeds, cells, strict=True)) or np.finfo(float).tiny
        step = min(self.longest, self.flow.time_stepping.max_cfl / rate)
        for i, axis in enumerate("xy"):
            wave = np.abs(np.fft.rfft(vorticity, axis=i)) ** 2
            by_order = 2 * wave.mean(axis=1 - i) / vorticity.shape[i] ** 2 / (vorticity.var() or 1.0)
            short, longer = (_share(by_order, *band) for band in (SHORT, LONGER))
            most = _longest_step(self.flow, cells[i], speeds[i])
            if short > max(longer, LEAST) and step > most:
                yield (
                    axis,
                    f"short waves along {axis}: at t = {time:.4g} s waves of two to three cells hold {short:.1%} of "
                    f"the square of the vorticity, because they grow in steps of {step:.2g} s at {speeds[i]:.3g} m/s; "
                    f"`fluid.time_stepping.max_step` of {below(most)} s damps them",
                )


def _plane(fluid: Unit, name: str) -> np.ndarray:
    """Return a field, `[nx, ny]`, in space that in the middle of the box along z; empty if the unit shows none."""
    field = fluid.shown_field(name)
    if field is None:
        return np.empty((0, 0))
    return field[:, :, field.shape[2] // 2].copy() if field.ndim == 3 else field


def _share(by_order: np.ndarray, low: float, high: float) -> float:
    """Return the part of the waves between two parts of the highest order."""
    n = len(by_order) - 1
    return float(by_order[int(low * n) : int(high * n)].sum())


def _longest_step(flow: Fluid, cell: float, speed: float) -> float:
    """Return the step (s) above which a wave along an axis with cells of `cell` (m) grows at `speed` (m/s)."""
    k, speed = LEFT * np.pi / cell, max(speed, 1e-30)
    if flow.time_stepping.scheme == "sbdf2":
        return float(NEUTRAL / (k * speed))
    return float((8 * flow.kinematic_viscosity / (k**2 * speed**4)) ** (1 / 3))
