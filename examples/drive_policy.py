"""A drive that acts as a trained policy does: a small network from a file, as `train_ppo.py` writes it.

nervure run examples/steered-plate.json --drive examples/drive_policy.py
POLICY=learned/policy.json nervure run learned/scene.json --drive examples/drive_policy.py
"""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

ROUNDING = 1e-9  # Part of a step


class Policy:
    """Chooses targets every so often, which the inputs follow as the servos of `nervure.gym.Action` do."""

    def __init__(self, path: Path) -> None:
        made = json.loads(path.read_text(encoding="utf-8"))
        self.names, scales = zip(*made["seen"], strict=True)
        self.scales, self.every = np.array(scales), made["every"]
        self.layers = [(np.array(weights), np.array(bias)) for weights, bias in made["layers"]]
        self.actions = made["actions"]
        self.due = 0.0
        self.targets, self.places, self.speeds = np.zeros((3, len(self.actions)))

    def __call__(self, time: float, values: Mapping[str, float]) -> dict[str, float]:
        h = time - values["time"]
        if values["time"] > self.due - ROUNDING * h:
            self.due += self.every
            self.targets = self.choose(np.array([values[name] for name in self.names]) / self.scales)
        omega = np.array([1 / own["lag"] for own in self.actions])
        apart = self.places - self.targets
        pull, decay = self.speeds + omega * apart, np.exp(-omega * h)
        self.places, self.speeds = self.targets + (apart + pull * h) * decay, (self.speeds - omega * pull * h) * decay
        given = {own["name"]: place for own, place in zip(self.actions, self.places, strict=True)}
        return given | {own["rate"]: speed for own, speed in zip(self.actions, self.speeds, strict=True) if own["rate"]}

    def choose(self, seen: np.ndarray) -> np.ndarray:
        """Return the targets after an observation."""
        for weights, bias in self.layers[:-1]:
            seen = np.tanh(weights @ seen + bias)
        weights, bias = self.layers[-1]
        share = (np.clip(weights @ seen + bias, -1, 1) + 1) / 2
        return np.array([own["low"] + part * (own["high"] - own["low"]) for own, part in
                         zip(self.actions, share, strict=True)])  # fmt: skip

    def state(self) -> dict[str, object]:
        return {"due": self.due, "servos": np.array([self.targets, self.places, self.speeds])}

    def restore(self, state: dict[str, Any]) -> None:
        self.due, (self.targets, self.places, self.speeds) = state["due"], np.array(state["servos"])


drive = Policy(Path(os.environ.get("POLICY", Path(__file__).with_suffix(".json"))))
