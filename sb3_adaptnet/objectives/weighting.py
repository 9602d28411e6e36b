"""How much each objective counts (w_k of the paper's eq. 9): as training goes on, in turns and without a companion."""

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.objectives.schedule import Schedule, check_schedule, value_at

IMITATION, GOAL = "imitation", "goal"
DEFAULT_WEIGHTS = {IMITATION: 0.5, GOAL: 0.5}
"""The paper's (app. B); motion styles take 0.35 and 0.65."""
AHEAD, ASIDE = 0.95, 0.75
"""Cosines of the angle between the heading and the way to the target at which a turn begins (18 degrees) and from which
on it counts in full (41 degrees)."""


class ObjectiveWeights:
    """Weights of K objectives.

    Attributes:
        names: the objectives, in the order of the critic's columns.
    """

    def __init__(
        self,
        weights: Mapping[str, Schedule],
        in_turns: Mapping[str, Schedule] | None = None,
        alone: Mapping[str, Schedule] | None = None,
    ) -> None:
        """Choose weights.

        Args:
            weights: name to weight.
            in_turns: name to the factor, 0 to 1, that its weight has where the character has to turn; what that takes
                away counts for the goal there. A motion that walks straight ahead says little about turns.
            alone: likewise where no companion acts beside what learns.

        Raises:
            ValueError: for a weight or factor that is none, factors without the objective "goal" that gets the rest, of
                the goal itself or of what is no objective.
        """
        self._weights = dict(weights)
        self.names = tuple(self._weights)
        for name, weight in self._weights.items():
            check_schedule(f"the weight of objective {name!r}", weight)
        self._in_turns = self._checked("in_turns", in_turns or {})
        self._alone = self._checked("alone", alone or {})

    def _checked(self, what: str, factors: Mapping[str, Schedule]) -> dict[str, Schedule]:
        others = [name for name in self.names if name != GOAL]
        for name, factor in factors.items():
            if name not in others or GOAL not in self.names:
                known = f"objectives beside the goal are: {', '.join(others) or 'none'}"
                raise ValueError(f"{what} gives weight of {name!r} to the goal, but {known}")
            check_schedule(f"the factor of objective {name!r} of {what}", factor)
            largest = max(factor.values() if isinstance(factor, Mapping) else [factor])
            if largest > 1:
                raise ValueError(f"the factor of objective {name!r} of {what} is at most 1, not {largest}")
        return dict(factors)

    def check_rewards(self, known: Collection[str]) -> None:
        """Refuse objectives that nobody rewards.

        Raises:
            ValueError: naming one.
        """
        for name in self.names:
            if name not in known:
                raise ValueError(f"objective {name!r} has no reward; known are: {', '.join(known)} (see reward_terms)")

    def at(self, samples: int) -> list[float]:
        """The K weights after `samples` samples, straight ahead."""
        return [value_at(weight, samples) for weight in self._weights.values()]

    def where(
        self, goals: NDArray[np.floating], companions: NDArray[np.integer] | None, samples: int
    ) -> NDArray[np.float64]:
        """Weights where characters have these goals and companions.

        Args:
            goals: (..., G) goals as observed; the first number is the cosine to the way to the target.
            companions: (...) numbers of the companions that act, 0 for none; None where there are none.
            samples: samples seen.

        Returns:
            (K,) without factors, else (..., K).

        Raises:
            ValueError: with factors of `alone` and without companions.
        """
        weights = np.array(self.at(samples))
        if self._in_turns:
            weights = self._scaled(weights, self._in_turns, turning(goals), samples)
        if self._alone:
            if companions is None:
                raise ValueError("alone needs worlds with companions, and policy_kwargs names none")
            weights = self._scaled(weights, self._alone, np.asarray(companions == 0, np.float64), samples)
        return weights

    def _scaled(
        self, weights: NDArray[np.float64], factors: Mapping[str, Schedule], how_much: NDArray[np.float64], samples: int
    ) -> NDArray[np.float64]:
        """Weights (..., K) with factors, as much as (...) says; the goal gets the rest."""
        scaled = np.broadcast_to(weights, (*how_much.shape, len(self.names))).copy()
        for name, factor in factors.items():
            lost = how_much * (1 - value_at(factor, samples)) * scaled[..., self.names.index(name)]
            scaled[..., self.names.index(name)] -= lost
            scaled[..., self.names.index(GOAL)] += lost
        return scaled


def turning(goals: NDArray[np.floating]) -> NDArray[np.float64]:
    """How much of a turn lies before characters (...): 0 straight ahead, 1 from `ASIDE` on, of goals (..., G)."""
    return np.asarray(np.clip((AHEAD - goals[..., 0]) / (AHEAD - ASIDE), 0, 1), np.float64)
