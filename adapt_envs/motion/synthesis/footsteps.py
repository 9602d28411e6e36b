"""Where and when the feet touch the ground: along a path, or again and again straight ahead."""

import numpy as np
from numpy.typing import NDArray

from adapt_envs.motion.clip import FPS
from adapt_envs.motion.synthesis.feet import Footsteps
from adapt_envs.motion.synthesis.gait import Gait
from adapt_envs.motion.synthesis.path import Path

Array = NDArray[np.float64]
_STILL = 0.16
"""Below this speed the character stands [m/s]."""
_SWING_TURN = np.radians(70)
"""Largest difference of yaw between consecutive feet."""


def cyclic_steps(gait: Gait, repeats: int) -> Footsteps:
    """Contacts of `repeats` periods of a style, straight ahead along x; the first strike is the right foot's."""
    half = gait.frames / FPS / gait.cycles / 2
    n = 2 * gait.cycles * repeats + 2
    side = np.arange(n) % 2
    lasts = half * np.array(gait.share)[side]
    on = np.r_[0, np.cumsum(lasts)[:-1]]
    length = np.array(gait.length)[side]
    sign = 2.0 * side - 1
    pos = np.column_stack([np.cumsum(length), sign * gait.width / 2])
    yaw = np.radians(gait.toe_out) * sign
    off = _offs(on, np.full(n, gait.double) * lasts)
    return Footsteps(side, pos, yaw, on, off, _phases(n))


def skipping_steps(gait: Gait, repeats: int) -> Footsteps:
    """Contacts of a skip: each foot steps, hops and lands on itself, then the other one steps.

    A foot's two places lie where the body is in the middle of its two times on the ground.
    """
    if gait.hop is None:
        raise ValueError(f"gait {gait.name!r} has no hop")
    half = gait.frames / FPS / gait.cycles / 2
    overlap, hop_off, hop_on = gait.double * half, gait.hop[0] * half, gait.hop[1] * half
    halves = np.arange(2 * gait.cycles * repeats + 2)
    start = halves * half
    on = np.column_stack([start, start + hop_on]).ravel()
    off = np.column_stack([start + hop_off, start + half + overlap]).ravel()
    side = np.repeat(halves % 2, 2)
    sign = 2.0 * side - 1
    middle = np.column_stack([start + (overlap + hop_off) / 2, start + (hop_on + half) / 2]).ravel()
    speed = sum(gait.length) / 2 / half
    pos = np.column_stack([speed * middle, sign * gait.width / 2])
    return Footsteps(side, pos, np.radians(gait.toe_out) * sign, on, off, np.pi * on / half)


def _phases(n: int) -> Array:
    """Phase at the strikes of alternating feet, the right one's first."""
    return np.asarray(np.pi * np.arange(n), dtype=np.float64)


def _offs(on: Array, overlap: Array) -> Array:
    """When contacts end: `overlap` [s] after the next one's beginning."""
    off = np.r_[on[1:] + overlap[:-1], 0.0]
    off[-1] = on[-1] + (off[-2] - on[-2])
    return off


def path_steps(gait: Gait, path: Path, seed: int, walking: bool) -> Footsteps:
    """Contacts along a path with human variation in timing, length and width (2.5 %, 3.5 %, 16 %)."""
    rng = np.random.default_rng(seed)
    on, lifts = _timing(path, rng, walking)
    n = len(on)
    off = np.r_[lifts[2:], on[-1] + 0.1, on[-1] + 0.6] if walking else _run_offs(path, on)
    side = np.arange(n) % 2
    sign = 2.0 * side - 1
    begin = np.r_[on[0], off[:-1]] if walking else on
    end = np.r_[on[1:], off[-1]] if walking else off
    middle = (begin + np.maximum(end, begin)) / 2
    around = middle[:, None] + np.linspace(-0.14, 0.14, 9)
    place = path.at(path.carry, around).mean(axis=1)
    heading = path.at(path.heading, middle)
    ahead = np.column_stack([np.cos(heading), np.sin(heading)])
    left = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    wide = sign * gait.width / 2 * (1 + 0.16 * rng.standard_normal(n))
    stride = 0.035 * rng.standard_normal(n) * path.at(path.speed, middle) * 0.5
    pos = place + (stride - np.mean(gait.roll))[:, None] * ahead + wide[:, None] * left
    yaw = heading + np.radians(gait.toe_out + 2 * rng.standard_normal(n)) * sign
    for k in range(1, n):
        yaw[k] = yaw[k - 1] + np.clip(yaw[k] - yaw[k - 1], -_SWING_TURN, _SWING_TURN)
        pos[k] = _within_step(pos[k - 1], pos[k], (yaw[k - 1], yaw[k]), sign[k], walking)
    return Footsteps(side, pos, yaw, on, off, _phases(n))


def _within_step(before: Array, pos: Array, yaws: tuple[float, float], sign: float, walking: bool) -> Array:
    """The place moved to where a leg can step without crossing or touching the other one."""
    yaw = (yaws[0] + yaws[1]) / 2
    ahead = np.array([np.cos(yaw), np.sin(yaw)])
    left = np.array([-ahead[1], ahead[0]])
    step = pos - before
    longest, narrow = (0.8, 0.105) if walking else (1.5, 0.05)
    far = np.clip(step @ ahead, -0.25, longest)
    # Feet side by side need room for heels and toes that point at each other.
    beside = max(0.0, 1 - abs(far) / 0.25)
    narrow += beside * (0.02 + 0.1 * abs(np.sin(yaws[1] - yaws[0])))
    wide = np.clip(step @ left * sign, narrow, 0.36)
    return before + far * ahead + wide * sign * left


def _timing(path: Path, rng: np.random.Generator, walking: bool) -> tuple[Array, Array]:
    """Strikes, and for each the moment at which its swing began."""
    on, lift, still = [0.0], [-0.3], False
    time = 0.0
    while time < path.t[-1] - 1.0:
        speed = float(path.at(path.speed, time + 0.25))
        turning = min(1.0, abs(float(path.at(path.rate, time + 0.25))) / np.radians(90))
        lasts = (_walk_step(speed, turning) if walking else _run_step(speed)) * (1 + 0.025 * rng.standard_normal())
        if walking and speed < _STILL and turning < 0.2 and still:
            going = np.flatnonzero((path.t > time) & ((path.speed > _STILL) | (np.abs(path.rate) > 0.4)))
            if not len(going):
                break
            time, lasts, still = max(time, float(path.t[going[0]]) - 0.2), 0.62, False
        elif speed < _STILL and turning < 0.2:
            still = True
        else:
            still = False
        time += lasts
        on.append(time)
        lift.append(time - lasts * (1 - np.clip(0.30 - 0.085 * speed, 0.16, 0.27)))
    return np.array(on), np.array(lift)


def _walk_step(speed: float, turning: float) -> float:
    """Step time [s] by the walk ratio (0.005 m per step/min for legs of 0.88 m), brisker in turns."""
    plain = float(np.clip(0.55 / np.sqrt(max(speed, 0.1)), 0.43, 0.72))
    return plain + turning * (min(plain, 0.45) - plain)


def _run_step(speed: float) -> float:
    """Step time [s]: 158 to 176 steps a minute."""
    return float(np.clip(0.385 - 0.013 * speed, 0.33, 0.38))


def _run_offs(path: Path, on: Array) -> Array:
    """Ends of running stances: flights of 0.06 s at 1 m/s to 0.12 s at 3 m/s."""
    flight = np.clip(0.035 + 0.03 * path.at(path.speed, on), 0.06, 0.125)
    off = np.r_[on[1:], on[-1] + 0.36] - flight
    return off
