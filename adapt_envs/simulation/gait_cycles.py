"""The gait cycles of a reference motion: the motion itself if it repeats, else cut out of it at several speeds."""

import math
from collections.abc import Sequence

import numpy as np

from adapt_envs.motion.clip import MotionError
from adapt_envs.motion.gaits.gaits_of_clip import gaits_of
from adapt_envs.motion.library import ReferenceMotion
from adapt_envs.suite import STANDING
from adapt_envs.tasks.tracking import GaitCycle

SPEED_STEP = 1.2
"""About how many times as fast each cycle is as the one before it."""


def gaits_at(reference: ReferenceMotion, speeds: Sequence[float]) -> list[ReferenceMotion]:
    """Gait cycles of a motion of minutes, one at about each speed [m/s] that it has.

    Raises:
        MotionError: if it holds no cycle at any of them, or repeats itself.
    """
    return [reference.of(cycle) for cycle in gaits_of(reference.clips[0], speeds)]


def gait_cycles(reference: ReferenceMotion, speed_range: tuple[float, float]) -> list[GaitCycle]:
    """What `GaitClocks` follow where preferred speeds are within a range [m/s].

    Raises:
        MotionError: if the motion holds no gait.
    """
    clip = reference.clips[0]
    if not clip.cyclic:
        slow, fast = speed_range
        count = 1 + math.ceil(math.log(fast / slow) / math.log(SPEED_STEP))
        gaits = gaits_at(reference, np.geomspace(slow, fast, count).tolist())
    elif reference.speed < STANDING:
        raise MotionError(f"clip {clip.name!r} holds no gait cycle: it stands still")
    else:
        gaits = [reference]
    return [GaitCycle(gait.poses[..., :3], gait.speed) for gait in gaits]
