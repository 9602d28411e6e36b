"""Adapting a base with the callback: what learns, what is saved, what comes back."""

import numpy as np
import pytest
import torch
from objective_cases import Check, make_callback, make_model
from stable_baselines3 import PPO
from toy_env import ToyVectorEnv

from sb3_adaptnet import (
    AdaptNetPolicy,
    AdaptVecEnv,
    FinetunePolicy,
    ProgressivePolicy,
    save_base,
)
from sb3_adaptnet.modules import read_observation


@pytest.fixture(scope="module")
def base_file(tmp_path_factory):
    model = make_model()
    model.learn(16 * 16, callback=make_callback())
    return save_base(model, tmp_path_factory.mktemp("base") / "tiny")


@pytest.mark.parametrize("policy", [AdaptNetPolicy, FinetunePolicy, ProgressivePolicy], ids=lambda p: p.__name__)
def test_adapting_a_base_with_the_callback(policy, base_file, tmp_path):
    """Frozen weights stay to the bit, the others move; a saved zip opens without the base and learns on."""
    file = tmp_path / "base.safetensors"
    file.write_bytes(base_file.read_bytes())
    env = AdaptVecEnv(ToyVectorEnv(16, drift=0.03))
    model = PPO(policy, env, n_steps=16, batch_size=64, n_epochs=2, policy_kwargs={"base": str(file)}, seed=0)
    callback = make_callback()
    callback.init_callback(model)  # K outputs before the snapshot
    before = {name: p.detach().clone() for name, p in model.policy.named_parameters()}
    model.learn(16 * 16 * 2, callback=callback)
    for name, parameter in model.policy.named_parameters():
        assert torch.equal(parameter, before[name]) != parameter.requires_grad, name
    model.save(tmp_path / "model")
    file.unlink()
    with pytest.warns(UserWarning, match="base.safetensors"):
        again = PPO.load(tmp_path / "model", env=env)
    observations = env.reset()
    assert np.array_equal(*(m.predict(observations, deterministic=True)[0] for m in (model, again)))
    with pytest.raises(RuntimeError, match="learned with 2 objectives: pass DiscriminatorRewardCallback"):
        again.learn(16 * 16, reset_num_timesteps=False)
    again.learn(16 * 16, callback=make_callback(), reset_num_timesteps=False)


def test_the_code_of_the_frozen_base_stands_beside_its_observations(base_file):
    """Row by row the buffer holds what the base's encoder makes of the observations: no step is off by one."""
    model = PPO(
        AdaptNetPolicy, AdaptVecEnv(ToyVectorEnv(4)), n_steps=16, batch_size=64, policy_kwargs={"base": str(base_file)}
    )
    seen = []

    def check(model):
        kept = {key: torch.from_numpy(rows).flatten(0, 1) for key, rows in model.rollout_buffer.observations.items()}
        frames = read_observation(kept["observation"], model.policy.architecture).frames
        with torch.no_grad():
            torch.testing.assert_close(kept["base_code"], model.policy.actor.base.code(frames), rtol=1e-4, atol=1e-5)
        seen.append(kept["base_code"].clone())

    model.learn(16 * 4 * 2, callback=[make_callback(), Check(check)])
    assert len(seen) == 2 and not torch.equal(*seen)
