"""A foreign motion set upright and scaled to the character, its joints sorted by their roles."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import pdist

from adapt_envs.features import rotations
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import LINKS
from adapt_envs.motion.clip import MotionError
from adapt_envs.motion.importing.bvh import Bvh
from adapt_envs.motion.importing.directions import from_matrices, unit
from adapt_envs.motion.importing.skeletons import SIDES, JointMap

Array = NDArray[np.floating]
_LINKS_OF = {
    "hip": "thigh", "knee": "shin", "ankle": "foot", "shoulder": "upper_arm", "elbow": "lower_arm", "wrist": "hand",
}  # fmt: skip
_LINK_OF = {"hips": "pelvis", "head": "head"} | {
    f"{side}_{role}": f"{side}_{link}" for side in SIDES for role, link in _LINKS_OF.items()
}
"""Roles -> the links that turn there."""
_SAME = 0.001
"""Most difference [m] between distances of joints of two skeletons that are the same."""


@dataclass(frozen=True)
class ForeignBody:
    """A foreign motion with z up, in metres of the character.

    Attributes:
        pos: role -> (T, 3) position of its joint, world.
        quat: role -> (T, 4) orientation of its joint, world.
        rest: role -> (3,) position of its joint when no joint is turned.
        rest_quat: (4,) orientation of all joints then.
        spine: (T, K, 3) joints from the hips' middle to the neck.
    """

    pos: dict[str, Array]
    quat: dict[str, Array]
    rest: dict[str, Array]
    rest_quat: Array
    spine: Array

    def __len__(self) -> int:
        return len(self.spine)

    @property
    def natural(self) -> bool:
        """Whether the skeleton stands upright at rest, so that its rest pose tells how its joints sit in the body."""
        down = [unit(self.rest[f"{side}_ankle"] - self.rest[f"{side}_hip"])[2] for side in SIDES]
        across = unit(self.rest["left_hip"] - self.rest["right_hip"])[2]
        upward = unit(self.rest["top"] - self.rest["hips"])[2]
        return bool(max(down) < -0.9 and abs(across) < 0.3 and upward > 0.9)


def is_own(bvh: Bvh, joints: JointMap) -> bool:
    """Whether a file's skeleton is the character's own, as `write_bvh` writes it, in any unit and with any axis up."""
    if any(role not in joints.joints for role in _LINK_OF):
        return False
    theirs = pdist(bvh.rest()[[bvh.names.index(joints.joints[role]) for role in _LINK_OF]])
    model = plain_model()
    rest = Kinematics(model).link_states(model.qpos0[None])[0, :, :3]
    own = pdist(rest[[LINKS.index(link) for link in _LINK_OF.values()]])
    return bool(np.abs(theirs * own.sum() - own * theirs.sum()).max() < _SAME * theirs.sum())


def foreign_body(bvh: Bvh, joints: JointMap, path: Path) -> ForeignBody:
    """Turn and scale a BVH motion to the character's world; arguments as those of `retarget`.

    Raises:
        MotionError: if a leg or the trunk has no length.
    """
    pos, quat = bvh.world()
    rest = bvh.rest()
    index = {role: bvh.names.index(name) for role, name in joints.joints.items()}
    for side in SIDES:  # a skeleton without toes or wrists may still have an end site there
        for role, parent in (("toe", "ankle"), ("wrist", "elbow")):
            children = np.flatnonzero(bvh.parents == index[f"{side}_{parent}"])
            if f"{side}_{role}" not in index and len(children):
                index[f"{side}_{role}"] = int(children[0])
    chain = _spine(bvh, index)
    above = next((role for role in ("neck", "head") if role in index), None)
    if above is not None and not chain:
        raise MotionError(f"{path}: line 1: {above} and hips are the same joint; is the joint map right?")
    index["top"] = chain[-1] if chain else index["left_shoulder"]
    turn = _upright(pos, index, joints.up)
    scale = _metres_per_unit(pos, index, path)
    pos = (rotations.rotate(turn, pos) * scale).astype(np.float64)
    rest = (rotations.rotate(turn, rest) * scale).astype(np.float64)
    middles = [(pos[:, index[f"right_{role}"]] + pos[:, index[f"left_{role}"]]) / 2 for role in ("hip", "shoulder")]
    ends = [] if above is not None else [middles[1]]
    return ForeignBody(
        {role: pos[:, i] for role, i in index.items()},
        {role: rotations.multiply(np.broadcast_to(turn, (len(pos), 4)), quat[:, i]) for role, i in index.items()},
        {role: rest[i] for role, i in index.items()},
        turn,
        np.stack([middles[0], *(pos[:, joint] for joint in chain), *ends], axis=1),
    )


def _spine(bvh: Bvh, index: dict[str, int]) -> list[int]:
    """Joints from above the hips to the neck (or head), or to where the arms branch off if there is neither."""
    tops = [index[role] for role in ("neck", "head") if role in index]
    joint = tops[0] if tops else int(bvh.parents[index["left_shoulder"]])
    chain = []
    while joint >= 0 and joint != index["hips"]:
        chain.append(joint)
        joint = int(bvh.parents[joint])
    return chain[::-1]


def _upright(pos: Array, index: dict[str, int], up: str | None) -> Array:
    """Quaternion (4,) that turns the file's world to z up; if not given, the head is above the feet on average."""
    if up is None:
        rise = (pos[:, index["top"]] - (pos[:, index["right_ankle"]] + pos[:, index["left_ankle"]]) / 2).mean(axis=0)
        axis = int(np.abs(rise).argmax())
        up = ("" if rise[axis] > 0 else "-") + "xyz"[axis]
    axis = "xyz".index(up[-1])
    # A cyclic change of axes is a turn: y up becomes (z, x, y), so BVH's usual forward, z, becomes x.
    matrix = np.roll(np.eye(3), axis - 2, axis=1)
    if up.startswith("-"):
        matrix = np.diag([1.0, -1.0, -1.0]) @ matrix
    return from_matrices(matrix[None])[0]


def _metres_per_unit(pos: Array, index: dict[str, int], path: Path) -> float:
    """Metres of the character that a unit of the file is, by the length of the legs."""
    pairs = [(f"{side}_{a}", f"{side}_{b}") for side in SIDES for a, b in (("hip", "knee"), ("knee", "ankle"))]
    bones = [float(np.median(np.linalg.norm(pos[:, index[a]] - pos[:, index[b]], axis=1))) for a, b in pairs]
    for (a, b), length in zip(pairs, bones, strict=True):
        if length < 0.1 * max(bones) or length <= 1e-9:
            raise MotionError(f"{path}: line 1: the bone from {a} to {b} is {length:g} units long; is the map right?")
    model = plain_model()
    own = sum(abs(model.body(f"right_{link}").pos[2]) for link in ("shin", "foot"))
    return 2 * own / sum(bones)
