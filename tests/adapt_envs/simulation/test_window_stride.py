"""Pose windows whose frames lie several control steps apart."""

import numpy as np
import pytest

from adapt_envs import env_id, make_vector
from adapt_envs.features import heading_frame_features


@pytest.mark.parametrize("stride", [1, 2, 4, 9])
@pytest.mark.parametrize("name", ["Walk", "Stoop"])
def test_a_window_shows_every_nth_frame(name, stride):
    env = make_vector(env_id(name), 2, window_stride=stride)
    env.reset(seed=0)
    worlds, rng = env.worlds, np.random.default_rng(1)
    assert np.allclose(worlds.windows, worlds.reference._windows[worlds.starts], atol=2e-5)
    links = list(worlds.history.copy().transpose(1, 0, 2, 3))
    for _ in range(3):
        worlds.step(rng.normal(0, 0.05, env.action_space.shape), None)
        links.append(worlds.history[:, -1].copy())
        frames = np.stack([links[-1 - stride * back] for back in (4, 3, 2, 1, 0)], axis=1)
        assert np.allclose(worlds.windows, heading_frame_features(frames)[..., :7], atol=1e-6)
    assert worlds.reference.sample_windows(3, rng).shape == (3, 5, 15, 7)


def test_neither_observations_nor_start_states_of_a_cycle_change_with_the_stride():
    near, far = (make_vector(env_id("Stoop"), 4, window_stride=stride) for stride in (1, 4))
    assert near.worlds.reference.num_states == far.worlds.reference.num_states
    first, second = (env.reset(seed=3)[0] for env in (near, far))
    assert np.allclose(first, second, atol=1e-6)
    actions = np.zeros(near.action_space.shape, np.float32)
    for one, other in zip(near.step(actions)[:2], far.step(actions)[:2], strict=True):
        assert np.allclose(one, other, atol=1e-6)
    assert np.allclose(near.worlds.footing, far.worlds.footing)


@pytest.mark.parametrize("stride", [0, -1, 1.5, "far"])
def test_impossible_strides_are_refused(stride):
    with pytest.raises(ValueError, match=f"window_stride is {stride!r}"):
        make_vector(env_id("Walk"), 1, window_stride=stride)
