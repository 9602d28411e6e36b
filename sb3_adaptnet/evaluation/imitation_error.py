"""How far a policy's motion is from the reference: the paper's imitation error (sec. 9.3), in the root's frame.

The paper measures links in world space; there the figure mixes style with drift along the path. Here both motions are
expressed in their own heading frame (origin on the ground below the root, x along the heading, heights kept), so the
figures are not to be compared to the paper's digit by digit.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adapt_envs.features.heading_frame import heading_frame_features
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.motion.clip import MotionClip
from sb3_adaptnet.evaluation.recording import Recording
from sb3_adaptnet.evaluation.warping import match

SETTLING_SECONDS = 2.0
"""What is dropped after every start [s]: the policy is still near the reference state it was put into."""
_SHORTEST = 30
"""Frames that a stretch must have to be matched: a second."""


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
    """A clip to compare with.

    Attributes:
        positions: (P, 15, 3) link positions [m] of its frames, of one period if it repeats; heading frame.
        cyclic: whether it repeats.
    """

    positions: NDArray[np.float32]
    cyclic: bool

    @classmethod
    def of(cls, clip: MotionClip) -> "Reference":
        """The reference that a clip is.

        Raises:
            ValueError: if the clip is for a character with other joints.
        """
        model = compile_model()
        if tuple(model.actuator(i).name for i in range(model.nu)) != clip.joint_names:
            raise ValueError(f"clip {clip.name!r} is for a character with other joints")
        return cls(local_positions(Kinematics(model).link_states(clip.qpos[: clip.period])), clip.cyclic)

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


def matched_errors(motion: NDArray[np.float32], reference: Reference) -> NDArray[np.float32]:
    """Errors (T,) [m] of a motion's frames (T, 15, 3) against the frames of the reference that time warping matches.

    A reference that does not repeat and is shorter than the motion is matched anew in windows of its own length.
    """
    window = reference.window(len(motion))
    frames = reference.looped(window)
    parts = []
    for start in range(0, len(motion), window):
        cost = frame_errors(motion[start : start + window], frames)
        parts.append(cost[np.arange(len(cost)), match(cost)])
    return np.concatenate(parts)


def imitation_error(recording: Recording, clip: MotionClip) -> ImitationError:
    """The error of worlds that go straight ahead, without the first 2 s after every start.

    Args:
        recording: of `record_straight` at the clip's speed.
        clip: the reference. Of the bases' clips of minutes, which hold many speeds and turns, the stretch that is most
            alike counts.
    """
    settling, reference = round(SETTLING_SECONDS / CONTROL_DT), Reference.of(clip)
    errors = []
    for world, start, stop in recording.segments():
        rows = slice(start + settling, stop)
        if stop - rows.start >= _SHORTEST:
            local = local_positions(recording.links[rows, world], recording.floor[rows, world])
            errors.append(matched_errors(local, reference))
    if not errors:
        return ImitationError(None, None, 0)
    values = np.concatenate(errors).astype(np.float64)
    return ImitationError(float(values.mean()), float(values.std()), len(values))
