"""Motions for elsewhere: the character's skeleton with its motion as BVH and glTF files."""

from adapt_envs.motion.exporting.bvh import write_bvh
from adapt_envs.motion.exporting.glb import write_glb
from adapt_envs.motion.exporting.performance import Performance, perform

__all__ = ["Performance", "perform", "write_bvh", "write_glb"]
