"""Poses at the right time: how near characters are to a gait cycle that runs at its own tempo.

A reward beyond the paper's two. Discriminators see five frames; steps a fifth too quick look like the clip's there.
"""

import numpy as np
from numpy.typing import NDArray

TRACKING_SCALE = 0.1
"""Mean distance of the links [m] at which the reward has fallen to 1/e."""
TEMPO_EXPONENT, SLOWEST_TEMPO, FASTEST_TEMPO = 0.5, 0.87, 1.15
"""The cycle runs at this power of the preferred speed over its own, within these bounds: who walks faster takes longer
and quicker steps, about equally so (Grieve and Gear 1966, doi:10.1080/00140136608964399)."""
MOST_DRIFT = 0.05
"""Frames per step by which a clock may run ahead or behind to stay with its character."""
LOST = 0.25
"""Mean distance [m] from which on a clock is set to the nearest frame of the cycle. Half a cycle off is about 0.2 m."""


class PhaseClock:
    """Which frame of a gait cycle each of N characters should be in.

    Attributes:
        phases: (N,) frames, fractions included, below the cycle's P.
    """

    def __init__(self, cycle: NDArray[np.floating], speed: float, num_worlds: int) -> None:
        """Clocks before their first `restart`.

        Args:
            cycle: (P, L, 3) positions of the links [m], heading frame, one frame a control step; the first follows the
                last.
            speed: the cycle's own [m/s].
            num_worlds: N.
        """
        self._cycle, self._speed = np.asarray(cycle, np.float32), speed
        self.phases = np.zeros(num_worlds)

    def restart(self, ids: NDArray[np.integer], positions: NDArray[np.floating]) -> None:
        """Set the clocks `ids` (n,) to the frames that are nearest to the positions (n, L, 3) [m], heading frame."""
        flat, frames = positions.reshape(len(positions), -1), self._cycle.reshape(len(self._cycle), -1)
        self.phases[ids] = ((frames * frames).sum(axis=1) - 2 * flat @ frames.T).argmin(axis=1)

    def advance(self, positions: NDArray[np.floating], speeds: NDArray[np.floating]) -> NDArray[np.float64]:
        """Let all clocks go on by one control step.

        Args:
            positions: (N, L, 3) of the links after it [m], heading frame.
            speeds: (N,) preferred speeds [m/s].

        Returns:
            (N,) mean distances [m] of the links from where the cycle has them.
        """
        tempo = np.clip((speeds / self._speed) ** TEMPO_EXPONENT, SLOWEST_TEMPO, FASTEST_TEMPO)
        self.phases = (self.phases + tempo) % len(self._cycle)
        behind, here, ahead = (self.distances(positions, shift) for shift in (-1, 0, 1))
        better = np.sign(behind - ahead) * (np.minimum(behind, ahead) < here)
        self.phases = (self.phases + MOST_DRIFT * better) % len(self._cycle)
        lost = np.flatnonzero(here > LOST)
        if len(lost):
            self.restart(lost, positions[lost])
        return here

    def distances(self, positions: NDArray[np.floating], shift: int = 0) -> NDArray[np.float64]:
        """Mean distances (N,) [m] of links (N, L, 3) from the frames that lie `shift` after the present ones."""
        frames = self._cycle[np.rint(self.phases + shift).astype(np.int64) % len(self._cycle)]
        return np.linalg.norm(positions - frames, axis=-1).mean(axis=-1, dtype=np.float64)


def tracking_reward(distances: NDArray[np.floating]) -> NDArray[np.float64]:
    """Rewards (N,) in (0, 1] of mean distances (N,) [m] from a cycle: exp(-(d / 0.1 m)^2)."""
    return np.exp(-np.square(np.asarray(distances, np.float64) / TRACKING_SCALE))
