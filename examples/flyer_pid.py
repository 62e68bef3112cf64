"""A drive that keeps a free flyer in its place: a PID controller of the amplitude of its stroke holds the height, three
others hold the angles of the body by the means of the strokes, the difference of their amplitudes and that of the
angles of the chords, as flies do (Whitehead et al. 2015).

nervure run examples/flyer-pid.json --drive examples/flyer_pid.py

The wings beat along y. A mean off by an angle lifts beside the centre of mass and turns the body about x, a larger
stroke of one wing about y, and chords that lean against each other about z. Each angle a obeys I (a'' + b a') = M c
with its command c and the damping b by the wings, which is large about y, and a body that leans drifts:

    c = I (w² (a_wanted - a) - (2 w - b) a')/M  has the two poles -w,   y'' = -g a_x,   x'' = g a_y

So a_wanted = (v² y + 2 v y')/g for a_x has two poles at -v for a slow v, and minus that of x for a_y. The integral
finds the mean of a flight without a moment; mirror images need none about y and z.
"""

import math
from collections.abc import Mapping

FREQUENCY = 200.0  # Hz
AMPLITUDE, LEAST, LARGEST = 1.3, 0.9, 1.5  # Of the stroke before it is controlled, and its limits, rad
PITCH, LEAD, SHARPNESS = 0.7, 0.3, 2.5  # Turn of the chord from upright, rad; how early, rad; how sudden
KP, KI, KD = 1400.0, 6e4, 19.0  # rad per m, per m s, and per m/s
LAG = 1e-3  # Averaging time of the velocities, which each half stroke shakes, s
RAMP = 2.5e-3  # Time in which the wings turn upright and the stroke begins, s

GRAVITY, INERTIA = 9.81, (3.6e-13, 1e-13, 3.6e-13)  # m/s², and about x, y, z, kg m²
MOMENTS = (1.2e-8, -4.4e-8, -3.1e-8)  # About x, y, z by mean, difference of amplitudes and lean of the chords, N m
POLES, DAMPINGS = (150.0, 300.0, 150.0), (0.0, 600.0, 0.0)  # w, and b (an estimate), about x, y, z, 1/s
SLOW_POLE, SUM_POLE = 25.0, 25.0  # v, and of the integral, 1/s
FARTHEST, STEEPEST = 0.3, 0.3  # Command and wanted angle, rad

VELOCITIES = [f"body_v{axis}" for axis in "xyz"] + [f"body_omega_{axis}" for axis in "xyz"]


def within(value: float, limit: float) -> float:
    """Return the value, or the limit that it exceeds to either side."""
    return min(max(value, -limit), limit)


class Pid:
    """Returns the angles of both hinges. A checkpoint holds the averages of velocities and angular velocities, and the
    sums of the errors of the height and the angle about x. The wanted height rises by `climb`, m/s; the wings beat
    with a `frequency`, Hz."""

    def __init__(self, climb: float = 0.0, frequency: float = FREQUENCY) -> None:
        self.climb, self.frequency = climb, frequency
        self.velocities = [0.0] * 6
        self.sum, self.mean = 0.0, 0.0

    def __call__(self, time: float, values: Mapping[str, float]) -> dict[str, float]:
        step = time - values["time"]
        present = [values[name] for name in VELOCITIES]
        self.velocities = [own + step / LAG * (now - own) for own, now in zip(self.velocities, present, strict=True)]
        aside, drift, climb, *turns = self.velocities

        error = self.climb * time - values["body_z"]
        wanted = AMPLITUDE + KP * error + KI * self.sum - KD * (climb - self.climb)
        amplitude = min(max(wanted, LEAST), LARGEST)
        if amplitude == wanted:  # The sum stands still at the limits
            self.sum += step * error

        def lean(place: float, velocity: float) -> float:
            return within((SLOW_POLE**2 * place + 2 * SLOW_POLE * velocity) / GRAVITY, STEEPEST)

        leans = lean(values["body_y"], drift), -lean(values["body_x"], aside), 0.0
        off = [wanted - values[f"body_angle_{axis}"] for wanted, axis in zip(leans, "xyz", strict=True)]
        gains = [inertia / moment for inertia, moment in zip(INERTIA, MOMENTS, strict=True)]
        parts = zip(gains, POLES, DAMPINGS, off, turns, strict=True)
        commands = [gain * (w**2 * angle - (2 * w - b) * turn) for gain, w, b, angle, turn in parts]
        wanted = commands[0] + self.mean
        mean, more, chord = (within(command, FARTHEST) for command in (wanted, *commands[1:]))
        if mean == wanted:
            self.mean += step * SUM_POLE * gains[0] * POLES[0] ** 2 * off[0]

        phase, begun = math.tau * self.frequency * time, min(time / RAMP, 1.0)
        begun = begun**2 * (3 - 2 * begun)
        turned = PITCH * math.tanh(SHARPNESS * math.cos(phase + LEAD)) / math.tanh(SHARPNESS)
        return {
            "left.stroke": begun * (mean + (amplitude + more) * math.sin(phase)),
            "right.stroke": begun * (mean + (amplitude - more) * math.sin(phase)),
            "left.pitch": begun * (math.pi / 2 - turned + chord),
            "right.pitch": -begun * (math.pi / 2 - turned - chord),
        }

    def state(self) -> list[float]:
        return [*self.velocities, self.sum, self.mean]

    def restore(self, state: list[float]) -> None:
        *self.velocities, self.sum, self.mean = state


drive = Pid()
