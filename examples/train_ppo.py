"""Train controllers of a task by PPO, draw how they learn beside the classical one, and write the best as a policy.

python examples/train_ppo.py nervure/Flag-v0 learned --seeds 5 --steps 30000
needs `pip install stable-baselines3`; `drive_policy.py` runs a policy as a drive.
"""

import argparse
import json
from functools import partial
from pathlib import Path
from time import process_time

import gymnasium
import matplotlib.pyplot as plt
import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.monitor import Monitor

from nervure.gym import BASELINES, Baseline, Env


def make(task: str) -> gymnasium.Env[np.ndarray, np.ndarray]:
    """Return the task with actions from -1 to 1."""
    return gymnasium.wrappers.RescaleAction(gymnasium.make(task), np.float64(-1), np.float64(1))


def judged(env: gymnasium.Env[np.ndarray, np.ndarray], control: Baseline) -> float:
    """Return the mean reward of the episodes from each start under a controller."""
    own, space = env.unwrapped, env.action_space
    assert isinstance(own, Env) and isinstance(space, gymnasium.spaces.Box)
    found = []
    for start in range(len(own.starts)):
        seen, info = env.reset(options={"start": start})
        total, over = 0.0, False
        while not over:
            action = np.clip(control(seen, info["time"]), space.low, space.high)
            seen, reward, ended, truncated, info = env.step(action)
            total, over = total + float(reward), ended or truncated
        found.append(total)
    return float(np.mean(found))


def choose(model: PPO, seen: np.ndarray, _time: float) -> np.ndarray:
    """Return the mean action of a policy."""
    return np.asarray(model.predict(seen, deterministic=True)[0])


def policy(model: PPO, own: Env) -> dict[str, object]:
    """Return the layers of the mean action, and the names and scales around them, as JSON holds them."""
    layers = [part for part in [*model.policy.mlp_extractor.policy_net, model.policy.action_net]
              if isinstance(part, torch.nn.Linear)]  # fmt: skip
    return {
        "seen": [[name, 1 / factor] for name, factor in own.observed],
        "actions": [vars(action) | {"rate": own.session.driver.rates[action.name]} for action in own.actions],
        "every": own.steps * own.session.grid.communication_step,
        "layers": [[part.weight.detach().tolist(), part.bias.detach().tolist()] for part in layers],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("task", choices=BASELINES)
    parser.add_argument("output", type=Path)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=30_000)
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    plain = gymnasium.make(given.task)
    own = plain.unwrapped
    assert isinstance(own, Env)
    none, classical = judged(plain, lambda _seen, _time: np.zeros(own.low.shape)), judged(plain, BASELINES[given.task])
    curves: list[tuple[np.ndarray, np.ndarray]] = []
    best: tuple[float, dict[str, object]] = (-np.inf, {})
    for seed in range(given.seeds):
        begin = process_time()
        env = Monitor(make(given.task))
        network = {"net_arch": [32, 32], "log_std_init": -1.0}
        model = PPO("MlpPolicy", env, seed=seed, gamma=0.98, learning_rate=1e-3, n_steps=1000, batch_size=100,
                    policy_kwargs=network, device="cpu")  # fmt: skip
        model.learn(given.steps)
        sums = np.array(env.get_episode_rewards())
        curves.append((np.cumsum(env.get_episode_lengths()), sums))
        learned = judged(env, partial(choose, model))
        rewards = f"learned {learned:.4g}, none {none:.4g}, classical {classical:.4g}"
        print(f"seed {seed}: {rewards}, {(process_time() - begin) / 60:.1f} min of a core", flush=True)
        if learned > best[0]:
            best = learned, policy(model, own)
        env.close()
    (given.output / "policy.json").write_text(json.dumps(best[1]), encoding="utf-8")
    (given.output / "scene.json").write_text(json.dumps(own.session.scene.document(), indent=2), encoding="utf-8")
    plain.close()
    figure, axis = plt.subplots(figsize=(6, 3.2), layout="constrained")
    for steps, sums in curves:
        wide = min(10, len(sums))
        axis.plot(steps[wide - 1 :], np.convolve(sums, np.ones(wide) / wide, "valid"), color="C0", linewidth=0.9)
    axis.axhline(none, color="0.5", linestyle=":", label="no control")
    axis.axhline(classical, color="C1", linestyle="--", label="classical controller")
    axis.plot([], [], color="C0", label=f"PPO, {given.seeds} seeds")
    axis.set(xlabel="environment steps", ylabel="reward of an episode", title=given.task)
    axis.legend(frameon=False)
    figure.savefig(given.output / "learning.png", dpi=120)


if __name__ == "__main__":
    main()
