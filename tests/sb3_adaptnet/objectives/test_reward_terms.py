"""Rewards that the environments keep themselves."""

import numpy as np
import pytest
from objective_cases import Check, make_model

from sb3_adaptnet import AdaptVecEnv, DiscriminatorRewardCallback
from sb3_adaptnet.objectives.reward_terms import check_terms


def test_an_objective_that_the_environment_rewards_itself():
    env = AdaptVecEnv("AdaptNet/Humanoid-Walk-v0", 4, num_threads=1)
    callback = DiscriminatorRewardCallback({"goal": 0.6, "footing": 0.4})
    seen = []
    check = Check(lambda model: seen.append((callback.rollout.rewards["footing"][-1].copy(), env.vector_env.footing)))
    make_model(env).learn(16 * 4 * 2, callback=[callback, check])
    assert len(seen) == 2
    for kept, latest in seen:
        assert np.allclose(kept, latest) and (kept > 0).all()
    with pytest.raises(ValueError, match="'footing' needs environments"):
        make_model().learn(16, callback=DiscriminatorRewardCallback({"footing": 1.0}))


def test_what_these_worlds_cannot_reward_is_refused():
    hills = AdaptVecEnv("AdaptNet/Humanoid-TerrainHills-v0", 1, num_threads=1)
    check_terms(["goal", "imitation", "tracking"], hills)
    with pytest.raises(ValueError, match="the objective 'footing' cannot be had here: .* this ground is not even"):
        check_terms(["goal", "footing"], hills)
