"""The table of gaits: one row is one motion."""

from adapt_envs.motion.synthesis.gait import Arm, Gait, Wave

WALK = Gait("Walk", kind="walk")
GAITS = {gait.name.lower(): gait for gait in (WALK,)}
