"""A scene as an environment of gymnasium, to train controllers that act on what a scene leaves to the master."""

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import gymnasium
import numpy as np
from gymnasium.error import ClosedEnvironmentError
from gymnasium.spaces import Box

from nervure import arguments
from nervure.coupling import CouplingError, stand_still
from nervure.errors import InputError, UnitError
from nervure.files import write_whole
from nervure.gym import identity
from nervure.scene import Scene, load, with_files
from nervure.simulation.session import Session

MOST_STEPS = 100_000
"""Most communication steps in a step, of which servos keep their ways."""
LAGS = 1e-100, 1e100
"""Shortest and longest lag, s, whose square is a number."""

Values = Mapping[str, float]
Reward = Callable[[Values, np.ndarray], float]
Baseline = Callable[[np.ndarray, float], np.ndarray]
"""A controller: the action after an observation at a time, s."""


@dataclass(frozen=True)
class Action:
    """A driven input by name, and the range of its targets, in its unit.

    The input y follows the target z as a critically damped servo with the time `lag`, s:

        lag² y'' + 2 lag y' + y = z
    """

    name: str
    low: float
    high: float
    lag: float


class Servos:
    """The servos of the actions of a session, which stand at its inputs, and their way over `times`, s from now. Raise
    `InputError` for an impossible one. They are few: numbers of Python are faster than arrays."""

    def __init__(self, actions: Sequence[Action], session: Session, times: np.ndarray):
        driver = session.driver
        names = [own.name for own in actions]
        for own in actions:
            if names.count(own.name) > 1:
                raise InputError(f"there are {names.count(own.name)} actions {own.name!r}, but an input follows one")
            if own.name not in driver.rates:
                known = ", ".join(driver.rates) or "nothing"
                raise InputError(f"there is an action {own.name!r}, but the scene leaves open {known}")
            is_range = own.low < own.high and math.isfinite(own.low) and math.isfinite(own.high)
            if not (is_range and LAGS[0] <= own.lag <= LAGS[1]):
                raise InputError(
                    f"the action {own.name} has the range {own.low:g} to {own.high:g} and the lag {own.lag:g} s, but "
                    f"the range must be finite and not empty, and the lag from {LAGS[0]:g} to {LAGS[1]:g} s"
                )
        # Factors of the first distance and of the first speed, `[times, actions, 2]`, for places from the target and
        # for speeds.
        t, omega = times[:, None], np.array([1 / own.lag for own in actions])
        decay = np.exp(-omega * t)
        of_places = np.stack([(1 + omega * t) * decay, t * decay], axis=2)
        of_speeds = np.stack([-omega * omega * t * decay, (1 - omega * t) * decay], axis=2)
        self._factors = [*zip(of_places.tolist(), of_speeds.tolist(), strict=True)]
        self.places = [float(driver[own.name]) for own in actions]
        self.speeds = [0.0 for _ in actions]
        columns = [(own.name, i) for i, own in enumerate(actions)]
        columns += [(rate, len(actions) + i) for i, own in enumerate(actions) if (rate := driver.rates[own.name])]
        self.inputs = [(*driver.places[name], column) for name, column in columns]
        """Array of inputs, place in it, and column of `plan`."""

    def plan(self, targets: Sequence[float]) -> list[list[float]]:
        """Go towards `targets`; return the values at the times, places before speeds."""
        first = [(z, x - z, v) for z, x, v in zip(targets, self.places, self.speeds, strict=True)]
        rows = []
        for of_places, of_speeds in self._factors:
            self.places = [a * d + b * v + z for (a, b), (z, d, v) in zip(of_places, first, strict=True)]
            self.speeds = [a * d + b * v for (a, b), (_, d, v) in zip(of_speeds, first, strict=True)]
            rows.append(self.places + self.speeds)
        return rows


