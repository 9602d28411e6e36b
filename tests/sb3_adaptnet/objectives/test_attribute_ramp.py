"""Attributes of the worlds that move with the samples."""

import pytest
from objective_cases import Check, make_model
from toy_env import ToyVectorEnv

from sb3_adaptnet import (
    AdaptVecEnv,
)
from sb3_adaptnet.objectives.attribute_ramp import AttributeRamp


def test_a_ramp_moves_an_attribute_with_the_samples():
    env, seen = AdaptVecEnv(ToyVectorEnv(4)), []
    ramp = AttributeRamp("drift", 0.2, 0.1, samples=128)
    model = make_model(env)
    model.learn(64 * 4, callback=[ramp, Check(lambda _: seen.append(env.vector_env.drift))])
    assert seen == pytest.approx([0.2, 0.15, 0.1, 0.1])
    with pytest.raises(ValueError, match="positive.*0"):
        AttributeRamp("drift", 0.0, 1.0, samples=0)


def test_a_ramp_needs_something_to_move():
    with pytest.raises(ValueError, match="no attribute 'drifft'"):
        make_model(AdaptVecEnv(ToyVectorEnv(4))).learn(64, callback=AttributeRamp("drifft", 0.2, 0.1, samples=128))
