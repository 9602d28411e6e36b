"""Gait cycles at given speeds, cut out of a clip of minutes."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from adapt_envs.motion.clip import MotionClip, MotionError
from adapt_envs.motion.gaits.draft import from_poses
from adapt_envs.motion.gaits.gait_cycle import closed, find_cycle
from adapt_envs.motion.gaits.inverse_kinematics import looped


def gaits_of(clip: MotionClip, speeds: Sequence[float]) -> list[MotionClip]:
    """Cycles of a clip that does not repeat, one at about each speed [m/s], each straight ahead along x.

    Speeds that the clip never goes at are left out, and none is cut out twice.

    Raises:
        MotionError: if it goes at none of them, or repeats.
    """
    return list(_gaits_of(clip, tuple(speeds)))


@lru_cache(maxsize=16)  # each takes inverse kinematics over all its frames, and bodies and grounds share the clip
def _gaits_of(clip: MotionClip, speeds: tuple[float, ...]) -> tuple[MotionClip, ...]:
    if clip.cyclic:
        raise MotionError(f"clip {clip.name!r} is one gait cycle; gaits at several speeds need a motion of minutes")
    draft, found = from_poses(clip.qpos), dict[str, MotionClip]()
    for speed in speeds:
        try:
            cycle = find_cycle(draft, speed)
        except MotionError:
            continue
        origin = f"{clip.name}, frames {cycle.first} to {cycle.first + cycle.period}"
        if origin in found:
            continue
        # What closes a cycle moves its feet: unrepaired ones slid by up to 11 cm/s and stood up to 2 cm off the ground.
        qpos = looped(closed(draft, cycle), clean=True).astype(np.float64)
        name = f"{clip.name} at {speed:.2f} m/s"
        found[origin] = MotionClip(name, qpos, clip.joint_names, cyclic=True, origin=origin)
    if not found:
        at = ", ".join(f"{speed:.2f}" for speed in speeds)
        raise MotionError(f"clip {clip.name!r} holds no gait cycle at {at} m/s")
    return tuple(found.values())
