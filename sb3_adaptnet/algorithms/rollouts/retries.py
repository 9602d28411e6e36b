"""What came before episodes failed: worlds are put back there until they succeed, and again."""

from collections import deque
from itertools import takewhile
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.vec_env import Situations

BACK = (30, 90)
"""Fewest and most control steps before a failure that a retry begins at, 1 to 3 s: at some of them it can be avoided.

Limp falls 2.2 s after it has begun to turn at the wrong moment: 1.5 s before the fall may be too late.
"""
LENGTHS = (120, 180)
"""Fewest and most control steps of a retry, 4 to 6 s: what made it fail, and a little after that."""
SUCCESSES = 3
"""So often in a row it must succeed to be over: by luck, with the noise on the actions, it may do so once."""
TRIES = 9
"""So often a situation is tried again at most: there may be no way out of it."""
KEPT = 500
"""Situations at most that wait; beyond that, earlier ones are forgotten."""


class _Waiting(NamedTuple):
    """A situation of one world, how often it was tried, and with how many successes since it last failed."""

    situation: Situations
    tries: int = 0
    successes: int = 0


class Retries:
    """Situations that wait to be tried again. One that is drawn leaves, and is back until it succeeds for good.

    Falls are rare, and so is what leads to them: who meets each once learns little from it.
    """

    def __init__(self, worlds: int, rng: np.random.Generator) -> None:
        """Watch so many worlds; none waits at first. `rng` is the source of the draws."""
        self._rng = rng
        self._past: deque[Situations] = deque(maxlen=BACK[1])
        self._tried: list[_Waiting | None] = [None] * worlds
        self._waiting: deque[_Waiting] = deque(maxlen=KEPT)

    def __len__(self) -> int:
        """How many wait."""
        return len(self._waiting)

    @property
    def trying(self) -> NDArray[np.bool_]:
        """(N,) which worlds try again what failed."""
        return np.array([tried is not None for tried in self._tried], np.bool_)

    def watch(self, now: Situations) -> None:
        """Remember what all worlds are in the middle of, before each of their steps."""
        self._past.append(now)

    def forget(self) -> None:
        """What was watched is over; what waits goes on waiting."""
        self._past.clear()

    def failed(self, worlds: NDArray[np.integer], ages: NDArray[np.integer]) -> None:
        """Take up what came before the episodes of `worlds` (n,) failed, after `ages` (n,) control steps each.

        A retry that failed waits again as it was; what came before other failures is new, and begins with the episode
        if that was younger, and with the target if that was: before it, another target might come up instead.
        """
        backs = self._rng.integers(BACK[0], BACK[1] + 1, len(worlds))
        for world, back in zip(worlds, np.minimum(backs, ages), strict=True):
            tried = self._tried[world]
            if tried is not None:
                self._wait(tried._replace(successes=0))
            elif self._past:
                most = max(BACK[0], self._steps_since_its_target(world))
                moment = self._past[-min(int(back), most, len(self._past))]
                self._wait(_Waiting(moment.of(np.array([world]))))
            self._tried[world] = None

    def _steps_since_its_target(self, world: int) -> int:
        """For how many of the steps that were watched a world has had its target."""
        latest = self._past[-1].target[world]
        same = (bool((now.target[world] == latest).all()) for now in reversed(self._past))
        return sum(1 for _ in takewhile(bool, same))

    def succeeded(self, worlds: NDArray[np.integer]) -> None:
        """The episodes of `worlds` (n,) are over and did not fail; those that are no retries do not matter."""
        for world in worlds:
            tried = self._tried[world]
            if tried is not None and tried.successes + 1 < SUCCESSES:
                self._wait(tried._replace(successes=tried.successes + 1))
            self._tried[world] = None

    def _wait(self, tried: _Waiting) -> None:
        if tried.tries < TRIES:
            self._waiting.append(tried)

    def lengths(self, worlds: NDArray[np.integer]) -> NDArray[np.integer]:
        """(n,) control steps that the episodes of `worlds` (n,), which begin, shall last: 0 where it is no retry."""
        trying = self.trying[worlds]
        steps = np.zeros(len(worlds), np.int64)
        steps[trying] = self._rng.integers(LENGTHS[0], LENGTHS[1] + 1, int(trying.sum()))
        return steps

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
        for world, waiting in zip(chosen, drawn, strict=True):
            self._tried[world] = waiting._replace(tries=waiting.tries + 1)
        return chosen, Situations.together([waiting.situation for waiting in drawn])
