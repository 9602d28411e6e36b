"""The loss of a window: tracking, travel, smooth actions, what comes after; the actor adds the penalties of eq. 12."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass

import torch

from sb3_adaptnet.algorithms.imagination import Imagined
from sb3_adaptnet.algorithms.rollouts.real_rollout import Guided
from sb3_adaptnet.algorithms.svg_settings import grouped
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.algorithms.tracking.tracking_loss import TrackingWeights, tracking_loss
from sb3_adaptnet.algorithms.tracking.travel_loss import TravelWeights, goal_loss, travel_errors, travel_loss
from sb3_adaptnet.objectives.schedule import Schedule, check_schedule, value_at
from sb3_adaptnet.world_model.links import HeadingView
from sb3_adaptnet.world_model.state import State

CostToCome = Callable[[Imagined], torch.Tensor]
"""Worlds whose window or episode is over -> weighted costs (B,) of what comes after."""


@dataclass(frozen=True)
class LossWeights(TrackingWeights, TravelWeights):
    """How much the parts of the loss count; see `TrackingWeights` and `TravelWeights`.

    Attributes:
        smoothness: of squared changes of the actions.
        symmetry: of squared differences between mean actions in the mirror and the mirror images of those that acted,
            at the first steps of windows. Without it each side is learned for itself, and one may stay the worse.
            It needs `mirror`.
    """

    smoothness: float = 0.02
    symmetry: float = 0.0


@dataclass(frozen=True)
class LossSchedules:
    """`LossWeights` that change with the samples: what shapes the end of a training may be in the way of its beginning.

    Attributes:
        weights: name of a weight -> its schedule; the others keep their defaults.
    """

    weights: Mapping[str, Schedule]

    @classmethod
    def of(cls, given: LossWeights | Mapping[str, Schedule] | None) -> "LossSchedules":
        """Schedules from weights that stay as they are, or by name.

        Raises:
            ValueError: for an unknown name, or a number that is negative or none.
        """
        weights = asdict(given) if isinstance(given, LossWeights) else dict(given or {})
        grouped(LossWeights, weights)  # refuses names that it has not
        for name, schedule in weights.items():
            check_schedule(name, schedule)
        return cls(weights)

    def at(self, samples: int) -> LossWeights:
        """The weights after `samples` samples."""
        return LossWeights(**{name: value_at(schedule, samples) for name, schedule in self.weights.items()})


def state_costs(
    state: State, view: HeadingView, motion: TrackedMotion, guided: Guided, weights: LossWeights
) -> dict[str, torch.Tensor]:
    """Costs (B,) of being in a state, by name."""
    links = view.latest(motion.links.shape[1])
    phases = guided.phases
    tracking = tracking_loss(state, links, motion, phases, guided.turn_rates, weights)
    errors = travel_errors(state.velocity, view, motion, phases, guided.headings, guided.speeds)
    costs = {"tracking": guided.style * tracking, "travel": travel_loss(errors, weights)}
    if weights.goal > 0:
        short = goal_loss(state.position, state.velocity, guided.targets, guided.speeds)
        costs["goal"] = weights.goal * short
    return costs


def window_loss(
    steps: Iterable[Imagined], motion: TrackedMotion, weights: LossWeights, to_come: CostToCome | None = None
) -> tuple[torch.Tensor, dict[str, float]]:
    """Mean loss () over the steps of a window and its worlds, and the means of its parts; ended episodes count 0."""
    parts = defaultdict[str, list[torch.Tensor]](list)
    before: torch.Tensor | None = None
    for step in steps:
        costs = state_costs(step.state, step.view, motion, step.guided, weights)
        costs["smoothness"] = weights.smoothness * smoothness_loss(step.actions, before)
        if before is None and weights.symmetry > 0:
            costs["symmetry"] = weights.symmetry * asymmetry(step)
        before = step.actions
        for name, cost in costs.items():
            parts[name].append((cost * step.guided.weights).mean())
        if to_come is not None:
            last = step.last_seen()
            worlds = len(step.guided.weights)
            parts["to_come"].append(before.new_zeros(()) if last is None else to_come(last).sum() / worlds)
    means = {name: torch.stack(values).mean() for name, values in parts.items()}
    return torch.stack(list(means.values())).sum(), {name: float(mean.detach()) for name, mean in means.items()}


def asymmetry(step: Imagined) -> torch.Tensor:
    """(B,) squared difference between mean actions in the mirror and the mirror images of those that acted; else 0.

    It means something at the first step of a window, whose state is the real one's mirror image.
    """
    return step.guided.mirrored * (step.actions - step.guided.means).square().sum(1)


def smoothness_loss(actions: torch.Tensor, before: torch.Tensor | None) -> torch.Tensor:
    """Loss (B,): squared change of the mean actions (B, J) since those `before`; 0 without any."""
    if before is None:
        return actions.new_zeros(len(actions))
    return (actions - before).square().sum(1)
