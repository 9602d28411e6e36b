"""PPO.save and PPO.load: a saved model restores everything, without the files it was made from."""

import numpy as np
import pytest
import torch
from policy_cases import CASES, CHOICES, PPO_ARGUMENTS, SIZES, act, adapt, disturb
from stable_baselines3 import PPO
from toy_env import ToyEnv

from sb3_adaptnet import AdaptNetPolicy, PretrainPolicy
from sb3_adaptnet.policies.optimizer_groups import group_named


def assert_same(first, second, heightmap=False):
    states = first.policy.state_dict(), second.policy.state_dict()
    assert states[0].keys() == states[1].keys()
    assert all(torch.equal(states[0][key], states[1][key]) for key in states[0])
    assert np.array_equal(act(first.policy, heightmap), act(second.policy, heightmap))


@pytest.mark.parametrize(("name", "heightmap"), CASES)
def test_saved_model_opens_without_the_base_and_goes_on_identically(name, heightmap, tiny_base, tmp_path):
    policy_class, choices = CHOICES[name]
    copied = tmp_path / "gone.safetensors"
    copied.write_bytes(tiny_base.read_bytes())
    model = adapt(policy_class, ToyEnv(heightmap=heightmap), copied, **choices)
    model.learn(64)
    model.save(tmp_path / "model")
    copied.unlink()
    with pytest.warns(UserWarning, match="no base file"):
        loaded = PPO.load(tmp_path / "model", env=ToyEnv(heightmap=heightmap), device="cpu")
    assert_same(model, loaded, heightmap)
    for trained in (model, loaded):
        trained.set_random_seed(1)
        trained.env.seed(1)
        trained.learn(32, reset_num_timesteps=True)
    assert_same(model, loaded, heightmap)


@pytest.mark.parametrize("weights", [(0.5, 0.5), (0.2, 0.3, 0.5)])
def test_saved_model_restores_objectives_alpha_blend_and_optimiser(weights, two_styles, tiny_base, tmp_path):
    model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base)
    model.policy.set_objectives(weights)
    model.policy.value_norm.update(torch.randn(20, len(weights)))
    group_named(model.policy.optimizer, "actor")["lr_scale"] = 0.125
    model.policy.add_adaptation(two_styles[1], weight=0.3)
    model.policy.alpha = 0.6
    model.save(tmp_path / "model")
    loaded = PPO.load(tmp_path / "model", device="cpu")
    assert_same(model, loaded)
    assert loaded.policy.objective_weights == weights
    assert loaded.policy.alpha == 0.6
    assert loaded.policy.weights == {"main": 1.0, "limp": 0.3}
    assert group_named(loaded.policy.optimizer, "actor")["lr_scale"] == 0.125
    trained = {id(p) for group in loaded.policy.optimizer.param_groups for p in group["params"]}
    assert trained == {id(p) for p in loaded.policy.parameters() if p.requires_grad}


def test_merged_model_is_restored_merged(tiny_base, tmp_path):
    model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base)
    disturb(model.policy.actor.adaptations)
    model.policy.merge()
    state = model.policy.state_dict()
    other = adapt(AdaptNetPolicy, ToyEnv(), tiny_base)
    other.policy.load_state_dict(state)
    assert_same(model, other)
    assert other.policy.merged


def test_saved_pretraining_restores_its_sizes(tmp_path):
    model = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS)
    model.learn(32)
    model.save(tmp_path / "model")
    assert_same(model, PPO.load(tmp_path / "model", device="cpu"))


def test_policy_alone_is_saved_and_loaded(tiny_base, tmp_path):
    policy = adapt(AdaptNetPolicy, ToyEnv(), tiny_base, injection="z1", noise=0.5, beta=3.0, companion_kl=2.0).policy
    disturb(policy.actor.adaptations)
    policy.save(tmp_path / "policy.pt")
    loaded = AdaptNetPolicy.load(tmp_path / "policy.pt", device="cpu")
    assert np.array_equal(act(loaded), act(policy))
    assert loaded.actor.log_noise == policy.actor.log_noise < 0
    assert loaded.actor.penalties == policy.actor.penalties == (3.0, 0.01, 2.0)
