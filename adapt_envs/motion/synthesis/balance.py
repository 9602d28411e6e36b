"""From footsteps to a centre of mass that they can carry.

The zero-moment point p rolls through the stance foot and crosses over in double support; the centre of mass x obeys
x'' = f / z (x - p) (linear inverted pendulum; f = g + z'' the vertical force per mass), which is solved as a boundary
value problem: the one solution that stays bounded. In flight f = 0, so the same equation makes it ballistic.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.linalg import solve_banded
from scipy.ndimage import gaussian_filter1d

from adapt_envs.model.soles import sole_edges
from adapt_envs.motion.dynamics import GRAVITY
from adapt_envs.motion.synthesis.feet import Footsteps, hermite
from adapt_envs.motion.synthesis.gait import Gait
from adapt_envs.motion.synthesis.legs import REACH

Array = NDArray[np.float64]
_SETTLE = 0.35
"""Time to bring the weight to the middle when the character stops [s]."""


def zmp_plan(gait: Gait, steps: Footsteps, t: Array) -> Array:
    """Planned zero-moment point (T, 2) [m] at times t (T,) [s], evenly spaced."""
    times, points = [], []
    for k in range(len(steps.on)):
        begin, end = steps.single(k)
        for moment, ahead in ((begin, gait.roll[0]), (begin + 0.75 * (end - begin), gait.roll[1]), (end, gait.roll[1])):
            times.append(moment)
            points.append(_under(gait, steps, k, ahead))
        if k + 1 < len(steps.on) and steps.off[k] - steps.on[k + 1] > 3 * _SETTLE:
            middle = (_under(gait, steps, k, 0.045) + _under(gait, steps, k + 1, 0.045)) / 2
            times += [steps.on[k + 1] + _SETTLE, steps.off[k] - _SETTLE]
            points += [middle, middle]
    order = np.argsort(times, kind="stable")
    knots, values = np.array(times)[order], np.array(points)[order]
    plan = np.column_stack([np.interp(t, knots, column) for column in values.T])
    return gaussian_filter1d(plan, 0.022 / (t[1] - t[0]), axis=0, mode="nearest")


def _under(gait: Gait, steps: Footsteps, k: int, ahead: float) -> Array:
    c, s = np.cos(steps.yaw[k]), np.sin(steps.yaw[k])
    inward = gait.inset * (1 if steps.side[k] == 0 else -1)
    return steps.pos[k] + ahead * np.array([c, s]) + inward * np.array([-s, c])


def height_plan(gait: Gait, steps: Footsteps, t: Array) -> Array:
    """Planned height of the pelvis (T,) [m]: low in double support, high in mid-stance, or ballistic in flights."""
    gaps = steps.on[1:] - steps.off[:-1]
    if (gaps > 0.02).any():
        return _ballistic(gait, steps, t)
    lengths = np.linalg.norm(np.diff(steps.pos, axis=0), axis=1)
    low = strike_height(lengths) - gait.crouch
    times = [t[0] - 1.0]
    heights = [low[0]]
    for k in range(1, len(steps.on)):
        times.append((steps.on[k] + min(steps.off[k - 1], steps.on[k] + 0.3)) / 2)
        heights.append(low[k - 1])
        begin, end = steps.single(k)
        if steps.off[k - 1] - steps.on[k] > 1.2:
            times.append((steps.on[k] + steps.off[k - 1]) / 2)
            heights.append(_STANDING - gait.crouch)
        if k + 1 < len(steps.on) and end > begin:
            following = low[min(k, len(low) - 1)]
            lasts = (steps.on[k + 1] - steps.on[k - 1]) / 2
            possible = 2 * gait.surge * GRAVITY * (lasts / (2 * np.pi)) ** 2
            rise = min(gait.bob, possible)
            times.append((begin + end) / 2)
            heights.append(min((low[k - 1] + following) / 2 + rise, _STANDING - gait.crouch))
    spline = CubicSpline(np.array(times) + gait.bob_shift * np.median(np.diff(steps.on)), heights)
    return spline(np.clip(t, times[0], times[-1]))


_STANDING = 0.874
"""Highest pelvis [m]: standing with the knees a little bent."""


def strike_height(length: Array) -> Array:
    """Height of the pelvis (n,) [m] at which a leg reaches a heel strike after a step of `length` (n,) [m]."""
    sole = sole_edges().below
    return np.minimum(sole + 0.01 + np.sqrt((0.9985 * REACH) ** 2 - (0.5 * length + _LEAD) ** 2), _STANDING)


_LEAD = 0.042
"""By how much the foot strikes farther ahead of the hip than half a step [m]: it does so before mid-step."""


def _ballistic(gait: Gait, steps: Footsteps, t: Array) -> Array:
    """Height with flights: free fall between contacts, a parabola of force (zero at its ends) during them."""
    begins, ends, firsts = _supports(steps)
    level = _landing_heights(steps, begins, ends, firsts) - gait.crouch
    flight = np.r_[0.1, begins[1:] - ends[:-1], 0.1]
    climb = np.r_[0, np.diff(level), 0] / flight
    height = np.full(len(t), level[-1])
    for i, (begin, end) in enumerate(zip(begins, ends, strict=True)):
        span = end - begin
        rows = np.arange(*np.searchsorted(t, [begin, end]))
        down, up = climb[i] - flight[i] * GRAVITY / 2, climb[i + 1] + flight[i + 1] * GRAVITY / 2
        height[rows] = level[i] + _on_ground((t[rows] - begin) / span, span, down, up, gait.bob)
        if i + 1 < len(begins):
            rows = np.arange(*np.searchsorted(t, [end, begins[i + 1]]))
            since = t[rows] - end
            height[rows] = level[i] + up * since - GRAVITY / 2 * since**2
    return height


def _on_ground(u: Array, span: float, down: float, up: float, dip: float) -> Array:
    """Height (T,) over u in [0, 1] of a stance of `span` seconds, from landing at `down` to leaving at `up` [m/s].

    The force is zero at both ends. A long stance, on one foot after the other, rests `dip` lower in its middle.
    """
    if span < _LONG_STANCE:
        bend = -GRAVITY * span**2
        return hermite(u, np.array([0, down * span, bend]), np.array([0, up * span, bend]))
    half, rest = span / 2, np.array([-dip, 0, 0])
    landing = hermite(2 * u, np.array([0, down * half, -GRAVITY * half**2]), rest)
    leaving = hermite(2 * u - 1, rest, np.array([0, up * half, -GRAVITY * half**2]))
    return np.where(u < 0.5, landing, leaving)


_LONG_STANCE = 0.45
"""Stances longer than this [s] are a landing and a take-off, shorter ones a bounce."""


def _landing_heights(steps: Footsteps, begins: Array, ends: Array, firsts: NDArray[np.int64]) -> Array:
    """Height of the pelvis (n,) [m] at which the landing leg reaches the ground ahead, from the speed of each step."""
    places = steps.pos[firsts]
    speed = np.linalg.norm(np.gradient(places, begins, axis=0), axis=1)
    lead = np.maximum(speed * np.minimum(ends - begins, 0.3) / 2 - _LAND_UNDER, 0.0)
    return np.minimum(sole_edges().below + 0.003 + np.sqrt((0.998 * REACH) ** 2 - lead**2), 0.875)


_LAND_UNDER = 0.06
"""How far farther under the body than half of its travel in stance the foot of a runner lands [m]."""


def _supports(steps: Footsteps) -> tuple[Array, Array, NDArray[np.int64]]:
    """Beginnings and ends of the times on the ground, and the first contact of each."""
    begins, ends, firsts = [steps.on[0]], [steps.off[0]], [0]
    for k in range(1, len(steps.on)):
        if steps.on[k] > ends[-1] + 1e-6:
            begins.append(steps.on[k])
            ends.append(steps.off[k])
            firsts.append(k)
        else:
            ends[-1] = max(ends[-1], steps.off[k])
    return np.array(begins), np.array(ends), np.array(firsts)


def centre_of_mass(zmp: Array, height: Array, dt: float) -> Array:
    """Horizontal centre of mass (T, 2) over a zero-moment point (T, 2), at height (T,) [m]; bounded solution.

    Solves x[i-1] - (2 + c) x[i] + x[i+1] = -c p[i] with c = dt^2 f / z; at its ends it stands over the point.
    """
    force = np.zeros_like(height)
    force[1:-1] = np.maximum(GRAVITY + (height[2:] - 2 * height[1:-1] + height[:-2]) / dt**2, 0.0)
    stiffness = dt**2 * force / height
    bands = np.ones((3, len(height)))
    bands[1] = -(2 + stiffness)
    bands[1, [0, -1]], bands[0, 1], bands[2, -2] = 1, 0, 0
    right = -stiffness[:, None] * zmp
    right[[0, -1]] = zmp[[0, -1]]
    return solve_banded((1, 1), bands, right)
