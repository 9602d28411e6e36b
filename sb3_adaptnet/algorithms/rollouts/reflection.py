"""Rollouts in a mirror: what a character learns of turns to one side serves it on the other."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.rollouts.real_rollout import RealRollout, root_headings
from sb3_adaptnet.algorithms.tracking.gaits import Gaits
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.mirror import Mirror
from sb3_adaptnet.world_model.transitions import Transitions

SYMMETRIC = 0.05
"""Mean difference [rad] of the joints' angles up to which a motion is its own mirror image half a cycle later."""


@dataclass(frozen=True)
class Reflection:
    """What turns a rollout into one that might have happened as well.

    Attributes:
        mirror: the character's.
        gaits: the motion's, which half a cycle later is its own mirror image.
    """

    mirror: Mirror
    gaits: Gaits

    @classmethod
    def of(cls, character: Character, motion: TrackedMotion) -> Self | None:
        """The reflection; None if the character's sides differ, or the motion's do, or it is no cycle."""
        mirror, gaits = Mirror.of(character), motion.gaits
        if mirror is None or not gaits.cyclic.all():
            return None
        angles = motion.angles.t().cpu().numpy()
        difference = mirror.of_joints(angles) - angles[half_a_cycle_later(gaits, np.arange(len(motion)))]
        return cls(mirror, gaits) if np.abs(difference).mean() <= SYMMETRIC else None

    def of_rollout(self, rollout: RealRollout, worlds: NDArray[np.bool_], left_from_behind: float) -> RealRollout:
        """The rollout with some worlds (N,) in the mirror.

        To a target within `left_from_behind` [rad] of straight behind guides turn left, and in the mirror right. There
        the episodes of these worlds count as ended, so that nobody learns to turn either way.
        """
        data = rollout.transitions

        def changed(part: NDArray, change: Callable[[NDArray], NDArray]) -> NDArray:
            part = part.copy()
            part[:, worlds] = change(part[:, worlds])
            return part

        transitions = Transitions(
            qpos=changed(data.qpos, self.mirror.of_qpos),
            qvel=changed(data.qvel, self.mirror.of_qvel),
            actions=changed(data.actions, self.mirror.of_joints),
            ended=data.ended | (straight_behind(rollout, left_from_behind) & worlds),
        )
        return replace(
            rollout,
            transitions=transitions,
            noise=changed(rollout.noise, self.mirror.of_joints),
            frames=changed(rollout.frames, self.mirror.of_links),
            targets=changed(rollout.targets, lambda part: part * np.array([1, -1], part.dtype)),
            phases=changed(rollout.phases, lambda part: half_a_cycle_later(self.gaits, part)),
            headings=changed(rollout.headings, np.negative),
            turn_rates=changed(rollout.turn_rates, np.negative),
            mirrored=worlds,
        )


def half_a_cycle_later(gaits: Gaits, phases: NDArray[np.integer]) -> NDArray[np.integer]:
    """Phases (...) half a cycle after others; of an odd number of phases, half a phase less."""
    return gaits.shifted(phases, gaits.lengths[gaits.of(phases)] // 2)


def straight_behind(rollout: RealRollout, within: float) -> NDArray[np.bool_]:
    """(T, N) whether the target is within an angle [rad] of straight behind the guide or the character after a step."""
    qpos = rollout.transitions.qpos[1:]
    x, y = np.moveaxis(rollout.targets[1:] - qpos[..., :2], -1, 0)
    headings = (rollout.headings, root_headings(qpos))
    behind = [np.cos(np.arctan2(y, x) - heading) < -np.cos(within) for heading in headings]
    return behind[0] | behind[1]
