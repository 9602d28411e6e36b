"""The plan of bounded ground: square patches of 24 m in rows and columns about the world's origin."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

PATCH = 24.0
"""Side of a patch [m]."""
STRIP = 3.0
"""Width [m] of the strip between patches, where one's ground passes into the next one's."""
PITCH = PATCH + STRIP
"""Distance of the middles of neighbouring patches [m]."""
INSET = 3.0
"""Goals and spawns stay this far [m] inside their patch."""


@dataclass(frozen=True)
class Patches:
    """A square of patches.

    Attributes:
        per_side: number of patches in a row, and of rows.
    """

    per_side: int

    @property
    def centres_1d(self) -> NDArray[np.float64]:
        """(per_side,) middles of the patches along x, and along y [m]."""
        return np.asarray((np.arange(self.per_side) - (self.per_side - 1) / 2) * PITCH, np.float64)

    @property
    def half(self) -> float:
        """Half the side [m] of the whole square, strips around it included."""
        return self.per_side * PITCH / 2

    def split(self, values: NDArray[np.floating]) -> tuple[NDArray[np.int32], NDArray[np.floating]]:
        """For coordinates along x or y: the patch's number there, and the distance [m] from its lower edge.

        The distance is outside [0, 24] in the strips and beyond the square.
        """
        patch = np.clip((values + self.half) / PITCH, 0, self.per_side - 1).astype(np.int32)
        return patch, values + values.dtype.type(self.half - STRIP / 2) - patch * values.dtype.type(PITCH)

    def clipped(self, xy: NDArray[np.floating], near: NDArray[np.floating]) -> NDArray[np.floating]:
        """Points `xy` (n, 2) moved to lie 3 m inside the patch that `near` (n, 2) is in or closest to."""
        middle = self.centres_1d[self.split(near)[0]]
        reach = PATCH / 2 - INSET
        return np.clip(xy, middle - reach, middle + reach)

    def sample(self, n: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """`n` points (n, 2), uniform over all patches, 3 m inside them."""
        patch = rng.integers(self.per_side, size=(n, 2))
        return self.centres_1d[patch] + rng.uniform(-1, 1, (n, 2)) * (PATCH / 2 - INSET)
