"""AdaptNet at run time: alpha, blending, merging, what it refuses."""

import math

import numpy as np
import pytest
import torch
from policy_cases import PPO_ARGUMENTS, SIZES, act, adapt, disturb, observations
from stable_baselines3 import PPO
from toy_env import ToyEnv

from sb3_adaptnet import (
    AdaptNetPolicy,
    CheckpointError,
    PretrainPolicy,
    load_policy,
    save_adaptation,
    save_base,
)


def test_alpha_zero_is_the_base_after_training_and_may_change_every_step(tiny_base):
    model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base)
    model.learn(64)
    disturb(model.policy.actor.adaptations)
    base = act(load_policy(tiny_base, ToyEnv()))
    adapted = act(model.policy)
    assert not np.allclose(adapted, base, atol=1e-3)
    for alpha, wanted in ((0.0, base), (1.0, adapted), (0.0, base)):
        model.policy.alpha = alpha
        assert np.array_equal(act(model.policy), wanted)
    model.policy.alpha = 0.5
    assert not np.allclose(act(model.policy), base, atol=1e-4)
    with pytest.raises(ValueError, match="finite"):
        model.policy.alpha = float("inf")


def test_blending_and_switching(two_styles, tiny_base):
    alone = [act(load_policy(file, ToyEnv(), base=tiny_base)) for file in two_styles]
    policy = load_policy(two_styles[0], ToyEnv(), base=tiny_base)
    name = policy.add_adaptation(two_styles[1])
    assert name == "limp"
    assert policy.weights == {"main": 1.0, "limp": 0.0}
    for weights, wanted in (({"main": 1.0}, alone[0]), ({"limp": 1.0}, alone[1])):
        policy.blend(weights)
        assert np.array_equal(act(policy), wanted)
    policy.blend({"main": 0.5, "limp": 0.5})
    assert not np.allclose(act(policy), alone[0], atol=1e-3)
    with pytest.raises(ValueError, match=r"limp.*already"):
        policy.add_adaptation(two_styles[1])


def spread_of(policy):
    """Standard deviations of its actions."""
    with torch.no_grad():
        return policy.get_distribution(policy.obs_to_tensor(observations())[0]).distribution.stddev.numpy()


def test_merging_keeps_the_actions_and_then_fixes_alpha(two_styles, tiny_base):
    policy = load_policy(two_styles[0], ToyEnv(), base=tiny_base)
    policy.alpha = 0.8
    policy.actor.log_noise = math.log(0.5)
    wanted, spread = act(policy), spread_of(policy)
    policy.merge()
    assert np.allclose(act(policy), wanted, atol=1e-5) and np.allclose(spread_of(policy), spread)
    for forbidden in (policy.merge, lambda: setattr(policy, "alpha", 0.1), lambda: policy.blend({"main": 1.0})):
        with pytest.raises(ValueError, match="merged"):
            forbidden()


def test_adaptation_of_another_base_is_refused(two_styles, tmp_path):
    other = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS)
    file = save_base(other, tmp_path / "other")
    with pytest.raises(CheckpointError, match=r"adapts base 'tiny'.*not 'other'"):
        load_policy(two_styles[0], ToyEnv(), base=file)


def test_nothing_to_train_is_refused(tiny_base):
    with pytest.raises(ValueError, match="nothing to train"):
        adapt(AdaptNetPolicy, ToyEnv(), tiny_base, injector=False, adaptors=None)


@pytest.mark.parametrize("heightmap", [False, True])
def test_code_of_the_frozen_base_may_be_handed_back(heightmap, tiny_base):
    policy = adapt(AdaptNetPolicy, ToyEnv(heightmap=heightmap), tiny_base).policy
    disturb(policy.actor.adaptations)
    obs = observations(heightmap=heightmap)
    obs = {k: torch.from_numpy(v) for k, v in obs.items()} if heightmap else {"observation": torch.from_numpy(obs)}
    with torch.no_grad():
        actions, values, old = policy(obs if heightmap else obs["observation"])
        assert policy.remembered["base_code"].shape == (6, 8)
        for kept in (obs, obs | {"base_code": policy.remembered["base_code"]}):
            again, new, _ = policy.evaluate_actions(kept, actions)
            assert torch.equal(new, old)
            assert torch.equal(again, values)
        _, other, _ = policy.evaluate_actions(obs | {"base_code": policy.remembered["base_code"] + 1}, actions)
    assert not torch.allclose(other, old)


def test_starts_from_another_adaptation_and_goes_on_learning_it(two_styles, tiny_base):
    alone = act(load_policy(two_styles[0], ToyEnv(), base=tiny_base))
    model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base, start=two_styles[0])
    assert np.array_equal(act(model.policy), alone)
    model.learn(64)
    assert not np.array_equal(act(model.policy), alone)
    assert np.array_equal(act(load_policy(two_styles[0], ToyEnv(), base=tiny_base)), alone)


def test_a_refused_file_leaves_the_adaptation(two_styles, tiny_base, tmp_path):
    policy = load_policy(two_styles[0], ToyEnv(), base=tiny_base)
    alone = act(policy)
    with pytest.raises(CheckpointError, match="moonwalk"):
        policy.load_adaptation("moonwalk")
    assert np.array_equal(act(policy), alone)
    assert save_adaptation(policy, tmp_path / "again").is_file()


def test_a_start_that_is_no_adaptation_of_the_base_is_refused(two_styles, tiny_base, tmp_path):
    with pytest.raises(CheckpointError, match="moonwalk"):
        adapt(AdaptNetPolicy, ToyEnv(), tiny_base, start="moonwalk")
    with pytest.raises(CheckpointError, match="holds 'base', not 'adaptation'"):
        adapt(AdaptNetPolicy, ToyEnv(), tiny_base, start=tiny_base)
    other = save_base(PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS), tmp_path / "other")
    with pytest.raises(CheckpointError, match="not 'other'"):
        adapt(AdaptNetPolicy, ToyEnv(), other, start=two_styles[0])


def test_a_start_that_reads_no_heightmap_is_taken_with_a_warning(two_styles, tiny_base):
    with pytest.warns(UserWarning, match="reads no heightmap"):
        model = adapt(AdaptNetPolicy, ToyEnv(heightmap=True), tiny_base, start=two_styles[0])
    assert not model.policy.actor.parts()["main"].shape.heightmap


def test_a_start_that_is_gone_is_missed_by_a_policy_that_would_act_but_not_by_one_that_is_loaded(
    two_styles, tiny_base, tmp_path
):
    start = tmp_path / "start.safetensors"
    start.write_bytes(two_styles[0].read_bytes())
    model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base, start=start)
    model.learn(64)
    model.save(tmp_path / "model")
    start.unlink()
    with pytest.warns(UserWarning, match=r"no file .*start\.safetensors.* of an adaptation to start from"):
        loaded = PPO.load(tmp_path / "model")
    assert np.array_equal(act(loaded.policy), act(model.policy))
    with pytest.warns(UserWarning, match="cannot act"), pytest.raises(CheckpointError, match=r"start\.safetensors"):
        adapt(AdaptNetPolicy, ToyEnv(), tiny_base, start=start).learn(64)
