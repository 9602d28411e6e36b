"""Inverse kinematics: the configuration within the joint limits that best follows a draft and its foot targets."""

from dataclasses import replace

import mink
import numpy as np
from scipy.ndimage import gaussian_filter1d

from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import FEET, joint_names
from adapt_envs.motion.gaits.draft import Array, Draft
from adapt_envs.motion.gaits.gait_cycle import repeated
from adapt_envs.motion.gaits.planted_feet import planted
from adapt_envs.progress import Progress

_STEPS = 3
"""Quadratic programs solved per frame; each frame starts from the one before."""
_FOOT_COST, _FOOT_TURN_COST = 20.0, 2.0
_ROOT_COSTS = ((2.0, 2.0), (20.0, 2.0))
_POSTURE_COST, _LEG_COST = 0.7, 0.05
"""Weights of metres and radians: feet first, then the root, then the pose; the legs give way.

The root has one pair of weights for each of two passes: in the first the root goes where the legs' reach and limits
push it; the second holds it to a smoothed version of that, since a root that jerks has impossible forces.
"""
_ROOT_SMOOTHING = 3.0
"""Standard deviation [frames] of that smoothing."""
_MARGIN = 0.01
"""Distance from the joint limits [rad]: single precision and interpolation must not cross them."""
_LEG = ("hip", "knee", "ankle")


def settled(draft: Draft, progress: Progress = iter) -> Array:
    """Solve every frame of a draft.

    Args:
        draft: what to follow.
        progress: wraps the frame numbers, for a progress bar.

    Returns:
        (T, 7 + J) configurations within the joint limits.
    """
    low, high = _limits()
    wanted = draft.qpos.copy()
    wanted[:, 7:] = np.clip(wanted[:, 7:], low, high)
    first = _solved(replace(draft, qpos=wanted), _ROOT_COSTS[0], progress)
    wanted[:, :3] += gaussian_filter1d(first[:, :3] - wanted[:, :3], _ROOT_SMOOTHING, axis=0, mode="nearest")
    return _solved(replace(draft, qpos=wanted), _ROOT_COSTS[1], progress)


def looped(cycle: Draft, progress: Progress = iter, clean: bool = False) -> Array:
    """Solve a closed cycle amid its own repetitions, its feet planted, and keep the middle one.

    Args:
        cycle: a cycle of T frames, the last of which is like the first.
        progress: wraps the frame numbers, for a progress bar.
        clean: of `planted`.

    Returns:
        (T, 7 + J) configurations, starting above the origin.
    """
    period = len(cycle) - 1
    qpos = settled(planted(repeated(cycle, 3), clean), progress)[period : 2 * period + 1]
    qpos[:, :2] -= qpos[0, :2]
    step = cycle.qpos[-1, :2] - cycle.qpos[0, :2]
    qpos[-1] = np.concatenate([qpos[0, :2] + step, qpos[0, 2:]])
    return qpos


def _solved(draft: Draft, root_costs: tuple[float, float], progress: Progress) -> Array:
    model = plain_model()
    low, high = _limits()
    limits = [mink.ConfigurationLimit(model, min_distance_from_limits=_MARGIN)]
    feet = [mink.FrameTask(name, "body", _FOOT_COST, _FOOT_TURN_COST) for name in FEET]
    root = mink.FrameTask("pelvis", "body", *root_costs)
    costs = [0.0] * 6 + [_LEG_COST if any(part in name for part in _LEG) else _POSTURE_COST for name in joint_names()]
    posture = mink.PostureTask(model, cost=np.array(costs))
    configuration = mink.Configuration(model)
    out = np.empty_like(draft.qpos)
    start = draft.qpos[0]
    for frame in progress(range(len(draft))):
        wanted = draft.qpos[frame]
        posture.set_target(wanted)
        root.set_target(_pose(wanted[3:7], wanted[:3]))
        for task, quat, pos in zip(feet, draft.foot_quat[frame], draft.foot_pos[frame], strict=True):
            task.set_target(_pose(quat, pos))
        configuration.update(start)
        for _ in range(_STEPS):
            velocity = mink.solve_ik(configuration, [*feet, root, posture], 1.0, "daqp", damping=1e-3, limits=limits)
            configuration.integrate_inplace(velocity, 1.0)
        out[frame] = configuration.q
        # The next frame starts where this one ended, moved on as the draft moves on.
        following = draft.qpos[min(frame + 1, len(draft) - 1)]
        start = out[frame].copy()
        start[:3] += following[:3] - wanted[:3]
        start[7:] = np.clip(start[7:] + following[7:] - wanted[7:], low, high)
    return out


def _limits() -> tuple[Array, Array]:
    low, high = plain_model().jnt_range[1:].T
    return low + _MARGIN, high - _MARGIN


def _pose(quat: Array, pos: Array) -> mink.SE3:
    return mink.SE3(np.concatenate([quat, pos]))
