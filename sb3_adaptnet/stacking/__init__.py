"""Adaptations at once: what each changes of its base's world, pairs of them, and worlds to learn beside others in."""

from sb3_adaptnet.stacking.joined_worlds import JoinedWorlds, worlds_with_companions
from sb3_adaptnet.stacking.parts import Pair, Part, pairs_of, part_of

__all__ = ["JoinedWorlds", "Pair", "Part", "pairs_of", "part_of", "worlds_with_companions"]
