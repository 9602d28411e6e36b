"""Dynamic time warping with open ends: which frame of a reference each frame of a motion is like.

The reference may run faster or slower, within bounds that hold everywhere and not only on average: a *leap* skips one
frame of it, a *rest* stays on one for two frames, and each of them belongs to a stretch of frames that step one by one.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_ROUNDING = 1e-9
"""So that 1 / (1 - 2/3) is 3."""


class _Move(NamedTuple):
    """A piece of a path: so many frames of the motion against so many of the reference, one by one but for the first.

    The reference goes one frame further than the motion in a leap, and one less in a rest.
    """

    motion: int
    reference: int


def match(cost: NDArray[np.floating], slowest: float = 0.5, fastest: float = 2.0) -> NDArray[np.int64]:
    """The cheapest monotonous match of all frames of a motion to a stretch of a reference, wherever it lies.

    In a rest both frames of the motion are matched to the one frame of the reference, so that every frame of the motion
    is matched, and paid for, exactly once: otherwise a path would be cheap merely because it leaves out frames.

    Args:
        cost: (T, R) cost of matching frame t of the motion to frame r of the reference.
        slowest: least tempo of the reference, in [0.5, 1): at most one rest in 1 / (1 - slowest) frames.
        fastest: highest tempo of the reference, in (1, 2]: at most one leap in 1 / (fastest - 1) frames.

    Returns:
        (T,) matched frames of the reference, never falling.

    Raises:
        ValueError: if the reference is too short to be run through that slowly.
    """
    leap, rest = (math.ceil(1 / change - _ROUNDING) for change in (fastest - 1, 1 - slowest))
    frames, length = cost.shape
    if length < frames - frames // rest:
        raise ValueError(f"{frames} frames cannot be matched to {length} at a tempo of {slowest:g} or more")
    moves = (_Move(1, 1), _Move(leap, leap + 1), _Move(rest, rest - 1))
    total, chosen = _cheapest(np.asarray(cost, np.float64), moves)
    return _path(chosen, int(total.argmin()), moves)


def _cheapest(cost: NDArray[np.float64], moves: tuple[_Move, ...]) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Cheapest totals (R,) of paths by their last reference frame, and the last move (T + 1, R) of all cheapest paths.

    Row t of the tables stands for paths over the first t frames of the motion; a path may begin anywhere.
    """
    frames, length = cost.shape
    total, along = np.full((frames + 1, length), np.inf), np.zeros((frames + 1, length))
    chosen = np.zeros((frames + 1, length), np.uint8)
    for t in range(1, frames + 1):
        along[t] = cost[t - 1] + _moved(along[t - 1], 1, 0.0)  # sums along the diagonal
        choices = np.full((len(moves), length), np.inf)
        for choice, move in zip(choices, moves, strict=True):
            begins = t == move.motion
            if t < move.motion or (begins and move.reference > move.motion):
                continue
            diagonal = min(move)
            choice[:] = along[t] - _moved(along[t - diagonal], diagonal, 0.0)
            choice += 0.0 if begins else _moved(total[t - move.motion], move.reference, np.inf)
            if move.reference < move.motion:
                choice += _moved(cost[t - move.motion], move.reference - 1, np.inf)
        chosen[t] = choices.argmin(axis=0)
        total[t] = choices.min(axis=0)
    return total[frames], chosen


def _moved(row: NDArray[np.float64], by: int, fill: float) -> NDArray[np.float64]:
    """The row (R,) moved `by` entries to the right."""
    out = np.full(len(row), fill)
    out[by:] = row[: max(len(row) - by, 0)]
    return out


def _path(chosen: NDArray[np.uint8], last: int, moves: tuple[_Move, ...]) -> NDArray[np.int64]:
    """Walk back from reference frame `last`."""
    t, r = len(chosen) - 1, last
    matched = np.empty(t, np.int64)
    while t > 0:
        motion, reference = moves[int(chosen[t, r])]
        matched[t - motion : t] = np.maximum(np.arange(r - motion + 1, r + 1), r - reference + 1)
        t, r = t - motion, r - reference
    return matched
