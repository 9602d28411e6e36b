"""Base motions: minutes of walking or running along a path."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from adapt_envs.motion.clip import FPS, MotionClip
from adapt_envs.motion.dynamics import GRAVITY
from adapt_envs.motion.synthesis.assemble import DT, OVERSAMPLING, body_motion, both_feet, gait_phase, to_clip
from adapt_envs.motion.synthesis.body import Course
from adapt_envs.motion.synthesis.feet import FootPath
from adapt_envs.motion.synthesis.footsteps import path_steps
from adapt_envs.motion.synthesis.gait import Gait
from adapt_envs.motion.synthesis.path import Command, Path, follow, running_commands, walking_commands

Array = NDArray[np.float64]
WALK_SECONDS, RUN_SECONDS = 336.0, 285.0
"""Durations of the bases [s]; the paper's are 334.07 and 282.87 (Table 1)."""
_MARGIN = 1.5
"""Seconds cut off at either end, where the balance is not settled."""


def along_path(gait: Gait, commands: list[Command], seconds: float, seed: int, sideways: float) -> MotionClip:
    """A motion of at least `seconds` along a path.

    Args:
        gait: how to move.
        commands: the path, at least 4 s longer.
        seconds: duration.
        seed: of the variation from step to step.
        sideways: largest sideways acceleration [m/s^2].
    """
    walking = gait.double > 0
    path = follow(commands, DT, sideways, ease=0.2 if walking else 0.46)
    steps = path_steps(gait, path, seed, walking)
    t = path.t[path.t < min(steps.on[-2], seconds + 2 * _MARGIN + 0.1)]
    course = _course(path, t, both_feet(gait, steps, t), gait_phase(steps, t), walking)
    qpos = body_motion(gait, steps, course, t)
    first = round(_MARGIN * FPS) * OVERSAMPLING
    qpos = qpos[first : first + (round(seconds * FPS) + 1) * OVERSAMPLING]
    qpos[:, :2] -= qpos[0, :2]
    return to_clip(gait.name, qpos, cyclic=False)


def _course(path: Path, t: Array, feet: tuple[FootPath, FootPath], phase: Array, walking: bool) -> Course:
    """What the body follows at times t (T,): it looks and leans into turns, and swings its limbs with its speed."""
    n = len(t)
    heading = path.heading[:n]
    look = np.clip(path.at(path.heading, t + 0.3) - heading, -0.7, 0.7)
    ahead = np.column_stack([np.cos(heading), np.sin(heading)])
    forward = (path.acc[:n] * ahead).sum(axis=1) / GRAVITY
    left = (path.acc[:n, 1] * ahead[:, 0] - path.acc[:n, 0] * ahead[:, 1]) / GRAVITY
    lean = np.column_stack([-(0.75 if walking else 0.9) * np.arctan(left), 0.35 * np.arctan(forward)])
    speed = path.speed[:n]
    scale = 1.27 * speed / (speed + 0.35) if walking else 0.55 + 0.45 * speed / 2.5
    smooth = [gaussian_filter1d(x, 0.1 / DT, axis=0, mode="nearest") for x in (look, scale, lean)]
    return Course(heading, smooth[0], phase, smooth[1], smooth[2], feet)


def base_clip(gait: Gait) -> MotionClip:
    """The base motion of a row without a period: walking or running along its own random path."""
    if gait.kind == "run":
        return along_path(gait, running_commands(RUN_SECONDS + 6, seed=11), RUN_SECONDS, seed=12, sideways=2.9)
    return along_path(gait, walking_commands(WALK_SECONDS + 6, seed=3), WALK_SECONDS, seed=5, sideways=2.4)
