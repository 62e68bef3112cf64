"""A drive that keeps a flyer in its place: a PID controller of the amplitude of its stroke holds the height, and one of
the mean of its stroke the pitch of the body, as flies do (Whitehead et al. 2015).

nervure run examples/flyer-pid.json --drive examples/flyer_pid.py

The wings beat along y. A mean off by an angle m lifts beside the centre of mass and turns the body about x, and a body
that leans by an angle a drifts:

    I a'' = TURNING m,    y'' = -g a

So m = -I (w² (a - a_wanted) + 2 w a')/TURNING has the two poles -w, and a_wanted = (v² y + 2 v y')/g two at -v for a
slow v. The integral finds the mean of a flight without a moment.
"""

import math
from collections.abc import Mapping

FREQUENCY = 200.0  # Hz
AMPLITUDE, LEAST, LARGEST = 1.3, 0.9, 1.5  # Of the stroke before it is controlled, and its limits, rad
PITCH, LEAD, SHARPNESS = 0.7, 0.3, 2.5  # Turn of the chord from upright, rad; how early, rad; how sudden
WANTED = 0.0  # Height, m
KP, KI, KD = 1400.0, 6e4, 19.0  # rad per m, per m s, and per m/s
LAG = 1e-3  # Averaging time of the velocities, which each half stroke shakes, s
RAMP = 2.5e-3  # Time in which the wings turn upright and the stroke begins, s

GRAVITY, INERTIA = 9.81, 3.6e-13  # m/s², and about x, kg m²
TURNING = 1.2e-8  # Moment about x by the mean of the stroke, N m
POLE, SLOW_POLE, SUM_POLE = 150.0, 25.0, 25.0  # w and v, and of the integral, 1/s
FARTHEST, STEEPEST = 0.3, 0.3  # Mean of the stroke and wanted angle, rad


def within(value: float, limit: float) -> float:
    """Return the value, or the limit that it exceeds to either side."""
    return min(max(value, -limit), limit)


class Pid:
    """Returns the angles of both hinges. A checkpoint holds the averages of climb, drift and turn, and the sums of both
    errors."""

    def __init__(self) -> None:
        self.climb, self.drift, self.turn = 0.0, 0.0, 0.0
        self.sum, self.mean = 0.0, 0.0

    def __call__(self, time: float, values: Mapping[str, float]) -> dict[str, float]:
        step = time - values["time"]
        self.climb += step / LAG * (values["body_vz"] - self.climb)
        self.drift += step / LAG * (values["body_vy"] - self.drift)
        self.turn += step / LAG * (values["body_omega_x"] - self.turn)

        error = WANTED - values["body_z"]
        wanted = AMPLITUDE + KP * error + KI * self.sum - KD * self.climb
        amplitude = min(max(wanted, LEAST), LARGEST)
        if amplitude == wanted:  # The sum stands still at the limits
            self.sum += step * error

        lean = (SLOW_POLE**2 * values["body_y"] + 2 * SLOW_POLE * self.drift) / GRAVITY
        off = within(lean, STEEPEST) - values["body_angle_x"]
        wanted = INERTIA / TURNING * (POLE**2 * off - 2 * POLE * self.turn) + self.mean
        mean = within(wanted, FARTHEST)
        if mean == wanted:
            self.mean += step * SUM_POLE * INERTIA / TURNING * POLE**2 * off

        phase, begun = math.tau * FREQUENCY * time, min(time / RAMP, 1.0)
        begun = begun**2 * (3 - 2 * begun)
        stroke = begun * (mean + amplitude * math.sin(phase))
        turned = math.tanh(SHARPNESS * math.cos(phase + LEAD)) / math.tanh(SHARPNESS)
        pitch = begun * (math.pi / 2 - PITCH * turned)
        return {"left.stroke": stroke, "right.stroke": stroke, "left.pitch": pitch, "right.pitch": -pitch}

    def state(self) -> list[float]:
        return [self.climb, self.drift, self.turn, self.sum, self.mean]

    def restore(self, state: list[float]) -> None:
        self.climb, self.drift, self.turn, self.sum, self.mean = state


drive = Pid()
