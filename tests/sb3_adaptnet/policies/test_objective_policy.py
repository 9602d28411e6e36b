"""How policies act and are trained: statistics, precision, values."""

import numpy as np
import pytest
import torch
from policy_cases import PPO_ARGUMENTS, SIZES, act, adapt, observations
from stable_baselines3 import PPO
from toy_env import ToyEnv

from sb3_adaptnet import (
    AdaptNetPolicy,
    PretrainPolicy,
)


def test_first_ratio_is_one_after_statistics_moved(tiny_base):
    """Old and new log-probabilities see the same normaliser within a rollout and its update."""
    model = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS)
    model.learn(64)
    policy = model.policy
    policy.set_training_mode(False)
    obs = torch.from_numpy(observations())
    with torch.no_grad():
        actions, _, old = policy(obs)
        policy(obs * 3 + 1)
        policy.set_training_mode(True)
        _, new, _ = policy.evaluate_actions(obs, actions)
        assert torch.equal(old, new)
        policy.set_training_mode(False)
        moved = policy.evaluate_actions(obs, actions)[1]
    assert not torch.equal(old, moved)


def test_predicting_inside_a_rollout_does_not_move_the_statistics():
    policy = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS).policy
    policy.set_training_mode(False)
    with torch.no_grad():
        policy(torch.from_numpy(observations()))
        before = act(policy)
        policy(torch.from_numpy(observations(seed=9) * 4 + 2))
    assert np.array_equal(act(policy), before)


def test_what_is_expected_is_not_clipped_and_what_was_known_counts_as_much(tiny_base):
    policy = adapt(AdaptNetPolicy, ToyEnv(), tiny_base).policy
    (normalizer,) = policy.actor.normalizers()
    before = normalizer.mean.clone()
    frames = torch.from_numpy(observations(count=50)[:, :-4]) + 1000
    single = frames.reshape(-1, policy.architecture.frame_size)
    assert (normalizer(single).abs() == 5).all()
    policy.expect(frames)
    assert normalizer(single).abs().max() < 5
    assert torch.allclose(normalizer.mean, (before + single.mean(0)) / 2, rtol=1e-4)
    assert torch.equal(policy.actor.base.normalizer.mean, before)


@pytest.mark.parametrize("weights", [(1.0,), (0.35, 0.65), (0.2, 0.3, 0.5)])
def test_objectives(weights, tiny_base):
    policy = adapt(AdaptNetPolicy, ToyEnv(), tiny_base).policy
    policy.set_objectives(weights)
    count, obs = len(weights), torch.from_numpy(observations())
    policy.value_norm.update(torch.randn(50, count) * 5 + 3)
    with torch.no_grad():
        actions, values, _ = policy(obs)
        normalized, _, entropy = policy.evaluate_actions(obs, actions)
        assert values.shape == normalized.shape == (6, count)
        assert entropy.shape == (6,)
        assert torch.allclose(policy.value_norm.denormalize(normalized), values, atol=1e-5)
        assert torch.allclose(policy.predict_objective_values(obs), values, atol=1e-5)
        wanted = (values * torch.tensor(weights)).sum(1, keepdim=True)
        assert torch.allclose(policy.predict_values(obs), wanted, atol=1e-5)
    trained = {id(p) for group in policy.optimizer.param_groups for p in group["params"]}
    assert trained == {id(p) for p in policy.parameters() if p.requires_grad}


def test_bfloat16_keeps_heads_and_log_probabilities_in_float32(tiny_base):
    policy = adapt(AdaptNetPolicy, ToyEnv(), tiny_base, precision="bf16").policy
    policy.precision = "bf16"  # also on machines that would fall back to fp32
    exact = adapt(AdaptNetPolicy, ToyEnv(), tiny_base).policy
    obs = torch.from_numpy(observations())
    actions, values, old = policy(obs)
    _, new, _ = policy.evaluate_actions(obs, actions)
    assert old.dtype == values.dtype == actions.dtype == torch.float32
    assert torch.equal(old, new)
    assert torch.allclose(policy.get_distribution(obs).mode(), exact.get_distribution(obs).mode(), atol=0.05)
    (new.sum() + values.sum()).backward()
    assert all(torch.isfinite(p.grad).all() for p in policy.parameters() if p.grad is not None)


def test_a_critic_of_the_base_code_values_the_same_with_and_without_the_code_at_hand(tiny_base):
    policy = adapt(AdaptNetPolicy, ToyEnv(), tiny_base, critic={"encoder": "base", "hidden_sizes": [10]}).policy
    obs = torch.from_numpy(observations())
    with torch.no_grad():
        actions, values, _ = policy(obs)
        assert torch.allclose(policy.predict_objective_values(obs), values, atol=1e-6)
        with_code = {"observation": obs, "base_code": policy.remembered["base_code"]}
        kept, _, _ = policy.evaluate_actions(with_code, actions)
        assert torch.allclose(policy.evaluate_actions(obs, actions)[0], kept, atol=1e-6)
        assert torch.equal(kept, values)


@pytest.mark.parametrize(
    ("critic", "words"), [({"encoder": "base"}, "no frozen base's code"), ({"size": 3}, r"encoder.*hidden_sizes.*size")]
)
def test_critics_that_cannot_be_are_refused(critic, words):
    with pytest.raises(ValueError, match=words):
        PPO(PretrainPolicy, ToyEnv(), policy_kwargs={**SIZES, "critic": critic})


def test_unknown_precision_lists_the_known():
    with pytest.raises(ValueError, match=r"fp32.*medium.*bf16.*fp7"):
        PPO(PretrainPolicy, ToyEnv(), policy_kwargs={"precision": "fp7"})


def test_state_dependent_noise_is_refused():
    with pytest.raises(ValueError, match="use_sde"):
        PPO(PretrainPolicy, ToyEnv(), use_sde=True)