class Start:
    """The present state of a session and of its units, to which it returns without a step."""

    def __init__(self, session: Session, servos: Servos):
        self.session, self.servos, self.steps, self.time = session, servos, session.steps, session.time
        for unit in session.units.values():
            unit.get()
        self.handles = [unit.keep() for unit in session.units.values()]
        self.exchanged = [(own, own.copy()) for _, own in _exchanged(session)]
        self.memory = {name: array.copy() for name, array in session.scheme.memory().items()}
        self.places, self.speeds = servos.places, servos.speeds

    def restore(self) -> None:
        """Return to the state."""
        session = self.session
        for unit, handle in zip(session.units.values(), self.handles, strict=True):
            unit.restore(handle)
            unit.stale = False
        for own, kept in self.exchanged:
            own[:] = kept
        session.scheme.remember(self.memory)
        self.servos.places, self.servos.speeds = self.places, self.speeds
        session.steps, session.time = self.steps, self.time

    def write(self, path: Path) -> None:
        """Write the state, which is the present one, into a file."""
        arrays = {f"scheme_{name}": array for name, array in self.memory.items()} | dict(_exchanged(self.session))
        arrays["servos"] = np.array([self.places, self.speeds])
        for name, unit in self.session.units.items():
            arrays[f"{name}_state"] = np.frombuffer(unit.serialize(), np.uint8)

        def writer(unfinished: Path) -> None:
            with open(unfinished, "wb") as file:
                np.savez(file, allow_pickle=False, **arrays)

        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, writer)


def _exchanged(session: Session) -> list[tuple[str, np.ndarray]]:
    """Return the buffers of the units, by name."""
    parts = ("inputs", "outputs", "integers")
    return [(f"{name}_{part}", getattr(unit, part)) for name, unit in session.units.items() for part in parts]


def _read(session: Session, servos: Servos, path: Path) -> bool:
    """Put a started session and its servos into the state in a file; return False where it holds none of these
    units."""
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as kept:
            arrays = dict(kept)
        for name, unit in session.units.items():
            unit.deserialize(arrays[f"{name}_state"].tobytes())
        for name, own in _exchanged(session):
            own[:] = arrays[name]
        servos.places, servos.speeds = arrays["servos"].tolist()
    except (OSError, ValueError, KeyError, UnitError, BadZipFile):
        return False
    memory = [(name, array) for name, array in arrays.items() if name.startswith("scheme_")]
    session.scheme.remember({name.removeprefix("scheme_"): array for name, array in memory})
    return True


def _checked_actions(actions: Any) -> tuple[Action, ...]:
    """Return actions whose numbers are finite; raise `InputError` where there are others."""
    if not isinstance(actions, Iterable) or isinstance(actions, str):
        raise InputError(f"actions is {arguments.shown(actions)}, but must be a list of `nervure.gym.Action`")
    found = tuple(actions)
    for own in found:
        if not isinstance(own, Action):
            raise InputError(f"an action is {arguments.shown(own)}, but must be a `nervure.gym.Action`")
        for name in ("low", "high", "lag"):
            arguments.number(f"`{name}` of the action {own.name}", getattr(own, name))
    return found


