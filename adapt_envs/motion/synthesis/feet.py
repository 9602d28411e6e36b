"""Trajectories of the feet: flat on the ground, rolling over heel and toe edge, swinging to the next place."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.soles import sole_edges
from adapt_envs.motion.synthesis.gait import Gait, Kick

Array = NDArray[np.float64]
_FLAT = 0.11
"""Time from heel strike to foot flat [s]: some 12 % of a cycle (Perry)."""


@dataclass(frozen=True)
class FootPath:
    """Where one foot is at T times.

    Attributes:
        ankle: (T, 3) position [m], world.
        yaw, pitch: (T,) direction and slope, toe down positive [rad].
        stretch: (T,) in [0, 1]: how far the knee is straightened beyond what the ankle's place asks for.
    """

    ankle: Array
    yaw: Array
    pitch: Array
    stretch: Array


@dataclass(frozen=True)
class Footsteps:
    """Contacts of the feet with the ground in the order of their beginnings; arrays of length n.

    Attributes:
        side: 0 right, 1 left.
        pos: (n, 2) place of the ankle when the foot is flat [m].
        yaw: direction of the foot [rad].
        on, off: when it touches and leaves the ground [s].
        phase: of the gait cycle when it touches [rad]; whole turns are strikes of the right foot.
    """

    side: NDArray[np.int64]
    pos: Array
    yaw: Array
    on: Array
    off: Array
    phase: Array

    def single(self, k: int) -> tuple[float, float]:
        """When contact k carries alone: from the previous foot's leaving to the next one's strike."""
        begin = max(self.on[k], self.off[k - 1]) if k > 0 else self.on[k]
        end = min(self.off[k], self.on[k + 1]) if k + 1 < len(self.on) else self.off[k]
        return float(begin), float(max(end, begin))


def hermite(u: Array, start: Array, end: Array) -> Array:
    """Quintic with value, slope and curvature `start` (3, ...) at u = 0 and `end` at u = 1, at u (T,): (T, ...)."""
    p0, v0, a0 = start
    p1, v1, a1 = end
    rise, slope, bend = p1 - p0 - v0 - a0 / 2, v1 - v0 - a0, a1 - a0
    c3, c4, c5 = 10 * rise - 4 * slope + bend / 2, -15 * rise + 7 * slope - bend, 6 * rise - 3 * slope + bend / 2
    u = u.reshape(-1, *np.ones(np.ndim(p0), dtype=int))
    return p0 + u * (v0 + u * (a0 / 2 + u * (c3 + u * (c4 + u * c5))))


def bump(u: Array, peak: float = 0.5, sharpness: float = 3.0) -> Array:
    """A smooth hill over u in [0, 1]: 0 with flat ends, 1 at `peak`."""
    rise = sharpness * max(1.0, peak / (1 - peak))
    fall = rise * (1 - peak) / peak
    u = np.clip(u, 0, 1)
    return (u / peak) ** rise * ((1 - u) / (1 - peak)) ** fall


def _pivot(pitch: Array, edge: Array | float) -> tuple[Array, Array]:
    """Ankle ahead of and above its flat-foot place on the ground when the foot rolls about an edge."""
    below = sole_edges().below
    ahead = edge - edge * np.cos(pitch) + below * np.sin(pitch)
    return ahead, edge * np.sin(pitch) + below * np.cos(pitch)


def _stance_pitch(t: Array, on: float, rise: float, off: float, strike: float, push: float) -> Array:
    flat = min(_FLAT, 0.45 * (off - on))
    zero = np.zeros(3)
    u = np.clip((t - on) / flat, 0, 1)
    landing = hermite(u, np.array([-strike, 0, 0]), zero)
    u = np.clip((t - rise) / (off - rise), 0, 1)
    return landing + hermite(u, zero, np.array([push, _PUSH_RATE * push, 0]))


_PUSH_RATE = 1.9
"""Slope of the heel's rise at toe-off, over its mean."""


