"""Motions from elsewhere: BVH and JSON files become clips of the character."""

from adapt_envs.motion.importing.pipeline import SUFFIXES, import_motion

__all__ = ["SUFFIXES", "import_motion"]
