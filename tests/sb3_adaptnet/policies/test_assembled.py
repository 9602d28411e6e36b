"""What assembling makes: the critic's outputs, the optimiser's groups."""

import copy

import pytest
import torch
from policy_cases import PPO_ARGUMENTS, SIZES, adapt
from stable_baselines3 import PPO
from toy_env import ToyEnv

from sb3_adaptnet import (
    AdaptNetPolicy,
    PretrainPolicy,
)


def test_setting_the_same_number_of_objectives_keeps_the_critic():
    policy = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS).policy
    policy.set_objectives((0.5, 0.5))
    head, optimizer = policy.critic.head, policy.optimizer
    policy.set_objectives((0.35, 0.65))
    assert policy.critic.head is head
    assert policy.optimizer is optimizer
    with pytest.raises(ValueError, match="at least one"):
        policy.set_objectives(())


def test_optimizer_groups_carry_two_learning_rates(tiny_base):
    model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base, actor_lr=5e-6, critic_lr=1e-4)
    rates = {group["name"]: group["lr"] * group["lr_scale"] for group in model.policy.optimizer.param_groups}
    assert rates == pytest.approx({"actor": 5e-6, "critic": 1e-4})
    before = copy.deepcopy(dict(model.policy.named_parameters()))
    for parameter in model.policy.parameters():
        parameter.grad = torch.ones_like(parameter) if parameter.requires_grad else None
    model.policy.optimizer.step()
    moved = {name: (p - before[name]).abs().max().item() for name, p in model.policy.named_parameters()}
    assert moved["critic.head.linear.weight"] == pytest.approx(1e-4, rel=1e-2)
    assert moved["actor.adaptations.main.injector.maps.0.weight"] == pytest.approx(5e-6, rel=1e-2)
    assert moved["actor.base.mean.weight"] == 0.0
