"""Coefficients of every body in the flow, over the window of the run.

    c = 2 F / (rho U² L),   C_P = 2 P / (rho U³ L),   St = f L / U

with F and P per metre of depth, U that of `evaluate.dimensionless`, and L the body's own: its diameter or its length.
Thrust and power are averages over time; drag and lift have mean and amplitude by their extremes, as everywhere.
"""

from dataclasses import dataclass

import numpy as np

from nervure.evaluate import flapping, statistics
from nervure.evaluate.dimensionless import Dimensionless
from nervure.evaluate.statistics import Window
from nervure.recorder import Series
from nervure.scene import Scene


@dataclass(frozen=True, kw_only=True)
class BodyCoefficients:
    """Those of one body. Drag is the force along x and lift that along y, thrust the force against the stream, or
    against x where there is none."""

    cd_mean: float
    cd_amplitude: float
    cl_mean: float
    cl_amplitude: float
    ct: float
    cp: float | None  # Of the power that the drive of the root puts in; None without one
    st: float | None  # By the frequency of the lift; None where it does not oscillate
    st_tip: float | None  # f A / U, A from end to end of the tip's path along the axis on which it goes farthest


def evaluate(
    scene: Scene, numbers: Dimensionless | None, series: Series, window: Window, width: float
) -> dict[str, BodyCoefficients]:
    """The coefficients by body; none where nothing drives the flow. Drag and lift are filtered over `width` (s)."""
    if scene.fluid is None or numbers is None or not numbers.velocity:
        return {}
    time, velocity = series["time"], numbers.velocity
    stream = flapping.stream(scene, window)
    ahead = np.array([-1.0, 0.0]) if stream is None else -stream / np.linalg.norm(stream)
    found = {}
    for name, body in numbers.bodies.items():
        forces = [f"{name}_drag", f"{name}_lift"]
        if not series.keys() >= {*forces}:
            continue
        pressure = scene.fluid.density * velocity**2 * body.length / 2
        drag, lift = (
            statistics.evaluate(time, statistics.box_filter(time, series[force], width), window) for force in forces
        )
        thrust = ahead @ [flapping.average(time, series[force], window) for force in forces]
        driven = name == "beam" and "root_power" in series
        found[name] = BodyCoefficients(
            cd_mean=drag.mean / pressure,
            cd_amplitude=drag.amplitude / pressure,
            cl_mean=lift.mean / pressure,
            cl_amplitude=lift.amplitude / pressure,
            ct=float(thrust) / pressure,
            cp=flapping.average(time, series["root_power"], window) / (pressure * velocity) if driven else None,
            st=lift.frequency_hz * body.length / velocity if lift.frequency_hz and window.periods else None,
            st_tip=_tip(series, window, velocity) if name == "beam" else None,
        )
    return found


def _tip(series: Series, window: Window, velocity: float) -> float | None:
    tip = f"tip_u{flapping.main_axis(series) or 'y'}"
    if tip not in series or window.periods == 0:
        return None
    path = statistics.evaluate(series["time"], series[tip], window)
    return path.frequency_hz * 2 * path.amplitude / velocity if path.frequency_hz else None
