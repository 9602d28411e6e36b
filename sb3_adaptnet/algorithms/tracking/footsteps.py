"""How often a motion sets its feet down."""

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.world_model.integration import CONTROL_DT

LIFTED, LANDED = 0.03, 0.015
"""Heights [m] over its lowest place, from which on a foot is lifted, and below which it has landed again."""


def footsteps_per_second(heights: NDArray[np.floating], cyclic: bool) -> float:
    """Landings of all feet per second, of a motion whose F feet have heights (F, P) [m]; infinite if there are none.

    A skipping foot lands twice in a stride.
    """
    landings = sum(_landings(foot - foot.min(), cyclic) for foot in heights)
    return landings / (heights.shape[1] * CONTROL_DT) if landings else float("inf")


def _landings(height: NDArray[np.floating], cyclic: bool) -> int:
    """How often a foot lands whose height over its lowest place is (P,) [m]."""
    known = height[(height > LIFTED) | (height < LANDED)]
    lifted = known > LIFTED
    before = np.roll(lifted, 1) if cyclic else np.concatenate([lifted[:1], lifted[:-1]])
    return int((before & ~lifted).sum())
