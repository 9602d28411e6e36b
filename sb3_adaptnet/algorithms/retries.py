"""What came before episodes failed: worlds are put back there until they succeed."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.vec_env import Situations

BACK = 45
"""Control steps before a failure that a retry begins at, 1.5 s: it can be seen to come, and be avoided."""
TRIES = 5
"""So often a situation is tried again at most: there may be no way out of it."""
KEPT = 500
"""Situations at most that wait; beyond that, earlier ones are forgotten."""


class Retries:
    """Situations that wait to be tried again. One that is drawn leaves, and is back if it fails again.

    Falls are rare, and so is what leads to them: who meets each once learns little from it.
    """

    def __init__(self, worlds: int, rng: np.random.Generator) -> None:
        """Watch so many worlds; none waits at first. `rng` is the source of the draws."""
        self._rng = rng
        self._past: deque[Situations] = deque(maxlen=BACK)
        self._tries = np.zeros(worlds, np.int64)
        self._waiting: deque[tuple[Situations, int]] = deque(maxlen=KEPT)

    def __len__(self) -> int:
        """How many wait."""
        return len(self._waiting)

    def watch(self, now: Situations) -> None:
        """Remember what all worlds are in the middle of, before each of their steps."""
        self._past.append(now)

    def forget(self) -> None:
        """What was watched is over; what waits goes on waiting."""
        self._past.clear()

    def note(self, failed: NDArray[np.integer], ages: NDArray[np.integer]) -> None:
        """Take up what came before the episodes of the worlds `failed` (n,) did, after `ages` (n,) control steps each.

        What fails within 1.5 s is tried again from where it began.
        """
        for world, age in zip(failed, ages, strict=True):
            again = self._tries[world] + 1 if age <= BACK else 1
            if again <= TRIES and self._past:
                moment = self._past[-min(int(age), len(self._past))]
                self._waiting.append((moment.of(np.array([world])), int(again)))

    def begin(self, worlds: NDArray[np.integer]) -> None:
        """The worlds (n,) have begun anew, and not from here."""
        self._tries[worlds] = 0

    def draw(self, worlds: NDArray[np.integer], share: float) -> tuple[NDArray[np.integer], Situations | None]:
        """Which of the worlds (n,) shall try again, each with the probability `share`, and from where.

        There are no more of them than situations wait; they are ascending. None goes with none of them.
        """
        number = min(int(self._rng.binomial(len(worlds), share)), len(self._waiting))
        if not number:
            return worlds[:0], None
        chosen = np.sort(self._rng.choice(worlds, number, replace=False))
        places = self._rng.permutation(len(self._waiting))[:number]
        drawn = [self._waiting[place] for place in places]
        for place in sorted(places, reverse=True):
            del self._waiting[place]
        self._tries[chosen] = [tries for _, tries in drawn]
        return chosen, Situations.together([situation for situation, _ in drawn])
