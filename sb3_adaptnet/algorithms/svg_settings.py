"""What one may choose of SVG, in groups; a YAML entry gives each group as a mapping."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, TypeVar, cast

from sb3_adaptnet.algorithms.tracking.tracking_loss import TrackingWeights
from sb3_adaptnet.algorithms.tracking.travel_loss import TravelWeights
from sb3_adaptnet.objectives.schedule import Schedule, check_schedule

Group = TypeVar("Group")


@dataclass(frozen=True)
class Episodes:
    """How episodes go while rollouts are collected.

    Attributes:
        error_limit: mean error of the links' positions [m] at which an episode ends.
        turn_rate: at most so fast the reference turns towards the goal [rad/s].
        fewest_steps, most_steps: control steps of an episode.
    """

    error_limit: Schedule = 0.2
    turn_rate: Schedule = 0.3
    fewest_steps: int = 50
    most_steps: int = 150

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: for a negative limit or rate, or numbers of steps that do not rise.
        """
        check_schedule("error_limit", self.error_limit)
        check_schedule("turn_rate", self.turn_rate)
        if not 0 < self.fewest_steps <= self.most_steps:
            raise ValueError(f"episodes of {self.fewest_steps} to {self.most_steps} steps do not exist")


@dataclass(frozen=True)
class Exploration:
    """Noise on the actions.

    Attributes:
        std: standard deviation; 1 is half of the action range.
        share: share of the steps that have any.
    """

    std: float = 0.05
    share: float = 0.8


@dataclass(frozen=True)
class ModelRefresh:
    """How the world model keeps up with the policy.

    Attributes:
        learning_rate: Adam's.
        updates: per rollout.
        batch: transitions per update.
        rollouts: latest rollouts that they are taken from.
    """

    learning_rate: float = 1e-4
    updates: int = 3
    batch: int = 1024
    rollouts: int = 12


@dataclass(frozen=True)
class LossWeights(TrackingWeights, TravelWeights):
    """How much the parts of the loss count; see `TrackingWeights` and `TravelWeights`.

    Attributes:
        smoothness: of squared changes of the actions.
    """

    smoothness: float = 0.02


def grouped(kind: type[Group], given: Group | Mapping[str, Any] | None) -> Group:
    """A group of settings, from itself, a mapping, or None for the defaults.

    Raises:
        ValueError: for a name that is not in the group, listing those that are.
    """
    if isinstance(given, kind):
        return given
    values = dict(cast(Mapping[str, Any], given or {}))
    valid = [field.name for field in fields(kind)]  # type: ignore[arg-type]  # all groups are dataclasses
    unknown = [name for name in values if name not in valid]
    if unknown:
        raise ValueError(f"{kind.__name__} has no {unknown[0]!r}; it has {', '.join(valid)}")
    return kind(**values)
