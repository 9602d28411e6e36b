"""Foreign skeletons onto the character: directions of bones become joint angles, ankles become foot targets.

What is copied are the places of the joints relative to each other, not the file's angles: so it does not matter how a
skeleton's joints are turned at rest. Its rotations serve for what places cannot tell: the twist of straight limbs, the
head, the roll of the feet. Sizes follow from the length of the legs, so a file's unit does not matter either.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from adapt_envs.features import rotations
from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import joint_names
from adapt_envs.motion.clip import MotionError
from adapt_envs.motion.gaits.draft import Array, Draft, angles_within, joint_columns
from adapt_envs.motion.importing.bvh import Bvh
from adapt_envs.motion.importing.directions import frame, local, swung, unit
from adapt_envs.motion.importing.foreign_body import ForeignBody, foreign_body
from adapt_envs.motion.importing.skeletons import SIDES, JointMap

_UP = np.array([0.0, 0.0, 1.0])
_STRAIGHT = 0.15
"""Sine of the bend below which a limb's own twist outweighs the plane of its bend."""
_T_POSE_SECONDS = 2.0


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
    body = foreign_body(bvh, joints, path)
    try:
        draft, torso = _fitted(body)
    except ValueError:  # a frame without directions: places that coincide
        raise MotionError(f"{path}: line 1: joints of the trunk or limbs coincide; is the joint map right?") from None
    drop = _leading_t_pose(body, torso, bvh.frame_time) if joints.drop is None else joints.drop
    return draft.rows(slice(drop, None))


def _fitted(body: ForeignBody) -> tuple[Draft, Array]:
    """The draft, and the torso's world orientation (T, 4)."""
    pelvis, torso = _trunk(body)
    quats = {"pelvis": pelvis, "abdomen": local(pelvis, torso), "neck": local(torso, _head(body, pelvis))}
    qpos = np.zeros((len(body), 7 + len(joint_names())))
    qpos[:, :3] = (body.pos["right_hip"] + body.pos["left_hip"]) / 2
    qpos[:, 3:7] = pelvis
    feet = []
    for side in SIDES:
        upper, bend = _limb(body, side, ("shoulder", "elbow", "wrist"), torso, -1.0)
        quats[f"{side}_shoulder"] = local(torso, upper)
        qpos[:, joint_columns(f"{side}_elbow")] = -bend[:, None]
        thigh, bend = _limb(body, side, ("hip", "knee", "ankle"), pelvis, 1.0)
        quats[f"{side}_hip"] = local(pelvis, thigh)
        qpos[:, joint_columns(f"{side}_knee")] = bend[:, None]
        shin = rotations.multiply(thigh, rotations.from_axis_angle(np.tile([0.0, 1, 0], (len(bend), 1)), bend))
        feet.append(_foot(body, side, shin))
        quats[f"{side}_ankle"] = local(shin, feet[-1])
    for joint, quat in quats.items():
        if joint != "pelvis":
            qpos[:, joint_columns(joint)] = angles_within(quat, joint)
    ankles = np.stack([body.pos[f"{side}_ankle"] for side in SIDES], axis=1)
    return Draft(qpos, ankles, np.stack(feet, axis=1)), torso


def _trunk(body: ForeignBody) -> tuple[Array, Array]:
    """World orientations (T, 4) of pelvis and torso: lines from hips to waist to neck, the sides' left and right."""
    model = plain_model()
    lower, upper = model.body("torso").pos[2], model.body("head").pos[2]
    waist = _along(body.spine, lower / (lower + upper))
    pelvis_up, torso_up = waist - body.spine[:, 0], body.spine[:, -1] - waist
    pelvis = frame(up=pelvis_up, left=body.pos["left_hip"] - body.pos["right_hip"], exact="left")
    torso = frame(up=torso_up, left=body.pos["left_shoulder"] - body.pos["right_shoulder"], exact="up")
    return pelvis, torso


def _along(points: Array, share: float) -> Array:
    """Points (T, 3) at a share of the length of the lines through `points` (T, K, 3)."""
    steps = np.linalg.norm(np.diff(points, axis=1), axis=-1).mean(axis=0)
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = share * lengths[-1]
    after = int(np.clip(np.searchsorted(lengths, wanted), 1, len(lengths) - 1))
    weight = (wanted - lengths[after - 1]) / max(steps[after - 1], 1e-12)
    return points[:, after - 1] * (1 - weight) + points[:, after] * weight


