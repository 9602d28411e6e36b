"""What one may choose of SVG, in groups; a YAML entry gives each group as a mapping."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.checks import check_positive
from sb3_adaptnet.objectives.schedule import (
    Schedule,
    check_number,
    check_schedule,
    checked_decay,
    highest,
    two,
)
from sb3_adaptnet.world_model.model import Sizes

Group = TypeVar("Group")


@dataclass(frozen=True)
class Episodes:
    """How episodes go while rollouts are collected.

    Attributes:
        error_limit: mean error of the links' positions [m] at which an episode ends.
        loose_limit: the same for loose worlds, and for all others until they have been calm for a while. From 1 m on
            only falls are left.
        loose_share: share of the worlds that are loose: they last longer, and seldom end by their error.
        calm_seconds: so long [s] after turning only the loose limit holds.
        goal_spread: share of the circle, centred ahead, that new goals lie in; 1 is the task's own.
        loose_goal_spread: the same of loose worlds.
        partial_share: share of the time in which the adaptation acts in part, in each world at a strength drawn from 0
            to 1, so that half a style steers, too. The error ends no such episode, and the style's loss counts by the
            strength squared. Styles far from the base pay for much of it at full strength.
        retry_share: share of the episodes that follow on one of a loose world at its whole strength, which begin 1 to 3
            s before one failed, as long as there are such situations. Each comes again until it succeeds three times
            in a row, nine times at most, with the goal of then; when that is over, others are drawn.
        steps: fewest and most control steps of an episode.
        loose_steps: the same of a loose world.
    """

    error_limit: Schedule = 0.16
    loose_limit: Schedule = 0.4
    loose_share: Schedule = 0.5
    calm_seconds: float = 1.5
    goal_spread: Schedule = 1.0
    loose_goal_spread: Schedule = 1.0
    partial_share: Schedule = 0.0
    retry_share: Schedule = 0.0
    steps: tuple[int, int] = (50, 150)
    loose_steps: tuple[int, int] = (100, 450)

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: for a negative limit, share or time, a share above 1, or numbers of steps that do not rise.
        """
        check_number("calm_seconds", self.calm_seconds)
        for name, value in vars(self).items():
            if name not in ("steps", "loose_steps", "calm_seconds"):
                check_schedule(name, value)
            if name.endswith(("_share", "_spread")) and highest(value) > 1:
                raise ValueError(f"{name} is a share, at most 1, not {value!r}")
        for fewest, most in (two("steps", self.steps), two("loose_steps", self.loose_steps)):
            if not (isinstance(fewest, int) and isinstance(most, int) and 0 < fewest <= most):
                raise ValueError(f"episodes of {fewest!r} to {most!r} steps do not exist")


@dataclass(frozen=True)
class Exploration:
    """Noise on the actions.

    Attributes:
        std: standard deviation; 1 is half of the action range.
        share: share of the steps that have any.
    """

    std: float = 0.05
    share: float = 0.8

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: for a negative one, or a share above 1.
        """
        check_number("exploration.std", self.std)
        check_number("exploration.share", self.share)
        if self.share > 1:
            raise ValueError(f"exploration.share is a share, at most 1, not {self.share!r}")

    def noise(self, shape: tuple[int, ...], rng: np.random.Generator) -> NDArray[np.float32]:
        """Sample it for actions of shape (N, J)."""
        noisy = rng.random((shape[0], 1)) < self.share
        return (self.std * rng.standard_normal(shape) * noisy).astype(np.float32)


@dataclass(frozen=True)
class ModelRefresh:
    """How the world model keeps up with the policy.

    With a quarter of the rate and a third of the updates a model of 512 lags behind when turning begins.

    Attributes:
        learning_rate: Adam's.
        updates: per rollout.
        batch: transitions per update.
        rollouts: latest rollouts that they are taken from.
    """

    learning_rate: float = 4e-4
    updates: int = 48
    batch: int = 256
    rollouts: int = 12

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: for a rate, updates, transitions or rollouts that are not positive.
        """
        for name in ("updates", "batch", "rollouts"):
            check_positive(**{f"model_refresh.{name}": getattr(self, name)})
        if not self.learning_rate > 0:
            raise ValueError(f"model_refresh.learning_rate is {self.learning_rate!r}, expected one above 0")


@dataclass(frozen=True)
class ModelFits:
    """How a world model begins from nothing.

    Attributes:
        efforts: samples from which on it is fitted, each time from its first weights to all that was recorded, and a
            factor on the number of updates of a model that ships (1200 of one step and 900 of several). The first fit
            is to what the policy's base does, or to servos that follow the motion if it has none; later ones also to
            the policy. They must come before the critic. A resumed run has only the records made since.
        steps: control steps of every world that are recorded for a fit; they count as samples.
        width: of the network.
    """

    efforts: Mapping[int, float] = field(default_factory=lambda: {0: 0.3})
    steps: int = 600
    width: int = Sizes().width

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: unless the first fit comes first, and steps, width and efforts are positive.
        """
        if not isinstance(self.efforts, Mapping) or not self.efforts or min(self.efforts) != 0:
            raise ValueError(f"the first fit of a new world model is due at 0 samples, not {self.efforts!r}")
        if self.steps < 1 or self.width < 1 or min(self.efforts.values()) <= 0:
            raise ValueError(f"steps, width and efforts must be positive, not {self}")

    def due(self, done: int, samples: int) -> bool:
        """Whether a fit is due after so many samples, when `done` were made."""
        return done < len(self.efforts) and samples >= sorted(self.efforts)[done]

    def effort(self, done: int) -> float:
        """What the fit after `done` others is worth."""
        return self.efforts[sorted(self.efforts)[done]]


@dataclass(frozen=True)
class CostToGo:
    """The critic: which costs a state leads to, and how it learns that.

    Attributes:
        weight: of its value at a window's end, beside the window's costs; 0 switches it off. Before the style
            and the turns were there, 0.5 outweighed them.
        discount: what a cost counts one control step later.
        trace: lambda of TD(lambda).
        end_cost: cost-to-go of an end that is the character's fault: a fall, the error, to get lost. It must be above
            what a bad state costs otherwise: 60 was not. 300 while most episodes still end by their error drowns all
            else.
        updates: before it acts first, and per rollout from then on.
        average_decay: what an update leaves of the running average of its weights. The average is what judges; with 0
            it is the latest weights.
    """

    weight: Schedule = 0.25
    discount: float = 0.97
    trace: float = 0.9
    end_cost: Schedule = 100.0
    updates: tuple[int, int] = (300, 12)
    average_decay: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: for a negative weight or cost, a discount, trace or decay beyond 0 to 1, or no updates.
        """
        check_schedule("weight", self.weight)
        check_schedule("end_cost", self.end_cost)
        if not (0 <= self.discount < 1 and 0 <= self.trace <= 1):
            raise ValueError(f"discount and trace lie within 0 to 1, and discount below 1; not {self}")
        checked_decay("average_decay of cost_to_go", self.average_decay)
        first, later = two("cost_to_go.updates", self.updates)
        check_positive(first_updates=first, later_updates=later)


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
