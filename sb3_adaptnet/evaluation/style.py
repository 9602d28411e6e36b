"""Whether a style can be seen: a policy's gait and motion beside its clip's, at about the clip's tempo."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adapt_envs import AdaptVectorEnv
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.model.soles import sole_corners
from adapt_envs.motion.clip import MotionClip
from adapt_envs.motion.library import BASES, load_clip
from adapt_envs.progress import Progress
from sb3_adaptnet.evaluation.alpha import record_base
from sb3_adaptnet.evaluation.gait import Gait, clip_gait, gait_of
from sb3_adaptnet.evaluation.imitation_error import (
    BOUNDED,
    imitation_error,
    matches,
    mean_error,
    settled,
    world_error,
)
from sb3_adaptnet.evaluation.recording import Acting, Recording, reference_speed

CADENCE_RANGE, FOOT_HEIGHT_RANGE, FLIGHT_RANGE = (0.85, 1.15), (0.75, 1.3), (0.5, 1.5)
"""Where a policy's figure over its clip's must lie for the style to be visible."""
LEAST_FLIGHT = 0.05
"""Flight share of a clip from which flights belong to its style."""
MOST_ERROR = 0.5
"""Tempo-bounded error of a visible style over its base's, at most."""
SPEED_RANGE = (0.75, 1.25)
"""Where its speed over the one that it is asked for must lie: who marches on the spot has all else."""


@dataclass(frozen=True)
class StyleFigures:
    """What is measured straight ahead, at the clip's speed; None where no world stayed up for 3 s.

    Attributes:
        visible: whether the style can be seen: no test failed; None where there is none, or no base to compare with.
        failed_tests: which tests failed, in words.
        speed_m_s: how fast the root gets ahead [m/s].
        asked_speed_m_s: the preferred speed [m/s].
        cadence_hz: strides per second of one foot; None also where nothing repeats.
        clip_cadence_hz: the clip's.
        foot_height_m: how high a foot rises in a typical stride [m], see `gait_of`.
        clip_foot_height_m: the clip's.
        flight_share: share of frames in which neither foot touches the ground.
        clip_flight_share: the clip's.
        tempo_error_m: mean distance to the clip [m], whose tempo may change by at most 15 %; in the root's frame.
        base_tempo_error_m: the base's on the same clip.
        world_error_m: mean distance to the clip in world space [m] (see `world_error`).
    """

    visible: bool | None
    failed_tests: tuple[str, ...]
    speed_m_s: float | None
    asked_speed_m_s: float | None
    cadence_hz: float | None
    clip_cadence_hz: float | None
    foot_height_m: float | None
    clip_foot_height_m: float | None
    flight_share: float | None
    clip_flight_share: float | None
    tempo_error_m: float | None
    base_tempo_error_m: float | None
    world_error_m: float | None

    def as_dict(self) -> dict[str, Any]:
        """The fields as plain values."""
        return asdict(self) | {"failed_tests": list(self.failed_tests)}


def is_style(clip: MotionClip) -> bool:
    """Whether a clip is one to adapt to, and not one that a base learned from."""
    return clip.digest not in [load_clip(name).digest for name in BASES]


def tempo_error_of_base(
    policy: Acting, env: AdaptVectorEnv, seed: int, progress: Progress = iter, base: Acting | None = None,
    speed: float | None = None,
) -> float | None:  # fmt: skip
    """A base's tempo-bounded error [m] on the worlds' style; None if it is no style, or if there is no base.

    Args:
        policy: an adaptation whose own base is meant.
        env: worlds without a time limit.
        seed: of the start states.
        progress: wraps the step numbers.
        base: another base.
        speed: preferred speed [m/s]; None for the worlds' `reference_speed`.
    """
    clip, body = env.worlds.reference.clips[0], env.worlds.reference.model
    straight = record_base(policy, env, seed, progress, base, speed) if is_style(clip) else None
    return None if straight is None else imitation_error(straight, clip, BOUNDED, body).mean


