"""Parametric gaits: the motions that ship, made from footsteps up. A style is a row of `styles.GAITS`."""

from adapt_envs.motion.clip import MotionClip
from adapt_envs.motion.synthesis.base import base_clip
from adapt_envs.motion.synthesis.cycle import cyclic_clip
from adapt_envs.motion.synthesis.gait import Arm, Gait, Kick, Wave
from adapt_envs.motion.synthesis.styles import GAITS

__all__ = ["GAITS", "Arm", "Gait", "Kick", "Wave", "make_clip", "synthesize"]


def synthesize(name: str) -> MotionClip:
    """The motion of a row of the table; always the same one.

    Args:
        name: a key of `GAITS`, in any case, such as `"stoop"`.

    Raises:
        ValueError: if there is no such row.
    """
    if name.lower() not in GAITS:
        raise ValueError(f"no gait {name!r}; the gaits are {', '.join(GAITS)}")
    return make_clip(GAITS[name.lower()])


def make_clip(gait: Gait) -> MotionClip:
    """The motion of any row, also of one that is not in the table: a period of a style, or a base along its path."""
    return cyclic_clip(gait) if gait.frames else base_clip(gait)
