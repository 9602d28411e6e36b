"""Who has fallen: which links touch the ground, and on uneven ground how high they are."""

import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.build import FALL_PARTS
from adapt_envs.model.ground import Ground
from adapt_envs.model.humanoid import LINKS

_PARTS = tuple(np.array([LINKS.index(name) for name in links]) for links in FALL_PARTS.values())


def fallen(
    touching: NDArray[np.bool_], positions: NDArray[np.floating], ground: Ground, limit: float | None
) -> NDArray[np.bool_]:
    """Worlds whose character has fallen.

    Args:
        touching: (N, 6) which of `FALL_PARTS` touch something static.
        positions: (N, 15, 3) of the links' origins [m], world.
        ground: what they stand on.
        limit: a part all of whose links are at least this high [m] above the ground below them may touch; None if
            nothing may.

    Returns:
        (N,) bool.
    """
    found = np.asarray(touching.any(axis=1))
    rows = np.flatnonzero(found)
    if limit is None or not len(rows):
        return found
    height = positions[rows, :, 2] - ground.floor_at(positions[rows, :, :2])
    low = np.stack([height[:, part].min(axis=1) < limit for part in _PARTS], axis=1)
    found[rows] = (touching[rows] & low).any(axis=1)
    return found
