"""Tracked worlds beside companions: each group follows a motion of its own, and all are one batch."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.rollouts.real_rollout import Moment
from sb3_adaptnet.algorithms.svg_settings import Episodes
from sb3_adaptnet.algorithms.tracked_worlds import TrackedStep, TrackedWorlds
from sb3_adaptnet.algorithms.tracking.guide import Guidance, Guiding
from sb3_adaptnet.algorithms.tracking.tracked_groups import Env, TrackedMotions
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.modules.observation import FLAT
from sb3_adaptnet.stacking import JoinedWorlds


class JoinedTrackedWorlds:
    """Groups of `TrackedWorlds` as one batch of N worlds, with what `SVG` needs of them.

    Phases count through the motions of all groups, one after another.

    Attributes:
        env: the worlds.
        groups: those of each motion.
        companions: (N,) number of the group, and so of the frozen adaptation that acts there; 0 for none.
    """

    def __init__(
        self,
        env: JoinedWorlds,
        motions: Sequence[TrackedMotion],
        episodes: Episodes,
        guiding: Guiding,
        rng: np.random.Generator,
    ) -> None:
        """Guide each group of `env` along its motion; otherwise as `TrackedWorlds`."""
        self.env, self.companions = env, env.numbers
        self.groups = [
            TrackedWorlds(group, motion, episodes, guiding, rng)
            for group, motion in zip(env.groups, motions, strict=True)
        ]
        self._first_phases = np.cumsum([0, *(len(motion) for motion in motions)])[:-1]
        self._ends = np.cumsum([group.num_envs for group in env.groups])[:-1]

    @property
    def strengths(self) -> NDArray[np.float32]:
        """(N,) at which what learns acts."""
        return np.concatenate([group.strengths for group in self.groups])

    @property
    def lengths(self) -> list[int]:
        """Steps of the episodes that ended in the last rollout."""
        return list(chain.from_iterable(group.lengths for group in self.groups))

    @property
    def left_from_behind(self) -> float:
        """The guides' [rad]."""
        return self.groups[0].left_from_behind

    def schedule(self, samples: int) -> None:
        """As `TrackedWorlds.schedule`."""
        for group in self.groups:
            group.schedule(samples)

    def begin(self, samples: int) -> NDArray[np.float32]:
        """As `TrackedWorlds.begin`."""
        self.schedule(samples)
        observed: Any = self.env.reset()
        for group, part in zip(self.groups, np.split(observed[FLAT], self._ends), strict=True):
            group.take_up(part)
        return np.asarray(observed[FLAT])

    def resynchronise(self, observations: NDArray[np.float32]) -> None:
        """As `TrackedWorlds.resynchronise`."""
        for group, part in zip(self.groups, np.split(observations, self._ends), strict=True):
            group.resynchronise(part)

    def now(self) -> Moment:
        """The worlds before the next step."""
        moments = [vars(group.now()) for group in self.groups]
        return Moment(**{name: np.concatenate([moment[name] for moment in moments]) for name in moments[0]})

    def step(self, actions: NDArray[np.float32]) -> TrackedStep:
        """As `TrackedWorlds.step`."""
        parts = zip(self.groups, np.split(actions, self._ends), strict=True)
        steps = [group.step(part)._asdict() for group, part in parts]
        guided = [dict(vars(step.pop("guidance"))) for step in steps]
        for part, first in zip(guided, self._first_phases, strict=True):
            part["phases"] = part["phases"] + first
        infos = list(chain.from_iterable(step.pop("infos") for step in steps))
        joined = {name: np.concatenate([step[name] for step in steps]) for name in steps[0]}
        guidance = Guidance(**{name: np.concatenate([part[name] for part in guided]) for name in guided[0]})
        return TrackedStep(**joined, infos=infos, guidance=guidance)


@contextmanager
def own_goals(env: Env) -> Iterator[None]:
    """Afterwards new goals lie again where they did before, whatever schedules made of that meanwhile."""
    before = np.asarray(env.get_attr("goal_spread"), np.float64)
    try:
        yield
    finally:
        env.set_attr("goal_spread", before)


def tracked_worlds(
    env: Env, motions: TrackedMotions, episodes: Episodes, guiding: Guiding, rng: np.random.Generator
) -> TrackedWorlds | JoinedTrackedWorlds:
    """Worlds whose groups follow these motions."""
    if isinstance(env, JoinedWorlds):
        return JoinedTrackedWorlds(env, motions.of_groups, episodes, guiding, rng)
    return TrackedWorlds(env, motions.together, episodes, guiding, rng)
