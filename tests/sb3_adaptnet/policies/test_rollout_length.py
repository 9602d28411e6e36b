"""A long rollout warns once."""

import warnings

import pytest
import torch
from policy_cases import PPO_ARGUMENTS, SIZES
from stable_baselines3 import PPO
from toy_env import ToyEnv

from sb3_adaptnet import (
    PretrainPolicy,
)


def test_long_rollout_warns_once_and_an_update_starts_the_count_again():
    policy = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS).policy
    half = torch.zeros(32_768, 784)
    with torch.no_grad(), warnings.catch_warnings():
        warnings.simplefilter("error")
        policy(half)
        policy(half)
        policy.set_training_mode(True)
        policy(half)
        policy(half)
        with pytest.raises(UserWarning, match="65,536"):
            policy(half[:1])
        policy(half[:1])
