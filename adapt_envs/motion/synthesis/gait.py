"""What a gait is made of: the row of the table from which a motion is synthesised."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Pair = tuple[float, float]
"""A value for the right and one for the left side."""


@dataclass(frozen=True)
class Wave:
    """An angle over the gait cycle, in degrees: mean + swing cos(phase - lag) + twice cos(2 phase - twice_lag).

    The phase is 0 at the strike of the right foot and 180 at that of the left; limbs of the left side see it 180 later,
    so that one wave serves both.
    """

    mean: float = 0.0
    swing: float = 0.0
    lag: float = 0.0
    twice: float = 0.0
    twice_lag: float = 0.0

    def __call__(self, phase: Array, scale: Array) -> Array:
        """Angles (T,) in radians at phases (T,) [rad]; `scale` (T,) multiplies all but the mean."""
        first = self.swing * np.cos(phase - np.radians(self.lag))
        second = self.twice * np.cos(2 * phase - np.radians(self.twice_lag))
        return np.radians(self.mean + scale * (first + second))


@dataclass(frozen=True)
class Arm:
    """Waves of one arm: flexion forward, away from the body, inward twist, elbow flexion."""

    flexion: Wave = Wave(6, -17, 15)
    outward: Wave = Wave(7)
    twist: Wave = Wave(8)
    elbow: Wave = Wave(24, -9, 30)


@dataclass(frozen=True)
class Kick:
    """A detour of the swing foot, on top of its plain path.

    Attributes:
        forward, up: displacement at its peak [m].
        pitch: change of the foot's pitch at the peak, toe down positive [deg].
        stretch: how straight the knee gets at the peak: 1 is straight.
        peak: when, as a fraction of the swing.
        sharpness: 3 is as long as the swing allows, 6 a brief flick.
    """

    forward: float = 0.0
    up: float = 0.0
    pitch: float = 0.0
    stretch: float = 0.0
    peak: float = 0.5
    sharpness: float = 3.0


@dataclass(frozen=True)
class Gait:
    """One row: all that sets a way of walking apart. Defaults are the plain walk (gait figures of Perry and of Winter).

    Values that differ between the sides are pairs (right, left).

    Attributes:
        name: name of the clip.
        kind: which quality thresholds hold: walk, run, quiet, forceful or hopping.
        frames: period in frames at 30 Hz of a style; 0 for a base, which follows a path.
        cycles: gait cycles in one period.
        length: step length [m] of a style: how far the foot lands ahead of the other.
        share: the time of the step that this foot's strike begins, over half the cycle.
        width: lateral distance of the ankles [m].
        double: double support as a fraction of the step time; negative is flight.
        toe_out: yaw of the feet outward [deg].
        strike: toe-up pitch at heel strike [deg].
        push: heel-up pitch at toe-off [deg].
        rise: when the heel rises, as a fraction of single support.
        clearance: height of the swing foot's lowest point [m].
        outward: sideways detour of the swing foot [m].
        braking: deceleration of the foot as it lands [m/s^2]: it arrives late and brisk, not early and slow.
        kick: detours of the swing foot.
        roll: where the zero-moment point enters and leaves the foot, ahead of the ankle [m].
        inset: how far inside of the ankle it runs [m].
        crouch: pelvis lowered by this [m] below the height that keeps the legs nearly straight.
        bob: largest vertical travel of the centre of mass [m] (less if its force would pass `surge`); of a skip, how
            much it dips between landing and take-off.
        bob_shift: how much later than mid-step the bob is, as a fraction of the step.
        surge: largest swing of the vertical force that the bob makes, over the weight.
        pelvis_yaw, pelvis_list, pelvis_tilt: pelvis relative to the heading: right side forward, left side up, forward.
        torso_yaw, torso_roll, torso_pitch: trunk relative to the heading: left, right side down, forward.
        head_yaw, head_roll, head_pitch: head relative to the heading.
        arms: waves of the right and the left arm.
        knee_out: degrees that the knees point outward.
        hop: None, or when the foot of a skip hops off and lands again, as fractions of its half cycle.
    """

    name: str
    kind: str = "quiet"
    frames: int = 0
    cycles: int = 1
    length: Pair = (0.66, 0.66)
    share: Pair = (1.0, 1.0)
    width: float = 0.12
    double: float = 0.22
    toe_out: float = 6.0
    strike: Pair = (20.0, 20.0)
    push: Pair = (52.0, 52.0)
    rise: float = 0.55
    clearance: float = 0.025
    outward: float = 0.015
    braking: float = 24.0
    kick: tuple[tuple[Kick, ...], tuple[Kick, ...]] = ((), ())
    roll: Pair = (0.0, 0.12)
    inset: float = 0.008
    crouch: float = 0.0
    bob: float = 0.045
    surge: float = 0.205
    bob_shift: float = 0.0
    pelvis_yaw: Wave = Wave(0, 6.5, 10)
    pelvis_list: Wave = Wave(0, -3.5, 75)
    pelvis_tilt: Wave = Wave(3, 0, 0, 1, 0)
    torso_yaw: Wave = Wave(0, -5, 10)
    torso_roll: Wave = Wave(0, 1.5, 90)
    torso_pitch: Wave = Wave(3, 0, 0, 1.0, 60)
    head_yaw: Wave = Wave()
    head_roll: Wave = Wave()
    head_pitch: Wave = Wave(2)
    arms: tuple[Arm, Arm] = field(default=(Arm(), Arm()))
    knee_out: float = 0.0
    hop: Pair | None = None