def foot_path(gait: Gait, steps: Footsteps, side: int, t: Array) -> FootPath:
    """Path of the foot of one side (0 right, 1 left) at times t (T,)."""
    pos, yaw, pitch, stretch = np.zeros((len(t), 3)), np.zeros(len(t)), np.zeros(len(t)), np.zeros(len(t))
    strike, push = np.radians(gait.strike[side]), np.radians(gait.push[side])
    sole, ks = sole_edges(), np.flatnonzero(steps.side == side)
    for order, k in enumerate(ks.tolist()):
        on, off = steps.on[k], steps.off[k]
        begin, end = steps.single(k)
        rise = begin + gait.rise * (end - begin) if end - begin > 0.05 else on + 0.6 * (off - on)
        if off - rise > 0.6:
            rise = off - 0.35
        rows = np.arange(*np.searchsorted(t, [on if order else -np.inf, off if k != ks[-1] else np.inf]))
        pitch[rows] = _stance_pitch(t[rows], on, rise, off, strike * (on > t[0]), push)
        yaw[rows] = steps.yaw[k]
        edge = np.where(pitch[rows] > 0, sole.ahead, -sole.behind)
        ahead, height = _pivot(pitch[rows], edge)
        pos[rows] = _place(steps, k, ahead, height)
        if order + 1 < len(ks):
            rows = np.arange(*np.searchsorted(t, [off, steps.on[ks[order + 1]]]))
            if len(rows):
                swing = _swing(gait, steps, k, int(ks[order + 1]), rise, t[rows])
                pos[rows], yaw[rows], pitch[rows], stretch[rows] = swing.ankle, swing.yaw, swing.pitch, swing.stretch
    return FootPath(pos, yaw, pitch, stretch)


def _place(steps: Footsteps, k: int, ahead: Array, height: Array) -> Array:
    direction = np.array([np.cos(steps.yaw[k]), np.sin(steps.yaw[k])])
    return np.column_stack([steps.pos[k] + ahead[:, None] * direction, height])


def _swing(gait: Gait, steps: Footsteps, k: int, following: int, rise: float, t: Array) -> FootPath:
    side = int(steps.side[k])
    off, on = steps.off[k], steps.on[following]
    span = on - off
    u = (t - off) / span
    strike, push = np.radians(gait.strike[side]), np.radians(gait.push[side])
    rate = _PUSH_RATE * push / (off - rise)
    pitch = hermite(u, np.array([push, rate * span, 0]), np.array([-strike, 0, 0]))
    sole = sole_edges()
    ahead, _ = _pivot(np.array([push]), np.array([sole.ahead]))
    speed = (sole.ahead * np.sin(push) + sole.below * np.cos(push)) * rate
    acc = (sole.ahead * np.cos(push) - sole.below * np.sin(push)) * rate**2
    direction = np.array([np.cos(steps.yaw[k]), np.sin(steps.yaw[k])])
    start = np.stack([steps.pos[k] + ahead * direction, speed * span * direction, acc * span**2 * direction])
    back, _ = _pivot(np.array([-strike]), np.array([-sole.behind]))
    landing = steps.pos[following] + back * np.array([np.cos(steps.yaw[following]), np.sin(steps.yaw[following])])
    braking = -gait.braking * span**2 * np.tanh(np.linalg.norm(landing - steps.pos[k])) * _unit(landing - steps.pos[k])
    xy = hermite(u, start, np.stack([landing, np.zeros(2), braking]))
    turn = hermite(u, np.array([steps.yaw[k], 0, 0]), np.array([steps.yaw[following], 0, 0]))
    outward = np.column_stack([np.sin(turn), -np.cos(turn)]) * (1 - 2 * side)
    xy += gait.outward * bump(u)[:, None] * outward
    kicks = gait.kick[side] if following > k + 1 else ()  # none while the same foot hops
    pitch, xy, lift = _detours(kicks, u, pitch, xy, turn - np.radians(gait.toe_out) * (2 * side - 1))
    height = gait.clearance * bump(u, 0.5, 2.5) + lift + _lowest(pitch, 0.02 * bump(u))
    straight = sum((kick.stretch * bump(u, kick.peak, kick.sharpness) for kick in kicks), np.zeros_like(u))
    return FootPath(np.column_stack([xy, height]), turn, pitch, straight)


def _unit(vector: Array) -> Array:
    return vector / max(float(np.linalg.norm(vector)), 1e-9)


def _detours(kicks: tuple[Kick, ...], u: Array, pitch: Array, xy: Array, yaw: Array) -> tuple[Array, Array, Array]:
    lift = np.zeros_like(u)
    for kick in kicks:
        hill = bump(u, kick.peak, kick.sharpness)
        pitch = pitch + np.radians(kick.pitch) * hill
        xy = xy + kick.forward * hill[:, None] * np.column_stack([np.cos(yaw), np.sin(yaw)])
        lift += kick.up * hill
    return pitch, xy, lift


def _lowest(pitch: Array, softness: Array) -> Array:
    """Height of the ankle over the foot's lowest edge (T,), with the change from toe to heel rounded off."""
    below, toe, heel = sole_edges()
    s = np.sin(pitch)
    return below * np.cos(pitch) + ((toe - heel) * s + np.sqrt(((toe + heel) * s) ** 2 + softness**2)) / 2
