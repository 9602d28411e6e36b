"""What the learner's tests share: one thread, a tiny base, two adaptations of it."""

import pytest
import torch
from policy_cases import PPO_ARGUMENTS, SIZES, adapt, disturb
from stable_baselines3 import PPO
from torch import nn
from toy_env import ToyEnv

from sb3_adaptnet import AdaptNetPolicy, PretrainPolicy, save_adaptation, save_base


@pytest.fixture(autouse=True, scope="session")
def _one_thread():
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.fixture(scope="session")
def tiny_base(tmp_path_factory):
    """A base that has seen data and whose actions are not near zero."""
    model = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS)
    nn.init.normal_(model.policy.actor.mean.weight, std=0.3)
    model.learn(64)
    return save_base(model, tmp_path_factory.mktemp("base") / "tiny")


@pytest.fixture
def two_styles(tiny_base, tmp_path):
    """Files of two adaptations of the tiny base, with full-rank and with low-rank adaptors."""
    files = []
    for seed, name in enumerate(("stoop", "limp")):
        torch.manual_seed(seed)
        model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base, adaptors=("full", "lora")[seed], rank=3)
        disturb(model.policy.actor.adaptations)
        files.append(save_adaptation(model, tmp_path / name))
    return files
