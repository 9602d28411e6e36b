"""Sliding feet and jerk of rollouts, measured as for clips."""

import numpy as np
from numpy.typing import NDArray

from adapt_envs import AdaptVectorEnv
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import compile_model
from adapt_envs.motion.clip import FPS, MotionClip
from adapt_envs.motion.quality import foot_corners, slip_speeds
from sb3_adaptnet.evaluation.recording import Recording

_DIFFERENCES = 3
"""Jerk is the third derivative of position."""


def mean_jerk(positions: NDArray[np.floating]) -> float:
    """Mean length [m/s^3] of the third differences at 30 Hz of positions (T, L, 3); NaN for fewer than 4 frames."""
    if len(positions) <= _DIFFERENCES:
        return float("nan")
    third = np.diff(positions.astype(np.float64), n=_DIFFERENCES, axis=0)
    return float(np.linalg.norm(third, axis=-1).mean() * FPS**_DIFFERENCES)


def clip_jerk(clip: MotionClip) -> float:
    """Mean jerk [m/s^3] of a clip's links in the world; a clip that repeats is taken across its seam."""
    extra = _DIFFERENCES if clip.cyclic else 0
    qpos = clip.at(np.arange(clip.period + extra))
    return mean_jerk(Kinematics(compile_model()).link_states(qpos)[..., :3])


def jerk_ratio(recording: Recording, clip: MotionClip) -> float | None:
    """Mean jerk of a recording's links over the clip's; None if no stretch has four frames."""
    total, frames = 0.0, 0
    for world, start, stop in recording.segments():
        count = stop - start - _DIFFERENCES
        if count > 0:
            total += count * mean_jerk(recording.links[start:stop, world, :, :3])
            frames += count
    return total / frames / clip_jerk(clip) if frames else None


def slips(recording: Recording, env: AdaptVectorEnv) -> NDArray[np.float64]:
    """Sliding speeds [cm/s] of the feet's lowest corners while near the ground, over all worlds and frames of `env`."""
    parts = []
    for world, start, stop in recording.segments():
        if stop - start > 1:
            corners = foot_corners(env.worlds.model, recording.qpos[start:stop, world])
            corners[..., 2] -= env.worlds.ground.floor_at(corners[..., :2])
            parts.append(slip_speeds(corners))
    return np.concatenate(parts) if parts else np.zeros(0)
