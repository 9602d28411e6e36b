"""Whether a character goes where its guide goes, as fast as the goal asks, facing as the reference does."""

from dataclasses import dataclass

import torch

from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.world_model.links import HeadingView
from sb3_adaptnet.world_model.pseudo_huber import pseudo_huber

VELOCITY_SCALE = 0.3
"""Error [m/s] from which on the loss grows straight."""


@dataclass(frozen=True)
class TravelWeights:
    """How much the parts of the travel loss count.

    Attributes:
        travel: velocity of the root on the ground.
        facing: its heading.
    """

    travel: float = 0.4
    facing: float = 2.0


def travel_loss(
    velocity: torch.Tensor,
    view: HeadingView,
    motion: TrackedMotion,
    phases: torch.Tensor,
    headings: torch.Tensor,
    speeds: torch.Tensor,
    weights: TravelWeights,
) -> torch.Tensor:
    """Loss (B,) of the root's velocity on the ground and of its heading.

    Args:
        velocity: (3, B) of the root [m/s], world.
        view: for the root's heading.
        motion: the reference; its velocity is scaled to the preferred speed.
        phases: (B,) where the characters should be in it.
        headings: (B,) directions of travel of the guides [rad], world.
        speeds: (B,) preferred [m/s].
        weights: of the parts.
    """
    cos, sin, facing = torch.cos(headings), torch.sin(headings), motion.facing[phases]
    ahead, aside = cos * velocity[0] + sin * velocity[1], cos * velocity[1] - sin * velocity[0]
    wanted = motion.velocity[:, phases] * (speeds / motion.mean_speed)
    square = (ahead - wanted[0]).square() + (aside - wanted[1]).square()
    along, across = view.cos * cos + view.sin * sin, view.sin * cos - view.cos * sin
    turned_away = 1 - (along * torch.cos(facing) + across * torch.sin(facing))
    return weights.travel * pseudo_huber(square, VELOCITY_SCALE) + weights.facing * turned_away
