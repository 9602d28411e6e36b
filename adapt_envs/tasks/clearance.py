"""Room to the obstacles: a reward beyond the paper's two. A pure function over arrays.

Touches are rare, a few in a minute, and a penalty for them alone is learned slowly; this tells at every step whether
the character comes too near.
"""

import numpy as np
from numpy.typing import NDArray

NEAREST, FREE = 0.3, 0.5
"""Distances [m] of the root from a block's side: there shoulders touch, and nothing does."""


def clearance_reward(distance: NDArray[np.floating]) -> NDArray[np.float64]:
    """How much room the character has.

    Args:
        distance: (N,) of the roots from the nearest obstacle's sides [m], infinite where there is none.

    Returns:
        (N,) in [0, 1]: 0 at 0.3 m and nearer, 1 at 0.5 m and beyond, linear between.
    """
    return np.clip((distance.astype(np.float64) - NEAREST) / (FREE - NEAREST), 0, 1)
