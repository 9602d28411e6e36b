"""A motion of the plain character as another body shows it, which has other legs or lacks joints."""

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import FEET, joints_of
from adapt_envs.model.soles import lowest_corner
from adapt_envs.motion.clip import MotionClip


def on_body(qpos: NDArray[np.float64], joints: Sequence[str], body: mujoco.MjModel) -> NDArray[np.float64]:
    """Poses of the plain character, put on a body: the same joint angles, on feet as far off the ground.

    Args:
        qpos: (T, 7 + J) root position [m], quaternion (w, x, y, z) and joint angles [rad].
        joints: the J joints.
        body: a character with some or all of these joints.

    Returns:
        (T, nq) with the joints that the body has. The root is higher or lower by as much as brings the lowest corner of
        the feet to where it was; its way on the ground stays, so that longer legs slide.
    """
    found = qpos[:, [*range(7), *(7 + list(joints).index(name) for name in joints_of(body))]]
    found[:, 2] += _lowest_foot(plain_model(), qpos) - _lowest_foot(body, found)
    return found


def shown_by(clip: MotionClip, body: mujoco.MjModel) -> MotionClip:
    """A clip of the plain character as a body shows it: `on_body`, in steps as much longer as its legs are.

    Legs L times as long take L times as long a way with the same joint angles. They do so in sqrt(L) times as long a
    time, as pendulums would: the Froude number v^2 / (g l) stays (dynamic similarity, Alexander and Jayes 1983,
    doi:10.1111/j.1469-7998.1983.tb04266.x). The speed is sqrt(L) times the clip's.
    """
    longer = leg_length(body) / leg_length(plain_model())
    qpos = _slowed(clip, np.sqrt(longer)) if abs(longer - 1) > 1e-6 else clip.qpos
    qpos = on_body(qpos, clip.joint_names, body)
    qpos[:, :2] *= longer
    return replace(clip, qpos=qpos, joint_names=joints_of(body))


def leg_length(model: mujoco.MjModel) -> float:
    """From hip to ankle [m], the mean of both legs."""
    lengths = []
    for foot in FEET:
        ankle = model.body(foot)
        lengths.append(np.linalg.norm(ankle.pos) + np.linalg.norm(model.body(ankle.parentid[0]).pos))
    return float(np.mean(lengths))


def _slowed(clip: MotionClip, factor: float) -> NDArray[np.float64]:
    """Configurations (T, nq) of a clip in `factor` times the time; a period stays whole frames."""
    frames = round((len(clip.qpos) - 1) * factor) + 1
    times = np.linspace(0, len(clip.qpos) - 1, frames)
    rows = np.minimum(times.astype(int), len(clip.qpos) - 2)
    before, after = clip.qpos[rows], clip.qpos[rows + 1].copy()
    after[:, 3:7] *= np.where((before[:, 3:7] * after[:, 3:7]).sum(axis=1, keepdims=True) < 0, -1, 1)
    found = before + (times - rows)[:, None] * (after - before)
    found[:, 3:7] /= np.linalg.norm(found[:, 3:7], axis=1, keepdims=True)
    return found


def _lowest_foot(model: mujoco.MjModel, qpos: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T,) height [m] of the lowest corner of the feet in configurations (T, nq)."""
    return lowest_corner(model, Kinematics(model).link_states(qpos))
