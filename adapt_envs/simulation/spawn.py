"""Start states put somewhere on the ground: pure functions over arrays."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.model.ground import Ground
from adapt_envs.model.humanoid import FOOT_LINKS
from adapt_envs.model.soles import sole_grid

_SOLE_POINTS = 6, 4
"""Points of a sole along and across the foot, at which it must not sink into the ground: 4 cm apart at most."""

Array = NDArray[np.floating]


def moved(
    qpos: NDArray[np.float64], qvel: NDArray[np.float64], history: NDArray[np.float32], xy: Array, heading: Array
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float32]]:
    """Start states moved to other places, their roots turned to other headings.

    Args:
        qpos: (n, nq) states over the world's origin.
        qvel: (n, nv) their velocities.
        history: (n, F, 15, 13) link states that end in them, world frame.
        xy: (n, 2) where the roots shall be [m].
        heading: (n,) where the roots shall face [rad].

    Returns:
        The three arrays, moved.
    """
    turn = rotations.from_yaw(heading - rotations.heading(qpos[:, 3:7]))
    qpos, qvel, history = qpos.copy(), qvel.copy(), history.copy()
    qpos[:, :2] += xy
    qpos[:, 3:7] = rotations.multiply(turn, qpos[:, 3:7])
    qvel[:, :3] = rotations.rotate(turn, qvel[:, :3])  # the root's angular velocity is in its own frame
    turns = turn[:, None, None].astype(np.float32)
    for part in (slice(0, 3), slice(7, 10), slice(10, 13)):
        history[..., part] = rotations.rotate(turns, history[..., part])
    history[..., 3:7] = rotations.multiply(turns, history[..., 3:7])
    history[..., :2] += xy[:, None, None].astype(np.float32)
    return qpos, qvel, history


def spawned(
    model: mujoco.MjModel, ground: Ground,
    qpos: NDArray[np.float64], qvel: NDArray[np.float64], history: NDArray[np.float32], xy: Array, heading: Array,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float32]]:  # fmt: skip
    """Start states moved, as `moved` does, and lifted to stand on the ground there."""
    qpos, qvel, history = moved(qpos, qvel, history, xy, heading)
    if not ground.plain:
        lift = standing_lift(model, history[:, -1], ground)
        qpos[:, 2] += lift
        history[..., 2] += lift[:, None, None].astype(np.float32)
    return qpos, qvel, history


def standing_lift(model: mujoco.MjModel, links: Array, ground: Ground) -> NDArray[np.float64]:
    """How far to lift characters so that their soles are as high over the ground as they were over the plane z = 0.

    Args:
        model: the character's model.
        links: (n, 15, 13) link states, world frame.
        ground: the ground.

    Returns:
        (n,) lift [m].
    """
    feet = links[:, FOOT_LINKS]
    soles = sole_grid(model, *_SOLE_POINTS)
    points = rotations.placed(feet[..., :3], feet[..., 3:7].astype(np.float64), soles)
    height = points[..., 2]
    return height.min(axis=(1, 2)) - (height - ground.height_at(points[..., :2])).min(axis=(1, 2))
