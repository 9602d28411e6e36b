"""One gait cycle cut out of a motion and closed, so that it repeats without a seam, straight along x."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.motion.clip import FPS, MotionError
from adapt_envs.motion.gaits.draft import Array, Draft

_SHORTEST, _LONGEST = int(0.4 * FPS), int(3.0 * FPS)
"""Frames of a cycle."""
_VELOCITY_WEIGHT = 3.0
"""Frames: a difference in speed counts as the difference in pose it makes in this time."""
_SWING_SHARE = 0.3
"""Share of the feet's whole travel that each must be ahead of the other within a cycle."""
_SLOW_SHARE = 0.33
"""The same where a speed is asked for, in what it is otherwise."""
_SPEED_RANGE = 0.08
"""Share of a speed by which a cycle's may differ from it."""
_LENGTH_PENALTY = 0.15
"""Price of a second of length: of cycles that close alike the shortest is taken."""
_MOST_GAP = 0.35
"""Mean difference [rad] between first and last frame beyond which nothing repeats."""
_MOST_TURN = np.radians(25)
"""Turning within a cycle that may be straightened."""
_LITTLE_TURN = np.radians(4)
"""The same of a cycle out of minutes, where there is a choice: what is straightened lets the feet slide."""


@dataclass(frozen=True)
class Cycle:
    """A stretch of a draft: frames `first` to `first + period`, the last of which is like the first."""

    first: int
    period: int


def find_cycle(draft: Draft, speed: float | None = None) -> Cycle:
    """The stretch of 0.4 to 3 s that best closes into a loop, with a step of either foot.

    Args:
        draft: the motion.
        speed: about how fast it shall travel [m/s]; None for any speed.

    Raises:
        MotionError: if the motion holds no gait cycle.
    """
    poses = _poses(draft)
    separation = _separation(draft)
    low, high = np.percentile(separation, [3, 97])
    # Of slow steps in a motion of many speeds, a third of the fast steps' reach is enough.
    middle, reach = (low + high) / 2, _SWING_SHARE * (high - low) * (1.0 if speed is None else _SLOW_SHARE)
    best: tuple[float, Cycle] | None = None
    if high - low > 0.1:
        turn = np.unwrap(rotations.heading(draft.qpos[:, 3:7]))
        for period in range(_SHORTEST, min(_LONGEST, len(draft) - 1) + 1):
            cost = np.abs(poses[period:] - poses[:-period]).mean(axis=1)
            windows = np.lib.stride_tricks.sliding_window_view(separation, period + 1)
            steps = (windows.max(axis=1) > middle + reach) & (windows.min(axis=1) < middle - reach)
            straight = np.abs(turn[period:] - turn[:-period]) < (_MOST_TURN if speed is None else _LITTLE_TURN)
            fit = steps & straight & (cost < _MOST_GAP) & _at_speed(draft, period, speed)
            cost = np.where(fit, cost * (1 + _LENGTH_PENALTY * period / FPS), np.inf)
            first = int(cost.argmin())
            if np.isfinite(cost[first]) and (best is None or cost[first] < best[0]):
                best = float(cost[first]), Cycle(first, period)
    if best is None:
        at = "" if speed is None else f" at {speed:.2f} m/s"
        raise MotionError(
            f"no gait cycle of {_SHORTEST / FPS:.1f} to {_LONGEST / FPS:.1f} s{at}, straight and with a step of"
            f" each foot, was found in {(len(draft) - 1) / FPS:.2f} s of motion"
        )
    return best[1]


def _at_speed(draft: Draft, period: int, speed: float | None) -> NDArray[np.bool_]:
    """Which stretches (T - period,) of the draft travel at about a speed [m/s]; all of them at None."""
    travel = np.linalg.norm(draft.qpos[period:, :2] - draft.qpos[:-period, :2], axis=1)
    if speed is None:
        return np.ones(len(travel), np.bool_)
    return np.abs(travel * FPS / period - speed) < _SPEED_RANGE * speed


