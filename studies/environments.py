"""What environments cost: steps and resets, Python's part of a step, and several of them in processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

import gymnasium
import numpy as np

from nervure.gym import BASELINES, DaskVectorEnv
from studies import simulate
from studies.engine import COUPLED, Case, Run, Study
from studies.store import Data

SOURCES = (*COUPLED, "wing", "body", "command")
FMI = ("_set_reals", "_do_step", "_get_reals", "_get_integers")  # Functions of a unit that a step calls
STEPS, ROUNDS, RESETS = 50, 20, 200
SWIMMER, PROCESSES = "nervure/Swimmer-v0", (1, 2, 4)


def per_step(clock: Callable[[], float], step: Callable[[Any], Any], actions: Sequence[Any]) -> float:
    """Return the time of a step, s."""
    begin = clock()
    for action in actions:
        step(action)
    return (clock() - begin) / len(actions)


def controlled(env: gymnasium.Env[Any, Any], name: str) -> list[np.ndarray]:
    """Return the first actions of the classical controller from the first start."""
    seen, info = env.reset(options={"start": 0})
    space: Any = env.action_space
    actions = []
    for _ in range(STEPS):
        actions.append(np.clip(BASELINES[name](seen, info["time"]), space.low, space.high))
        seen, *_, info = env.step(actions[-1])
    return actions


def alone(case: Case, _folder: Path) -> dict[str, Any]:
    """Return the medians of processor times of a step and of a reset, ms, and of the part of a step's wall time outside
    of the functions of the units."""
    name = case.options["task"]
    env = gymnasium.make(name)
    actions, own = controlled(env, name), getattr(env.unwrapped, "session")  # noqa: B009 - of any environment
    plain = [(unit, function, getattr(unit, function)) for unit in own.units.values() for function in FMI]

    def episode(clock: Callable[[], float]) -> float:
        env.reset(options={"start": 0})
        return per_step(clock, env.step, actions)

    steps, parts = [], []
    for _ in range(ROUNDS):
        steps.append(episode(process_time))
        whole, spent = episode(perf_counter), {"fmi": 0.0}
        for unit, function, call in plain:
            setattr(unit, function, simulate.timed(call, spent, "fmi"))
        env.reset(options={"start": 0})
        spent["fmi"] = 0.0
        per_step(perf_counter, env.step, actions)
        for unit, function, call in plain:
            setattr(unit, function, call)
        parts.append(1 - spent["fmi"] / len(actions) / whole)
    resets = [per_step(process_time, lambda _: env.reset(), [None]) for _ in range(RESETS)]
    env.close()
    return {"times": {"step_ms": 1e3 * median(steps), "reset_ms": 1e3 * median(resets), "python": median(parts)}}


def several(case: Case, _folder: Path) -> dict[str, Any]:
    """Return environment steps a second of wall time in each number of processes, which step in turns, and the median
    ratio of those in four to those in two."""
    make = partial(gymnasium.make, f"nervure.gym:{SWIMMER}")
    rates: dict[int, list[float]] = {count: [] for count in PROCESSES}
    with ExitStack() as stack:
        vectors: dict[int, gymnasium.vector.VectorEnv[Any, Any, Any]] = {}
        for count in PROCESSES:
            kind = case.options["kind"]
            vectors[count] = (
                DaskVectorEnv(make, count)
                if kind == DaskVectorEnv.__name__
                else gymnasium.vector.AsyncVectorEnv([make] * count)
            )
            stack.callback(vectors[count].close)
        for _ in range(ROUNDS):
            for count, env in vectors.items():
                env.reset(seed=1)
                env.action_space.seed(1)
                actions = [env.action_space.sample() for _ in range(STEPS)]
                rates[count].append(count / per_step(perf_counter, env.step, actions))
    ratio = median(four / two for four, two in zip(rates[4], rates[2], strict=True))
    return {"times": {f"rate_{count}": median(found) for count, found in rates.items()} | {"ratio": ratio}}


def cases() -> Iterator[Case]:
    for name in BASELINES:
        yield Case(f"alone/{name.removesuffix('-v0')}", SOURCES, options={"task": name}, action=alone)
    for kind in ("AsyncVectorEnv", "DaskVectorEnv"):
        yield Case(f"processes/{kind}", SOURCES, options={"kind": kind}, action=several)


def extract(_case: Case, run: Run) -> dict[str, Any]:
    return run.found


def costs(data: Data) -> list[dict[str, Any]]:
    """Return steps a second, the time of a reset, ms, and Python's part, of each task."""
    return [record.view | {"rate": 1e3 / record["step_ms"]} for record in data.of("gym/alone/*")]


STUDY = Study("gym", cases, extract, {"gym-cost": costs})
