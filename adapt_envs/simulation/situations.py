"""What some worlds are in the middle of, so that others can go on from there."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Situations(NamedTuple):
    """N worlds at one time, with all that what comes next depends on, but for pushes and goals to come.

    Attributes:
        qpos, qvel: (N, nq) and (N, nv) generalised coordinates, as MuJoCo has them.
        history: (N, 5, 15, 13) states of the links up to now, world frame, oldest first.
        target: (N, 2) targets on the ground [m], world.
        speed: (N,) preferred speeds [m/s].
        distance: (N,) distances to the targets when they were sampled [m].
        steps_left: (N,) control steps until new targets are sampled.
    """

    qpos: NDArray[np.float64]
    qvel: NDArray[np.float64]
    history: NDArray[np.float32]
    target: NDArray[np.float32]
    speed: NDArray[np.float32]
    distance: NDArray[np.float32]
    steps_left: NDArray[np.int64]

    def of(self, ids: NDArray[np.integer]) -> "Situations":
        """The situations of some worlds (n,), as copies."""
        return Situations(*(part[ids] for part in self))

    @classmethod
    def together(cls, parts: Sequence["Situations"]) -> "Situations":
        """The situations of all parts, of which there is at least one, one after the other."""
        return cls(*(np.concatenate(fields) for fields in zip(*parts, strict=True)))
