"""Where the gaits of a reference motion lie among its phases."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Gaits:
    """One gait, or G of different speeds one after another, P phases in all.

    Attributes:
        starts, lengths: (G,) first phase and number of phases of each gait.
        cyclic: (G,) whether its first phase follows its last one.
        speeds: (G,) mean speed of the root [m/s].
        footsteps: (G,) of both feet per second; infinite if none are found.
        counterparts: (G, P) the phase of each gait that is most like each phase.
    """

    starts: NDArray[np.integer]
    lengths: NDArray[np.integer]
    cyclic: NDArray[np.bool_]
    speeds: NDArray[np.floating]
    footsteps: NDArray[np.floating]
    counterparts: NDArray[np.integer]

    def of(self, phases: NDArray[np.integer]) -> NDArray[np.integer]:
        """The gaits that phases (...) belong to."""
        return np.searchsorted(self.starts, phases, side="right") - 1

    def shifted(self, phases: NDArray[np.integer], by: NDArray[np.integer] | int) -> NDArray[np.integer]:
        """Phases some frames later or earlier: a cycle goes on, any other gait holds its ends."""
        gaits = self.of(phases)
        start, length = self.starts[gaits], self.lengths[gaits]
        local = phases - start + by
        return np.where(self.cyclic[gaits], local % length, np.clip(local, 0, length - 1)) + start

    def at_speeds(self, phases: NDArray[np.integer], speeds: NDArray[np.floating]) -> NDArray[np.integer]:
        """Phases (N,) in the gaits that are nearest to preferred speeds (N,) [m/s], in proportion."""
        if len(self.starts) == 1:
            return phases
        wanted = np.abs(np.log(speeds[:, None] / self.speeds)).argmin(axis=1)
        return np.where(self.of(phases) == wanted, phases, self.counterparts[wanted, phases])
