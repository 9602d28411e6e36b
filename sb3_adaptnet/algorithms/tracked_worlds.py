"""Real worlds whose characters shall follow a motion: their episodes end where they lose it."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.rollouts.real_rollout import Moment, root_headings
from sb3_adaptnet.algorithms.rollouts.retries import Retries
from sb3_adaptnet.algorithms.rollouts.strengths import strengths_at
from sb3_adaptnet.algorithms.svg_settings import Episodes
from sb3_adaptnet.algorithms.tracking.guide import Guidance, Guide, Guiding
from sb3_adaptnet.algorithms.tracking.tracked_motion import OBSERVED_FRAMES, TrackedMotion
from sb3_adaptnet.objectives.schedule import value_at
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.world_model.integration import CONTROL_DT

FAILURES = ("fall", "diverged", "lost")
"""Ends of the environment that are the character's fault. The other ends say nothing about its state."""


class TrackedStep(NamedTuple):
    """What one step of all worlds gave.

    Attributes:
        observations: (N, 784) after it, of new episodes where old ones ended.
        rewards: (N,) of the environment.
        dones: (N,) whether the environment ended an episode.
        infos: the environment's.
        ended: (N,) whether anything ended an episode.
        failed: (N,) whether the character's fault did: a fall, the error, or that it got lost.
        guidance: what the worlds should have looked like.
        errors: (N,) how far [m] the links were from it; NaN where the environment ended the episode.
    """

    observations: NDArray[np.float32]
    rewards: NDArray[np.float32]
    dones: NDArray[np.bool_]
    infos: list[dict[str, Any]]
    ended: NDArray[np.bool_]
    failed: NDArray[np.bool_]
    guidance: Guidance
    errors: NDArray[np.floating]


