"""A base from nothing."""

import torch
from policy_cases import PPO_ARGUMENTS, SIZES, observations
from stable_baselines3 import PPO
from toy_env import ToyEnv

from sb3_adaptnet import (
    PretrainPolicy,
)


def test_a_held_standard_deviation_stays_and_survives_saving(tmp_path):
    choices = SIZES | {"learn_std": False, "initial_std": 0.1}
    model = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=choices, **PPO_ARGUMENTS)
    model.learn(64)
    model.save(tmp_path / "held")
    again = PPO.load(tmp_path / "held", env=ToyEnv())
    again.learn(64)
    for policy in (model.policy, again.policy):
        spread = policy.get_distribution(torch.as_tensor(observations())).distribution.stddev
        assert torch.allclose(spread, torch.full_like(spread, 0.1))
