"""Room to obstacles: distances from the blocks' sides, and the reward made of them."""

import numpy as np
import pytest
from gymnasium import make

from adapt_envs import make_vector
from adapt_envs.model.obstacles import OBSTACLES, Obstacles
from adapt_envs.model.patch_grid import Patches
from adapt_envs.tasks import clearance_reward


@pytest.fixture
def blocks():
    return Obstacles(OBSTACLES["blocks"], Patches(2), np.random.default_rng(0))


def test_distances_count_from_the_nearest_blocks_sides(blocks):
    along = np.stack([np.cos(blocks.yaw), np.sin(blocks.yaw)], axis=1)
    beside = blocks.centre + (blocks.half[:, :1] + 0.3) * along
    assert blocks.distance(beside) == pytest.approx(0.3, abs=1e-5)  # lanes are wider, no other block is nearer
    corner = blocks.centre + blocks.half[:, :1] * along + blocks.half[:, 1:] * along[:, ::-1] * [-1, 1]
    outwards = (corner - blocks.centre) / np.linalg.norm(corner - blocks.centre, axis=1, keepdims=True)
    assert np.all(blocks.distance(corner + 0.2 * outwards) <= 0.2 + 1e-5)
    assert np.all(blocks.distance(blocks.centre) == 0)


def test_distance_and_raised_heights_agree_on_what_is_within(blocks):
    xy = np.random.default_rng(1).uniform(-27, 27, (5000, 2))
    heights = np.zeros(len(xy), np.float32)
    blocks.raise_heights(heights, *xy.T.astype(np.float32))
    assert np.array_equal(blocks.distance(xy) == 0, heights > 0) and (heights > 0).any()


def test_the_reward_falls_from_one_to_none_where_shoulders_touch():
    assert clearance_reward(np.array([np.inf, 0.6, 0.5, 0.4, 0.3, 0.0])) == pytest.approx([1, 1, 1, 0.5, 0, 0])


def test_environments_keep_it_for_every_step():
    with make("AdaptNet/Humanoid-Obstacles-v0") as env:
        env.reset(seed=0)
        env.step(np.zeros(28, np.float32))
        worlds = env.unwrapped.worlds
        assert env.unwrapped.clearance == clearance_reward(worlds.ground.distance_to_obstacles(worlds.root_xy))[0]
    flat = make_vector("AdaptNet/Humanoid-Walk-v0", num_envs=3)
    flat.reset(seed=0)
    flat.step(np.zeros((3, 28), np.float32))
    assert flat.unwrapped.clearance == pytest.approx(1.0)
