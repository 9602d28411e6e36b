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
from sb3_adaptnet.policies.optimizer_groups import ACTOR, set_step_size, step_size


def test_setting_the_same_number_of_objectives_keeps_the_critic():
    policy = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS).policy
    policy.set_objectives((0.5, 0.5))
    head, optimizer = policy.critic.head, policy.optimizer
    policy.set_objectives((0.35, 0.65))
    assert policy.critic.head is head
    assert policy.optimizer is optimizer
    with pytest.raises(ValueError, match="at least one"):
        policy.set_objectives(())


def test_another_number_of_objectives_keeps_what_the_optimiser_gathered(tiny_base):
    policy = adapt(AdaptNetPolicy, ToyEnv(), tiny_base, actor_lr=5e-6).policy
    policy.set_objectives((0.5, 0.5))
    for parameter in policy.parameters():
        parameter.grad = torch.ones_like(parameter) if parameter.requires_grad else None
    policy.optimizer.step()
    set_step_size(policy.optimizer, ACTOR, 2e-6)
    moments = {id(parameter): state for parameter, state in policy.optimizer.state.items()}
    policy.set_objectives((0.3, 0.3, 0.4))
    assert step_size(policy.optimizer, ACTOR) == pytest.approx(2e-6)
    head = {id(parameter) for parameter in policy.critic.head.parameters()}
    learned = [parameter for group in policy.optimizer.param_groups for parameter in group["params"]]
    assert len(learned) > len(head) > 0
    for parameter in learned:
        assert policy.optimizer.state.get(parameter) is moments.get(id(parameter))
        assert (id(parameter) in moments) == (id(parameter) not in head)


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
