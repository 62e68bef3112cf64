"""Environments of gymnasium (the extra `gym`): `Env` takes any scene, and the tasks are registered under their names.

import gymnasium, nervure.gym
env = gymnasium.make("nervure/Flag-v0", render_mode="rgb_array")
several = gymnasium.make_vec("nervure.gym:nervure/Flag-v0", num_envs=2, vectorization_mode="async")
"""

from nervure.extras import require

require("gymnasium", "an environment")

from gymnasium.envs.registration import register  # noqa: E402

from nervure.gym.env import Action, Baseline, Env, Reward, Values  # noqa: E402
from nervure.gym.tasks import BASELINES, EPISODES  # noqa: E402
from nervure.gym.vector import DaskVectorEnv  # noqa: E402

__all__ = ["BASELINES", "Action", "Baseline", "DaskVectorEnv", "Env", "Reward", "Values"]

for name, episode in EPISODES.items():
    register(f"nervure/{name}-v0", f"nervure.gym.tasks:{name.lower()}", max_episode_steps=episode)