def _head(body: ForeignBody, pelvis: Array) -> Array:
    """World orientation (T, 4) of the head.

    How the joint sits in the head comes from the rest pose; if that is no stand, the head is level on average.
    """
    role = next((name for name in ("head", "neck") if name in body.quat), None)
    if role is None:
        return _facing(pelvis)
    quat = body.quat[role]
    if body.natural:
        ahead = frame(up=_UP[None], left=(body.rest["left_hip"] - body.rest["right_hip"])[None], exact="up")
        fixed = rotations.multiply(rotations.conjugate(body.rest_quat[None]), ahead)
    else:
        offsets = rotations.multiply(rotations.conjugate(quat), _facing(pelvis))
        fixed = np.roll(Rotation.from_quat(np.roll(offsets, -1, axis=1)).mean().as_quat(), 1)[None]
    return rotations.multiply(quat, np.broadcast_to(fixed, quat.shape))


def _facing(quat: Array) -> Array:
    return rotations.from_yaw(rotations.heading(quat))


def _limb(body: ForeignBody, side: str, roles: tuple[str, str, str], trunk: Array, sign: float) -> tuple[Array, Array]:
    """World orientation (T, 4) of a thigh or upper arm that hangs along -z, and the bend (T,) of its hinge.

    The hinge's axis, +y in the link, is the normal of the plane of the bend (`sign` 1: the lower part goes backward, as
    at a knee; -1: forward). Where the limb is straight, what the bone remembers of that axis holds; a bend the other
    way, of a knee that gives way backward, is negative.
    """
    top, joint, end = (f"{side}_{role}" for role in roles)
    upper = unit(body.pos[joint] - body.pos[top])
    lower = unit(body.pos[end] - body.pos[joint]) if end in body.pos else upper
    normal = sign * np.cross(upper, lower)
    sine = np.linalg.norm(normal, axis=1, keepdims=True)
    untwisted = swung(rotations.rotate(trunk, np.array([[0.0, 1.0, 0.0]])), rotations.rotate(trunk, -_UP[None]), upper)
    bone = body.quat[top]
    # Mean of the normal in the bone's own frame, weighted by the bend; a limb that never bends is not twisted.
    seen = rotations.rotate(rotations.conjugate(bone), normal * sine + 1e-3 * untwisted)
    remembered = rotations.rotate(bone, np.broadcast_to(unit(seen.mean(axis=0)), normal.shape))
    axis = normal + _STRAIGHT * remembered
    link = frame(up=-upper, left=axis, exact="up")
    bend = np.arctan2(sine[:, 0], np.sum(upper * lower, axis=1))
    backward = np.sum(normal * rotations.rotate(link, np.array([[0.0, 1.0, 0.0]])), axis=1) < 0
    return link, np.where(backward, -bend, bend)


def _foot(body: ForeignBody, side: str, shin: Array) -> Array:
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
    fixed = frame(up=upward[None], left=np.cross(upward, forward)[None], exact="up")
    return rotations.multiply(quat, np.broadcast_to(fixed, quat.shape))


def _standing(ankle: Array, toe: Array) -> NDArray[np.bool_]:
    """Frames (T,) in which a foot most likely stands flat: both ends slow, the ankle low."""
    speed = sum(np.linalg.norm(np.gradient(point, axis=0), axis=1) for point in (ankle, toe))
    slow, low = speed <= np.quantile(speed, 0.3), ankle[:, 2] <= np.quantile(ankle[:, 2], 0.5)
    return slow & low if (slow & low).any() else slow


def _leading_t_pose(body: ForeignBody, torso: Array, frame_time: float) -> int:
    """Number of leading frames with both arms straight out to the sides, if they are few and end."""
    posed = np.ones(len(body), bool)
    for side, sign in zip(SIDES, (-1.0, 1.0), strict=True):
        for end in (f"{side}_elbow", f"{side}_wrist"):
            reach = unit(body.pos.get(end, body.pos[f"{side}_elbow"]) - body.pos[f"{side}_shoulder"])
            posed &= sign * rotations.rotate(rotations.conjugate(torso), reach)[:, 1] > 0.85
    count = len(body) if posed.all() else int(np.argmin(posed))
    return count if count * frame_time <= _T_POSE_SECONDS and count < len(body) else 0
