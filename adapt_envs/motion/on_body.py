"""A motion of the plain character as another body shows it: the same joint angles, on feet as far off the ground."""

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import plain_model
from adapt_envs.model.soles import lowest_corner


def joint_names(model: mujoco.MjModel) -> tuple[str, ...]:
    """The joints of a character in the order of its configurations."""
    return tuple(model.actuator(i).name for i in range(model.nu))


def on_body(qpos: NDArray[np.float64], joints: Sequence[str], body: mujoco.MjModel) -> NDArray[np.float64]:
    """Configurations of the plain character, put on a body.

    Args:
        qpos: (T, 7 + J) root position [m], quaternion (w, x, y, z) and joint angles [rad].
        joints: the J joints.
        body: a character with some or all of these joints.

    Returns:
        (T, nq) with the joints that the body has. The root is higher or lower by as much as brings the lowest corner of
        the feet to where it was; its way on the ground stays, so that longer legs slide.
    """
    found = qpos[:, [*range(7), *(7 + list(joints).index(name) for name in joint_names(body))]]
    found[:, 2] += _lowest_foot(plain_model(), qpos) - _lowest_foot(body, found)
    return found


def _lowest_foot(model: mujoco.MjModel, qpos: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T,) height [m] of the lowest corner of the feet in configurations (T, nq)."""
    return lowest_corner(model, Kinematics(model).link_states(qpos))
