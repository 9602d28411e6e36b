"""Feet on the ground: finds when a foot stands, puts it there and keeps it from sliding."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import FEET
from adapt_envs.model.soles import sole_corners
from adapt_envs.motion.clip import FPS
from adapt_envs.motion.gaits.draft import Array, Draft

_NEAR = 0.04
"""Height [m] of the lowest corner below which a slow foot stands."""
_SLOW = 0.6
"""Speed [m/s] of that corner below which a low foot stands."""
_SHORTEST, _LONGEST_GAP = 3, 2
"""Frames: shorter stances are dropped, shorter gaps between two are closed."""
_RAMP = 4
"""Frames over which a stance's correction of height fades in and out."""
_CLEARANCE, _CLEAR_FRAMES = 0.018, 1
"""Height [m] of a swinging foot's lowest corner at least, from this many frames away from its stances."""
_MOST_DRIFT = 0.35
"""A stance that slides farther [m] is meant to slide."""
_GROUND_QUANTILE = 0.15
"""Share of the frames whose lowest point may lie below the ground, before each is lifted by itself."""


def corners_in_world(pos: Array, quat: Array) -> Array:
    """Corners (T, 2, 4, 3) [m] of the soles of feet at `pos` (T, 2, 3), turned by `quat` (T, 2, 4)."""
    return rotations.placed(pos, quat, sole_corners(plain_model()))


def grounded(draft: Draft) -> Draft:
    """The draft moved up or down as a whole so that its feet stand on z = 0."""
    lowest = corners_in_world(draft.foot_pos, draft.foot_quat)[..., 2].min(axis=(1, 2))
    return draft.moved(np.array([0.0, 0.0, -np.quantile(lowest, _GROUND_QUANTILE)]))


def planted(draft: Draft, clean: bool = False) -> Draft:
    """The draft with foot targets that neither sink, float nor slide while they stand; the rest stays.

    Args:
        draft: a motion.
        clean: whether its swings are right as they are: then only stances change, so that flights of two frames stay
            flights.
    """
    ramp, clearance = (1, 0.0) if clean else (_RAMP, _CLEARANCE)
    pos = draft.foot_pos.copy()
    for side in range(len(FEET)):
        corners = corners_in_world(pos, draft.foot_quat)[:, side]
        stances = _runs(standing(corners))
        pos[:, side, :2] += _held(corners, stances)
        pos[:, side, 2] += _levelled(corners[..., 2].min(axis=1), stances, ramp, clearance)
    return replace(draft, foot_pos=pos)


def standing(corners: Array) -> NDArray[np.bool_]:
    """Frames (T,) in which a foot with these sole corners (T, 4, 3) stands: its lowest corner is low and slow."""
    heights = corners[..., 2]
    lowest = heights.argmin(axis=1)
    rows = np.arange(len(corners))
    velocity = np.gradient(corners, axis=0)[rows, lowest] * FPS
    mask = (heights.min(axis=1) < _NEAR) & (np.linalg.norm(velocity, axis=1) < _SLOW)
    for first, last in _runs(~mask):
        if last - first < _LONGEST_GAP and first > 0 and last < len(mask) - 1:
            mask[first : last + 1] = True
    for first, last in _runs(mask):
        if last - first + 1 < _SHORTEST:
            mask[first : last + 1] = False
    return mask


def _runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of each stretch of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


def _held(corners: Array, stances: list[tuple[int, int]]) -> Array:
    """Shift (T, 2) [m] that takes the sliding out of each stance and is spread over the swings between them.

    The foot may roll: from frame to frame it is the lowest corner that has to stay.
    """
    lowest = corners[..., 2].argmin(axis=1)
    times, shifts = [], []
    for first, last in stances:
        rows = np.arange(first, last)
        steps = corners[rows + 1, lowest[rows], :2] - corners[rows, lowest[rows], :2]
        slid = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
        if np.linalg.norm(slid[-1]) < _MOST_DRIFT:
            times.append(np.arange(first, last + 1))
            shifts.append(slid.mean(axis=0) - slid)
    if not times:
        return np.zeros((len(corners), 2))
    known, values = np.concatenate(times), np.concatenate(shifts)
    return np.stack([_eased(np.arange(len(corners)), known, values[:, axis]) for axis in (0, 1)], axis=1)


def _eased(rows: NDArray[np.integer], known: NDArray[np.integer], values: Array) -> Array:
    """Interpolation that leaves and reaches the known values without a jolt (a smooth step between neighbours)."""
    after = np.clip(np.searchsorted(known, rows), 1, len(known) - 1) if len(known) > 1 else np.zeros(len(rows), int)
    before = np.maximum(after - 1, 0)
    span = np.maximum(known[after] - known[before], 1)
    share = np.clip((rows - known[before]) / span, 0, 1)
    share = share * share * (3 - 2 * share)
    return values[before] * (1 - share) + values[after] * share


def _levelled(lowest: Array, stances: list[tuple[int, int]], ramp: int, clearance: float) -> Array:
    """Change of height (T,) [m] of a foot whose lowest corner is at `lowest`.

    Down (or up) to the ground in a stance, fading over `ramp` frames; clear of the ground between stances.
    """
    frames = np.arange(len(lowest))
    away = np.full(len(lowest), float(len(lowest)))
    for first, last in stances:
        away = np.minimum(away, np.maximum(np.maximum(first - frames, frames - last), 0))
    down = -np.clip(1 - away / ramp, 0, 1) * np.maximum(lowest, 0)
    clear = clearance * np.clip(away / _CLEAR_FRAMES, 0, 1)
    return np.maximum(down, clear - lowest)
