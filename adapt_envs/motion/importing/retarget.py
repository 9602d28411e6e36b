"""Foreign skeletons onto the character: directions of bones become joint angles, ankles become foot targets.

What is copied are the places of the joints relative to each other, not the file's angles: so it does not matter how a
skeleton's joints are turned at rest. Its rotations serve for what places cannot tell: the twist of straight limbs, the
head, the roll of the feet. Sizes follow from the length of the legs, so a file's unit does not matter either.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from adapt_envs.features import rotations
from adapt_envs.motion.clip import MotionError
from adapt_envs.motion.importing.bvh import Bvh
from adapt_envs.motion.importing.draft import Array, Draft, angles_within, character, joint_columns, joint_names
from adapt_envs.motion.importing.skeletons import SIDES, JointMap

_UP = np.array([0.0, 0.0, 1.0])
_STRAIGHT = 0.15
"""Sine of the bend below which a limb's own twist outweighs the plane of its bend."""
_T_POSE_SECONDS = 2.0


@dataclass(frozen=True)
class _Body:
    """A foreign motion with z up, in metres of the character: world pose of each role's joint, and at rest."""

    pos: dict[str, Array]
    quat: dict[str, Array]
    rest: dict[str, Array]
    rest_quat: Array
    spine: Array
    """(T, K, 3): joints from the hips' middle to the neck."""

    def __len__(self) -> int:
        return len(self.spine)

    @property
    def natural(self) -> bool:
        """Whether the skeleton stands upright at rest, so that its rest pose tells how its joints sit in the body."""
        down = [_unit(self.rest[f"{side}_ankle"] - self.rest[f"{side}_hip"])[2] for side in SIDES]
        across = _unit(self.rest["left_hip"] - self.rest["right_hip"])[2]
        upward = _unit(self.rest["top"] - self.rest["hips"])[2]
        return bool(max(down) < -0.9 and abs(across) < 0.3 and upward > 0.9)


def retarget(bvh: Bvh, joints: JointMap, path: Path) -> Draft:
    """Put a BVH motion onto the character, at the file's own frame rate.

    Args:
        bvh: the file's content.
        joints: which joint is which.
        path: the file, for messages.

    Returns:
        A draft; not yet on the ground, nor within limits.

    Raises:
        MotionError: if the skeleton's proportions make no sense.
    """
    body = _body(bvh, joints, path)
    try:
        draft, torso = _fitted(body)
    except ValueError:  # a frame without directions: places that coincide
        raise MotionError(f"{path}: line 1: joints of the trunk or limbs coincide; is the joint map right?") from None
    drop = _leading_t_pose(body, torso, bvh.frame_time) if joints.drop is None else joints.drop
    return draft.rows(slice(drop, None))


def _fitted(body: _Body) -> tuple[Draft, Array]:
    """The draft, and the torso's world orientation (T, 4)."""
    pelvis, torso = _trunk(body)
    quats = {"pelvis": pelvis, "abdomen": _local(pelvis, torso), "neck": _local(torso, _head(body, pelvis))}
    qpos = np.zeros((len(body), 7 + len(joint_names())))
    qpos[:, :3] = (body.pos["right_hip"] + body.pos["left_hip"]) / 2
    qpos[:, 3:7] = pelvis
    feet = []
    for side in SIDES:
        upper, bend = _limb(body, side, ("shoulder", "elbow", "wrist"), torso, -1.0)
        quats[f"{side}_shoulder"] = _local(torso, upper)
        qpos[:, joint_columns(f"{side}_elbow")] = -bend[:, None]
        thigh, bend = _limb(body, side, ("hip", "knee", "ankle"), pelvis, 1.0)
        quats[f"{side}_hip"] = _local(pelvis, thigh)
        qpos[:, joint_columns(f"{side}_knee")] = bend[:, None]
        shin = rotations.multiply(thigh, rotations.from_axis_angle(np.tile([0.0, 1, 0], (len(bend), 1)), bend))
        feet.append(_foot(body, side, shin))
        quats[f"{side}_ankle"] = _local(shin, feet[-1])
    for joint, quat in quats.items():
        if joint != "pelvis":
            qpos[:, joint_columns(joint)] = angles_within(quat, joint)
    ankles = np.stack([body.pos[f"{side}_ankle"] for side in SIDES], axis=1)
    return Draft(qpos, ankles, np.stack(feet, axis=1)), torso


