"""Dynamic time warping with open ends: which frame of a reference each frame of a motion is like."""

import numpy as np
from numpy.typing import NDArray

_NONE, _DIAGONAL, _FAST, _SLOW = range(4)
_BACK = {_DIAGONAL: (1, 1), _FAST: (1, 2), _SLOW: (2, 1)}
"""Steps as (frames of the motion, frames of the reference)."""


def match(cost: NDArray[np.floating]) -> NDArray[np.int64]:
    """The cheapest monotonous match of all frames of a motion to a stretch of a reference, wherever it lies.

    Steps are (1, 1), (1, 2) and (2, 1): the reference runs at half to double speed. In a step (2, 1) both frames of the
    motion are matched to the one frame of the reference, so that every frame of the motion is matched, and paid for,
    exactly once: otherwise a path would be cheap merely because it leaves out frames.

    Args:
        cost: (T, R) cost of matching frame t of the motion to frame r of the reference.

    Returns:
        (T,) matched frames of the reference, never falling.

    Raises:
        ValueError: if the reference is too short, R < T / 2.
    """
    frames, length = cost.shape
    if 2 * length < frames:
        raise ValueError(f"{frames} frames cannot be matched to {length}, which is less than half of them")
    total = np.full((frames + 1, length), np.inf)
    total[0] = 0
    step = np.zeros((frames + 1, length), np.uint8)
    for t in range(1, frames + 1):
        total[t], step[t] = _next_row(total, cost, t)
    return _path(step, int(total[frames].argmin()))


def _next_row(
    total: NDArray[np.float64], cost: NDArray[np.floating], t: int
) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Cheapest totals of paths over the first `t` frames of the motion, by their last reference frame, and last steps.

    Row 0 stands for "nothing matched yet": with open ends a path may begin anywhere, by any of the steps.
    """
    here = cost[t - 1]
    choices = np.full((4, len(here)), np.inf)
    if t == 1:
        choices[_DIAGONAL] = here
    else:
        choices[_DIAGONAL, 1:] = total[t - 1, :-1] + here[1:]
        choices[_FAST, 2:] = total[t - 1, :-2] + here[2:]
        before = total[t - 2] if t == 2 else np.concatenate([[np.inf], total[t - 2, :-1]])
        choices[_SLOW] = before + cost[t - 2] + here
    best = choices.argmin(axis=0)
    return choices[best, np.arange(len(here))], best.astype(np.uint8)


def _path(step: NDArray[np.uint8], last: int) -> NDArray[np.int64]:
    """Walk back from reference frame `last`."""
    t, r = len(step) - 1, last
    matched = np.empty(t, np.int64)
    while t > 0:
        frames, back = _BACK[int(step[t, r])]
        matched[t - frames : t] = r
        t, r = t - frames, r - back
    return matched
