"""Weights files that the tests of this folder read and damage."""

import pytest
import torch
from stable_baselines3 import PPO
from torch import nn
from weight_cases import ARGUMENTS, ENV

from sb3_adaptnet import (
    AdaptNetPolicy,
    PretrainPolicy,
    save_adaptation,
    save_base,
)


@pytest.fixture(scope="module")
def base_model():
    model = PPO(PretrainPolicy, ENV, policy_kwargs={"gru_size": 8, "hidden_sizes": (16, 12)}, **ARGUMENTS)
    nn.init.normal_(model.policy.actor.mean.weight, std=0.3)
    return model.learn(32)


@pytest.fixture
def base_file(base_model, tmp_path):
    return save_base(base_model, tmp_path / "tiny", clip_hash="abc", metrics={"goal_reward": 0.5}, training={"seed": 1})


@pytest.fixture
def adaptation_file(base_file, tmp_path):
    model = PPO(AdaptNetPolicy, ENV, policy_kwargs={"base": str(base_file)}, **ARGUMENTS)
    with torch.no_grad():
        for parameter in model.policy.actor.adaptations.parameters():
            parameter.add_(torch.randn_like(parameter) * 0.1)
    return save_adaptation(model, tmp_path / "stoop", environment="Toy-v0")
