"""Poses at the right time: how near characters are to a gait cycle, and whether they go through it at its own tempo.

A reward beyond the paper's two. Discriminators see five frames; steps a fifth too quick look like the clip's there.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

TRACKING_SCALE = 0.1
"""Mean distance of the links [m] that halves the reward."""
DRIFT_SCALE, FREE_DRIFT = 0.12, 0.03
"""Relative error of the tempo that halves the reward, and what is free of charge: tempo sways a little in turns."""
TEMPO_EXPONENT, SLOWEST_TEMPO, FASTEST_TEMPO = 0.5, 0.87, 1.15
"""The cycle should run at this power of the preferred speed over its own, within these bounds: who walks faster takes
longer and quicker steps. So do `SVG`'s guides, which know nothing of this package: a test holds the two together."""
GAIN, MOST_SHIFT = 0.3, 0.6
"""A clock moves by this share of the way to the best frame nearby, and by as many frames per step at most."""
LOST = 0.25
"""Mean distance [m] from which on a clock is set to the nearest frame of the cycle. Half a cycle off is about 0.2 m."""
_FLAT = 1e-6
"""Curvature [m^2 per frame^2] below which the distance says nothing about the phase."""


class PhaseClock:
    """Which frame of a gait cycle each of N characters is in, and how much faster than it should it goes through them.

    Attributes:
        phases: (N,) frames, fractions included, below the cycle's P.
        drifts: (N,) relative errors of the tempo over the last P steps: 0.1 for steps a tenth too quick.
    """

    def __init__(self, cycle: NDArray[np.floating], speed: float, num_worlds: int) -> None:
        """Clocks before their first `restart`.

        Args:
            cycle: (P, L, 3) positions of the links [m], heading frame, one frame a control step; the first follows the
                last.
            speed: the cycle's own [m/s].
            num_worlds: N.
        """
        self._cycle, self._speed = np.asarray(cycle, np.float32), speed
        self._swing = Swing(self._cycle, num_worlds)
        self.phases, self.drifts = np.zeros(num_worlds), np.zeros(num_worlds)
        self._set = np.zeros(num_worlds, bool)  # whose phases are known

    def restart(self, ids: NDArray[np.integer], positions: NDArray[np.floating]) -> None:
        """Set the clocks `ids` (n,) to the frames that are nearest to the positions (n, L, 3) [m], heading frame."""
        nearest = self._nearest(positions)
        self.phases[ids], self.drifts[ids], self._set[ids] = nearest, 0, True
        self._swing.restart(ids, nearest)

    def _nearest(self, positions: NDArray[np.floating]) -> NDArray[np.integer]:
        products = np.tensordot(positions, self._cycle, ((1, 2), (1, 2)))
        return np.asarray((np.square(self._cycle).sum(axis=(1, 2)) - 2 * products).argmin(axis=1))

    def advance(
        self,
        positions: NDArray[np.floating],
        speeds: NDArray[np.floating],
        followers: NDArray[np.bool_] | None = None,
    ) -> None:
        """Let all clocks go on by one control step.

        Args:
            positions: (N, L, 3) of the links after it [m], heading frame.
            speeds: (N,) preferred speeds [m/s].
            followers: (N,) whose phases go on, all by default; the others' stand still, and are set to the nearest
                frames when they follow again. Drifts are everybody's.
        """
        tempo = np.clip((speeds / self._speed) ** TEMPO_EXPONENT, SLOWEST_TEMPO, FASTEST_TEMPO)
        self.drifts = self._swing.advance(positions, tempo) - 1
        follow = np.ones(len(positions), bool) if followers is None else followers
        self._set &= follow
        going_on = np.flatnonzero(self._set)
        self.phases[going_on] += tempo[going_on] * (1 + self.drifts[going_on])
        self._approach(going_on, positions[going_on])
        lost = np.flatnonzero(follow & ~self._set)
        self.phases[lost], self._set[lost] = self._nearest(positions[lost]), True

    def _approach(self, ids: NDArray[np.integer], positions: NDArray[np.floating]) -> None:
        """Move towards the best frames nearby; who is lost is not set any more."""
        behind, here, ahead = (
            np.square(self._offsets(ids, positions, shift)).sum(axis=-1).mean(axis=-1) for shift in (-1, 0, 1)
        )
        to_best = (behind - ahead) / (2 * np.maximum(behind - 2 * here + ahead, _FLAT))
        moved = self.phases[ids] + np.clip(GAIN * to_best, -MOST_SHIFT, MOST_SHIFT)
        self.phases[ids] = moved % len(self._cycle)
        self._set[ids] = self.distances(positions, ids) <= LOST

    def distances(
        self, positions: NDArray[np.floating], ids: NDArray[Any] | slice = slice(None)
    ) -> NDArray[np.float64]:
        """Mean distances (n,) [m] of links (n, L, 3) from where the cycle has them; `ids`: whose they are."""
        return np.linalg.norm(self._offsets(ids, positions, 0), axis=-1).mean(axis=-1, dtype=np.float64)

    def _offsets(self, ids: NDArray[Any] | slice, positions: NDArray[np.floating], shift: int) -> NDArray[np.floating]:
        """(n, L, 3) from where the cycle has the links `shift` frames later; between frames in a straight line."""
        phases = self.phases[ids]
        whole = np.floor(phases).astype(np.int64)
        before, after = (self._cycle[(whole + shift + k) % len(self._cycle)] for k in (0, 1))
        return positions - before - (phases - whole)[:, None, None].astype(np.float32) * (after - before)


