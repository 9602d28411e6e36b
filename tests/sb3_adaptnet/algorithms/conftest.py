"""A tiny base for the real character, and SVG of tiny sizes."""

import numpy as np
import pytest
import torch
from policy_cases import SIZES
from stable_baselines3 import PPO
from world_cases import CHARACTER, recorded

from sb3_adaptnet import AdaptNetPolicy, AdaptVecEnv, PretrainPolicy, save_base
from sb3_adaptnet.algorithms.svg import SVG
from sb3_adaptnet.world_model.fitting.fit import set_statistics
from sb3_adaptnet.world_model.model import Sizes, WorldModel

TINY = {
    "n_steps": 8, "window": 4, "gradient_steps": 2, "recent_rollouts": 2, "regression_updates": 3, "seed": 0,
    "model_refresh": {"updates": 1, "batch": 16}, "cost_to_go": {"updates": (6, 2)},
    "device": "cpu", "learning_rate": {0: 1e-3, 100: 1e-4},
}  # fmt: skip


@pytest.fixture(scope="session")
def walk_base(tmp_path_factory):
    env = AdaptVecEnv("AdaptNet/Humanoid-Walk-v0", num_envs=4, num_threads=1)
    model = PPO(PretrainPolicy, env, n_steps=8, batch_size=16, policy_kwargs=SIZES, device="cpu", seed=0)
    model.learn(32)
    return save_base(model, tmp_path_factory.mktemp("base") / "tiny")


@pytest.fixture(scope="session")
def tiny_world():
    torch.manual_seed(0)
    model, data = WorldModel(CHARACTER, Sizes(16, 2)), recorded(steps=8, worlds=8)
    set_statistics(model, data, np.random.default_rng(0))
    return model


@pytest.fixture
def make_svg(walk_base, tiny_world):
    def make(worlds=6, environment="AdaptNet/Humanoid-Stoop-v0", env=None, policy_kwargs=None, world=None, **choices):
        env = env or AdaptVecEnv(environment, num_envs=worlds, num_threads=1, seed=0)
        policy_kwargs = {"base": str(walk_base), **(policy_kwargs or {})}
        return SVG(AdaptNetPolicy, env, world or tiny_world, policy_kwargs=policy_kwargs, **{**TINY, **choices})

    return make
