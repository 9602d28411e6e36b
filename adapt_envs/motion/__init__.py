"""Reference motions: clips, those that ship, what environments take from them, and how possible they are."""

from adapt_envs.motion.clip import FPS, MotionClip, MotionError
from adapt_envs.motion.library import BASES, CLIPS, STYLES, ReferenceMotion, load_clip, reference_motion
from adapt_envs.motion.quality import THRESHOLDS, Quality, Thresholds, check

__all__ = [
    "BASES",
    "CLIPS",
    "FPS",
    "STYLES",
    "THRESHOLDS",
    "MotionClip",
    "MotionError",
    "Quality",
    "ReferenceMotion",
    "Thresholds",
    "check",
    "load_clip",
    "reference_motion",
]
