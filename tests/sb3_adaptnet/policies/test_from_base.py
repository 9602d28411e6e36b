"""Policies from a base on stock PPO: where they start, what learns, what stays."""

import copy

import numpy as np
import pytest
import torch
from policy_cases import CASES, CHOICES, act, adapt, observations
from stable_baselines3 import PPO
from toy_env import ToyEnv

from sb3_adaptnet import (
    AdaptNetPolicy,
    CheckpointError,
    FinetunePolicy,
    ProgressivePolicy,
    RegularizedFinetunePolicy,
    load_policy,
)


@pytest.mark.parametrize(("name", "heightmap"), CASES)
def test_training_moves_what_learns_and_nothing_else(name, heightmap, tiny_base):
    policy_class, choices = CHOICES[name]
    model = adapt(policy_class, ToyEnv(heightmap=heightmap), tiny_base, **choices)
    before = copy.deepcopy({k: v for k, v in model.policy.state_dict().items() if k != "_extra_state"})
    learning = {name for name, p in model.policy.named_parameters() if p.requires_grad}
    model.learn(64)
    after = model.policy.state_dict()
    frozen = [k for k in before if k not in learning and ".base." in k]
    assert frozen or name == "finetune"
    assert all(torch.equal(before[k], after[k]) for k in frozen)
    still = [k for k in learning if torch.equal(before[k], after[k])]
    assert not still
    assert np.isfinite(act(model.policy, heightmap)).all()


@pytest.mark.parametrize("name", [name for name, (kind, _) in CHOICES.items() if kind is not ProgressivePolicy])
def test_adapting_starts_exactly_at_the_base(name, tiny_base):
    policy_class, choices = CHOICES[name]
    base = load_policy(tiny_base, ToyEnv())
    model = adapt(policy_class, ToyEnv(), tiny_base, **choices)
    assert np.array_equal(act(model.policy), act(base))


@pytest.mark.parametrize("name", ["adaptnet", "start", "finetune", "finetune_reg"])
def test_statistics_alone_change_no_action(name, tiny_base, two_styles):
    """A base's inputs may differ from today's; it must not act otherwise before it has learned anything."""
    policy_class, choices = (AdaptNetPolicy, {"start": two_styles[0]}) if name == "start" else CHOICES[name]
    policy = adapt(policy_class, ToyEnv(), tiny_base, **choices).policy
    before = act(policy)
    policy.learn_statistics(torch.from_numpy(100 + 30 * observations(20_000)))
    assert np.array_equal(act(policy), before)


def test_adapting_with_a_heightmap_starts_exactly_at_the_base(tiny_base):
    base = load_policy(tiny_base, ToyEnv())
    for policy_class in (AdaptNetPolicy, FinetunePolicy, RegularizedFinetunePolicy):
        model = adapt(policy_class, ToyEnv(heightmap=True), tiny_base)
        assert np.array_equal(act(model.policy, heightmap=True), act(base))


def test_log_std_stays_that_of_the_base_head(tiny_base):
    for policy_class in (AdaptNetPolicy, FinetunePolicy, RegularizedFinetunePolicy):
        policy = adapt(policy_class, ToyEnv(), tiny_base).policy
        heads = [p for name, p in policy.named_parameters() if "log_std" in name]
        assert heads
        assert not any(p.requires_grad for p in heads)


@pytest.mark.parametrize("policy_class", [AdaptNetPolicy, FinetunePolicy])
def test_noise_scales_the_bases_deviations_and_leaves_the_mean_alone(policy_class, tiny_base, tmp_path):
    plain, quiet = (adapt(policy_class, ToyEnv(), tiny_base, noise=noise) for noise in (1.0, 0.5))
    quiet.save(tmp_path / "quiet.zip")
    models = plain, quiet, PPO.load(tmp_path / "quiet.zip")
    seen = torch.as_tensor(observations())
    usual, half, loaded = (model.policy.get_distribution(seen).distribution for model in models)
    assert torch.equal(usual.mean, half.mean)
    for scaled in (half, loaded):
        assert torch.allclose(scaled.stddev, 0.5 * usual.stddev)
    for wrong in (0.0, -1.0, float("inf"), float("nan")):
        with pytest.raises(ValueError, match="noise is a factor above 0"):
            adapt(policy_class, ToyEnv(), tiny_base, noise=wrong)


def test_base_drops_the_joints_that_the_character_lacks(tiny_base):
    env = ToyEnv()
    whole = act(load_policy(tiny_base, env))
    few = ToyEnv(joints=5)
    few.action_space.joint_names = ("joint_7", "joint_2", "joint_20", "joint_0", "joint_27")
    for policy in (load_policy(tiny_base, few), adapt(AdaptNetPolicy, few, tiny_base).policy):
        assert np.allclose(act(policy), whole[:, [7, 2, 20, 0, 27]], atol=1e-6)
    few.action_space.joint_names = ("joint_7", "wing", "joint_20", "joint_0", "joint_27")
    with pytest.raises(ValueError, match="wing"):
        load_policy(tiny_base, few)


def test_missing_tiny_base_is_named_when_the_policy_acts(tmp_path):
    with pytest.warns(UserWarning, match=r"nowhere\.safetensors"):
        model = adapt(AdaptNetPolicy, ToyEnv(), tmp_path / "nowhere.safetensors")
    with pytest.raises(CheckpointError, match=r"nowhere\.safetensors"):
        model.learn(32)


def test_unknown_base_name_is_refused_at_once():
    with pytest.raises(CheckpointError, match="moonwalk"):
        adapt(AdaptNetPolicy, ToyEnv(), "moonwalk")


def test_same_seed_gives_the_same_weights(tiny_base):
    states = []
    for _ in range(2):
        model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base)
        model.env.seed(0)
        model.learn(128)
        states.append(model.policy.state_dict())
    assert all(torch.equal(states[0][key], states[1][key]) for key in states[0])
