"""The goals of N worlds over time: sampled, held and renewed (paper, app. A)."""

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.model.ground import Ground
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.tasks.goal import targets_ahead


class Goals:
    """The goals of N worlds, as arrays.

    Attributes:
        target: (N, 2) target on the ground [m], world.
        speed: (N,) preferred speed [m/s].
        steps_left: (N,) control steps until a new target is sampled.
        distance: (N,) distance to the target when it was sampled [m].
        held_heading: (N,) world heading [rad] the goal is held at, NaN where goals are random.
        held_speed: (N,) preferred speed [m/s] the goal is held at.
        spread: (N,) shares of the circle, centred straight ahead, that random headings come from; 1 is the paper's.
    """

    def __init__(
        self, num_worlds: int, ground: Ground, speed_range: tuple[float, float], timer_range: tuple[float, float]
    ) -> None:
        """Goals before the first sample, on `ground`, with preferred speeds [m/s] and timers [s] from these ranges."""
        self.ground, self.speed_range, self.timer_range = ground, speed_range, timer_range
        self.target = np.zeros((num_worlds, 2), np.float32)
        self.speed = np.ones(num_worlds, np.float32)
        self.steps_left = np.zeros(num_worlds, np.int64)
        self.distance = np.zeros(num_worlds, np.float32)
        self.held_heading = np.full(num_worlds, np.nan)
        self.held_speed = np.ones(num_worlds)
        self._held_before = self.held_heading.copy(), self.held_speed.copy()
        self.spread = np.ones(num_worlds)

    def put(
        self,
        ids: NDArray[np.integer],
        target: NDArray[np.floating],
        speed: NDArray[np.floating],
        distance: NDArray[np.floating],
        steps_left: NDArray[np.integer],
    ) -> None:
        """Give the worlds (n,) these goals: (n, 2), (n,), (n,) and (n,)."""
        self.target[ids], self.speed[ids] = target, speed
        self.distance[ids], self.steps_left[ids] = distance, steps_left

    def hold(
        self, ids: NDArray[np.integer], heading: float | None, speed: float | None, until_reset: bool = False
    ) -> None:
        """Hold the goals of the worlds `ids`, from their next sample on; None for both frees them.

        With `until_reset` what held before holds again after `restore`.

        Raises:
            ValueError: for one without the other, a heading that is not finite, or a speed that is not positive.
        """
        if (heading is None) != (speed is None):
            raise ValueError(f"a goal is held by heading and speed together, not by {heading} and {speed}")
        if heading is not None and speed is not None and not (np.isfinite(heading) and 0.0 < speed < np.inf):
            raise ValueError(f"a goal's heading must be finite and its speed positive, not {heading} rad, {speed} m/s")
        self.held_heading[ids] = np.nan if heading is None else heading
        self.held_speed[ids] = 1.0 if speed is None else speed
        if not until_reset:
            for before, now in zip(self._held_before, (self.held_heading, self.held_speed), strict=True):
                before[ids] = now[ids]

    def restore(self, ids: NDArray[np.integer]) -> None:
        """Hold again what held in the worlds `ids` before a reset's options asked for something else."""
        self.held_heading[ids], self.held_speed[ids] = (before[ids] for before in self._held_before)

    def expire(self) -> NDArray[np.bool_]:
        """Count one control step; return (N,) which goals must be sampled again. Held ones move at every step."""
        self.steps_left -= 1
        return (self.steps_left <= 0) | ~np.isnan(self.held_heading)

    @property
    def shortened(self) -> NDArray[np.bool_]:
        """(N,) whether a goal is held, and nearer than asked: the ground ends, so it no longer lies straight ahead."""
        held = ~np.isnan(self.held_heading)
        return held & (self.distance < self.held_speed * self.timer_range[1] - 1e-3)

    def sample(
        self,
        ids: NDArray[np.integer],
        root_xy: NDArray[np.floating],
        root_heading: NDArray[np.floating],
        rng: np.random.Generator,
    ) -> None:
        """Sample new goals (paper, app. A): direction uniform, speed and timer from their ranges; or held ones.

        On bounded ground random targets keep 3 m inside their patch and out of obstacles, held ones inside the ground.

        Args:
            ids: (n,) worlds.
            root_xy: (n, 2) positions of their roots [m], world.
            root_heading: (n,) their headings [rad], world.
            rng: source of randomness.
        """
        if not len(ids):
            return
        held = ~np.isnan(self.held_heading[ids])
        speed = np.where(held, self.held_speed[ids], rng.uniform(*self.speed_range, len(ids)))
        heading = rng.uniform(0, 2 * np.pi, len(ids))
        narrow = self.spread[ids] < 1
        ahead = root_heading + self.spread[ids] * rotations.wrapped(heading - root_heading)
        heading = np.where(narrow, ahead, heading)
        heading = np.where(held, self.held_heading[ids], heading)
        # A held goal keeps the longest distance a random one can have: far enough never to be reached.
        seconds = np.where(held, self.timer_range[1], rng.uniform(*self.timer_range, len(ids)))
        target, distance = targets_ahead(root_xy, heading, speed, seconds), speed * seconds
        if not self.ground.plain:
            target[held] = self.ground.inside_square(target[held])
            free = ~held
            target[free] = self.ground.kept_targets(
                target[free], root_xy[free], rng, root_heading[free], self.spread[ids][free]
            )
            distance = np.hypot(*(target - root_xy).T)
        self.target[ids], self.speed[ids], self.distance[ids] = target, speed, distance
        self.steps_left[ids] = np.round(seconds / CONTROL_DT).astype(np.int64)
