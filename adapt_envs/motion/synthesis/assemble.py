"""From a row of the table to a clip: footsteps, balance and poses, passed over a few times until they agree."""

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import joint_names
from adapt_envs.motion.clip import FPS, MotionClip
from adapt_envs.motion.dynamics import GRAVITY, momentum
from adapt_envs.motion.synthesis.balance import centre_of_mass, height_plan, zmp_plan
from adapt_envs.motion.synthesis.body import Course, hips, pelvis_frame, poses
from adapt_envs.motion.synthesis.feet import FootPath, Footsteps, foot_path
from adapt_envs.motion.synthesis.gait import Gait
from adapt_envs.motion.synthesis.legs import REACH

Array = NDArray[np.float64]
OVERSAMPLING = 2
"""Samples per frame while a motion is made."""
DT = 1 / (FPS * OVERSAMPLING)
ORIGIN = "synthesised by adapt_envs.motion.synthesis"
_PASSES, _LOWERING_PASSES = 6, 3


def gait_phase(steps: Footsteps, t: Array) -> Array:
    """Phase of the gait cycle (T,) [rad]: a smooth curve through the contacts'."""
    phase = PchipInterpolator(steps.on, steps.phase, extrapolate=True)(t)
    return gaussian_filter1d(phase, 0.05 / DT, mode="nearest")


def body_motion(gait: Gait, steps: Footsteps, course: Course, t: Array) -> Array:
    """Configurations (T, 35) every `DT`: the pelvis goes where the centre of mass can be carried.

    Each pass measures the centre of mass and the angular momentum of the motion so far, and moves the pelvis so that
    the zero-moment point of the next one comes nearer to its plan.
    """
    model = plain_model()
    plan, height = zmp_plan(gait, steps, t), height_plan(gait, steps, t)
    pelvis = pelvis_frame(gait, course)
    root = np.column_stack([centre_of_mass(plan, height, DT), height])
    above = 0.0
    target = plan
    for turn in range(_PASSES):
        motion = momentum(model, poses(gait, course, root), DT)
        com = _padded(motion.com)
        if turn == 0:
            above = float(np.mean(com[:, 2] - root[:, 2]))
        drop = _out_of_reach(course, pelvis, root)
        if turn < _LOWERING_PASSES:
            height = height - drop
        correction = _spin_shift(motion.spin_rate, motion.mass, _padded(motion.force))
        target = plan + correction
        wanted = np.column_stack([centre_of_mass(target, height + above, DT), height + above])
        root = root + 1.15 * (wanted - com)
    return within_limits(model, poses(gait, course, root))


def within_limits(model: mujoco.MjModel, qpos: Array, margin: float = 0.09) -> Array:
    """Configurations whose joints bend to their limits over the last `margin` [rad] instead of passing them."""
    low, high = model.jnt_range[1:, 0], model.jnt_range[1:, 1] - 1e-3
    joints, edge = qpos[:, 7:], margin * (np.ptp(model.jnt_range[1:], axis=1) < 2.0)
    joints = np.where(joints > high - edge, high - edge + _saturate(joints - high + edge, edge), joints)
    low = low + 1e-3
    joints = np.where(joints < low + edge, low + edge - _saturate(low + edge - joints, edge), joints)
    return np.concatenate([qpos[:, :7], joints], axis=1)


def _saturate(excess: Array, edge: Array) -> Array:
    return edge * np.tanh(excess / np.maximum(edge, 1e-9))


def _padded(values: Array) -> Array:
    return np.concatenate([values[:1], values[:1], values, values[-1:], values[-1:]])


def _spin_shift(spin_rate: Array, mass: float, force: Array) -> Array:
    """How far the limbs' angular momentum moves the zero-moment point (T, 2) [m], smoothed."""
    spin = _padded(spin_rate)
    weight = np.clip((force - 0.15) / 0.3, 0, 1)
    shift = np.stack([spin[:, 1], -spin[:, 0]], axis=1) / (mass * GRAVITY * np.maximum(force, 0.4))[:, None]
    return gaussian_filter1d(np.clip(shift, -0.25, 0.25) * weight[:, None], 0.02 / DT, axis=0, mode="nearest")


def _out_of_reach(course: Course, pelvis: Array, root: Array) -> Array:
    """By how much the pelvis must come down (T,) [m] for both legs to reach their feet, widened and smoothed."""
    excess = np.zeros(len(root))
    for hip, foot in zip(hips(pelvis, root), course.feet, strict=True):
        ankle = foot.ankle
        level = np.sum((hip[:, :2] - ankle[:, :2]) ** 2, axis=1)
        highest = ankle[:, 2] + np.sqrt(np.maximum((REACH - 0.003) ** 2 - level, 0.25))
        near = ankle[:, 2] < 0.17
        excess = np.maximum(excess, np.where(near, hip[:, 2] - highest, 0))
    window = int(0.3 / DT)
    return gaussian_filter1d(maximum_filter1d(excess, window), window / 3, mode="nearest")


def to_clip(name: str, qpos: Array, cyclic: bool) -> MotionClip:
    """The clip of configurations every `DT`, from the first sample on."""
    return MotionClip(name, qpos[::OVERSAMPLING], joint_names(), cyclic, ORIGIN)


def both_feet(gait: Gait, steps: Footsteps, t: Array) -> tuple[FootPath, FootPath]:
    """Trajectories of the right and the left foot at times t (T,)."""
    return foot_path(gait, steps, 0, t), foot_path(gait, steps, 1, t)