class GaitCycle(NamedTuple):
    """What a clock follows.

    Attributes:
        positions: (P, L, 3) of the links [m], heading frame, one frame a control step; the first follows the last.
        speed: its own [m/s].
    """

    positions: NDArray[np.floating]
    speed: float


class GaitClocks:
    """Clocks of N characters in one gait cycle, or in each of several that differ in speed.

    A character follows the cycle nearest in speed to its preferred one. The tempo of all of them is kept all the time,
    so who is asked for another speed is met where it is, with the steps that it has made.
    """

    def __init__(self, cycles: Sequence[GaitCycle], num_worlds: int) -> None:
        """Clocks before their first `restart`, of one cycle or more."""
        self._clocks = [PhaseClock(*cycle, num_worlds) for cycle in cycles]
        self._pace = np.log([cycle.speed for cycle in cycles])

    def restart(self, ids: NDArray[np.integer], positions: NDArray[np.floating]) -> None:
        """Set the clocks of the characters `ids` (n,) by their links (n, L, 3) [m], heading frame."""
        for clock in self._clocks:
            clock.restart(ids, positions)

    def advance(self, positions: NDArray[np.floating], speeds: NDArray[np.floating]) -> None:
        """Let all clocks go on by one control step; arguments as of `PhaseClock.advance`."""
        for clock, followers in zip(self._clocks, self._followers(speeds), strict=True):
            clock.advance(positions, speeds, followers)

    def rewards(self, positions: NDArray[np.floating], speeds: NDArray[np.floating]) -> NDArray[np.float64]:
        """`tracking_reward` (N,) of links (N, L, 3) [m], heading frame, at the preferred speeds (N,) [m/s] of now."""
        rewards = np.zeros(len(positions))
        for clock, whose in zip(self._clocks, self._followers(speeds), strict=True):
            rewards[whose] = tracking_reward(clock.distances(positions[whose], whose), clock.drifts[whose])
        return rewards

    def _followers(self, speeds: NDArray[np.floating]) -> list[NDArray[np.bool_]]:
        """Who (N,) follows each cycle."""
        nearest = np.abs(np.log(speeds)[:, None] - self._pace).argmin(axis=1)
        return [nearest == number for number in range(len(self._clocks))]


