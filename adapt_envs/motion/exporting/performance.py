"""A skeleton with its motion as animation tools want it: y up, z ahead, x to the left; bones, not hinges."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.model.humanoid import LINKS

BONES = {
    "pelvis": "Hips", "torso": "Spine", "head": "Head",
    "right_upper_arm": "RightArm", "right_lower_arm": "RightForeArm", "right_hand": "RightHand",
    "left_upper_arm": "LeftArm", "left_lower_arm": "LeftForeArm", "left_hand": "LeftHand",
    "right_thigh": "RightUpLeg", "right_shin": "RightLeg", "right_foot": "RightFoot",
    "left_thigh": "LeftUpLeg", "left_shin": "LeftLeg", "left_foot": "LeftFoot",
}  # fmt: skip
"""Links -> bones, by the names that retargeting tools know (MotionBuilder, Mixamo). A bone turns about its near end."""
_AXES, _QUAT = [1, 2, 0], [0, 2, 3, 1]
"""Where y up, z ahead takes its x, y, z from: a cyclic change of axes is a turn, so rotations change alike."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Performance:
    """The motion of a skeleton of J bones in T frames; y up, z ahead [m].

    Attributes:
        names: (J,) bones, parents before children, each bone's children before its next sister.
        parents: (J,) number of each bone's parent, -1 for the root.
        offsets: (J, 3) place of each bone in its parent; the root's is where it stands at rest.
        root: (T, 3) positions of the root, world.
        quats: (T, J, 4) rotations in the parent, wxyz; none at rest, when the arms hang down.
        fps: frames per second.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    offsets: Array
    root: Array
    quats: Array
    fps: float

    @property
    def rest(self) -> Array:
        """(J, 3) places of the bones at rest, world."""
        places = self.offsets.copy()
        for bone, parent in enumerate(self.parents):
            if parent >= 0:
                places[bone] += places[parent]
        return places


def perform(model: mujoco.MjModel, qpos: Array, fps: float, floor: float = 0.0) -> Performance:
    """What the character does in configurations, set down over the origin.

    Args:
        model: the character, of any body shape and with any locked joints.
        qpos: (T, nq) configurations, one every 1 / fps seconds.
        fps: frames per second.
        floor: height [m] of the ground where it begins, which becomes 0.
    """
    bodies = [model.body(link).id for link in LINKS]
    numbers = {int(body): number for number, body in enumerate(bodies)}
    parents = tuple(numbers.get(int(model.body_parentid[body]), -1) for body in bodies)
    pos, quat = _world(model, qpos, bodies)
    local = quat.copy()
    for bone, parent in enumerate(parents):
        if parent >= 0:
            local[:, bone] = rotations.multiply(rotations.conjugate(quat[:, parent]), quat[:, bone])
    start = np.array([*qpos[0, :2], floor])
    return Performance(
        names=tuple(BONES[link] for link in LINKS),
        parents=parents,
        offsets=y_up(model.body_pos[bodies]),
        root=y_up(pos[:, 0] - start),
        quats=local[..., _QUAT],
        fps=fps,
    )


def y_up(vectors: NDArray[np.floating]) -> Array:
    """Vectors (..., 3) of the simulation (z up, x ahead) with y up and z ahead."""
    return np.asarray(vectors, np.float64)[..., _AXES]


def _world(model: mujoco.MjModel, qpos: Array, bodies: list[int]) -> tuple[Array, Array]:
    """Positions (T, J, 3) and orientations (T, J, 4) of bodies, z up."""
    data = mujoco.MjData(model)
    pos, quat = np.empty((len(qpos), len(bodies), 3)), np.empty((len(qpos), len(bodies), 4))
    for frame, configuration in enumerate(qpos):
        data.qpos[:] = configuration
        mujoco.mj_kinematics(model, data)
        pos[frame], quat[frame] = data.xpos[bodies], data.xquat[bodies]
    return pos, quat
