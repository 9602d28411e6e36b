"""The latest rollouts, from which policy, model and critic learn."""

from collections import deque

import numpy as np

from sb3_adaptnet.algorithms.rollouts.real_rollout import RealRollout
from sb3_adaptnet.algorithms.rollouts.reflection import Reflection


class RecentRollouts:
    """The latest rollouts; with a reflection twice each, one half of the worlds in the mirror, then the other half."""

    def __init__(self, most: int, reflection: Reflection | None, rng: np.random.Generator) -> None:
        """Keep the `most` latest; `rng` chooses the halves."""
        self._reflection, self._rng = reflection, rng
        self._forms = 1 if reflection is None else 2
        self._kept = deque[RealRollout](maxlen=most * self._forms)

    def add(self, rollout: RealRollout, left_from_behind: float) -> None:
        """Add the latest; its guides turned left to targets within an angle [rad] of straight behind."""
        if self._reflection is None:
            self._kept.append(rollout)
            return
        worlds = rollout.transitions.num_worlds
        half = self._rng.permutation(worlds) < worlds // 2
        for mirrored in (half, ~half):
            self._kept.append(self._reflection.of_rollout(rollout, mirrored, left_from_behind))

    def latest(self, count: int) -> list[RealRollout]:
        """All forms of the `count` latest rollouts, oldest first."""
        return list(self._kept)[-count * self._forms :]

    def chosen(self, number: int, count: int) -> RealRollout:
        """What update `number` of a round learns from: every other one from the latest, its forms in turn.

        The others take any of the `count` latest.
        """
        recent = self.latest(count)
        newest = -1 - (number // 2) % self._forms
        return recent[newest if number % 2 == 0 else self._rng.integers(len(recent))]
