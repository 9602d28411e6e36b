"""A motion on its way to the character: poses that may break limits, and where the feet ought to be."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import FOOT_LINKS, joint_names

Array = NDArray[np.floating]
_PI = np.pi


@dataclass(frozen=True)
class Draft:
    """Configurations and foot targets of T frames.

    Attributes:
        qpos: (T, 7 + J) as in `MotionClip`; joint angles may lie beyond their limits.
        foot_pos: (T, 2, 3) where the foot frames (right, left) should be [m], world.
        foot_quat: (T, 2, 4) how they should be turned, world.
    """

    qpos: Array
    foot_pos: Array
    foot_quat: Array

    def __len__(self) -> int:
        return len(self.qpos)

    def rows(self, chosen: slice) -> "Draft":
        """Some of the frames."""
        return Draft(self.qpos[chosen], self.foot_pos[chosen], self.foot_quat[chosen])

    def moved(self, shift: Array) -> "Draft":
        """Everything moved by `shift`, (3,) or (T, 3) [m]."""
        shift = np.broadcast_to(shift, (len(self), 3))
        qpos = self.qpos.copy()
        qpos[:, :3] += shift
        return replace(self, qpos=qpos, foot_pos=self.foot_pos + shift[:, None])

    def turned(self, yaw: float | Array) -> "Draft":
        """Everything turned about the world's z axis by `yaw`, () or (T,) [rad]."""
        turn = np.broadcast_to(rotations.from_yaw(np.asarray(yaw, dtype=np.float64)), (len(self), 4))
        qpos = self.qpos.copy()
        qpos[:, :3] = rotations.rotate(turn, qpos[:, :3])
        qpos[:, 3:7] = rotations.multiply(turn, qpos[:, 3:7])
        turn = turn[:, None]
        return Draft(qpos, rotations.rotate(turn, self.foot_pos), rotations.multiply(turn, self.foot_quat))


def joint_columns(joint: str) -> list[int]:
    """Columns of `qpos` that hold a joint's angles: one hinge, or the three of `x`, `y`, `z`."""
    return [7 + i for i, name in enumerate(joint_names()) if name == joint or name[:-2] == joint and name[-2] == "_"]


def from_poses(qpos: Array) -> Draft:
    """A draft whose feet are to be where its configurations put them."""
    states = Kinematics(plain_model()).link_states(qpos)
    feet = states[:, FOOT_LINKS].astype(np.float64)
    quat = feet[..., 3:7] / np.linalg.norm(feet[..., 3:7], axis=-1, keepdims=True)
    return Draft(qpos, feet[..., :3], quat)


def angles_within(quats: Array, joint: str) -> Array:
    """Angles (T, 3) of a three-hinge joint with Rx Ry Rz = `quats` (T, 4) [rad].

    Every rotation has two sets of angles, each with whole turns to spare: taken is the one nearest to the limits and to
    the frame before.
    """
    first = rotations.to_intrinsic_xyz(quats)
    second = np.stack([first[:, 0] + _PI, _PI - first[:, 1], first[:, 2] + _PI], axis=1)
    model = plain_model()
    ranges = np.array([model.jnt_range[model.joint(f"{joint}_{axis}").id] for axis in "xyz"])
    middle = ranges.mean(axis=1)
    sets = np.stack([middle + (angles - middle + _PI) % (2 * _PI) - _PI for angles in (first, second)], axis=1)
    excess = np.maximum(np.maximum(sets - ranges[:, 1], ranges[:, 0] - sets), 0).sum(axis=-1)
    chosen = np.empty_like(first)
    previous = None
    for frame, (options, beyond) in enumerate(zip(sets, excess, strict=True)):
        cost = 4 * beyond if previous is None else 4 * beyond + np.abs(options - previous).sum(axis=-1)
        previous = chosen[frame] = options[np.argmin(cost)]
    return chosen
