"""Weights of objectives: with the samples, and where a character has to turn."""

import numpy as np
import pytest
from objective_cases import DISCRIMINATOR, Check, make_model, standardised_advantages

from sb3_adaptnet import AdaptVecEnv, DiscriminatorRewardCallback
from sb3_adaptnet.objectives.weighting import ObjectiveWeights, turning


def test_a_turn_is_what_lies_aside():
    angles = np.radians([0, 10, 45, 90, 180, -45, -10])
    goals = np.stack([np.cos(angles), np.sin(angles), np.full(7, 3.0), np.ones(7)], axis=-1)
    np.testing.assert_array_equal(turning(goals), [0, 0, 1, 1, 1, 1, 0])
    between = np.array([[0.85, np.sqrt(1 - 0.85**2), 3.0, 1.0]])
    np.testing.assert_allclose(turning(between), [0.5])


def test_in_turns_the_goal_gets_what_others_lose():
    weights = ObjectiveWeights(
        {"imitation": 0.1, "tracking": {0: 0.4, 100: 0.3}, "goal": 0.5}, {"tracking": {100: 1.0, 200: 0.5}}
    )
    goals = np.array([[1.0, 0, 3, 1], [0.85, 0.5, 3, 1], [0.0, 1, 3, 1]])
    np.testing.assert_allclose(weights.where(goals, None, 0), [[0.1, 0.4, 0.5]] * 3)
    np.testing.assert_allclose(
        weights.where(goals, None, 200), [[0.1, 0.3, 0.5], [0.1, 0.225, 0.575], [0.1, 0.15, 0.65]]
    )
    assert weights.at(50) == pytest.approx([0.1, 0.35, 0.5])


def test_without_factors_weights_are_the_same_everywhere():
    weights = ObjectiveWeights({"goal": 0.7, "imitation": 0.3})
    assert weights.where(np.zeros((5, 2, 4)), np.zeros((5, 2)), 0).tolist() == [0.7, 0.3]


def test_alone_the_goal_gets_what_others_lose():
    weights = ObjectiveWeights({"tracking": 0.4, "goal": 0.6}, {"tracking": 0.5}, {"tracking": 0.25})
    goals = np.array([[1.0, 0, 3, 1], [1.0, 0, 3, 1], [0.0, 1, 3, 1], [0.0, 1, 3, 1]])
    found = weights.where(goals, np.array([3, 0, 3, 0]), 0)
    np.testing.assert_allclose(found, [[0.4, 0.6], [0.1, 0.9], [0.2, 0.8], [0.05, 0.95]])
    with pytest.raises(ValueError, match="alone needs worlds with companions"):
        weights.where(goals, None, 0)


def test_advantages_of_a_rollout_are_weighed_where_each_sample_was():
    callback = DiscriminatorRewardCallback(
        {"imitation": 0.4, "goal": 0.6}, discriminator=DISCRIMINATOR, in_turns={"imitation": 0.25}
    )
    seen = []

    def check(model):
        buffer = model.rollout_buffer
        standard = standardised_advantages(buffer)
        aside = turning(buffer.observations["observation"][..., -4:])
        imitation = 0.4 - 0.3 * aside
        expected = imitation * standard[..., 0] + (1 - imitation) * standard[..., 1]
        np.testing.assert_allclose(buffer.advantages, expected, rtol=2e-3, atol=2e-3)
        seen.append((aside.min(), aside.max()))

    env = AdaptVecEnv("AdaptNet/Humanoid-Walk-v0", num_envs=16, num_threads=1, seed=0)
    make_model(env).learn(16 * 16 * 3, callback=[callback, Check(check)])
    assert min(low for low, _ in seen) == 0 and max(high for _, high in seen) == 1  # otherwise nothing was tested


def test_factors_of_worlds_that_are_not_there_are_refused_before_anything_is_learned():
    callback = DiscriminatorRewardCallback({"imitation": 0.4, "goal": 0.6}, alone={"imitation": 0.5})
    model = make_model()
    with pytest.raises(ValueError, match="alone needs worlds with companions"):
        model.learn(16 * 16, callback=callback)
    assert model.num_timesteps == 0


def test_refuses_factors_that_are_none():
    for factors, words in (
        ({"goal": 0.5}, "in_turns gives weight of 'goal' to the goal.*beside the goal are: imitation"),
        ({"tracking": 0.5}, "in_turns gives weight of 'tracking'.*are: imitation"),
        ({"imitation": 1.5}, "'imitation' of in_turns is at most 1, not 1.5"),
        ({"imitation": {0: 1.0, 100: 2.0}}, "'imitation' of in_turns is at most 1, not 2.0"),
        ({"imitation": -0.5}, "'imitation' of in_turns must be a number"),
        ({"imitation": "half"}, "'imitation' of in_turns must be a number"),
    ):
        with pytest.raises(ValueError, match=words):
            DiscriminatorRewardCallback({"imitation": 0.4, "goal": 0.6}, in_turns=factors)
    with pytest.raises(ValueError, match="alone gives weight of 'goal' to the goal"):
        DiscriminatorRewardCallback({"imitation": 0.4, "goal": 0.6}, alone={"goal": 0.5})
    with pytest.raises(ValueError, match="in_turns gives weight of 'imitation' to the goal"):
        DiscriminatorRewardCallback({"imitation": 1.0}, in_turns={"imitation": 0.5})
