"""The goal task: walk to a target at a preferred speed (paper, app. A). Pure functions over arrays."""

import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.humanoid import CONTROL_DT

GOAL_RADIUS = 0.5
"""Within this distance [m] of the target the reward is 1; R of app. A."""
SHARPNESS = 3.0
"""The 3 in app. A's exponent."""
NO_DIRECTION = 0.01
"""Closer than this [m] the direction to the target is zero: it would flicker."""

Array = NDArray[np.floating]


def targets_ahead(root_xy: Array, heading: Array, speed: Array, seconds: Array) -> NDArray[np.float32]:
    """Targets (N, 2): from `root_xy` (N, 2) along the world angle `heading` (N,), as far as one gets in `seconds`."""
    direction = np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    return (root_xy + (speed * seconds)[:, None] * direction).astype(np.float32)


def goal_observation(root_xy: Array, root_heading: Array, target: Array, speed: Array) -> NDArray[np.float32]:
    """Goal part of the observation.

    Args:
        root_xy: (N, 2) root position on the ground [m], world.
        root_heading: (N,) heading of the root [rad], world.
        target: (N, 2) target [m], world.
        speed: (N,) preferred speed [m/s].

    Returns:
        (N, 4): unit direction to the target in the heading frame (zero below 1 cm), distance [m], speed [m/s].
    """
    offset = target - root_xy
    distance = np.hypot(offset[:, 0], offset[:, 1])
    scale = np.where(distance < NO_DIRECTION, 0, 1 / np.maximum(distance, NO_DIRECTION))
    c, s = np.cos(root_heading), np.sin(root_heading)
    out = np.empty((len(root_xy), 4), np.float32)
    out[:, 0] = (c * offset[:, 0] + s * offset[:, 1]) * scale
    out[:, 1] = (c * offset[:, 1] - s * offset[:, 0]) * scale
    out[:, 2] = distance
    out[:, 3] = speed
    return out


def goal_reward(before_xy: Array, after_xy: Array, target: Array, speed: Array) -> NDArray[np.float64]:
    """Reward of app. A for one control step: exp(-3 |v - v*|^2 / |v*|^2), or 1 within 0.5 m of the target.

    v is the root's displacement over the step times 30; v* has the preferred speed and points from where the step
    began to the target.

    Args:
        before_xy: (N, 2) root position when the action was chosen [m].
        after_xy: (N, 2) root position one control step later [m].
        target: (N, 2) target [m].
        speed: (N,) preferred speed [m/s], positive.

    Returns:
        (N,) in (0, 1].
    """
    offset = target - before_xy
    distance = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), 1e-6)
    wanted = offset * (speed / distance)[:, None]
    error = (after_xy - before_xy) / CONTROL_DT - wanted
    reward = np.exp(-SHARPNESS * (error**2).sum(axis=1) / speed**2)
    left = target - after_xy
    return np.where(np.hypot(left[:, 0], left[:, 1]) < GOAL_RADIUS, 1.0, reward)
