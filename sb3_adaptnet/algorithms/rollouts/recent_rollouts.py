"""The latest rollouts, from which policy, model and critic learn."""

from collections import deque
from collections.abc import Iterator

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

    def chosen(self, updates: int, count: int, batch_size: int | None = None) -> Iterator[RealRollout]:
        """What each of a round's updates learns from: every other one from the latest, its forms in turn.

        The others take any of the `count` latest. With a `batch_size` it is only so many of the worlds, drawn anew.
        """
        recent = self.latest(count)
        for number in range(updates):
            newest = -1 - (number // 2) % self._forms
            rollout = recent[newest if number % 2 == 0 else self._rng.integers(len(recent))]
            if batch_size is not None:
                rollout = rollout.of(self._rng.choice(rollout.transitions.num_worlds, batch_size, replace=False))
            yield rollout
