"""Feet that stay where they stand: a reward beyond the paper's two. Pure functions over arrays."""

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.model.humanoid import CONTROL_DT, FOOT_LINKS
from adapt_envs.model.soles import TOUCHING

SLIP_SCALE = 0.15
"""Slip [m/s] at which a foot's reward has fallen to 1/e."""


def footing_reward(windows: NDArray[np.floating], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """How little the feet slid in the last transition.

    Args:
        windows: (N, 5, 15, 7) pose windows, heights over the ground below the root.
        corners: (2, 4, 3) of `sole_corners`.

    Returns:
        (N,) in (0, 1]: the mean over the feet of exp(-slip / 0.15 m/s), where the slip is the horizontal speed of the
        foot's lowest corner if it touches the ground before and after, else 0.
    """
    feet = windows[:, -2:, FOOT_LINKS].astype(np.float64)
    points = rotations.placed(feet[..., :3], feet[..., 3:7], corners)
    lowest = points[:, 0, ..., 2].argmin(axis=-1)[..., None, None]
    before, after = (np.take_along_axis(points[:, i], lowest, axis=2)[:, :, 0] for i in (0, 1))
    slip = np.linalg.norm((after - before)[..., :2], axis=-1) / CONTROL_DT
    slip[(before[..., 2] > TOUCHING) | (after[..., 2] > TOUCHING)] = 0
    return np.exp(-slip / SLIP_SCALE).mean(axis=1)
