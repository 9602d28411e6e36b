"""The worlds as files, for programs that are not Python: models, start states, and what an observation is made of."""

from adapt_envs.portable.choices import BODIES, GROUNDS, LOCKS, Choice
from adapt_envs.portable.grounds import SiteGround, site_ground
from adapt_envs.portable.scene import portable_scene
from adapt_envs.portable.specification import observation_specification

__all__ = [
    "BODIES",
    "GROUNDS",
    "LOCKS",
    "Choice",
    "SiteGround",
    "observation_specification",
    "portable_scene",
    "site_ground",
]
