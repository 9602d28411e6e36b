"""The loss of a window: tracking, travel and smooth actions; the penalties of eq. 12 are the actor's own."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import torch

from sb3_adaptnet.algorithms.imagination import Imagined
from sb3_adaptnet.algorithms.losses.smoothness import smoothness_loss
from sb3_adaptnet.algorithms.losses.tracking import TrackingWeights, tracking_loss
from sb3_adaptnet.algorithms.losses.travel import TravelWeights, travel_loss
from sb3_adaptnet.algorithms.tracked_motion import TrackedMotion


@dataclass(frozen=True)
class LossWeights:
    """How much the parts of the loss count.

    Attributes:
        tracking: of poses and velocities.
        travel: of where the character goes.
        smoothness: of changes of the actions.
    """

    tracking: TrackingWeights = field(default_factory=TrackingWeights)
    travel: TravelWeights = field(default_factory=TravelWeights)
    smoothness: float = 0.02


def window_loss(
    steps: Iterable[Imagined], motion: TrackedMotion, weights: LossWeights
) -> tuple[torch.Tensor, dict[str, float]]:
    """Mean loss () over the steps of a window and its worlds, and the means of its parts; ended episodes count 0."""
    parts: dict[str, list[torch.Tensor]] = {"tracking": [], "travel": [], "smoothness": []}
    before: torch.Tensor | None = None
    links = motion.links.shape[1]
    for step in steps:
        guided = step.guided
        costs = {
            "tracking": tracking_loss(
                step.state, step.view.latest(links), motion, guided.phases, guided.turn_rates, weights.tracking
            ),
            "travel": travel_loss(
                step.state.velocity,
                step.view,
                motion,
                guided.phases,
                guided.headings,
                guided.speeds,
                weights.travel,
            ),
            "smoothness": weights.smoothness * smoothness_loss(step.actions, before),
        }
        before = step.actions
        for name, cost in costs.items():
            parts[name].append((cost * guided.weights).mean())
    means = {name: torch.stack(values).mean() for name, values in parts.items()}
    return torch.stack(list(means.values())).sum(), {name: float(mean.detach()) for name, mean in means.items()}
