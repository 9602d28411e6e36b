"""Attributes of the worlds that move with the samples."""

import numpy as np
import pytest
from objective_cases import Check, make_model
from stable_baselines3 import PPO
from toy_env import ToyVectorEnv

from sb3_adaptnet import AdaptVecEnv
from sb3_adaptnet.objectives.attribute_ramp import AttributeRamp
from sb3_adaptnet.stacking import JoinedWorlds


def test_a_ramp_moves_an_attribute_with_the_samples():
    env, seen = AdaptVecEnv(ToyVectorEnv(4)), []
    ramp = AttributeRamp("drift", 0.2, 0.1, samples=128)
    model = make_model(env)
    model.learn(64 * 4, callback=[ramp, Check(lambda _: seen.append(env.vector_env.drift))])
    assert seen == pytest.approx([0.2, 0.15, 0.1, 0.1])
    with pytest.raises(ValueError, match="positive.*0"):
        AttributeRamp("drift", 0.0, 1.0, samples=0)
    with pytest.raises(ValueError, match="samples of a ramp must be a number, not '1e6'"):
        AttributeRamp("drift", 0.0, 1.0, samples="1e6")


def test_the_worlds_of_a_ramp_with_a_spread_share_out_easy_and_hard():
    env, seen = AdaptVecEnv("AdaptNet/Humanoid-PushWalk-v0", num_envs=3, num_threads=1), []
    ramp = AttributeRamp("push_scale", 0.4, 0.8, samples=48, spread=0.75)
    look = Check(lambda _: seen.append(env.vector_env.unwrapped.push_scale.tolist()))
    PPO("MlpPolicy", env, n_steps=8, batch_size=24, n_epochs=1, device="cpu").learn(72, callback=[ramp, look])
    assert np.allclose(seen, [[0.4, 0.1, 0.25], [0.6, 0.15, 0.375], [0.8, 0.2, 0.5]])
    with pytest.raises(ValueError, match=r"spread.*0 to 1.*1\.5"):
        AttributeRamp("push_scale", 0.0, 1.0, samples=1, spread=1.5)


def test_neighbours_have_of_all_of_a_spread_so_that_joined_groups_do():
    groups = [AdaptVecEnv("AdaptNet/Humanoid-PushWalk-v0", num_envs=count, num_threads=1) for count in (20, 10, 10)]
    ramp, found = AttributeRamp("push_scale", 0.5, 0.5, samples=40, spread=1.0), []
    look = Check(lambda _: found.extend(group.vector_env.unwrapped.push_scale.copy() for group in groups))
    joined = JoinedWorlds(groups)
    PPO("MultiInputPolicy", joined, n_steps=1, batch_size=40, n_epochs=1, device="cpu").learn(40, callback=[ramp, look])
    np.testing.assert_allclose(np.sort(np.concatenate(found)), np.linspace(0, 0.5, 40), atol=1e-12)
    for values in found:
        assert values.mean() == pytest.approx(0.25, abs=0.04) and values.min() < 0.08 and values.max() > 0.42
    joined.close()


def test_a_ramp_needs_something_to_move():
    with pytest.raises(ValueError, match="no attribute 'drifft'"):
        make_model(AdaptVecEnv(ToyVectorEnv(4))).learn(64, callback=AttributeRamp("drifft", 0.2, 0.1, samples=128))


def test_a_ramp_by_falls_moves_as_far_as_falls_are_rare_and_back_where_they_are_many():
    env, seen = AdaptVecEnv(ToyVectorEnv(4)), []
    ramp = AttributeRamp("drift", 0.0, 1.0, samples=640, falls_per_minute=1.0)
    model = make_model(env)
    model.learn(64, callback=[ramp, Check(lambda _: seen.append(env.vector_env.drift))])
    ramp._falls, ramp._seen = 0, 320
    ramp._on_rollout_start()
    assert ramp.position == 320 and env.vector_env.drift == pytest.approx(0.5)
    ramp._falls, ramp._seen = 1, 1800  # the falls at which it stands still
    ramp._on_rollout_start()
    assert ramp.position == pytest.approx(320)
    ramp._falls, ramp._seen = 100, 64  # as fast back as forth, at most
    state = ramp.state_dict()
    ramp._on_rollout_start()
    assert ramp.position == pytest.approx(256) and env.vector_env.drift == pytest.approx(0.4)
    again = AttributeRamp("drift", 0.0, 1.0, samples=640, falls_per_minute=1.0)
    again.load_state_dict(state)
    again._move()
    assert again.value == pytest.approx(0.4)
    with pytest.raises(ValueError, match="positive number of falls.*-1"):
        AttributeRamp("drift", 0.0, 1.0, samples=1, falls_per_minute=-1)
