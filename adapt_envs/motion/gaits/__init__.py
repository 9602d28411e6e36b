"""Gait cycles cut out of motions: poses in the making, ends that close, feet that are put back."""

from adapt_envs.motion.gaits.draft import Draft, from_poses
from adapt_envs.motion.gaits.gaits_of_clip import gaits_of

__all__ = ["Draft", "from_poses", "gaits_of"]
