"""When feet stand, and where their soles are."""

import numpy as np

from adapt_envs.model.humanoid import joint_names
from adapt_envs.motion.gaits.draft import from_poses
from adapt_envs.motion.gaits.planted_feet import corners_in_world, standing


def test_sole_corners_are_those_of_the_boxes():
    qpos = np.zeros((1, 7 + len(joint_names())))
    qpos[:, 2:4] = (0.881416, 1)
    draft = from_poses(qpos)
    corners = corners_in_world(draft.foot_pos, draft.foot_quat)
    np.testing.assert_allclose(corners[..., 2], 0, atol=1e-6)
    np.testing.assert_allclose(np.ptp(corners[0, 0], axis=0), [0.177, 0.09, 0], atol=1e-6)


def test_standing_is_low_and_slow():
    corners = np.zeros((30, 4, 3))
    corners[10:20, :, 2] = 0.1  # up in the air
    corners[20:, :, 0] = np.arange(10)[:, None] * 0.1  # down, at 3 m/s
    assert standing(corners)[:9].all() and not standing(corners)[10:].any()
