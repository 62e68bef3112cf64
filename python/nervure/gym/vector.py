"""Environments side by side on Dask's workers, which are processes of one thread, as the runs of a sweep are."""

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, suppress
from itertools import cycle
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ClosedEnvironmentError
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate

from nervure import arguments
from nervure.errors import InputError
from nervure.simulation.sweep import connected, local_cluster, main_not_imported


class Member:
    """One of the environments, at its worker. The step after the end of an episode resets it."""

    def __init__(self, make: Callable[[], gymnasium.Env[Any, Any]]):
        self.env, self.ended = make(), False

    def about(self) -> tuple[Any, ...]:
        """Return the spaces of observations and actions, metadata and render mode."""
        env = self.env
        return env.observation_space, env.action_space, env.metadata, env.render_mode

    def reset(self, seed: int | None, options: dict[str, Any] | None) -> tuple[Any, dict[str, Any]]:
        """Reset the environment."""
        self.ended = False
        return self.env.reset(seed=seed, options=options)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Make a step, or reset the environment after the last step of an episode."""
        if self.ended:
            seen, info = self.reset(None, None)
            return seen, 0.0, False, False, info
        made = self.env.step(action)
        self.ended = made[2] or made[3]
        return made

    def close(self) -> None:
        """Close the environment."""
        self.env.close()


class DaskVectorEnv(VectorEnv[Any, Any, np.ndarray]):
    """`count` environments that `make` returns, in turn on each worker of a `scheduler`, given by its address or as a
    cluster; by default each in a process of this machine.

    An environment has the bits that it has alone with its seed. What it raises comes out unchanged; where its worker
    is lost, an `OSError` or `RuntimeError`.
    """

    def __init__(self, make: Callable[[], gymnasium.Env[Any, Any]], count: int, scheduler: Any = None):
        arguments.function("make", make, "nothing")
        if not isinstance(count, int) or isinstance(count, bool) or count < 1:
            raise InputError(f"count is {arguments.shown(count)}, but must be a whole number from 1")
        super().__init__()
        with ExitStack() as stack:
            if scheduler is None:
                with main_not_imported():
                    scheduler = stack.enter_context(local_cluster(count))
            client = stack.enter_context(connected(scheduler))
            places = zip(range(count), cycle(client.nthreads()), strict=False)
            self._kept = [client.submit(Member, make, actor=True, pure=False, workers=[at]) for _, at in places]
            stack.callback(self._close_members)
            self.members = [future.result() for future in self._kept]
            self.single_observation_space, self.single_action_space, metadata, self.render_mode = self._ask("about")[0]
            self._open = stack.pop_all()
        self.num_envs, self.metadata = count, {**metadata, "autoreset_mode": AutoresetMode.NEXT_STEP}
        self.observation_space = batch_space(self.single_observation_space, count)
        self.action_space = batch_space(self.single_action_space, count)

    members: Sequence[Any] = ()
    """Dask's actors, each with a `Member`."""

    def _ask(self, name: str, *arguments: Sequence[Any]) -> list[Any]:
        """Call a method of all members at once, each with its own of `arguments`; return what they return."""
        if self.closed:
            raise ClosedEnvironmentError("the environments are closed, and step no more")
        each = [*zip(self.members, *arguments, strict=True)]  # Before anything is asked
        asked = [getattr(one, name)(*own) for one, *own in each]
        return [answer.result() for answer in asked]

    def _batch(self, seen: Sequence[Any], infos: Sequence[dict[str, Any]]) -> tuple[Any, dict[str, Any]]:
        both: dict[str, Any] = {}
        for number, info in enumerate(infos):
            both = self._add_info(both, info, number)
        space, empty = self.single_observation_space, create_empty_array(self.single_observation_space, self.num_envs)
        return concatenate(space, seen, empty), both  # type: ignore[arg-type]

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Reset all environments; a number as `seed` is that of the first, the next ones follow."""
        if seed is None or isinstance(seed, int):
            seed = [None if seed is None else seed + i for i in range(self.num_envs)]
        if not isinstance(seed, Iterable) or isinstance(seed, str) or len(seeds := [*seed]) != self.num_envs:
            raise InputError(f"seed is {arguments.shown(seed)}, but must be a number or a list of {self.num_envs}")
        return self._batch(*zip(*self._ask("reset", seeds, [options] * self.num_envs), strict=True))

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Make a step of all environments; of those whose episode has ended it is a reset. Raise `InputError` before
        any makes one where there is not an action for each."""
        seen, rewards, ended, cut, infos = zip(*self._ask("step", self._checked(actions)), strict=True)
        batch, info = self._batch(seen, infos)
        return batch, np.array(rewards, float), np.array(ended, bool), np.array(cut, bool), info

    def _checked(self, actions: Any) -> list[Any]:
        """Return the actions of the environments."""
        single, count = self.single_action_space, self.num_envs
        if isinstance(single, Box):
            try:
                given = np.asarray(actions, float)
            except (TypeError, ValueError):
                given = np.array(math.nan)
            if given.shape != (shape := (count, *single.shape)) or not np.isfinite(given).all():
                said = arguments.shown(actions)
                raise InputError(f"actions is {said}, but must be an array of finite numbers of shape {shape}")
            return [*actions]
        try:
            each = [*iterate(self.action_space, actions)]
        except (TypeError, ValueError, KeyError, IndexError):
            each = []
        if len(each) != count or not all(map(single.contains, each)):
            raise InputError(f"actions is {arguments.shown(actions)}, but must be {count} in {single}")
        return each

    def _close_members(self) -> None:
        with suppress(Exception):  # A worker that is lost has nothing to close
            for answer in [member.close() for member in self.members]:
                answer.result()

    def close_extras(self, **_: Any) -> None:
        """Close the environments, and end the processes that were started for them."""
        self._open.close()
