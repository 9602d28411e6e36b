"""Which phase and direction of the reference motion each world follows: an ideal walker that turns towards the goal."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.world_model.integration import CONTROL_DT

TURN_ACCELERATION = 3.0
"""How fast the turn rate may change [rad/s^2]."""
TURN_GAIN = 2.0
"""Turn rate per angle left to turn [1/s]."""
NEAR, FAR = 0.3, 0.7
"""Distances to the target [m] within which the guide keeps its direction, and from which it turns as fast as it may."""
LONGEST_LEAD = 0.6
"""How far [rad] the guide may be ahead of the character's own direction; then it waits."""
REACH, WIDE_REACH = 2, 6
"""Phases on either side that a world may be put to at a rollout's start; the wide reach for one that is lost."""
LOST = 0.2
"""Mean error of link positions [m] from which a world is lost."""
PHASE_COST = 0.002
"""Error [m] that moving by one phase must gain."""


@dataclass(frozen=True, eq=False)
class Guidance:
    """What N worlds follow at one time.

    Attributes:
        phases: (N,) of the reference motion.
        headings: (N,) direction of travel [rad], world.
        turn_rates: (N,) of that direction [rad/s].
    """

    phases: NDArray[np.integer]
    headings: NDArray[np.float32]
    turn_rates: NDArray[np.float32]


class Guide:
    """The guides of N worlds over time.

    Attributes:
        motion: what they show.
        phases, headings, turn_rates: as in `Guidance`.
        fastest_turn: largest turn rate [rad/s].
    """

    def __init__(self, motion: TrackedMotion, num_worlds: int) -> None:
        """Guides before the first `restart`."""
        self.motion = motion
        self.phases: NDArray[np.integer] = np.zeros(num_worlds, np.int64)
        self.headings = np.zeros(num_worlds)
        self.turn_rates = np.zeros(num_worlds)
        self.fastest_turn = 0.0
        self._facing = motion.facing.cpu().numpy()

    @property
    def now(self) -> Guidance:
        """A copy of the present guidance."""
        headings, rates = self.headings.astype(np.float32), self.turn_rates.astype(np.float32)
        return Guidance(self.phases.copy(), headings, rates)

    def restart(
        self, ids: NDArray[np.integer], phases: NDArray[np.integer], root_heading: NDArray[np.floating]
    ) -> None:
        """Guide the worlds `ids` from these phases (n,) on, in the directions that their roots' headings (N,) imply."""
        self.phases[ids] = phases
        self.headings[ids] = (root_heading - self._facing[self.phases])[ids]
        self.turn_rates[ids] = 0

    def advance(self, to_target: NDArray[np.floating], root_heading: NDArray[np.floating]) -> None:
        """One control step.

        Args:
            to_target: (N, 2) from the roots to the targets [m], world.
            root_heading: (N,) headings of the roots after the step [rad], world.
        """
        self.phases = self.motion.wrapped(self.phases + 1)
        left = _wrapped(np.arctan2(to_target[:, 1], to_target[:, 0]) - self.headings)
        far = np.clip((np.hypot(*to_target.T) - NEAR) / (FAR - NEAR), 0, 1)
        wanted = np.clip(TURN_GAIN * left, -self.fastest_turn, self.fastest_turn) * far
        most = TURN_ACCELERATION * CONTROL_DT
        self.turn_rates += np.clip(wanted - self.turn_rates, -most, most)
        self.headings += CONTROL_DT * self.turn_rates
        lead = _wrapped(self.headings - (root_heading - self._facing[self.phases]))
        self.headings -= lead - np.clip(lead, -LONGEST_LEAD, LONGEST_LEAD)

    def errors(self, positions: NDArray[np.floating]) -> NDArray[np.floating]:
        """(N,) mean distance [m] of the links at positions (N, L, 3), heading frame, from the guides' phases."""
        return np.linalg.norm(positions - self.motion.positions[self.phases], axis=-1).mean(axis=-1)

    def resynchronise(self, positions: NDArray[np.floating]) -> None:
        """Put every guide to the best phase near its own, by the links' positions (N, L, 3), heading frame."""
        shifts = np.arange(-WIDE_REACH, WIDE_REACH + 1)
        candidates = self.motion.wrapped(self.phases[:, None] + shifts)
        errors = np.linalg.norm(positions[:, None] - self.motion.positions[candidates], axis=-1).mean(axis=-1)
        found = errors[:, WIDE_REACH] <= LOST
        beyond = found[:, None] & (np.abs(shifts) > REACH)
        costs = np.where(beyond, np.inf, errors + PHASE_COST * np.abs(shifts))
        self.phases = candidates[np.arange(len(candidates)), costs.argmin(axis=1)]


def _wrapped(angle: NDArray[np.floating]) -> NDArray[np.floating]:
    return (angle + np.pi) % (2 * np.pi) - np.pi
