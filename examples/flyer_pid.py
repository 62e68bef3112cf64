"""A drive that keeps a flyer at its height: a PID controller of the amplitude of its stroke.

nervure run examples/flyer-pid.json --drive examples/flyer_pid.py
"""

import math
from collections.abc import Mapping

FREQUENCY = 200.0  # Hz
AMPLITUDE, LEAST, LARGEST = 1.3, 0.9, 1.5  # Of the stroke before it is controlled, and its limits, rad
PITCH, LEAD, SHARPNESS = 0.7, 0.3, 2.5  # Turn of the chord from upright, rad; how early, rad; how sudden
WANTED = 0.0  # Height, m
KP, KI, KD = 1400.0, 6e4, 19.0  # rad per m, per m s, and per m/s
LAG = 1e-3  # Averaging time of the climb, which each half stroke shakes, s
RAMP = 2.5e-3  # Time in which the wings turn upright and the stroke begins, s


class Pid:
    """Returns the angles of both hinges; a checkpoint holds the average of the climb and the sum of the error."""

    def __init__(self) -> None:
        self.climb, self.sum = 0.0, 0.0

    def __call__(self, time: float, values: Mapping[str, float]) -> dict[str, float]:
        step = time - values["time"]
        self.climb += step / LAG * (values["body_vz"] - self.climb)
        error = WANTED - values["body_z"]
        wanted = AMPLITUDE + KP * error + KI * self.sum - KD * self.climb
        amplitude = min(max(wanted, LEAST), LARGEST)
        if amplitude == wanted:  # The sum stands still at the limits
            self.sum += step * error
        phase, begun = math.tau * FREQUENCY * time, min(time / RAMP, 1.0)
        begun = begun**2 * (3 - 2 * begun)
        stroke = begun * amplitude * math.sin(phase)
        turned = math.tanh(SHARPNESS * math.cos(phase + LEAD)) / math.tanh(SHARPNESS)
        pitch = begun * (math.pi / 2 - PITCH * turned)
        return {"left.stroke": stroke, "right.stroke": stroke, "left.pitch": pitch, "right.pitch": -pitch}

    def state(self) -> list[float]:
        return [self.climb, self.sum]

    def restore(self, state: list[float]) -> None:
        self.climb, self.sum = state


drive = Pid()
