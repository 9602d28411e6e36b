"""How often a motion sets its feet down."""

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.world_model.integration import CONTROL_DT

SHORTEST_STRIDE = 9
"""Phases (0.3 s) below which nothing is a stride."""
ALIKE = 0.8
"""How much of the best correlation a shift must have: the first one that has it is a stride."""


def footsteps_per_second(heights: NDArray[np.floating], cyclic: bool) -> float:
    """Footsteps of both feet per second, of a motion whose one foot has heights (P,) [m]; infinite if none are found.

    A stride is the first shift of the motion that looks like the motion; two footsteps make a stride.
    """
    swing = heights - heights.mean()
    longest = len(swing) if cyclic else len(swing) // 2
    shifts = np.arange(SHORTEST_STRIDE, longest + 1)
    if not len(shifts) or not swing.any():
        return float("inf")
    alike = np.array([_correlation(swing, shift, cyclic) for shift in range(SHORTEST_STRIDE - 1, longest + 2)])
    inner, before, after = alike[1:-1], alike[:-2], alike[2:]
    rising, falling = inner >= before, inner >= after
    falling[-1] |= cyclic  # a whole cycle is always a stride, or several
    strides = shifts[rising & falling & (inner > ALIKE * inner.max()) & (inner > 0)]
    return 2 / (float(strides[0]) * CONTROL_DT) if len(strides) else float("inf")


def _correlation(swing: NDArray[np.floating], shift: int, cyclic: bool) -> float:
    first, second = (swing, np.roll(swing, -shift)) if cyclic else (swing[:-shift], swing[shift:])
    return float(first @ second / np.sqrt((first @ first) * (second @ second) + 1e-12))
