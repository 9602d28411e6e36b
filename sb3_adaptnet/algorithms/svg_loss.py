"""The loss of a window: tracking, travel and smooth actions; the penalties of eq. 12 are the actor's own."""

from collections.abc import Iterable

import torch

from sb3_adaptnet.algorithms.imagination import Imagined
from sb3_adaptnet.algorithms.svg_settings import LossWeights
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.algorithms.tracking.tracking_loss import tracking_loss
from sb3_adaptnet.algorithms.tracking.travel_loss import travel_loss


def window_loss(
    steps: Iterable[Imagined], motion: TrackedMotion, weights: LossWeights
) -> tuple[torch.Tensor, dict[str, float]]:
    """Mean loss () over the steps of a window and its worlds, and the means of its parts; ended episodes count 0."""
    parts: dict[str, list[torch.Tensor]] = {"tracking": [], "travel": [], "smoothness": []}
    before: torch.Tensor | None = None
    for step in steps:
        state, view, guided = step.state, step.view, step.guided
        links = view.latest(motion.links.shape[1])
        costs = {
            "tracking": tracking_loss(state, links, motion, guided.phases, guided.turn_rates, weights),
            "travel": travel_loss(state.velocity, view, motion, guided.phases, guided.headings, guided.speeds, weights),
            "smoothness": weights.smoothness * smoothness_loss(step.actions, before),
        }
        before = step.actions
        for name, cost in costs.items():
            parts[name].append((cost * guided.weights).mean())
    means = {name: torch.stack(values).mean() for name, values in parts.items()}
    return torch.stack(list(means.values())).sum(), {name: float(mean.detach()) for name, mean in means.items()}


def smoothness_loss(actions: torch.Tensor, before: torch.Tensor | None) -> torch.Tensor:
    """Loss (B,): squared change of the mean actions (B, J) since those `before`; 0 without any."""
    if before is None:
        return actions.new_zeros(len(actions))
    return (actions - before).square().sum(1)
