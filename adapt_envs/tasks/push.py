"""Pushes: a force on the torso now and then, in a random horizontal direction (paper, sec. 8.4)."""

from dataclasses import dataclass
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.humanoid import CONTROL_DT


@dataclass(frozen=True)
class PushSchedule:
    """When and how hard characters are pushed.

    Attributes:
        force: horizontal force on the torso's centre of mass [N].
        seconds: how long it acts [s], in whole control steps of 1/30 s.
        interval: range of the time from one push's start to the next one's, and from a reset to the first [s].
    """

    force: float = 1000.0
    seconds: float = 0.2
    interval: tuple[float, float] = (3.0, 6.0)

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: for a force that is not positive, or if pushes overlap, last less than a control step, or the
                range does not rise.
        """
        if isinstance(self.force, bool) or not isinstance(self.force, Real) or not 0 < self.force < float("inf"):
            raise ValueError(f"force is {self.force!r}, expected a positive number of newtons")
        try:
            low, high = self.interval
            possible = 0 < self.seconds <= low <= high < float("inf")
        except (TypeError, ValueError):  # not two numbers
            possible = False
        if not possible:
            found = f"seconds is {self.seconds!r} and interval {self.interval!r}"
            raise ValueError(f"{found}, expected 0 < seconds <= low <= high, all of them finite")


class Pushes:
    """The pushes of N worlds.

    Attributes:
        schedule: when and how hard.
        scale: (N,) factors on the force, to let it grow in training; 1 is the schedule's.
        force: (N, 3) force that acts now [N], world; zero where none does.
    """

    def __init__(self, schedule: PushSchedule, num_worlds: int) -> None:
        """Pushes of `num_worlds` worlds; `restart` comes first."""
        self.schedule = schedule
        self.scale = np.ones(num_worlds)
        self.force = np.zeros((num_worlds, 3))
        self._until_next = np.zeros(num_worlds, np.int64)
        self._left = np.zeros(num_worlds, np.int64)

    def restart(self, ids: NDArray[np.integer], rng: np.random.Generator) -> None:
        """End the pushes of the worlds `ids` and sample the time until their next ones."""
        self.force[ids] = 0
        self._left[ids] = 0
        self._until_next[ids] = self._waits(len(ids), rng)

    def step(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """Advance by one control step; return the forces (N, 3) [N] that act during it, world frame."""
        self._until_next -= 1
        self._left -= 1
        self.force[self._left <= 0] = 0
        ids = np.flatnonzero(self._until_next < 0)
        if len(ids):
            angle = rng.uniform(0, 2 * np.pi, len(ids))
            direction = np.stack([np.cos(angle), np.sin(angle), np.zeros(len(ids))], axis=-1)
            self.force[ids] = self.scale[ids, None] * self.schedule.force * direction
            self._left[ids] = max(1, round(self.schedule.seconds / CONTROL_DT))
            self._until_next[ids] = self._waits(len(ids), rng) - 1
        return self.force

    def _waits(self, n: int, rng: np.random.Generator) -> NDArray[np.int64]:
        return np.round(rng.uniform(*self.schedule.interval, n) / CONTROL_DT).astype(np.int64)
