"""Rollouts of a policy's mean action, kept as arrays."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from adapt_envs import AdaptVectorEnv, make_vector
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.progress import Progress
from adapt_envs.tasks.goal import GOAL_RADIUS

WORLDS = 20
"""Worlds of an evaluation."""
STRAIGHT_SECONDS = 10.0
"""Simulated seconds of each world that walks straight ahead."""


class Acting(Protocol):
    """What evaluation needs of a policy: SB3's `predict`."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = False
    ) -> tuple[NDArray[Any], Any]:
        """Actions (N, J) for observations of N worlds, and a state that is not used."""


class Segment(NamedTuple):
    """Frames `start` to `stop - 1` of one world, between two restarts."""

    world: int
    start: int
    stop: int


@dataclass(frozen=True)
class Recording:
    """T control steps of N worlds; frame 0 is the start, frame t the state after step t.

    The frame after the step in which an episode ended is the first one of the next episode.

    Attributes:
        qpos: (T + 1, N, nq) configurations, world frame.
        links: (T + 1, N, 15, 13) link states, world frame (see `adapt_envs.features.kinematics`).
        floor: (T + 1, N) height [m] of the ground below the roots.
        restarts: (T, N) whether an episode ended in the step.
        rewards: (T, N) goal rewards.
        ends: how many episodes ended for each reason.
        targets: how many targets were left behind: their timer or the episode ended.
        reached: how many of them had come within 0.5 m.
        asked_speed: the preferred speed [m/s] where the goal was held straight ahead; None for random goals.
    """

    qpos: NDArray[np.float64] = field(repr=False)
    links: NDArray[np.float32] = field(repr=False)
    floor: NDArray[np.float32] = field(repr=False)
    restarts: NDArray[np.bool_] = field(repr=False)
    rewards: NDArray[np.float64] = field(repr=False)
    ends: Counter[str]
    targets: int
    reached: int
    asked_speed: float | None = None

    @property
    def seconds(self) -> float:
        """Simulated seconds of all worlds together."""
        return self.restarts.size * CONTROL_DT

    def segments(self) -> Iterator[Segment]:
        """The stretches between restarts, world by world."""
        frames = len(self.qpos)
        for world in range(self.restarts.shape[1]):
            begins = [0, *(np.flatnonzero(self.restarts[:, world]) + 1), frames]
            for start, stop in zip(begins[:-1], begins[1:], strict=True):
                yield Segment(world, int(start), int(stop))


@dataclass
class _Targets:
    """Counts targets that were reached before they were replaced.

    Attributes:
        near: (N,) whether the present target has been reached.
        count: targets replaced so far.
        reached: those of them that had been reached.
    """

    near: NDArray[np.bool_]
    count: int = 0
    reached: int = 0

    def note(self, target: NDArray[np.floating], root_xy: NDArray[np.floating], replaced: NDArray[np.bool_]) -> None:
        """Take up one step: targets (N, 2) before it, roots (N, 2) after it, and which targets were replaced in it."""
        # The root of a world that restarted is elsewhere already; it must not count as near.
        self.near |= (np.linalg.norm(target - root_xy, axis=1) < GOAL_RADIUS) & ~replaced
        self.count += int(replaced.sum())
        self.reached += int((self.near & replaced).sum())
        self.near[replaced] = False


def open_worlds(environment: str, num_worlds: int = WORLDS, **overrides: Any) -> AdaptVectorEnv:
    """Worlds of the id `environment` without a time limit; overrides as `AdaptVectorEnv`'s (`motion=`, ...)."""
    return make_vector(environment, num_worlds, max_episode_steps=None, **overrides)


def reference_speed(env: AdaptVectorEnv) -> float:
    """The mean speed [m/s] of the clip as these worlds' body shows it, kept within the speeds that they ask for.

    Only a base's clip may leave those.
    """
    low, high = env.worlds.spec.speed_range or (0.0, np.inf)
    return float(np.clip(env.worlds.reference.shown.mean_speed, low, high))