class TrackedWorlds:
    """N worlds with their guides. Episodes also end when a world is too far off, or after a random number of steps.

    Attributes:
        env: the worlds.
        guide: what they follow.
        error_limit, loose_limit: mean errors of the links' positions [m] at which an episode ends.
        strengths: (N,) at which the adaptation acts; in part, no episode ends by its error.
        retries: what came before loose worlds failed, at the whole strength.
        loose: (N,) worlds with longer episodes and a wider limit.
        companions: (N,) 0: nothing acts beside what learns.
        lengths: steps of the episodes that ended in the last rollout.
    """

    def __init__(
        self,
        env: AdaptVecEnv,
        motion: TrackedMotion,
        episodes: Episodes,
        guiding: Guiding,
        rng: np.random.Generator,
    ) -> None:
        """Guide the worlds of `env` along `motion`; `begin` comes first.

        Args:
            env: the worlds.
            motion: their reference.
            episodes: how long they last.
            guiding: how they are led.
            rng: source of the numbers of steps.
        """
        self.env, self.rng = env, rng
        self.guide = Guide(motion, env.num_envs, guiding.longest_lead)
        self.error_limit = self.loose_limit = np.inf
        self.strengths = np.ones(env.num_envs, np.float32)
        self._strength_is_new = np.zeros(env.num_envs, np.bool_)
        self.retries, self._retry_share = Retries(env.num_envs, rng), 0.0
        self.loose = np.zeros(env.num_envs, np.bool_)
        self.companions = np.zeros(env.num_envs, np.int64)
        self.lengths: list[int] = []
        self._episodes, self._guiding = episodes, guiding
        self._ages = np.zeros(env.num_envs, np.int64)
        self._limits = np.zeros(env.num_envs, np.int64)
        self._all = np.arange(env.num_envs)

    @property
    def left_from_behind(self) -> float:
        """The guides' [rad]."""
        return self.guide.left_from_behind

    def schedule(self, samples: int) -> None:
        """Put what changes while learning to its values after so many samples."""
        episodes, guiding, guide = self._episodes, self._guiding, self.guide
        footsteps = guide.motion.gaits.footsteps[guide.motion.gaits.of(guide.phases)]
        guide.fastest_turn = np.minimum(value_at(guiding.turn_rate, samples), guiding.turn_per_footstep * footsteps)
        guide.turn_acceleration = value_at(guiding.turn_acceleration, samples)
        guide.turn_gain = value_at(guiding.turn_gain, samples)
        guide.turn_at_rest = value_at(guiding.turn_at_rest, samples)
        guide.left_from_behind = value_at(guiding.left_from_behind, samples)
        guide.least_style = value_at(guiding.least_style, samples)
        self.error_limit = value_at(episodes.error_limit, samples)
        self.loose_limit = value_at(episodes.loose_limit, samples)
        self.loose = self._all < value_at(episodes.loose_share, samples) * len(self._all)
        self._retry_share = value_at(episodes.retry_share, samples)
        spreads = value_at(episodes.goal_spread, samples), value_at(episodes.loose_goal_spread, samples)
        self.env.set_attr("goal_spread", np.where(self.loose, spreads[1], spreads[0]))
        strengths = strengths_at(samples, len(self._all), value_at(episodes.partial_share, samples))
        strengths[self.retries.trying] = 1  # as when it failed
        self.strengths, self._strength_is_new = strengths, strengths != self.strengths

    def begin(self, samples: int) -> NDArray[np.float32]:
        """New episodes in all worlds, by the schedules' values after so many samples; returns observations (N, 784)."""
        self.schedule(samples)
        observations = self.env.reset()
        assert isinstance(observations, np.ndarray)  # there is no heightmap
        self.take_up(observations)
        return observations

    def take_up(self, observations: NDArray[np.float32]) -> None:
        """Let guides and episodes begin where all worlds are."""
        self._follow(self._all, self.guide.motion.seen_in(observations))

    def _follow(self, ids: NDArray[np.integer], seen: NDArray[np.float32]) -> None:
        self.guide.restart(ids, seen, self._root_headings())
        lengths = np.where(self.loose[ids, None], self._episodes.loose_steps, self._episodes.steps)
        usual, again = self.rng.integers(lengths[:, 0], lengths[:, 1] + 1), self.retries.lengths(ids)
        self._ages[ids], self._limits[ids] = 0, np.where(again > 0, again, usual)

    def _root_headings(self) -> NDArray[np.floating]:
        return root_headings(self.env.simulation.physics_states.qpos)

    def now(self) -> Moment:
        """The worlds before the next step."""
        simulation = self.env.simulation
        states, goals = simulation.physics_states, simulation.goal_states
        return Moment(
            qpos=states.qpos.astype(np.float32),
            qvel=states.qvel.astype(np.float32),
            frames=simulation.link_histories[:, -OBSERVED_FRAMES:],
            targets=goals.target,
            speeds=goals.speed,
        )

    def resynchronise(self, observations: NDArray[np.float32]) -> None:
        """Put the guides to the phases that the worlds are in, and forget the lengths of past episodes.

        With a new strength a character will move another way: its guide begins from it anew, as after a turn.
        """
        seen, new = self.guide.motion.seen_in(observations), np.flatnonzero(self._strength_is_new)
        self.guide.resynchronise(seen)
        self.guide.restart(new, seen, self._root_headings())
        self.guide.calm_steps[new] = 0
        self.lengths = []

    def step(self, actions: NDArray[np.float32]) -> TrackedStep:
        """Advance all worlds and their guides by one control step; worlds that ended have begun again."""
        if self._retry_share > 0:
            self.retries.watch(self.env.simulation.situations)
        else:
            self.retries.forget()
        observations, rewards, dones, infos = self.env.step(actions)
        assert isinstance(observations, np.ndarray)
        self._ages += 1
        simulation = self.env.simulation
        states, goals = simulation.physics_states, simulation.goal_states
        moving = np.hypot(*states.qvel[:, :2].T)
        self.guide.advance(goals.target - states.qpos[:, :2], self._root_headings(), goals.speed, moving)
        guidance = self.guide.now
        errors = np.where(dones, np.nan, self.guide.errors(self.guide.motion.seen_in(observations)))
        failed = errors > self._error_limits()
        stopped = np.flatnonzero(~dones & ((self._ages >= self._limits) | failed))
        for world in np.flatnonzero(dones):
            failed[world] = infos[world].get("end") in FAILURES
        ended = dones.copy()
        ended[stopped] = True
        retried = self.loose & (self.strengths == 1)
        self.retries.failed(np.flatnonzero(retried & failed), self._ages[retried & failed])
        self.retries.succeeded(np.flatnonzero(ended & ~failed))
        self._restart(stopped, np.flatnonzero(retried & ended), observations)
        self.lengths.extend(self._ages[ended].tolist())
        self._follow(np.flatnonzero(ended), self.guide.motion.seen_in(observations))
        return TrackedStep(observations, rewards, dones, infos, ended, failed, guidance, errors)

    def _restart(
        self, stopped: NDArray[np.integer], retried: NDArray[np.integer], observations: NDArray[np.float32]
    ) -> None:
        """Begin episodes in the worlds `stopped`, and retries in some of `retried`; put first observations in place."""
        again, situations = self.retries.draw(retried, self._retry_share)
        others = np.setdiff1d(stopped, again)
        for ids, chosen in ((others, None), (again, situations)):
            if len(ids):
                fresh = self.env.restart(ids, chosen)
                assert isinstance(fresh, np.ndarray)
                observations[ids] = fresh

    def _error_limits(self) -> NDArray[np.floating]:
        """(N,) [m]."""
        turning = self.guide.calm_steps * CONTROL_DT < self._episodes.calm_seconds
        limits = np.where(self.loose | turning, self.loose_limit, self.error_limit)
        return np.where(self.strengths < 1, np.inf, limits)
