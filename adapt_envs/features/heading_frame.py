"""From link states to what policies and discriminators see; one path for simulation and clips.

Everything is expressed in the heading frame of the latest root: origin on the ground under it, z up, x along its
heading (paper, sec. 7). A *link history* is (N, FRAMES, 15, 13) link states in the world frame, oldest frame first.
"""

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features.kinematics import LINK_STATE
from adapt_envs.model.humanoid import LINKS

WINDOW_FRAMES = 5
"""Frames of a discriminator's pose window: the transition and the three frames before it; paper, sec. 7."""
OBSERVED_FRAMES = 4
"""Frames of the policy's observation; paper, sec. 7."""
POSE = 7
"""Numbers per link in a pose window: position 3 and quaternion 4."""
GOAL_SIZE = 4
"""Numbers of the goal: direction 2, distance, preferred speed; paper, app. A."""
OBSERVATION_SIZE = OBSERVED_FRAMES * len(LINKS) * LINK_STATE + GOAL_SIZE
"""784: the 780 numbers of the links and the goal."""


def heading_frame_features(
    history: NDArray[np.float32], ground: NDArray[np.float32] | float = 0.0
) -> NDArray[np.float32]:
    """Link histories in the heading frame of their last root.

    Args:
        history: (N, F, 15, 13) link states, world frame.
        ground: (N,) height [m] of the ground under the last root, or one height for all.

    Returns:
        (N, F, 15, 13): positions, quaternions with w >= 0, velocities, all absolute but along heading axes.
    """
    root = history[:, -1, 0]
    w, x, y, z = root[:, 3], root[:, 4], root[:, 5], root[:, 6]
    # cos and sin of the heading from the root's forward axis, and of half of it for the quaternions.
    forward_x, forward_y = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z)
    norm = np.maximum(np.hypot(forward_x, forward_y), 1e-9)
    c, s = (forward_x / norm)[:, None], (forward_y / norm)[:, None]
    half = np.arctan2(s, c) / 2
    hc, hs = np.cos(half), np.sin(half)

    n = len(history)
    flat = history.reshape(n, -1, LINK_STATE)
    columns = np.ascontiguousarray(flat.transpose(2, 0, 1))
    px, py, pz, qw, qx, qy, qz, vx, vy, vz, ox, oy, oz = columns
    px -= root[:, 0:1]
    py -= root[:, 1:2]
    pz -= np.reshape(np.asarray(ground, np.float32), (-1, 1))
    out = np.empty_like(columns)
    for a, b, target in ((px, py, 0), (vx, vy, 7), (ox, oy, 10)):
        out[target] = c * a + s * b
        out[target + 1] = c * b - s * a
    out[2], out[9], out[12] = pz, vz, oz
    out[3], out[4] = hc * qw + hs * qz, hc * qx + hs * qy
    out[5], out[6] = hc * qy - hs * qx, hc * qz - hs * qw
    out[3:7] *= np.where(out[3] < 0, np.float32(-1), np.float32(1))
    return np.ascontiguousarray(out.transpose(1, 2, 0)).reshape(history.shape)


def observations(features: NDArray[np.float32], goal: NDArray[np.float32]) -> NDArray[np.float32]:
    """Policy observations (N, 784) from features (N, >= 4, 15, 13) and goals (N, 4): four frames, then the goal."""
    n = len(features)
    out = np.empty((n, OBSERVATION_SIZE), np.float32)
    out[:, :-GOAL_SIZE] = features[:, -OBSERVED_FRAMES:].reshape(n, -1)
    out[:, -GOAL_SIZE:] = goal
    return out


def pose_windows(features: NDArray[np.float32]) -> NDArray[np.float32]:
    """Pose windows (N, 5, 15, 7) from features (N, 5, 15, 13): position and quaternion of every link."""
    return np.ascontiguousarray(features[..., :POSE])
