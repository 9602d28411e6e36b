"""Start states in which episodes soon failed: they come again until they succeed."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

SOON = 60
"""An episode of at most so many control steps failed by its start state, 2 s."""
KEPT = 2000
"""Start states at most that wait; the oldest are forgotten first."""


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

    def draw(self, starts: NDArray[np.integer], share: float) -> NDArray[np.integer]:
        """Replace start states (n,), each with the probability `share`, by ones that wait, as long as there are any."""
        drawn = starts.copy()
        for place in np.flatnonzero(self._rng.random(len(starts)) < share):
            if self._waiting:
                chosen = int(self._rng.integers(len(self._waiting)))
                drawn[place] = self._waiting[chosen]
                del self._waiting[chosen]
        return drawn
