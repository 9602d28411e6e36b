"""N characters with their goals: reset and step over arrays, without any notion of Gymnasium."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from adapt_envs import rotations
from adapt_envs.features import WINDOW_FRAMES, heading_frame_features, observations, pose_windows
from adapt_envs.kinematics import LINK_STATE
from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import CONTROL_DT, LINKS
from adapt_envs.motion.library import ReferenceMotion, load_clip
from adapt_envs.physics import PhysicsBatch
from adapt_envs.suite import TaskSpec, preferred_speeds
from adapt_envs.tasks.goal import draw_targets, goal_observation, goal_reward
from adapt_envs.tasks.termination import LOST_DISTANCE, RUNNING, ends


@dataclass
class Goals:
    """The goals of N worlds, as arrays.

    Attributes:
        target: (N, 2) target on the ground [m], world.
        speed: (N,) preferred speed [m/s].
        steps_left: (N,) control steps until a new target is drawn.
        distance: (N,) distance to the target when it was drawn [m].
        held_heading: (N,) world heading [rad] the goal is held at, NaN where goals are drawn at random.
        held_speed: (N,) preferred speed [m/s] the goal is held at.
    """

    target: NDArray[np.float32]
    speed: NDArray[np.float32]
    steps_left: NDArray[np.int64]
    distance: NDArray[np.float32]
    held_heading: NDArray[np.float64]
    held_speed: NDArray[np.float64]

    @classmethod
    def none(cls, n: int) -> "Goals":
        """Goals of `n` worlds before the first draw."""
        return cls(
            np.zeros((n, 2), np.float32), np.ones(n, np.float32), np.zeros(n, np.int64), np.zeros(n, np.float32),
            np.full(n, np.nan), np.ones(n),
        )  # fmt: skip


class Worlds:
    """N worlds of one task.

    Attributes:
        spec: the task's row, with overrides applied.
        reference: the reference motion.
        physics: the worlds' physics.
        goals: the worlds' goals.
        rng: source of all randomness; replace it to seed.
        steps: (N,) control steps since the worlds' last reset.
    """

    def __init__(self, spec: TaskSpec, num_worlds: int, num_threads: int = 0) -> None:
        """Build the model, load the motion and make `num_worlds` worlds; `reset` comes first."""
        self.model = compile_model(friction=spec.friction)
        clip = load_clip(spec.motion)
        self.spec = replace(spec, speed_range=preferred_speeds(spec, clip))
        self.reference = ReferenceMotion([clip], self.model)
        self.physics = PhysicsBatch(self.model, num_worlds, num_threads)
        self.goals = Goals.none(num_worlds)
        self.rng = np.random.default_rng()
        self.steps = np.zeros(num_worlds, np.int64)
        self.history = np.zeros((num_worlds, WINDOW_FRAMES, len(LINKS), LINK_STATE), np.float32)
        self._all = np.arange(num_worlds)
        self._features = np.zeros_like(self.history)
        self._observations = np.zeros((num_worlds, 0), np.float32)

    @property
    def root_xy(self) -> NDArray[np.float32]:
        """(N, 2) position of the roots on the ground [m], world."""
        return self.history[:, -1, 0, :2]

    @property
    def root_heading(self) -> NDArray[np.float32]:
        """(N,) heading of the roots [rad], world."""
        return rotations.heading(self.history[:, -1, 0, 3:7])

    @property
    def windows(self) -> NDArray[np.float32]:
        """(N, 5, 15, 7) pose windows of the last step's transitions, before any reset."""
        return pose_windows(self._features)

    def reset(self, ids: NDArray[np.integer], start: int | None = None) -> NDArray[np.float32]:
        """Start the worlds `ids` anew from states of the motion with new goals; held goals stay held.

        Args:
            ids: (n,) worlds.
            start: number of the start state, below `reference.num_states`; None draws it.

        Returns:
            (n, 784) first observations.
        """
        count = self.reference.num_states
        chosen = self.rng.integers(count, size=len(ids)) if start is None else np.full(len(ids), start)
        qpos, qvel, history = self.reference.states(chosen)
        self.physics.set_states(ids, qpos, qvel)
        self.history[ids] = history
        self.steps[ids] = 0
        self._draw_goals(ids)
        features = heading_frame_features(history)
        fresh = observations(features, self._goal_observation(ids))
        if not self._observations.shape[1]:
            self._observations = np.zeros((len(self._all), fresh.shape[1]), np.float32)
            self._features[ids] = features
        return fresh

    def step(
        self, actions: NDArray[np.floating], max_steps: int | None
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.int8]]:
        """Advance all worlds by one control step; worlds that end are not reset.

        Args:
            actions: (N, nu), clipped to [-1, 1].
            max_steps: time limit in control steps, or None.

        Returns:
            Observations (N, 784), goal rewards (N,) in [0, 1], and why each episode ended (N,), codes into
            `termination.ENDS`. A world that diverged has its last finite observation and reward 0.
        """
        before = self.root_xy.copy()
        diverged = self.physics.step(np.clip(actions, -1, 1))
        self._remember_links(diverged)
        self.steps += 1
        after = self.root_xy
        reward = goal_reward(before, after, self.goals.target, self.goals.speed)
        reward[diverged] = 0
        left = np.linalg.norm(self.goals.target - after, axis=1)
        timed_out = self.steps >= max_steps if max_steps is not None else np.zeros(len(left), bool)
        code = ends(self.physics.fallen(), left > self.goals.distance + LOST_DISTANCE, diverged, timed_out)
        self._renew_goals(code)
        self._features = heading_frame_features(self.history)
        fresh = observations(self._features, self._goal_observation(self._all))
        fresh[diverged] = self._observations[diverged]
        self._observations = fresh
        return fresh, reward, code

    def _remember_links(self, diverged: NDArray[np.bool_]) -> None:
        self.history[:, :-1] = self.history[:, 1:]
        self.physics.read_links(self.history[:, -1])
        # The state of a world that diverged means nothing: its previous frame stands for it.
        self.history[diverged, -1] = self.history[diverged, -2]

    def _goal_observation(self, ids: NDArray[np.integer]) -> NDArray[np.float32]:
        return goal_observation(
            self.root_xy[ids], self.root_heading[ids], self.goals.target[ids], self.goals.speed[ids]
        )

    def hold_goal(self, heading: float | None, speed: float | None, ids: NDArray[np.integer]) -> None:
        """Keep the target of the worlds `ids` ahead in the world direction `heading` [rad] at `speed` [m/s].

        None for either returns to goals drawn at random.
        """
        free = heading is None or speed is None
        self.goals.held_heading[ids] = np.nan if heading is None or free else heading
        self.goals.held_speed[ids] = 1.0 if speed is None or free else speed
        self._draw_goals(ids)

    def _renew_goals(self, code: NDArray[np.int8]) -> None:
        self.goals.steps_left -= 1
        expired = (self.goals.steps_left <= 0) | ~np.isnan(self.goals.held_heading)
        self._draw_goals(np.flatnonzero(expired & (code == RUNNING)))

    def _draw_goals(self, ids: NDArray[np.integer]) -> None:
        """Draw new goals (paper, app. A): direction uniform, speed and timer from the task's ranges; or held ones."""
        if not len(ids):
            return
        goals, held = self.goals, ~np.isnan(self.goals.held_heading[ids])
        low, high = self.spec.speed_range or (1.0, 1.0)
        speed = np.where(held, goals.held_speed[ids], self.rng.uniform(low, high, len(ids)))
        heading = np.where(held, goals.held_heading[ids], self.rng.uniform(0, 2 * np.pi, len(ids)))
        # A held goal keeps the longest distance a drawn one can have: far enough never to be reached.
        seconds = np.where(held, self.spec.timer_range[1], self.rng.uniform(*self.spec.timer_range, len(ids)))
        goals.target[ids] = draw_targets(self.root_xy[ids], heading, speed, seconds)
        goals.speed[ids] = speed
        goals.distance[ids] = speed * seconds
        goals.steps_left[ids] = np.round(seconds / CONTROL_DT).astype(np.int64)