def style_figures(
    env: AdaptVectorEnv, straight: Recording, base_error: float | None = None, expected: Gait | None = None
) -> StyleFigures:
    """Measure a recording of worlds that go straight ahead, beside their clip as their own body shows it.

    Args:
        env: the worlds.
        straight: of `record_straight`.
        base_error: tempo-bounded error of the base [m]; None if there is no base to compare with.
        expected: the clip's gait, if it is known already.
    """
    clip, body = env.worlds.reference.clips[0], env.worlds.reference.model
    asked = reference_speed(env) if straight.asked_speed is None else straight.asked_speed
    expected = expected or clip_gait(clip, asked, body)
    stretches = [straight.links[start:stop, world] for world, start, stop in settled(straight)]
    found = gait_of(stretches, sole_corners(env.worlds.model), env.worlds.ground.floor_at)
    matched = matches(straight, clip, BOUNDED, body)
    error = mean_error(matched).mean
    speed = speed_of(stretches)
    failed = failed_tests(found, expected, error, base_error, speed, asked) if is_style(clip) else ()
    return StyleFigures(
        visible=False if failed else True if is_style(clip) and base_error is not None else None,
        failed_tests=failed,
        speed_m_s=rounded(speed),
        asked_speed_m_s=rounded(asked),
        cadence_hz=rounded(found.cadence_hz),
        clip_cadence_hz=rounded(expected.cadence_hz),
        foot_height_m=rounded(found.foot_height_m),
        clip_foot_height_m=rounded(expected.foot_height_m),
        flight_share=rounded(found.flight_share),
        clip_flight_share=rounded(expected.flight_share),
        tempo_error_m=rounded(error),
        base_tempo_error_m=rounded(base_error),
        world_error_m=rounded(world_error(straight, clip, matched, body)),
    )


def speed_of(stretches: Sequence[NDArray[np.float32]]) -> float | None:
    """How fast [m/s] the roots get from where stretches of link states (T, 15, 13) begin to where they end."""
    ways = [float(np.linalg.norm(links[-1, 0, :2] - links[0, 0, :2])) for links in stretches]
    return sum(ways) / (CONTROL_DT * sum(len(links) - 1 for links in stretches)) if stretches else None


def failed_tests(
    found: Gait, clip: Gait, error: float | None, base_error: float | None, speed: float | None, asked: float
) -> tuple[str, ...]:
    """Which tests of a visible style fail, in words; a test without a clip's or a base's figure is left out.

    Args:
        found: the policy's gait.
        clip: its clip's.
        error: the policy's tempo-bounded error [m].
        base_error: its base's.
        speed: how fast the policy gets ahead [m/s].
        asked: how fast it shall [m/s].
    """
    flight = clip.flight_share if (clip.flight_share or 0) > LEAST_FLIGHT else None
    most = (0.0, MOST_ERROR)
    tests = (
        ("cadence", found.cadence_hz, clip.cadence_hz, "{:.2f} Hz", "the clip's", CADENCE_RANGE),
        ("foot height", found.foot_height_m, clip.foot_height_m, "{:.2f} m", "the clip's", FOOT_HEIGHT_RANGE),
        ("flight share", found.flight_share, flight, "{:.0%}", "the clip's", FLIGHT_RANGE),
        ("tempo error", error, base_error, "{:.3f} m", "the base's", most),
        ("speed", speed, asked, "{:.2f} m/s", "what is asked for", SPEED_RANGE),
    )
    return tuple(words for test in tests if (words := _complaint(*test)))


def _complaint(
    name: str, found: float | None, other: float | None, text: str, whose: str, bounds: tuple[float, float]
) -> str:
    """What is wrong with a figure whose ratio to another must lie within bounds; nothing if it does."""
    low, high = bounds
    if other is None or (found is not None and low * other <= found <= high * other):
        return ""
    value = "none" if found is None else text.format(found)
    wanted = f"{low:g} to {high:g}" if low else f"at most {high:g}"
    return f"{name} {value}: {whose} is {text.format(other)}, {wanted} of it wanted"


def rounded(value: Any) -> Any:
    """A float of four decimals, which is more than the measures are good for; None stays None."""
    return None if value is None else round(float(value), 4)
