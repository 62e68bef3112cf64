"""A drive that turns the root of a plate until its lift is as wanted: a PID controller.

nervure run examples/steered-plate.json --drive examples/drive_pid.py
"""

from collections.abc import Mapping

WANTED = 0.5  # Lift, N/m
KP, KI, KD = 0.3, 2.5, 0.01  # rad per N/m, and per s; rad s per N/m
LAG = 0.2  # Averaging time of the lift, which jumps with the acceleration of the plate, s


class Pid:
    """Returns the angle of the root; a checkpoint holds the average of the lift and the sum of the error."""

    def __init__(self) -> None:
        self.average, self.sum = 0.0, 0.0

    def __call__(self, time: float, values: Mapping[str, float]) -> dict[str, float]:
        step = time - values["time"]
        rate = (values["lift"] - self.average) / LAG
        self.average += step * rate
        error = WANTED - self.average
        self.sum += step * error
        return {"root.angle": KD * rate - KP * error - KI * self.sum}

    def state(self) -> list[float]:
        return [self.average, self.sum]

    def restore(self, state: list[float]) -> None:
        self.average, self.sum = state


drive = Pid()
