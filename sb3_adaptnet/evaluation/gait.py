"""The gait of a motion in three figures: how often a foot steps, how high the feet rise, how long both are in the air.

A policy and its clip are measured by the same functions, on link states alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import FEET, LINKS
from adapt_envs.model.soles import TOUCHING, sole_corners
from adapt_envs.motion.clip import FPS, MotionClip
from sb3_adaptnet.evaluation.imitation_error import Reference, local_positions

Floor = Callable[[NDArray[np.floating]], NDArray[np.floating]]
"""Heights (...) [m] of the ground at points (..., 2) [m]."""
_FEET = [LINKS.index(foot) for foot in FEET]
_HIGH = 99
"""Percentile of a foot's height in a stride that counts as its highest."""
_LAGS = range(round(0.25 * FPS), 3 * FPS + 1)
"""Frames after which a stride may repeat: 0.33 to 4 Hz."""
_ALIKE, _AS_GOOD = 0.5, 0.9
"""Correlation from which a stride counts as repeated; the first peak of this share of the best is one stride."""
_PIECE = 4 * FPS
"""Frames of each piece of a long clip that is measured."""
_STRIDE = 17
"""Frames, about half a stride: the root's sway does not count as way when it is seen so seldom."""
_STRAIGHT = 0.9
"""A piece goes straight on if it gets at least this share of its way far."""
_SPEED_RANGE = 0.1
"""Pieces of a long clip count whose speed is this near to the one asked for, relative to it."""


@dataclass(frozen=True)
class Gait:
    """The gait of a motion; all None without a stretch to measure.

    Attributes:
        cadence_hz: strides per second of one foot; None also where nothing repeats.
        foot_height_m: height of a foot's link frame, the ankle, above the ground [m]: the 99th percentile of a stride,
            median over the strides, mean over the feet. A standing foot's is 0.05 m. A foot in the air is measured
            from the straight line between the ground where it left and where it lands: a ditch that it swings over is
            no lift. One high step among many does not count, be it a stumble on uneven ground or a kick now and then.
        flight_share: share of frames in which no corner of a sole is within 1.5 cm of the ground.
    """

    cadence_hz: float | None
    foot_height_m: float | None
    flight_share: float | None


def flat(points: NDArray[np.floating]) -> NDArray[np.floating]:
    """Flat ground at height 0, where clips are."""
    return np.zeros(points.shape[:-1], points.dtype)


def gait_of(
    stretches: Sequence[NDArray[np.float32]],
    soles: NDArray[np.float64] | None = None,
    floor_at: Floor = flat,
    looped: bool = False,
) -> Gait:
    """The gait of a motion.

    Args:
        stretches: link states (T, 15, 13), world frame, of stretches without a jump.
        soles: corners (2, 4, 3) [m] of the soles in the feet's frames; None for the plain character's.
        floor_at: the ground.
        looped: whether each stretch is whole periods of a motion that repeats.
    """
    if not stretches:
        return Gait(None, None, None)
    corners = sole_corners(compile_model()) if soles is None else soles
    feet = [links[:, _FEET] for links in stretches]
    clearance = [clearances(foot, corners, floor_at) for foot in feet]
    heights = [foot_heights(*pair, floor_at) for pair in zip(feet, clearance, strict=True)]
    places = [
        local_positions(links, floor_at(links[:, 0, :2]))[:, _FEET].reshape(len(links), -1) for links in stretches
    ]
    strides_per_second = cadence(places, looped)
    return Gait(
        cadence_hz=strides_per_second,
        foot_height_m=_typical_top(heights, strides_per_second),
        flight_share=float((np.concatenate(clearance) > TOUCHING).all(axis=1).mean()),
    )


def clearances(feet: NDArray[np.float32], soles: NDArray[np.float64], floor_at: Floor = flat) -> NDArray[np.floating]:
    """Heights (T, 2) [m] of the lowest corner of each sole above the ground.

    Args:
        feet: states (T, 2, 13) of their links, world frame.
        soles: corners (2, 4, 3) [m] in the feet's frames.
        floor_at: the ground.
    """
    corners = feet[:, :, None, :3] + rotations.rotate(feet[:, :, None, 3:7], soles[None])
    return np.asarray((corners[..., 2] - floor_at(corners[..., :2])).min(axis=2))


