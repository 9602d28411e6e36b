"""Styles: one or two gait cycles straight ahead that repeat."""

import math

import numpy as np

from adapt_envs.motion.clip import FPS, MotionClip
from adapt_envs.motion.synthesis.assemble import DT, OVERSAMPLING, body_motion, both_feet, gait_phase, to_clip
from adapt_envs.motion.synthesis.body import Course
from adapt_envs.motion.synthesis.footsteps import cyclic_steps, skipping_steps
from adapt_envs.motion.synthesis.gait import Gait

_MARGIN = 4.0
"""Seconds of the same gait on either side of the period that is kept: the balance forgets its ends in a second."""


def cyclic_clip(gait: Gait) -> MotionClip:
    """The style as a clip of one period that starts at the origin and heads along x."""
    period = gait.frames / FPS
    around = math.ceil(_MARGIN / period)
    steps = (skipping_steps if gait.hop else cyclic_steps)(gait, 2 * around + 1)
    n = gait.frames * OVERSAMPLING
    t = np.asarray(np.arange((2 * around + 1) * n + 1) * DT, dtype=np.float64)
    level = np.zeros(len(t))
    course = Course(
        level, level, gait_phase(steps, t), np.ones(len(t)), np.zeros((len(t), 2)), both_feet(gait, steps, t)
    )
    qpos = body_motion(gait, steps, course, t)[around * n : (around + 1) * n + 1]
    distance = sum(gait.length) * gait.cycles
    qpos[-1] = qpos[0]
    qpos[-1, 0] += distance
    qpos[:, 0] -= qpos[0, 0]
    return to_clip(gait.name, qpos, cyclic=True)
