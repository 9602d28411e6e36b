"""The worlds: batched physics, start states, and one step over arrays."""

from adapt_envs.simulation.physics import PhysicsBatch
from adapt_envs.simulation.worlds import Worlds

__all__ = ["PhysicsBatch", "Worlds"]
