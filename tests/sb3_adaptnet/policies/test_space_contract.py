"""Spaces that lack what a policy reads from them."""

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3 import PPO
from toy_env import ToyEnv, ToySpace

from sb3_adaptnet import (
    AdaptNetPolicy,
    PretrainPolicy,
)


class PlainEnv(ToyEnv):
    def __init__(self):
        super().__init__()
        self.action_space = gym.spaces.Box(-1, 1, (28,), np.float32)


@pytest.mark.parametrize("policy_class", [AdaptNetPolicy, PretrainPolicy])
def test_plain_box_says_what_is_missing(policy_class):
    with pytest.raises(ValueError, match="joint_names"):
        PPO(policy_class, PlainEnv())


def test_action_space_with_wrong_names_is_refused():
    env = ToyEnv()
    env.action_space.joint_names = ("one", "two")
    with pytest.raises(ValueError, match="names 2 joints"):
        PPO(PretrainPolicy, env)
    assert isinstance(env.action_space, ToySpace)
