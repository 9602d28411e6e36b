"""Whether a policy stays up from the states in which episodes begin, towards random targets at once."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from adapt_envs import AdaptVectorEnv
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.progress import Progress
from sb3_adaptnet.evaluation.recording import Acting

START_SECONDS = 2.0
"""A fall within this time [s] is a fall from the start."""
STANDING_SPEED = 0.4
"""Slower than this [m/s] over the ground a start state stands."""


@dataclass(frozen=True)
class StartFalls:
    """Episodes that were begun, and those that fell within 2 s; of them those that began standing.

    `adaptnet eval` walks 20 episodes of a minute: what falls when it begins from a stand, as few states of a long
    motion do, may fall in none of them or in three.
    """

    starts: int
    falls: int
    standing: int
    standing_falls: int

    def as_dict(self) -> dict[str, Any]:
        """The numbers by name."""
        return asdict(self)

    def __str__(self) -> str:
        """A sentence."""
        words = f"{self.falls} of {self.starts} starts fell within {START_SECONDS:g} s"
        return f"{words}, of those from below {STANDING_SPEED:g} m/s {self.standing_falls} of {self.standing}"


def start_falls(policy: Acting, env: AdaptVectorEnv, count: int, seed: int, progress: Progress = iter) -> StartFalls:
    """Begin episodes from random start states towards random goals; the policy's mean action acts.

    Args:
        policy: acts on observations of all worlds.
        env: worlds without a time limit.
        count: episodes, rounded up to whole rounds of all worlds.
        seed: of start states and goals, which are the same for every policy.
        progress: wraps the numbers of the rounds.
    """
    env.set_goal(None, None)
    stood, fell = [], []
    for turn in progress(range(-(-count // env.num_envs))):
        # Every round has a seed of its own, so that all policies begin alike, however often they fall.
        observations, _ = env.reset(seed=int(np.random.SeedSequence((seed, turn)).generate_state(1)[0]))
        stood.append(np.hypot(*env.worlds.physics.qvel[:, :2].T) < STANDING_SPEED)
        down = np.zeros(env.num_envs, bool)
        for _ in range(round(START_SECONDS / CONTROL_DT)):
            actions, _ = policy.predict(observations, deterministic=True)
            observations, _, terminated, _, _ = env.step(actions)
            down |= terminated
        fell.append(down)
    standing, fallen = np.concatenate(stood), np.concatenate(fell)
    return StartFalls(len(fallen), int(fallen.sum()), int(standing.sum()), int((standing & fallen).sum()))
