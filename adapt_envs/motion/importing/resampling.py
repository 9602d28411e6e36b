"""A draft at the character's frame rate."""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from adapt_envs.motion.clip import FPS
from adapt_envs.motion.gaits.draft import Array, Draft


def resampled(draft: Draft, frame_time: float) -> Draft:
    """The draft at 30 Hz, from frames `frame_time` seconds apart; what is faster than 30 Hz shows is smoothed first."""
    times = np.arange(len(draft)) * frame_time
    wanted = np.arange(int(np.floor(times[-1] * FPS + 1e-6)) + 1) / FPS
    if abs(frame_time * FPS - 1) < 1e-6 or len(draft) < 4:
        return draft
    width = max(1, round(1 / (FPS * frame_time) / 2)) if frame_time * FPS < 0.75 else 0
    wanted = np.minimum(wanted, times[-1])

    def linear(values: Array) -> Array:
        return CubicSpline(times, _smoothed(values, width))(wanted)

    def turning(quats: Array) -> Array:
        steady = _smoothed(continuous(quats), width)
        rotation = Rotation.from_quat(np.roll(steady, -1, axis=-1))
        return np.roll(Slerp(times, rotation)(wanted).as_quat(), 1, axis=-1)

    qpos = np.concatenate([linear(draft.qpos[:, :3]), turning(draft.qpos[:, 3:7]), linear(draft.qpos[:, 7:])], axis=1)
    quats = np.stack([turning(draft.foot_quat[:, side]) for side in (0, 1)], axis=1)
    return Draft(qpos, linear(draft.foot_pos), quats)


def continuous(quats: Array) -> Array:
    """The same rotations (T, 4) with signs chosen so that neighbours lie on the same side."""
    flips = np.sign(np.sum(quats[1:] * quats[:-1], axis=-1))
    flips = np.concatenate([[1.0], np.cumprod(np.where(flips == 0, 1.0, flips))])
    return quats * flips[:, None]


def _smoothed(values: Array, half_width: int) -> Array:
    """Mean over 2 * half_width + 1 frames with triangular weights; the ends repeat."""
    if half_width == 0:
        return values
    kernel = np.bartlett(2 * half_width + 3)[1:-1]
    padded = np.concatenate([np.repeat(values[:1], half_width, 0), values, np.repeat(values[-1:], half_width, 0)])
    kernel = kernel / kernel.sum()
    shifted = np.stack([padded[i : i + len(values)] for i in range(len(kernel))])
    return np.tensordot(kernel, shifted, axes=1)
