"""Poses at the right time: how near characters are to a gait cycle, and whether they go through it at its own tempo.

A reward beyond the paper's two. Discriminators see five frames; steps a fifth too quick look like the clip's there.
"""

import numpy as np
from numpy.typing import NDArray

TRACKING_SCALE = 0.1
"""Mean distance of the links [m] that halves the reward."""
DRIFT_SCALE, FREE_DRIFT = 0.12, 0.03
"""Relative error of the tempo that halves the reward, and what is free of charge: tempo sways a little in turns."""
TEMPO_EXPONENT, SLOWEST_TEMPO, FASTEST_TEMPO = 0.5, 0.87, 1.15
"""The cycle should run at this power of the preferred speed over its own, within these bounds: who walks faster takes
longer and quicker steps. So do `SVG`'s guides, which know nothing of this package: a test holds the two together."""
GAIN, MOST_SHIFT = 0.3, 0.6
"""A clock moves by this share of the way to the best frame nearby, and by as many frames per step at most. It keeps up
with tempos of 0.6 to 1.5; one that could not would lose its character, and then no tempo were better than another."""
DRIFT_STEPS = 20
"""Control steps over which drift is averaged."""
LOST = 0.25
"""Mean distance [m] from which on a clock is set to the nearest frame of the cycle. Half a cycle off is about 0.2 m."""
_FLAT = 1e-6
"""Curvature [m^2 per frame^2] below which the distance says nothing about the phase."""


class PhaseClock:
    """Which frame of a gait cycle each of N characters is in, and how much faster than it should it goes through them.

    Attributes:
        phases: (N,) frames, fractions included, below the cycle's P.
        drifts: (N,) relative errors of the tempo: 0.1 for steps a tenth too quick.
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
        self.phases, self.drifts = np.zeros(num_worlds), np.zeros(num_worlds)

    def restart(self, ids: NDArray[np.integer], positions: NDArray[np.floating]) -> None:
        """Set the clocks `ids` (n,) to the frames that are nearest to the positions (n, L, 3) [m], heading frame."""
        self.phases[ids], self.drifts[ids] = self._nearest(positions), 0

    def _nearest(self, positions: NDArray[np.floating]) -> NDArray[np.integer]:
        products = np.tensordot(positions, self._cycle, ((1, 2), (1, 2)))
        return np.asarray((np.square(self._cycle).sum(axis=(1, 2)) - 2 * products).argmin(axis=1))

    def advance(self, positions: NDArray[np.floating], speeds: NDArray[np.floating]) -> None:
        """Let all clocks go on by one control step.

        Args:
            positions: (N, L, 3) of the links after it [m], heading frame.
            speeds: (N,) preferred speeds [m/s].
        """
        tempo = np.clip((speeds / self._speed) ** TEMPO_EXPONENT, SLOWEST_TEMPO, FASTEST_TEMPO)
        self.phases = self.phases + tempo
        behind, here, ahead = (
            np.square(self._offsets(positions, shift)).sum(axis=-1).mean(axis=-1) for shift in (-1, 0, 1)
        )
        to_best = (behind - ahead) / (2 * np.maximum(behind - 2 * here + ahead, _FLAT))
        shifts = np.clip(GAIN * to_best, -MOST_SHIFT, MOST_SHIFT)
        self.phases = (self.phases + shifts) % len(self._cycle)
        self.drifts += (shifts / tempo - self.drifts) / DRIFT_STEPS
        lost = np.flatnonzero(self.distances(positions) > LOST)
        self.phases[lost] = self._nearest(positions[lost])

    def distances(self, positions: NDArray[np.floating]) -> NDArray[np.float64]:
        """Mean distances (N,) [m] of links (N, L, 3) from where the cycle has them."""
        return np.linalg.norm(self._offsets(positions, 0), axis=-1).mean(axis=-1, dtype=np.float64)

    def _offsets(self, positions: NDArray[np.floating], shift: int) -> NDArray[np.floating]:
        """(N, L, 3) from where the cycle has the links `shift` frames later; between frames in a straight line."""
        whole = np.floor(self.phases).astype(np.int64)
        before, after = (self._cycle[(whole + shift + k) % len(self._cycle)] for k in (0, 1))
        return positions - before - (self.phases - whole)[:, None, None].astype(np.float32) * (after - before)


def tracking_reward(distances: NDArray[np.floating], drifts: NDArray[np.floating]) -> NDArray[np.float64]:
    """Rewards (N,) in (0, 1], with slopes far out, too.

    Args:
        distances: (N,) of the links from the cycle [m].
        drifts: (N,) relative errors of the tempo.

    Returns:
        1 / (1 + (distance / 0.1 m)^2) x 1 / (1 + (what the drift is over 0.03 / 0.12)^2). In turns, too, although a
        clip that walks straight shows none: with a fixed 0.5 for most of it there, steps stayed too quick.
    """
    beyond = np.maximum(np.abs(drifts) - FREE_DRIFT, 0)
    return np.asarray(1 / (1 + np.square(distances / TRACKING_SCALE)) / (1 + np.square(beyond / DRIFT_SCALE)))