class Env(gymnasium.Env[np.ndarray, np.ndarray]):
    """An environment of `scene`, an object or a name: each step sets the targets of `actions` and makes `steps`
    communication steps.

    An observation has the columns of the series, and driven inputs as `root.y`, that are the keys of `observed`, each
    by its scale there. `reward(values, action)` sees all of them at the end of the step. An episode begins at one of
    the times `starts` (s), by chance or by the option `start`, its number; until then the inputs stand still, or follow
    the controller `before`, in whole steps. It ends where `ends(values)` is true, or with the reward `failed` where a
    unit fails, and is truncated by the step that reaches the end of the scene, `time.end`. The folder `cache` keeps the
    states of the starts for other processes, by all that `before` computes with: code, values and what these refer to.
    Where a part of it can be no pickle, `InputError` is raised.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 25}  # noqa: RUF012 - as in its base

    def __init__(
        self,
        scene: Scene | str | Path,
        actions: Sequence[Action],
        observed: Mapping[str, float],
        reward: Reward,
        *,
        steps: int = 10,
        starts: Sequence[float] = (0.0,),
        before: Baseline | None = None,
        ends: Callable[[Values], bool] = lambda _values: False,
        failed: float = 0.0,
        cache: str | Path | None = None,
        render_mode: str | None = None,
    ):
        if not isinstance(scene, Scene):
            scene = load(scene)
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InputError(f"render_mode is {arguments.shown(render_mode)}, but must be None or rgb_array")
        if not (isinstance(steps, int | np.integer) and not isinstance(steps, bool) and 1 <= steps <= MOST_STEPS):
            raise InputError(f"steps is {arguments.shown(steps)}, but must be a whole number from 1 to {MOST_STEPS}")
        self.actions = _checked_actions(actions)
        if not isinstance(observed, Mapping):
            raise InputError(f"observed is {arguments.shown(observed)}, but must be a dictionary of scales by column")
        for name, scale in observed.items():
            arguments.text("a key of observed", name)
            if arguments.number(f"the scale of {name}", scale) == 0:
                raise InputError(f"{name} has the scale {scale!r}, but must have a finite one other than 0")
        arguments.function("reward", reward, "values and action")
        arguments.function("ends", ends, "values")
        if before is not None:
            arguments.function("before", before, "observation and time")
        for time in (starts := arguments.numbers("starts", starts)):
            if not 0 <= time < scene.time.end:
                raise InputError(
                    f"a start is at {time!r} s, but must be from 0 to before the end of the scene, {scene.time.end:g} s"
                )
        if len(starts) == 0:
            raise InputError("there are no starts, but an episode needs one")
        self.reward, self.steps, self.ends, self.failed = reward, int(steps), ends, arguments.number("failed", failed)
        self.before, self.render_mode, self.closed = before, render_mode, False
        self.low, self.high = (np.array([getattr(own, end) for own in self.actions], float) for end in ("low", "high"))
        self.session = Session(with_files(scene), drive=stand_still)  # Servos set its inputs
        try:
            times = self.session.grid.communication_step * np.arange(1, steps + 1)
            self.servos = Servos(self.actions, self.session, times)
            self.values = self.session.recorder.values
            self.observed = [(name, 1 / scale) for name, scale in observed.items()]
            self._read = self.values.reader([*observed])
            self._factors = np.array([factor for _, factor in self.observed])
            self.starts = self._make_starts(starts, None if cache is None else arguments.path("cache", cache))
        except BaseException:
            self.session.close()
            raise
        self.action_space = Box(self.low, self.high, dtype=np.float64)
        self.observation_space = Box(-np.inf, np.inf, (len(self.observed),), np.float64)

    def _make_starts(self, times: Sequence[float], cache: Path | None) -> list[Start]:
        """Step to each of `times`, s, or read the state from the folder `cache`, and keep it."""
        session, found = self.session, {}
        made_by = [unit.description.guid for unit in session.units.values()]
        if self.before and cache:
            try:
                made_by += [self.steps, *self.actions, *self.observed, identity.digest(self.before)]
            except identity.UnknownError as error:
                raise InputError(
                    f"the folder `cache` cannot tell `before` from another controller: it holds {error}; leave `cache` "
                    "out, or give a controller without it"
                ) from error
        digest = hashlib.blake2b(" ".join(map(str, made_by)).encode(), digest_size=16).hexdigest()
        session.start()
        for unit in session.units.values():
            unit.all_in_step = False
        for time in sorted(times):
            whole = self.steps if self.before else 1
            steps = whole * round(time / session.grid.communication_step / whole)
            path = cache and cache / f"{digest}-{steps}.npz"
            before = Start(session, self.servos)
            if read := path is not None and _read(session, self.servos, path):
                session.steps, session.time = steps, steps * session.grid.communication_step
            else:
                before.restore()
                while self.before and session.steps < steps:
                    given = self.before(self._observe(), session.time)
                    self._follow(self._targets("what `before` returns", given))
                self._advance([()] * (steps - session.steps))
            found[time] = Start(session, self.servos)
            if path and not read:
                try:
                    found[time].write(path)
                except OSError as error:
                    raise InputError(f"cannot write into the folder `cache`, {cache}: {error.strerror}") from error
        return [found[time] for time in times]

    def _targets(self, name: str, given: Any) -> np.ndarray:
        """Return targets as an array; raise `InputError` where they are no finite numbers, one for each action."""
        try:
            targets = np.asarray(given, float)
        except (TypeError, ValueError):
            targets = np.array(math.nan)
        if targets.shape != self.low.shape or not all(map(math.isfinite, targets.tolist())):
            count = len(self.actions)
            raise InputError(f"{name} is {given!r}, but must be {count} finite number{'s' * (count != 1)}")
        return targets

    def _follow(self, targets: np.ndarray) -> np.ndarray:
        """Make a step towards targets; return those within the ranges."""
        targets = np.minimum(np.maximum(targets, self.low), self.high)  # Faster than `clip`
        self._advance(self.servos.plan(targets.tolist()))
        return targets

    def _advance(self, rows: Sequence[Sequence[float]]) -> None:
        """Make a communication step for each of `rows` of the servos."""
        session, h, inputs = self.session, self.session.grid.communication_step, self.servos.inputs
        step, checks = session.scheme.step, [guard.check for guard in session.scheme.guards]
        number = session.steps
        try:
            for row in rows:
                for array, place, column in inputs if row else ():
                    array[place] = row[column]
                t = number * h
                step(t, h)
                for check in checks:
                    check(t + h, h)
                number += 1
                session.time = t + h
        finally:
            session.steps = number
        session.recorder.values.time = session.time

    def _observe(self) -> np.ndarray:
        seen: np.ndarray = self._read() * self._factors
        return seen

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Return to a start; `options["start"]` is its number."""
        self._require_open()
        super().reset(seed=seed)
        if not (options is None or isinstance(options, Mapping)):
            raise InputError(f"options is {arguments.shown(options)}, but must be a dictionary")
        number = (options or {}).get("start")
        if number is None:
            number = int(self.np_random.integers(len(self.starts)))
        elif number not in range(len(self.starts)):
            raise InputError(f"the option start is {number!r}, but must be from 0 to {len(self.starts) - 1}")
        self.starts[int(number)].restore()
        self.values.time = self.session.time
        self._last = self._observe()
        return self._last, {"time": self.session.time, "start": number}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Follow the targets `action`, clipped to their ranges, for `steps` communication steps."""
        self._require_open()
        targets = self._targets("the action", action)
        try:
            targets = self._follow(targets)
            self._last = self._observe()
        except (UnitError, CouplingError) as failure:
            return self._last, self.failed, True, False, {"time": self.session.time, "error": str(failure)}
        given = self.reward(self.values, targets)
        try:
            reward = float(given)
        except (TypeError, ValueError):
            reward = math.nan
        if not math.isfinite(reward):
            raise InputError(f"the reward is {given!r} at t = {self.session.time:g} s, but must be a finite number")
        ended = bool(self.ends(self.values))
        truncated = self.session.steps >= self.session.grid.steps
        return self._last, reward, ended, truncated, {"time": self.session.time}

    def render(self) -> np.ndarray | None:
        """Return the picture of the flow as it is now, `[height, width, 3]`, in the mode rgb_array."""
        if self.render_mode is None:
            gymnasium.logger.warn("the environment has no render_mode, which may be rgb_array")
            return None
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        from nervure.output import plots

        figure = plots.vorticity(self.session)
        if figure is None:
            raise InputError("there is no picture, as the scene has no fluid that shows its vorticity")
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba())[..., :3].copy()

    def close(self) -> None:
        """Free the units."""
        self.closed = True
        self.session.close()

    def _require_open(self) -> None:
        if self.closed:
            raise ClosedEnvironmentError("the environment is closed, and steps no more")
