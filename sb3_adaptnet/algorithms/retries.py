"""Start states in which episodes soon failed: they come again until they succeed."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

SOON = 60
"""An episode of at most so many control steps failed by its start state, 2 s."""
KEPT = 2000
"""Start states at most that wait; beyond that, earlier ones are forgotten."""


class Retries:
    """Numbers of start states that wait to be tried again. One that is drawn leaves, and is back if it fails again.

    A motion of minutes has few states of some kinds, such as standing: drawn evenly, they are too few to learn from.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        """None wait at first; `rng` is the source of the draws."""
        self._rng = rng
        self._waiting: deque[int] = deque(maxlen=KEPT)

    def __len__(self) -> int:
        """How many wait."""
        return len(self._waiting)

    def note(self, starts: NDArray[np.integer], ages: NDArray[np.integer]) -> None:
        """Take up episodes (n,) that failed: the start state of each, and the control steps that it lasted."""
        self._waiting.extend(starts[ages <= SOON].tolist())

    def draw(self, count: int, share: float) -> NDArray[np.integer]:
        """Take out start states for `count` new episodes, for each with the probability `share`, as long as any wait.

        Returns at most `count` of them; the other episodes begin anywhere.
        """
        number = min(int(self._rng.binomial(count, share)), len(self._waiting))
        if not number:
            return np.zeros(0, np.int64)
        mixed = self._rng.permutation(np.array(self._waiting))
        self._waiting = deque(mixed[number:].tolist(), maxlen=KEPT)
        return mixed[:number]
