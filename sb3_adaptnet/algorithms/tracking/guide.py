"""Which phase and direction of the reference motion each world follows: an ideal walker that turns towards the goal."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.objectives.schedule import Schedule, check_schedule, highest
from sb3_adaptnet.world_model.integration import CONTROL_DT

NEAR, FAR = 0.3, 0.7
"""Distances to the target [m] within which the guide keeps its direction, and from which it turns as fast as it may."""
STYLE_AT_REST, STYLE_ANGLE = 1.3, 0.8
"""The style counts by the first number, less the angle [rad] between travel and target over the second; at most 1."""
CALM_STYLE = 0.95
"""A world turns while its style counts less."""
TEMPO_EXPONENT, SLOWEST_TEMPO, FASTEST_TEMPO = 0.5, 0.87, 1.15
"""Phases per control step are this power of the preferred speed over the motion's own, within these bounds."""
REACH, WIDE_REACH = 2, 6
"""Phases on either side that a world may be put to at a rollout's start; the wide reach for one that is lost."""
LOST = 0.2
"""Mean error of link positions [m] from which a world is lost."""
PHASE_COST = 0.002
"""Error [m] that moving by one phase must gain."""
_LONG_CALM = 10_000
"""Control steps of calm that a new episode begins with: its start state is the motion's."""