def _body(bvh: Bvh, joints: JointMap, path: Path) -> _Body:
    pos, quat = bvh.world()
    rest = bvh.rest()
    index = {role: bvh.names.index(name) for role, name in joints.joints.items()}
    for side in SIDES:  # a skeleton without toes or wrists may still have an end site there
        for role, parent in (("toe", "ankle"), ("wrist", "elbow")):
            children = np.flatnonzero(bvh.parents == index[f"{side}_{parent}"])
            if f"{side}_{role}" not in index and len(children):
                index[f"{side}_{role}"] = int(children[0])
    chain = _spine(bvh, index)
    index["top"] = chain[-1] if chain else index["left_shoulder"]
    turn = _upright(pos, index, joints.up)
    scale = _leg_length(pos, index, path)
    pos = (rotations.rotate(turn, pos) * scale).astype(np.float64)
    rest = (rotations.rotate(turn, rest) * scale).astype(np.float64)
    middles = [(pos[:, index[f"right_{role}"]] + pos[:, index[f"left_{role}"]]) / 2 for role in ("hip", "shoulder")]
    above = [] if "neck" in index or "head" in index else [middles[1]]
    return _Body(
        {role: pos[:, i] for role, i in index.items()},
        {role: rotations.multiply(np.broadcast_to(turn, (len(pos), 4)), quat[:, i]) for role, i in index.items()},
        {role: rest[i] for role, i in index.items()},
        turn,
        np.stack([middles[0], *(pos[:, joint] for joint in chain), *above], axis=1),
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
    return _quats(matrix[None])[0]


def _leg_length(pos: Array, index: dict[str, int], path: Path) -> float:
    """Metres of the character per unit of the file, by the length of its legs."""
    pairs = [(f"{side}_{a}", f"{side}_{b}") for side in SIDES for a, b in (("hip", "knee"), ("knee", "ankle"))]
    bones = [float(np.median(np.linalg.norm(pos[:, index[a]] - pos[:, index[b]], axis=1))) for a, b in pairs]
    for (a, b), length in zip(pairs, bones, strict=True):
        if length < 0.1 * max(bones) or length <= 1e-9:
            raise MotionError(f"{path}: line 1: the bone from {a} to {b} is {length:g} units long; is the map right?")
    model = character()
    own = sum(abs(model.body(f"right_{link}").pos[2]) for link in ("shin", "foot"))
    return 2 * own / sum(bones)


def _trunk(body: _Body) -> tuple[Array, Array]:
    """World orientations (T, 4) of pelvis and torso: lines from hips to waist to neck, the sides' left and right."""
    model = character()
    lower, upper = model.body("torso").pos[2], model.body("head").pos[2]
    waist = _along(body.spine, lower / (lower + upper))
    pelvis_up, torso_up = waist - body.spine[:, 0], body.spine[:, -1] - waist
    pelvis = _frame(up=pelvis_up, left=body.pos["left_hip"] - body.pos["right_hip"], exact="left")
    torso = _frame(up=torso_up, left=body.pos["left_shoulder"] - body.pos["right_shoulder"], exact="up")
    return pelvis, torso


def _along(points: Array, share: float) -> Array:
    """Points (T, 3) at a share of the length of the lines through `points` (T, K, 3)."""
    steps = np.linalg.norm(np.diff(points, axis=1), axis=-1).mean(axis=0)
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = share * lengths[-1]
    after = int(np.clip(np.searchsorted(lengths, wanted), 1, len(lengths) - 1))
    weight = (wanted - lengths[after - 1]) / max(steps[after - 1], 1e-12)
    return points[:, after - 1] * (1 - weight) + points[:, after] * weight


def _head(body: _Body, pelvis: Array) -> Array:
    """World orientation (T, 4) of the head.

    How the joint sits in the head comes from the rest pose; if that is no stand, the head is level on average.
    """
    role = next((name for name in ("head", "neck") if name in body.quat), None)
    if role is None:
        return _facing(pelvis)
    quat = body.quat[role]
    if body.natural:
        ahead = _frame(up=_UP[None], left=(body.rest["left_hip"] - body.rest["right_hip"])[None], exact="up")
        fixed = rotations.multiply(rotations.conjugate(body.rest_quat[None]), ahead)
    else:
        offsets = rotations.multiply(rotations.conjugate(quat), _facing(pelvis))
        fixed = np.roll(Rotation.from_quat(np.roll(offsets, -1, axis=1)).mean().as_quat(), 1)[None]
    return rotations.multiply(quat, np.broadcast_to(fixed, quat.shape))


def _facing(quat: Array) -> Array:
    return rotations.from_yaw(rotations.heading(quat))


def _limb(body: _Body, side: str, roles: tuple[str, str, str], trunk: Array, sign: float) -> tuple[Array, Array]:
    """World orientation (T, 4) of a thigh or upper arm that hangs along -z, and the bend (T,) >= 0 of its hinge.

    The hinge's axis, +y in the link, is the normal of the plane of the bend (`sign` 1: the lower part goes backward, as
    at a knee; -1: forward). Where the limb is straight, what the bone remembers of that axis holds.
    """
    top, joint, end = (f"{side}_{role}" for role in roles)
    upper = _unit(body.pos[joint] - body.pos[top])
    lower = _unit(body.pos[end] - body.pos[joint]) if end in body.pos else upper
    normal = sign * np.cross(upper, lower)
    sine = np.linalg.norm(normal, axis=1, keepdims=True)
    untwisted = _swung(rotations.rotate(trunk, np.array([[0.0, 1.0, 0.0]])), rotations.rotate(trunk, -_UP[None]), upper)
    bone = body.quat[top]
    # Mean of the normal in the bone's own frame, weighted by the bend; a limb that never bends is not twisted.
    seen = rotations.rotate(rotations.conjugate(bone), normal * sine + 1e-3 * untwisted)
    remembered = rotations.rotate(bone, np.broadcast_to(_unit(seen.mean(axis=0)), normal.shape))
    axis = normal + _STRAIGHT * remembered
    link = _frame(up=-upper, left=axis, exact="up")
    bend = np.arctan2(sine[:, 0], np.sum(upper * lower, axis=1))
    backward = np.sum(normal * rotations.rotate(link, np.array([[0.0, 1.0, 0.0]])), axis=1) < 0
    return link, np.where(backward, 0.0, bend)


def _foot(body: _Body, side: str, shin: Array) -> Array:
    """World orientation (T, 4) of a foot, level when its sole is flat."""
    ankle, toe = f"{side}_ankle", f"{side}_toe"
    quat = body.quat[ankle]
    if toe in body.pos:
        forward: Array = body.pos[toe] - body.pos[ankle]
    else:
        forward = rotations.rotate(shin, np.array([[1.0, 0.0, 0.0]]))
    forward = rotations.rotate(rotations.conjugate(quat), forward).mean(axis=0)
    if body.natural:
        upward = rotations.rotate(rotations.conjugate(body.rest_quat), _UP)
    else:
        flat = _standing(body.pos[ankle], body.pos.get(toe, body.pos[ankle]))
        upward = rotations.rotate(rotations.conjugate(quat[flat]), _UP).mean(axis=0)
    fixed = _frame(up=upward[None], left=np.cross(upward, forward)[None], exact="up")
    return rotations.multiply(quat, np.broadcast_to(fixed, quat.shape))


def _standing(ankle: Array, toe: Array) -> NDArray[np.bool_]:
    """Frames (T,) in which a foot most likely stands flat: both ends slow, the ankle low."""
    speed = sum(np.linalg.norm(np.gradient(point, axis=0), axis=1) for point in (ankle, toe))
    slow, low = speed <= np.quantile(speed, 0.3), ankle[:, 2] <= np.quantile(ankle[:, 2], 0.5)
    return slow & low if (slow & low).any() else slow


def _leading_t_pose(body: _Body, torso: Array, frame_time: float) -> int:
    """Number of leading frames with both arms straight out to the sides, if they are few and end."""
    posed = np.ones(len(body), bool)
    for side, sign in zip(SIDES, (-1.0, 1.0), strict=True):
        for end in (f"{side}_elbow", f"{side}_wrist"):
            reach = _unit(body.pos.get(end, body.pos[f"{side}_elbow"]) - body.pos[f"{side}_shoulder"])
            posed &= sign * rotations.rotate(rotations.conjugate(torso), reach)[:, 1] > 0.85
    count = len(body) if posed.all() else int(np.argmin(posed))
    return count if count * frame_time <= _T_POSE_SECONDS and count < len(body) else 0


def _swung(vectors: Array, start: Array, end: Array) -> Array:
    """Vectors (T, 3), turned as the shortest turn takes the unit vectors `start` to `end` (T, 3)."""
    axis = np.cross(start, end)
    cosine = np.sum(start * end, axis=1, keepdims=True)
    first = np.cross(axis, vectors)
    return vectors + first + np.cross(axis, first) / np.maximum(1 + cosine, 1e-6)


def _local(parent: Array, child: Array) -> Array:
    return rotations.multiply(rotations.conjugate(parent), child)


def _unit(vectors: Array) -> Array:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)


def _frame(up: Array, left: Array, exact: str) -> Array:
    """Quaternions (T, 4) of frames with z along `up` and y along `left` (T, 3); the `exact` one is kept as it is."""
    forward = _unit(np.cross(left, up))
    z, y = _unit(up), _unit(left)
    if exact == "up":
        y = np.cross(z, forward)
    else:
        z = np.cross(forward, y)
    return _quats(np.stack([forward, y, z], axis=-1))


def _quats(matrices: Array) -> Array:
    return np.roll(Rotation.from_matrix(matrices).as_quat(), 1, axis=-1)