class Swing:
    """How fast N characters go around a gait cycle, whatever their poses are otherwise.

    Where the links are in the direction of the cycle's first harmonic (Fourier's), and how fast they move there, are a
    point that goes around once a cycle. Its turns count the tempo even of who does not look like the cycle: steps of
    another length, a bent back. The nearest frames do not: with them quick small steps looked like slow ones.
    """

    def __init__(self, cycle: NDArray[np.floating], num_worlds: int) -> None:
        """Of a cycle (P, L, 3) [m], heading frame."""
        flat = np.asarray(cycle, np.float64).reshape(len(cycle), -1)
        self._turn = 2 * np.pi / len(flat)  # per frame
        self._middle = flat.mean(axis=0)
        turns = np.exp(-1j * self._turn * np.arange(len(flat)))
        self._along = ((flat - self._middle) * turns[:, None]).sum(axis=0).conj()
        self._own = self._around(flat)
        self._own_points = self._point(self._own, np.roll(self._own, 1))
        self._own_paces = self._turned(self._own_points, np.roll(self._own_points, 1))
        shape = (num_worlds, len(flat))
        self._places, self._paces = np.zeros(shape, complex), np.ones(shape)  # of the last P steps, in turn
        self._points = np.ones(num_worlds, complex)
        self._steps = 0

    def restart(self, ids: NDArray[np.integer], frames: NDArray[np.integer]) -> None:
        """Let the characters `ids` (n,) have come to `frames` (n,) of the cycle as the cycle does."""
        period = len(self._own)
        ago = (self._steps - 1 - np.arange(period)) % period  # how many steps, of each column
        before = (frames[:, None] - ago) % period
        self._places[ids], self._paces[ids] = self._own[before], self._own_paces[before]
        self._points[ids] = self._own_points[frames]

    def advance(self, positions: NDArray[np.floating], tempo: NDArray[np.floating]) -> NDArray[np.float64]:
        """Means (N,) over P steps of how many frames a step went on by, divided by how many it should.

        Args:
            positions: (N, L, 3) of the links now [m], heading frame.
            tempo: (N,) how many frames this step should go on by.
        """
        column, before = self._steps % len(self._own), (self._steps - 1) % len(self._own)
        self._steps += 1
        middle, previous = self._places.mean(axis=1), self._places[:, before]
        now = self._around(positions.reshape(len(positions), -1))
        points = self._point(now - middle, previous - middle)
        self._places[:, column], self._paces[:, column] = now, self._turned(points, self._points) / tempo
        self._points = points
        return np.asarray(self._paces.mean(axis=1))

    def _around(self, flat: NDArray[np.floating]) -> NDArray[Any]:
        """Where links (n, 3 L) are in the direction of the harmonic."""
        away = flat - self._middle  # BLAS hands complex products to threads, which wait where cores are busy
        return np.asarray(away @ self._along.real + 1j * (away @ self._along.imag))

    def _point(self, now: NDArray[Any], previous: NDArray[Any]) -> NDArray[Any]:
        """Place and motion as one number, between two steps; of the harmonic itself it turns at a constant rate."""
        return np.asarray((now + previous) / 2 + (now - previous) / (2j * np.tan(self._turn / 2)))

    def _turned(self, now: NDArray[Any], before: NDArray[Any]) -> NDArray[np.float64]:
        """Frames between two points."""
        return np.asarray(np.angle(now * before.conj()) / self._turn)


def tracking_reward(distances: NDArray[np.floating], drifts: NDArray[np.floating]) -> NDArray[np.float64]:
    """Rewards (N,) in (0, 1], with slopes far out, too.

    Args:
        distances: (N,) of the links from the cycle [m].
        drifts: (N,) relative errors of the tempo.

    Returns:
        1 / (1 + (distance / 0.1 m)^2) x 1 / (1 + (what the drift is over 0.03 / 0.12)^2). In turns, too, although a
        clip that walks straight shows none: with a fixed 0.5 for most of it there, steps stayed too quick.
    """
    beyond = np.maximum(np.abs(drifts) - FREE_DRIFT, 0)
    return np.asarray(1 / (1 + np.square(distances / TRACKING_SCALE)) / (1 + np.square(beyond / DRIFT_SCALE)))
