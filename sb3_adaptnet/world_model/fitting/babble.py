"""Disturbances of a policy's actions, so that a model sees more than the policy does by itself.

A style is not needed for the data, but its range of motion is: legs that swing far, slow and fast rhythms, poses that
the base never takes. Every episode of every world samples its own mixture of three things: white noise; correlated
noise; and waves, joint targets that swing as in some unheard-of gait, added to the policy's actions or put in their
place.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.world_model.integration import CONTROL_DT

_SHARP = 0.85
"""Correlation of correlated noise from one control step to the next."""
_RISE = 6
"""Control steps in which waves rise from nothing, so that a character is not thrown over at once."""


@dataclass(frozen=True)
class BabbleSettings:
    """What is sampled per episode; actions are in half ranges.

    Attributes:
        white: standard deviations of white noise.
        correlated: standard deviations of correlated noise.
        wavy: share of the episodes with waves.
        alternating: share of these in which left and right swing by turns.
        amplitude, offset: standard deviations of a joint's swing, and of the pose that it swings about.
        frequency: slowest and fastest rhythm [Hz].
        silent: share of the joints that do not swing.
    """

    white: tuple[float, ...] = (0.0, 0.03, 0.07, 0.15)
    correlated: tuple[float, ...] = (0.0, 0.05, 0.15, 0.25)
    wavy: float = 0.5
    alternating: float = 0.7
    amplitude: float = 0.3
    offset: float = 0.12
    frequency: tuple[float, float] = (0.35, 2.2)
    silent: float = 0.4


class Babble:
    """The disturbances of N worlds.

    Attributes:
        settings: what is sampled.
    """

    def __init__(
        self,
        joints: Sequence[str],
        num_worlds: int,
        rng: np.random.Generator,
        settings: BabbleSettings | None = None,
    ) -> None:
        """Sample disturbances for `num_worlds` worlds whose actions drive `joints`, J of them."""
        self.settings, self._rng = settings or BabbleSettings(), rng
        self._right, self._left = _twins(joints)
        shape = (num_worlds, len(joints))
        self._ages = np.zeros(num_worlds, np.int64)
        self._white, self._correlated, self._share, self._replacing = (np.zeros((num_worlds, 1)) for _ in range(4))
        self._noise, self._amplitude, self._offset, self._phase, self._rate = (np.zeros(shape) for _ in range(5))
        self.restart(np.arange(num_worlds))

    def restart(self, ids: NDArray[np.integer]) -> None:
        """Sample for new episodes of the worlds `ids`."""
        n, settings, rng = len(ids), self.settings, self._rng
        self._ages[ids], self._noise[ids] = 0, 0
        self._white[ids] = rng.choice(settings.white, (n, 1))
        self._correlated[ids] = rng.choice(settings.correlated, (n, 1))
        self._share[ids] = rng.uniform(0.2, 1, (n, 1)) * (rng.random((n, 1)) < settings.wavy)
        self._replacing[ids] = rng.random((n, 1)) < 0.5
        self._sample_waves(ids)

    def _sample_waves(self, ids: NDArray[np.integer]) -> None:
        """One rhythm for all joints of a world, some twice as fast; left legs and arms often mirror the right ones."""
        settings, rng = self.settings, self._rng
        shape = (len(ids), self._phase.shape[1])
        slowest, fastest = np.log(settings.frequency)
        rhythm = np.exp(rng.uniform(slowest, fastest, (len(ids), 1)))
        harmonic = np.where(rng.random(shape) < 0.75, 1, 2)
        amplitude = np.abs(rng.normal(0, settings.amplitude, shape)) * (rng.random(shape) >= settings.silent)
        phase = rng.uniform(0, 2 * np.pi, shape)
        mirrored = rng.random((len(ids), 1)) < settings.alternating
        for part, shift in ((harmonic, 0), (amplitude, 0), (phase, np.pi * harmonic)):
            twin = (part + shift)[:, self._right]
            part[:, self._left] = np.where(mirrored, twin, part[:, self._left])
        self._amplitude[ids], self._phase[ids] = amplitude, phase
        self._rate[ids] = 2 * np.pi * rhythm * harmonic * CONTROL_DT
        self._offset[ids] = rng.normal(0, settings.offset, shape) * (rng.random(shape) < 0.5)

    def disturbed(self, actions: NDArray[np.floating], rest: NDArray[np.floating]) -> NDArray[np.float32]:
        """The next step's actions (N, J) in [-1, 1], from the policy's (N, J) and a pose (J,) for waves without it."""
        rng, ages = self._rng, self._ages[:, None]
        share = self._share * np.minimum(1, ages / _RISE)
        wave = self._offset + self._amplitude * np.sin(self._phase + self._rate * ages)
        steady = np.where(self._replacing, (1 - share) * actions + share * rest, actions)
        white, fresh = rng.standard_normal((2, *self._noise.shape))
        self._noise = _SHARP * self._noise + np.sqrt(1 - _SHARP**2) * fresh
        self._ages += 1
        noisy = steady + share * wave + self._white * white + self._correlated * self._noise
        return np.clip(noisy, -1, 1).astype(np.float32)


def _twins(joints: Sequence[str]) -> tuple[list[int], list[int]]:
    """Numbers of the right side's joints and of the left side's that answer them."""
    pairs = [
        (joints.index(name), joints.index("left_" + name.removeprefix("right_")))
        for name in joints
        if name.startswith("right_") and "left_" + name.removeprefix("right_") in joints
    ]
    return [right for right, _ in pairs], [left for _, left in pairs]
