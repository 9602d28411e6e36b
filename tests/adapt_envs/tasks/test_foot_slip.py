"""Feet that stay where they stand."""

import numpy as np
import pytest

from adapt_envs import env_id, make_vector
from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import CONTROL_DT, FEET, LINKS
from adapt_envs.model.soles import sole_corners
from adapt_envs.tasks.foot_slip import footing_reward

CORNERS = sole_corners(compile_model())


def slid(windows):
    return footing_reward(windows, CORNERS)


def standing(speeds=(0.0, 0.0), heights=(0.0, 0.0)):
    """One window (1, 5, 15, 7) of feet with level soles at these heights [m] that slide forward at `speeds` [m/s]."""
    windows = np.zeros((1, 5, len(LINKS), 7), np.float32)
    windows[..., 2], windows[..., 3] = 1.0, 1.0
    for foot, speed, height in zip(FEET, speeds, heights, strict=True):
        geom = compile_model().geom(foot)
        windows[0, :, LINKS.index(foot), 0] = np.arange(5) * speed * CONTROL_DT
        windows[0, :, LINKS.index(foot), 2] = height + geom.size[2] - geom.pos[2]
    return windows


def test_feet_that_stay_are_worth_one_and_sliding_ones_less():
    assert slid(standing()) == pytest.approx([1.0])
    assert slid(standing(speeds=(0.15, 0.0))) == pytest.approx([(np.exp(-1) + 1) / 2], rel=1e-4)
    assert slid(standing(speeds=(0.3, 0.6))) == pytest.approx([(np.exp(-2) + np.exp(-4)) / 2], rel=1e-4)


def test_a_foot_in_the_air_may_move():
    assert slid(standing(speeds=(5.0, 0.0), heights=(0.02, 0.0))) == pytest.approx([1.0])
    assert slid(standing(speeds=(5.0, 0.0), heights=(0.01, 0.0))) == pytest.approx([0.5], abs=1e-6)


def test_the_direction_of_a_slip_does_not_matter():
    turned = standing(speeds=(0.2, 0.1))
    turned[..., :2] = turned[..., [1, 0]]  # sideways instead of forward; the soles' own axes stay
    assert slid(turned) == pytest.approx(slid(standing(speeds=(0.2, 0.1))), rel=1e-4)


def test_environments_keep_it_for_the_transition_before_a_restart():
    env = make_vector(env_id("Walk"), 16)
    env.reset(seed=0)
    pose = np.tile(env.single_action_space.mean_pose, (16, 1))
    for _ in range(40):  # long enough for some to fall and restart
        *_, infos = env.step(pose)
        assert env.footing == pytest.approx(footing_reward(env.pose_windows, CORNERS))
    assert "_final_obs" in infos or env.worlds.steps.min() < 40
    clip = footing_reward(env.sample_reference_windows(500, np.random.default_rng(0)), CORNERS)
    assert clip.mean() > 0.8  # a swinging toe passes low and fast; the standing foot does not slide
    assert clip.mean() > env.footing.mean()


def test_uneven_ground_has_no_footing():
    env = make_vector(env_id("TerrainHills"), 1)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="this ground is not even"):
        _ = env.footing
