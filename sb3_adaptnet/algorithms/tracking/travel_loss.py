"""Whether a character goes where its guide goes, as fast as the goal asks, facing as the reference does."""

from dataclasses import dataclass
from typing import NamedTuple

import torch

from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.world_model.links import HeadingView
from sb3_adaptnet.world_model.pseudo_huber import pseudo_huber

VELOCITY_SCALE = 0.3
"""Error [m/s] from which on the loss grows straight."""
GOAL_RADIUS, SHARPNESS = 0.5, 3.0
"""Of the task's reward: within so many metres it is 1; the 3 in its exponent."""
_NO_DIRECTION = 0.01
"""Closer than this [m] there is no direction to the target; the loss is 0 there anyway."""


@dataclass(frozen=True)
class TravelWeights:
    """How much the parts of the travel loss count.

    Attributes:
        travel: velocity of the root on the ground.
        facing: its heading; with half of it, walking on beside the goal was cheaper than turning.
        goal: what the task's reward falls short of 1. The guide turns like a person; this asks for more, wherever the
            character is near enough to what the task wants for it to have a slope.
    """

    travel: float = 0.4
    facing: float = 4.0
    goal: float = 0.0


class TravelErrors(NamedTuple):
    """How a character's travel differs from its guide's, (B,) each.

    Attributes:
        ahead, aside: velocity of the root beyond the wanted one [m/s], along the guide's axes.
        alike: cosine of the angle between its heading and the wanted one.
        turned_left: sine of that angle.
    """

    ahead: torch.Tensor
    aside: torch.Tensor
    alike: torch.Tensor
    turned_left: torch.Tensor


def travel_errors(
    velocity: torch.Tensor,
    view: HeadingView,
    motion: TrackedMotion,
    phases: torch.Tensor,
    headings: torch.Tensor,
    speeds: torch.Tensor,
) -> TravelErrors:
    """Errors of the root's velocity on the ground and of its heading.

    Args:
        velocity: (3, B) of the root [m/s], world.
        view: for the root's heading.
        motion: the reference; its velocity is scaled to the preferred speed.
        phases: (B,) where the characters should be in it.
        headings: (B,) directions of travel of the guides [rad], world.
        speeds: (B,) preferred [m/s].
    """
    cos, sin, facing = torch.cos(headings), torch.sin(headings), motion.facing[phases]
    ahead, aside = cos * velocity[0] + sin * velocity[1], cos * velocity[1] - sin * velocity[0]
    wanted = motion.velocity[:, phases] * (speeds / motion.speeds[phases])
    along, across = view.cos * cos + view.sin * sin, view.sin * cos - view.cos * sin
    cos, sin = torch.cos(facing), torch.sin(facing)
    return TravelErrors(ahead - wanted[0], aside - wanted[1], along * cos + across * sin, across * cos - along * sin)


def travel_loss(errors: TravelErrors, weights: TravelWeights) -> torch.Tensor:
    """Loss (B,) of the root's velocity on the ground and of its heading."""
    square = errors.ahead.square() + errors.aside.square()
    return weights.travel * pseudo_huber(square, VELOCITY_SCALE) + weights.facing * (1 - errors.alike)


def goal_loss(
    position: torch.Tensor, velocity: torch.Tensor, targets: torch.Tensor, speeds: torch.Tensor
) -> torch.Tensor:
    """Loss (B,): 1 less the task's reward (`adapt_envs.tasks.goal_reward`), by velocities in place of displacements.

    Args:
        position: (3, B) of the root [m], world.
        velocity: (3, B) of the root [m/s], world.
        targets: (B, 2) [m], world.
        speeds: (B,) preferred [m/s].
    """
    left = targets.t() - position[:2]
    distance = left.square().sum(0).clamp_min(_NO_DIRECTION**2).sqrt()
    square = (velocity[:2] - left * (speeds / distance)).square().sum(0)
    return torch.where(distance < GOAL_RADIUS, 0.0, 1 - torch.exp(-SHARPNESS * square / speeds.square()))
