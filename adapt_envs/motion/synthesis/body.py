"""Poses: pelvis, trunk, head and arms from waves over the gait cycle, legs by inverse kinematics."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.motion.synthesis.feet import FootPath
from adapt_envs.motion.synthesis.gait import Arm, Gait
from adapt_envs.motion.synthesis.legs import HIP, REACH, euler_xyz, leg_angles, rot_x, rot_y, rot_z

Array = NDArray[np.float64]
_KNEE_WITH_FOOT = 0.5
"""How far the knee follows the foot's yaw rather than the pelvis's."""


@dataclass(frozen=True)
class Course:
    """What the body follows over T times.

    Attributes:
        heading: (T,) direction of the body [rad].
        lead: (T,) how far head and trunk look ahead into a turn [rad].
        phase: (T,) of the gait cycle [rad].
        scale: (T,) size of the waves, 1 at a comfortable walk.
        lean: (T, 2) roll (right side down) and pitch (forward) of the trunk from accelerations [rad].
        feet: paths of the right and the left foot.
    """

    heading: Array
    lead: Array
    phase: Array
    scale: Array
    lean: Array
    feet: tuple[FootPath, FootPath]


def poses(gait: Gait, course: Course, root: Array) -> Array:
    """Configurations (T, 35) with the pelvis at `root` (T, 3): root, then joints in the model's order."""
    pelvis = pelvis_frame(gait, course)
    torso, head = _trunk(gait, course), _head(gait, course)
    joints = [
        euler_xyz(np.swapaxes(pelvis, -1, -2) @ torso),
        euler_xyz(np.swapaxes(torso, -1, -2) @ head),
        *(_arm(gait.arms[side], course.phase + np.pi * side, course.scale, side) for side in (0, 1)),
        *(_leg(gait, course, pelvis, root, side) for side in (0, 1)),
    ]
    return np.concatenate([root, _quaternion(pelvis), *joints], axis=1)


def pelvis_frame(gait: Gait, course: Course) -> Array:
    """Orientation of the pelvis (T, 3, 3)."""
    phase, scale = course.phase, course.scale
    yaw = course.heading + gait.pelvis_yaw(phase, scale)
    roll = gait.pelvis_list(phase, scale) + course.lean[:, 0]
    return rot_z(yaw) @ rot_y(gait.pelvis_tilt(phase, scale) + 0.3 * course.lean[:, 1]) @ rot_x(roll)


def hips(pelvis: Array, root: Array) -> tuple[Array, Array]:
    """Positions (T, 3) of the right and the left hip."""
    return root - HIP * pelvis[..., 1], root + HIP * pelvis[..., 1]


def _trunk(gait: Gait, course: Course) -> Array:
    phase, scale = course.phase, course.scale
    yaw = course.heading + 0.35 * course.lead + gait.torso_yaw(phase, scale)
    pitch = gait.torso_pitch(phase, scale) + course.lean[:, 1]
    return rot_z(yaw) @ rot_y(pitch) @ rot_x(gait.torso_roll(phase, scale) + course.lean[:, 0])


def _head(gait: Gait, course: Course) -> Array:
    phase, scale = course.phase, course.scale
    yaw = course.heading + course.lead + gait.head_yaw(phase, scale)
    pitch = gait.head_pitch(phase, scale) + 0.3 * course.lean[:, 1]
    return rot_z(yaw) @ rot_y(pitch) @ rot_x(gait.head_roll(phase, scale) + 0.3 * course.lean[:, 0])


def _arm(arm: Arm, phase: Array, scale: Array, side: int) -> Array:
    """Shoulder x, y, z and elbow (T, 4); a left arm is a right arm in the mirror."""
    mirror = 1 - 2 * side
    flexion, outward, twist = arm.flexion(phase, scale), arm.outward(phase, scale), arm.twist(phase, scale)
    return np.stack([-mirror * outward, -flexion, mirror * twist, -arm.elbow(phase, scale)], axis=1)


def _leg(gait: Gait, course: Course, pelvis: Array, root: Array, side: int) -> Array:
    foot = course.feet[side]
    facing = np.arctan2(pelvis[:, 1, 0], pelvis[:, 0, 0])
    twist = rotations.wrapped(foot.yaw - facing)
    knee = facing + _KNEE_WITH_FOOT * twist + np.radians(gait.knee_out) * (2 * side - 1)
    hip = hips(pelvis, root)[side]
    span = foot.ankle - hip
    distance = np.linalg.norm(span, axis=1)
    longer = 1 + foot.stretch * np.maximum(0.99 * REACH / distance - 1, 0)
    return leg_angles(pelvis, hip, hip + span * longer[:, None], rot_z(foot.yaw) @ rot_y(foot.pitch), knee)


def _quaternion(matrix: Array) -> Array:
    """Quaternions (T, 4) of rotations whose trace is not near -1 about a level axis: upright bodies; w may be small."""
    yaw = np.arctan2(matrix[:, 1, 0], matrix[:, 0, 0])
    pitch = np.arcsin(np.clip(-matrix[:, 2, 0], -1, 1))
    roll = np.arctan2(matrix[:, 2, 1], matrix[:, 2, 2])
    cy, sy, cp, sp, cr, sr = (f(a / 2) for a in (yaw, pitch, roll) for f in (np.cos, np.sin))
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=1,
    )