def record(policy: Acting, env: AdaptVectorEnv, steps: int, seed: int, progress: Progress = iter) -> Recording:
    """Run the policy's mean action from random start states towards random goals.

    Args:
        policy: acts on observations of all worlds.
        env: worlds, best without a time limit (`open_worlds`).
        steps: control steps T of each world.
        seed: of start states and goals.
        progress: wraps the step numbers.
    """
    env.set_goal(None, None)
    observations, _ = env.reset(seed=seed)
    return _run(policy, env, observations, range(steps), progress, _as_it_comes)


def record_straight(
    policy: Acting, env: AdaptVectorEnv, speed: float | None, seed: int, seconds: float | None = None,
    progress: Progress = iter,
) -> Recording:  # fmt: skip
    """Run the policy's mean action with the goal held straight ahead of where each world starts out heading.

    Args:
        policy: acts on observations of all worlds.
        env: worlds without a time limit; afterwards their goals are random again.
        speed: preferred speed [m/s]; None for their `reference_speed`.
        seed: of the start states.
        seconds: simulated seconds of each world; None for `STRAIGHT_SECONDS`.
        progress: wraps the step numbers.
    """
    seconds = STRAIGHT_SECONDS if seconds is None else seconds
    asked = reference_speed(env) if speed is None else speed

    def hold_ahead(ids: NDArray[np.integer]) -> None:
        # The observation in hand still shows the goal sampled at the restart, for this one step.
        for world in ids:
            env.set_goal(float(env.worlds.root_heading[world]), asked, np.array([world]))

    observations, _ = env.reset(seed=seed)
    hold_ahead(np.arange(env.num_envs))
    recording = _run(policy, env, observations, range(round(seconds / CONTROL_DT)), progress, hold_ahead)
    env.set_goal(None, None)
    return replace(recording, asked_speed=asked)


def _as_it_comes(ids: NDArray[np.integer]) -> None:
    """Leave restarted worlds the goals that were sampled for them."""


def _run(
    policy: Acting, env: AdaptVectorEnv, observations: Any, steps: range, progress: Progress,
    on_restart: Callable[[NDArray[np.integer]], None],
) -> Recording:  # fmt: skip
    worlds, count = env.worlds, len(steps)
    qpos = np.empty((count + 1, *worlds.physics.qpos.shape))
    links = np.empty((count + 1, *worlds.history[:, -1].shape), np.float32)
    floor = np.empty((count + 1, env.num_envs), np.float32)
    restarts, rewards = np.zeros((count, env.num_envs), bool), np.empty((count, env.num_envs))
    qpos[0], links[0], floor[0] = _state(env)
    ends: Counter[str] = Counter()
    targets = _Targets(np.zeros(env.num_envs, bool))
    for step in progress(steps):
        actions, _ = policy.predict(observations, deterministic=True)
        target = worlds.goals.target.copy()
        observations, rewards[step], terminated, truncated, infos = env.step(actions)
        ended = terminated | truncated
        targets.note(target, worlds.root_xy, (worlds.goals.target != target).any(axis=1))
        if ended.any():
            ids = np.flatnonzero(ended)
            ends.update(infos["final_info"]["end"][ids])
            on_restart(ids)
        restarts[step] = ended | worlds.goals.shortened  # at a border of the ground nobody goes straight ahead
        qpos[step + 1], links[step + 1], floor[step + 1] = _state(env)
    return Recording(qpos, links, floor, restarts, rewards, ends, targets.count, targets.reached)


def _state(env: AdaptVectorEnv) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.float32]]:
    """Views of the present configurations, link states and heights of the ground below the roots."""
    worlds = env.worlds
    return worlds.physics.qpos, worlds.history[:, -1], worlds.ground.floor_at(worlds.root_xy)
