"""Models, callbacks and checks that several tests of training share; not a test itself."""

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from toy_env import ToyVectorEnv

from sb3_adaptnet import (
    AdaptVecEnv,
    DiscriminatorRewardCallback,
    PretrainPolicy,
)

SMALL = {"gru_size": 8, "hidden_sizes": (16, 8)}
DISCRIMINATOR = {"batch_size": 64, "network": {"gru": 8, "hidden": [8], "heads": 4}}
WEIGHTS = {
    1: {"imitation": 1.0},
    2: {"imitation": 0.35, "goal": 0.65},
    3: {"imitation": 0.3, "goal": 0.5, "effort": 0.2},
}


def effort(step):
    return -np.square(step["actions"]).mean(axis=1)


def make_model(env=None, seed=0, precision="fp32", **kwargs):
    env = AdaptVecEnv(ToyVectorEnv(16, drift=0.03)) if env is None else env
    settings = {"n_steps": 16, "batch_size": 64, "n_epochs": 2, "gamma": 0.9, "gae_lambda": 0.8, **kwargs}
    return PPO(PretrainPolicy, env, policy_kwargs={**SMALL, "precision": precision}, seed=seed, **settings)


def make_callback(k=2, **kwargs):
    return DiscriminatorRewardCallback(
        WEIGHTS[k], discriminator=DISCRIMINATOR, reward_terms={"effort": effort}, **kwargs
    )


def standardised_advantages(buffer):
    """(T, N, K) of each objective by itself, before weights."""
    raw = buffer.returns - buffer.values
    return (raw - raw.mean((0, 1))) / (raw.std((0, 1)) + 1e-8)


class Check(BaseCallback):
    """Runs a function at every rollout's end, after the discriminators' callback."""

    def __init__(self, function):
        super().__init__()
        self.function, self.calls = function, 0

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        self.calls += 1
        self.function(self.model)