def closed(draft: Draft, cycle: Cycle) -> Draft:
    """The cycle alone, starting above the origin, its end made equal to its start but for a distance along x.

    What the ends differ by is taken out evenly over the cycle: turning, tilt, height, joint angles, feet.
    """
    part = draft.rows(slice(cycle.first, cycle.first + cycle.period + 1))
    start = part.qpos[0, :3] * (1, 1, 0)
    part = part.moved(-start)
    share = np.linspace(0, 1, len(part))
    turn = rotations.heading(part.qpos[-1, 3:7]) - rotations.heading(part.qpos[0, 3:7])
    part = part.turned(-rotations.wrapped(turn) * share)
    part = part.moved(np.outer(share, [0, 0, part.qpos[0, 2] - part.qpos[-1, 2]]))
    travel = part.qpos[-1, :2] - part.qpos[0, :2]
    course = np.arctan2(travel[1], travel[0]) if np.hypot(*travel) > 0.1 else rotations.heading(part.qpos[0, 3:7])
    return _joined(part.turned(-float(course)), share)


def _joined(part: Draft, share: Array) -> Draft:
    """Limbs and feet of the last frame brought to the first's."""
    root = part.qpos[:, :3]
    qpos = part.qpos.copy()
    qpos[:, 3:7] = _turned_into(part.qpos[:, 3:7], share)
    qpos[:, 7:] += np.outer(share, qpos[0, 7:] - qpos[-1, 7:])
    feet = part.foot_pos - root[:, None]
    feet = feet + share[:, None, None] * (feet[0] - feet[-1]) + root[:, None]
    quats = np.stack([_turned_into(part.foot_quat[:, side], share) for side in (0, 1)], axis=1)
    return Draft(qpos, feet, quats)


def repeated(part: Draft, times: int) -> Draft:
    """A closed cycle of T frames run through several times: (T - 1) * times + 1 frames."""
    step = (part.qpos[-1, :3] - part.qpos[0, :3]) * (1, 1, 0)
    body = part.rows(slice(0, -1))
    pieces = [body.moved(step * i) for i in range(times)] + [part.rows(slice(0, 1)).moved(step * times)]
    parts = zip(*((piece.qpos, piece.foot_pos, piece.foot_quat) for piece in pieces), strict=True)
    return Draft(*(np.concatenate(part) for part in parts))


def _turned_into(quats: Array, share: Array) -> Array:
    """Orientations (T, 4), turned gradually so that the last equals the first."""
    rest = rotations.positive(rotations.multiply(rotations.conjugate(quats[-1]), quats[0]))
    sine = np.linalg.norm(rest[1:])
    axis = rest[1:] / max(sine, np.finfo(np.float64).tiny)
    return rotations.multiply(quats, rotations.from_axis_angle(axis, share * 2 * np.arctan2(sine, rest[0])))


def _poses(draft: Draft) -> Array:
    """What must agree between the ends of a cycle (T, D): posture and its speed; neither place nor heading."""
    upright = rotations.multiply(rotations.from_yaw(-rotations.heading(draft.qpos[:, 3:7])), draft.qpos[:, 3:7])
    tilt = 2 * rotations.positive(upright)[:, 1:3]
    posture = np.concatenate([draft.qpos[:, 7:], tilt, 2 * draft.qpos[:, 2:3]], axis=1)
    return np.concatenate([posture, _VELOCITY_WEIGHT * np.gradient(posture, axis=0)], axis=1)


def _separation(draft: Draft) -> Array:
    """How far the right foot is ahead of the left one (T,) [m]."""
    ahead = rotations.rotate(rotations.from_yaw(rotations.heading(draft.qpos[:, 3:7])), np.array([[1.0, 0, 0]]))
    return np.sum((draft.foot_pos[:, 0] - draft.foot_pos[:, 1]) * ahead, axis=1)