def foot_heights(
    feet: NDArray[np.float32], clearance: NDArray[np.floating], floor_at: Floor = flat
) -> NDArray[np.floating]:
    """Heights (T, 2) [m] of the ankles above the ground that the feet (T, 2, 13) stand on.

    While a foot is in the air, the ground is interpolated over its way between where it left and where it lands.
    """
    ground = np.array(floor_at(feet[..., :2]), np.float64)
    ways = np.cumsum(np.linalg.norm(np.diff(feet[..., :2], axis=0, prepend=feet[:1, :, :2]), axis=2), axis=0)
    for foot, touching in enumerate((clearance <= TOUCHING).T):
        if touching.any():
            way = ways[:, foot]
            ground[:, foot] = np.interp(way, way[touching], ground[touching, foot])
    return np.asarray(feet[..., 2] - ground)


def _typical_top(heights: Sequence[NDArray[np.floating]], cadence_hz: float | None) -> float:
    """Median over strides of the top of heights (T, 2); of whole stretches where nothing repeats."""
    strides = [
        stride
        for height in heights
        for stride in np.array_split(height, max(round(len(height) * (cadence_hz or 0) / FPS), 1))
    ]
    return float(np.median([np.percentile(stride, _HIGH, axis=0) for stride in strides], axis=0).mean())


def cadence(signals: Sequence[NDArray[np.floating]], looped: bool = False) -> float | None:
    """How often per second signals repeat: by the first high peak of their common autocorrelation.

    Of both feet's places relative to the root a step is no repetition: the feet have changed places. Stretches are
    pooled, each for lags of up to half its length, so that short ones help and slow strides are left to long ones.

    Args:
        signals: (T, C) each.
        looped: whether each is whole periods.

    Returns:
        The frequency [Hz]; None if nothing repeats.
    """
    likeness = np.array([_likeness(signals, lag, looped) for lag in _LAGS])
    before, here, after = likeness[:-2], likeness[1:-1], likeness[2:]
    peaks = np.flatnonzero((here >= _ALIKE) & (here > before) & (here >= after))
    if not len(peaks):
        return None
    peak = next(peak for peak in peaks if here[peak] >= _AS_GOOD * here[peaks].max())
    bend = before[peak] - 2 * here[peak] + after[peak]
    lag = _LAGS[1] + peak + (before[peak] - after[peak]) / (2 * bend)  # the top of the parabola through the three
    return float(FPS / lag)


def _likeness(signals: Sequence[NDArray[np.floating]], lag: int, looped: bool) -> float:
    """Correlation of signals (T, C) with themselves `lag` frames later: 1 if they repeat; -1 if all are too short."""
    product = power = 0.0
    for signal in signals:
        centred = signal - signal.mean(axis=0)
        now, later = (centred, np.roll(centred, -lag, axis=0)) if looped else (centred[:-lag], centred[lag:])
        if looped or len(signal) >= 2 * lag:
            product += 2 * float((now * later).sum())
            power += float(np.square(now).sum() + np.square(later).sum())
    return product / power if power > 0 else -1.0


def clip_gait(clip: MotionClip, speed: float, body: mujoco.MjModel | None = None) -> Gait:
    """The gait of a clip: of its period if it repeats, else of its straight stretches of 4 s at about `speed` [m/s].

    As `body` shows it, or the plain character.
    """
    reference = Reference.of(clip, body)
    shown = reference.clip
    pieces = [shown.qpos[: shown.period]] if shown.cyclic else _pieces_at(shown, speed)
    return gait_of([reference.links(piece) for piece in pieces], sole_corners(reference.body), looped=clip.cyclic)


def _pieces_at(clip: MotionClip, speed: float) -> list[NDArray[np.float64]]:
    """Configurations (T, nq) of the pieces of a clip that go at that speed, straight on if any do.

    A turning piece gets less far than it goes: by its ends alone, faster ones that curve would count.
    """
    starts = range(0, max(len(clip.qpos) - _PIECE, 0) + 1, _PIECE)
    pieces = [clip.qpos[start : start + _PIECE] for start in starts]
    gone, got = np.array([_way(piece) for piece in pieces]).T
    straight = got >= _STRAIGHT * gone
    if not straight.any():
        straight[:] = True
    off = np.where(straight, np.abs(gone - speed), np.inf)
    return [piece for piece, d in zip(pieces, off, strict=True) if d <= max(_SPEED_RANGE * speed, off.min())]


def _way(piece: NDArray[np.float64]) -> tuple[float, float]:
    """How far the root goes per second [m/s] along its way, without its sway, and from the first frame to the last."""
    knots = np.linspace(0, len(piece) - 1, max(round(len(piece) / _STRIDE), 1) + 1).round().astype(int)
    seconds = (len(piece) - 1) / FPS
    ways = np.linalg.norm(np.diff(piece[knots, :2], axis=0), axis=1).sum()
    return float(ways / seconds), float(np.linalg.norm(piece[-1, :2] - piece[0, :2]) / seconds)
