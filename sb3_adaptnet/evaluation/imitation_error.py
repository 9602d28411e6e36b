"""How far a policy's motion is from the reference, in the root's frame and in the world's (paper, sec. 9.3).

Root's frame: origin on the ground below the root, x along the heading, heights kept. World: where the paper measures;
there the error mixes style with drift along the path, and the paper does not say how it aligns the two paths. Here the
clip is moved and turned on the ground every two seconds, to where it fits best: a wrong speed, direction or sway counts
as far as it goes in that time, and drift over a whole rollout does not.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features.heading_frame import heading_frame_features
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import plain_model
from adapt_envs.model.humanoid import CONTROL_DT, joint_names
from adapt_envs.motion.clip import FPS, MotionClip
from adapt_envs.motion.on_body import shown_by
from sb3_adaptnet.evaluation.recording import Recording, Segment
from sb3_adaptnet.evaluation.warping import match

SETTLING_SECONDS = 2.0
"""What is dropped after every start [s]: the policy is still near the reference state it was put into."""
_SHORTEST = FPS
"""Frames that a stretch must have to be matched: a second."""
_ALIGNED = 2 * FPS
"""Frames that are aligned in the world at once: two seconds."""


class Tempo(NamedTuple):
    """Bounds of the tempo at which time warping may run the reference; 1 is its own."""

    slowest: float
    fastest: float


FREE, BOUNDED = Tempo(0.5, 2.0), Tempo(0.85, 1.15)
"""Half to double tempo; and within 15 %, so that a style at another tempo is not taken for the style."""


@dataclass(frozen=True)
class ImitationError:
    """Mean and standard deviation over matched frames [m], and their number; None if no frame could be matched."""

    mean: float | None
    std: float | None
    frames: int


def local_positions(links: NDArray[np.float32], floor: NDArray[np.float32] | float = 0.0) -> NDArray[np.float32]:
    """Link positions (T, 15, 3) of link states (T, 15, 13), each frame in the heading frame of its own root.

    `floor` (T,) is the height [m] of the ground below the root.
    """
    return heading_frame_features(links[:, None], floor)[:, 0, :, :3]


@dataclass(frozen=True)
class Reference:
    """A clip to compare with, as a body shows it.

    Attributes:
        clip: the clip, of the body's joints.
        body: the character that shows it.
    """

    clip: MotionClip
    body: mujoco.MjModel

    @classmethod
    def of(cls, clip: MotionClip, body: mujoco.MjModel | None = None) -> "Reference":
        """The reference that a clip is for a body (`shown_by`), or for the plain character.

        Raises:
            ValueError: if the clip is for a character with other joints.
        """
        if joint_names() != clip.joint_names:
            raise ValueError(f"clip {clip.name!r} is for a character with other joints")
        return cls(clip, plain_model()) if body is None else cls(shown_by(clip, body), body)

    @property
    def cyclic(self) -> bool:
        """Whether it repeats."""
        return self.clip.cyclic

    def links(self, qpos: NDArray[np.float64]) -> NDArray[np.float32]:
        """Link states (T, 15, 13), world frame, of configurations (T, nq) of the clip."""
        return Kinematics(self.body).link_states(qpos)

    @cached_property
    def positions(self) -> NDArray[np.float32]:
        """Link positions (P, 15, 3) [m] of its frames, of one period if it repeats; heading frame."""
        return local_positions(self.links(self.clip.qpos[: self.clip.period]))

    def window(self, frames: int) -> int:
        """How many of `frames` frames can be matched at once: no more than a clip has that does not repeat."""
        return frames if self.cyclic else min(frames, len(self.positions))

    def looped(self, frames: int) -> NDArray[np.float32]:
        """Positions (R, 15, 3), looped until `frames` frames fit at double speed from any frame, if it repeats."""
        period = len(self.positions)
        return self.positions[np.arange(2 * frames + period) % period] if self.cyclic else self.positions


def frame_errors(motion: NDArray[np.float32], reference: NDArray[np.float32]) -> NDArray[np.float32]:
    """Errors e (T, R) [m] of the paper's sec. 9.3 between all frames of two motions: mean distance over the 15 links.

    Args:
        motion: (T, 15, 3) link positions.
        reference: (R, 15, 3) link positions.
    """
    links = motion.shape[1]
    columns = np.ascontiguousarray(reference.transpose(1, 2, 0))
    errors = np.empty((len(motion), len(reference)), np.float32)
    for row, frame in zip(errors, motion, strict=True):
        offset = columns - frame[:, :, None]
        np.square(offset, out=offset)
        row[:] = np.sqrt(offset[:, 0] + offset[:, 1] + offset[:, 2]).sum(axis=0) / links
    return errors


class Match(NamedTuple):
    """W frames `start` to `stop - 1` of a world, and what time warping matches them to.

    Attributes:
        segment: the frames of the recording.
        frames: (W,) frames of the clip; those of one that repeats go on beyond its period.
        errors: (W,) errors [m] between them.
    """

    segment: Segment
    frames: NDArray[np.int64]
    errors: NDArray[np.float32]


def settled(recording: Recording) -> Iterator[Segment]:
    """The stretches between restarts without their first 2 s, where a second or more is left."""
    settling = round(SETTLING_SECONDS / CONTROL_DT)
    for world, start, stop in recording.segments():
        if stop - start - settling >= _SHORTEST:
            yield Segment(world, start + settling, stop)


def matches(
    recording: Recording, clip: MotionClip, tempo: Tempo = FREE, body: mujoco.MjModel | None = None
) -> list[Match]:
    """The frames of all settled stretches against those of the clip that time warping matches.

    The clip is as `body`, the recorded character, shows it; None for the plain one.
    Stretches longer than a clip that does not repeat are matched in windows of its length. Of the bases' clips of
    minutes, which hold many speeds and turns, the stretch that is most alike counts.
    """
    reference, found = Reference.of(clip, body), []
    for world, start, end in settled(recording):
        window = reference.window(end - start)
        frames = reference.looped(window)
        for first in range(start, end, window):
            rows = slice(first, min(first + window, end))
            cost = frame_errors(local_positions(recording.links[rows, world], recording.floor[rows, world]), frames)
            matched = match(cost, *tempo)
            errors = cost[np.arange(len(cost)), matched]
            found.append(Match(Segment(world, rows.start, rows.stop), matched, errors))
    return found


def imitation_error(
    recording: Recording, clip: MotionClip, tempo: Tempo = FREE, body: mujoco.MjModel | None = None
) -> ImitationError:
    """The error of worlds that go straight ahead, without the first 2 s after every start.

    Args:
        recording: of `record_straight` at the clip's speed.
        clip: the reference.
        tempo: bounds of the time warping.
        body: the recorded character, which shows the clip; None for the plain one.
    """
    return mean_error(matches(recording, clip, tempo, body))


def mean_error(found: Sequence[Match]) -> ImitationError:
    """The error over all matched frames."""
    if not found:
        return ImitationError(None, None, 0)
    values = np.concatenate([part.errors for part in found]).astype(np.float64)
    return ImitationError(float(values.mean()), float(values.std()), len(values))


def world_error(
    recording: Recording, clip: MotionClip, found: Sequence[Match], body: mujoco.MjModel | None = None
) -> float | None:
    """Mean distance [m] of the links from the clip's in world space; None if there are no matches.

    Args:
        recording: of `record_straight` at the clip's speed.
        clip: the reference.
        found: the recording's frames matched to the clip's (`matches`).
        body: the recorded character, which shows the clip; None for the plain one.
    """
    reference, up, errors = Reference.of(clip, body), np.array([0, 0, 1], np.float32), []
    for (world, start, stop), frames, _ in found:
        here = recording.links[start:stop, world, :, :3] - recording.floor[start:stop, world, None, None] * up
        there = reference.links(reference.clip.at(frames))[..., :3]
        errors += [
            aligned_errors(here[i : i + _ALIGNED], there[i : i + _ALIGNED]) for i in range(0, len(here), _ALIGNED)
        ]
    return float(np.concatenate(errors).mean()) if errors else None


def aligned_errors(here: NDArray[np.float32], there: NDArray[np.float32]) -> NDArray[np.float32]:
    """Mean distances (T,) [m] of links (T, L, 3) from others, which are first aligned with them as well as they can be.

    The others are moved and turned on the ground, by the one shift and turn about z with the least sum of squares.
    """
    a, b = (points[..., 0] + 1j * points[..., 1] for points in (here, there))
    a, b = a - a.mean(), b - b.mean()
    turn = np.exp(1j * np.angle((a * b.conj()).sum()))
    return np.hypot(np.abs(a - turn * b), here[..., 2] - there[..., 2]).mean(axis=1)