@dataclass(frozen=True)
class Guiding:
    """How guides lead.

    Attributes:
        turn_rate: at most so fast the reference turns towards the goal [rad/s].
        turn_per_footstep: at most so far it turns per footstep [rad]: no style turns faster than it sets its feet.
        turn_acceleration: how fast the turn rate may change [rad/s^2].
        turn_gain: turn rate at most, per angle left to turn [1/s].
        turn_at_rest: share of the turn rate for a character that stands; it grows with its speed, to the whole at the
            preferred one. With 1 it shall turn on the spot, which gait cycles do not show, and may fall.
        left_from_behind: to a target within this angle [rad] of straight behind, on either side, it turns left. Who
            sways sees such a target now left, now right; if guides turn either way, it walks straight on until it is
            lost.
        gaits: speeds [m/s] of the gait cycles that are cut out of a motion of minutes, one for each range of preferred
            speeds; without any the motion is followed from its first state to its last.
        longest_lead: how far [rad] it may be ahead of the character's own direction; then it waits. With 0.6 it cost
            too little not to turn.
        least_style: what the style's loss is worth at least while the character turns; 1 for its full worth. A clip
            that walks straight has no right pose for a turn.
    """

    turn_rate: Schedule = 1.2
    turn_per_footstep: float = 0.8
    turn_acceleration: Schedule = 3.0
    turn_gain: Schedule = 2.0
    turn_at_rest: Schedule = 1.0
    longest_lead: float = 1.5
    left_from_behind: Schedule = 0.0
    gaits: tuple[float, ...] = ()
    least_style: Schedule = 0.2

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ValueError: for a negative rate, acceleration, gain, angle or worth, an angle of half a turn or more, a
                share above 1, or a turn, lead or speed that is not positive.
        """
        check_schedule("turn_rate", self.turn_rate)
        check_schedule("least_style", self.least_style)
        check_schedule("turn_acceleration", self.turn_acceleration)
        check_schedule("turn_gain", self.turn_gain)
        check_schedule("turn_at_rest", self.turn_at_rest)
        if highest(self.turn_at_rest) > 1:
            raise ValueError(f"turn_at_rest is a share, at most 1, not {self.turn_at_rest!r}")
        check_schedule("left_from_behind", self.left_from_behind)
        if highest(self.left_from_behind) >= np.pi:
            raise ValueError(f"left_from_behind is an angle below pi, not {self.left_from_behind!r}")
        if not (self.turn_per_footstep > 0 and self.longest_lead > 0):
            raise ValueError(f"turn_per_footstep and longest_lead must be positive, not {self}")
        if not isinstance(self.gaits, (tuple, list)) or any(speed <= 0 for speed in self.gaits):
            raise ValueError(f"gaits is a list of speeds above 0 m/s, not {self.gaits}")


@dataclass(frozen=True, eq=False)
class Guidance:
    """What N worlds follow at one time.

    Attributes:
        phases: (N,) of the reference motion.
        headings: (N,) direction of travel [rad], world.
        turn_rates: (N,) of that direction [rad/s].
        style: (N,) what the style's loss is worth, 1 but in turns.
    """

    phases: NDArray[np.integer]
    headings: NDArray[np.float32]
    turn_rates: NDArray[np.float32]
    style: NDArray[np.float32]


class Guide:
    """The guides of N worlds over time.

    Attributes:
        motion: what they show.
        phases, headings, turn_rates, style: as in `Guidance`.
        calm_steps: (N,) control steps since the character last turned.
        fastest_turn: largest turn rate [rad/s], for all or (N,).
        turn_acceleration, turn_gain, turn_at_rest, left_from_behind, least_style: as in `Guiding`, now.
    """

    def __init__(self, motion: TrackedMotion, num_worlds: int, longest_lead: float = 1.5) -> None:
        """Guides before the first `restart`; they stay at most `longest_lead` [rad] ahead."""
        self.motion, self.longest_lead = motion, longest_lead
        self.phases: NDArray[np.integer] = np.zeros(num_worlds, np.int64)
        self.headings = np.zeros(num_worlds)
        self.turn_rates = np.zeros(num_worlds)
        self.style = np.ones(num_worlds)
        self.calm_steps = np.full(num_worlds, _LONG_CALM)
        self.fastest_turn: float | NDArray[np.floating] = 0.0
        self.turn_acceleration, self.turn_gain, self.turn_at_rest = 3.0, 2.0, 1.0
        self.left_from_behind, self.least_style = 0.0, 1.0
        self._between = np.zeros(num_worlds)  # how far each guide is beyond its phase, -0.5 to 0.5
        self._facing = motion.facing.cpu().numpy()

    @property
    def now(self) -> Guidance:
        """A copy of the present guidance."""
        headings, rates = self.headings.astype(np.float32), self.turn_rates.astype(np.float32)
        return Guidance(self.phases.copy(), headings, rates, self.style.astype(np.float32))

    def restart(self, ids: NDArray[np.integer], seen: NDArray[np.floating], root_heading: NDArray[np.floating]) -> None:
        """Guide the worlds `ids` from where they are, in the directions that their roots' headings (N,) imply.

        `seen` are the states of all worlds' links (N, L, 6), as `TrackedMotion.seen` has them.
        """
        self.phases[ids] = self.motion.nearest(seen[ids])
        self.headings[ids] = (root_heading - self._facing[self.phases])[ids]
        self.turn_rates[ids], self._between[ids] = 0, 0
        self.style[ids], self.calm_steps[ids] = 1, _LONG_CALM

    def advance(
        self,
        to_target: NDArray[np.floating],
        root_heading: NDArray[np.floating],
        speeds: NDArray[np.floating],
        moving: NDArray[np.floating],
    ) -> None:
        """One control step.

        Args:
            to_target: (N, 2) from the roots to the targets [m], world.
            root_heading: (N,) headings of the roots after the step [rad], world.
            speeds: (N,) preferred [m/s].
            moving: (N,) speeds of the roots over the ground after the step [m/s].
        """
        self._advance_phases(speeds)
        travel, target = root_heading - self._facing[self.phases], np.arctan2(to_target[:, 1], to_target[:, 0])
        far = np.clip((np.hypot(*to_target.T) - NEAR) / (FAR - NEAR), 0, 1)
        left = _wrapped(target - self.headings - self.left_from_behind) + self.left_from_behind
        fastest = self.fastest_turn * (self.turn_at_rest + (1 - self.turn_at_rest) * np.minimum(moving / speeds, 1))
        wanted = self._wanted_turn(left, fastest) * far
        most = self.turn_acceleration * CONTROL_DT
        self.turn_rates += np.clip(wanted - self.turn_rates, -most, most)
        self.headings += CONTROL_DT * self.turn_rates
        lead = _wrapped(self.headings - travel)
        self.headings -= lead - np.clip(lead, -self.longest_lead, self.longest_lead)
        self._weigh_style(np.abs(_wrapped(target - travel)) * far)

    def _wanted_turn(self, left: NDArray[np.floating], fastest: NDArray[np.floating]) -> NDArray[np.floating]:
        """Turn rates (N,), at most `fastest`, for angles (N,) left to turn; the turns can still be ended in time."""
        in_time = np.sqrt(2 * self.turn_acceleration * np.abs(left))
        rate = np.minimum(self.turn_gain * np.abs(left), np.minimum(in_time, fastest))
        return np.asarray(np.sign(left) * rate)

    def _advance_phases(self, speeds: NDArray[np.floating]) -> None:
        gaits = self.motion.gaits
        self.phases = gaits.at_speeds(self.phases, speeds)
        usual = gaits.speeds[gaits.of(self.phases)]
        clock = self._between + np.clip((speeds / usual) ** TEMPO_EXPONENT, SLOWEST_TEMPO, FASTEST_TEMPO)
        whole = np.rint(clock).astype(np.int64)
        self.phases, self._between = gaits.shifted(self.phases, whole), clock - whole

    def _weigh_style(self, angles: NDArray[np.floating]) -> None:
        """By the angles (N,) [rad], not negative, between travel and target."""
        self.style = np.clip(STYLE_AT_REST - angles / STYLE_ANGLE, self.least_style, 1.0)
        self.calm_steps = np.where(self.style < CALM_STYLE, 0, self.calm_steps + 1)

    def errors(self, seen: NDArray[np.floating]) -> NDArray[np.floating]:
        """(N,) mean distance [m] of the links, as `seen` (N, L, 6), from the guides' phases."""
        return _distance(seen, self.motion.seen[self.phases])

    def resynchronise(self, seen: NDArray[np.floating]) -> None:
        """Put every guide to the best phase near its own, given the links as `seen` (N, L, 6)."""
        shifts = np.arange(-WIDE_REACH, WIDE_REACH + 1)
        candidates = self.motion.gaits.shifted(self.phases[:, None], shifts)
        errors = _distance(seen[:, None], self.motion.seen[candidates])
        found = errors[:, WIDE_REACH] <= LOST
        beyond = found[:, None] & (np.abs(shifts) > REACH)
        costs = np.where(beyond, np.inf, errors + PHASE_COST * np.abs(shifts))
        self.phases = candidates[np.arange(len(candidates)), costs.argmin(axis=1)]


def _distance(seen: NDArray[np.floating], there: NDArray[np.floating]) -> NDArray[np.floating]:
    """Mean distance [m] of the positions (..., L, 3) in (..., L, 6)."""
    return np.asarray(np.linalg.norm(seen[..., :3] - there[..., :3], axis=-1).mean(axis=-1))


def _wrapped(angle: NDArray[np.floating]) -> NDArray[np.floating]:
    return (angle + np.pi) % (2 * np.pi) - np.pi
