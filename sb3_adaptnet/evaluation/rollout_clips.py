"""Stretches of rollouts as motion clips, so that what draws and measures clips also serves policies."""

from collections.abc import Sequence

import mujoco
import numpy as np

from adapt_envs.motion.clip import FPS, MotionClip
from adapt_envs.motion.exporting import Performance, perform
from sb3_adaptnet.evaluation.imitation_error import SETTLING_SECONDS
from sb3_adaptnet.evaluation.recording import Recording, Segment

_FEWEST = 6
"""Frames that a clip must have."""


def longest(recording: Recording, seconds: float, skip: float = 0.0) -> Segment:
    """The longest stretch without a restart, cut to `seconds`; `skip` seconds at its start are left out if they can be.

    Raises:
        ValueError: if no stretch has the six frames of a clip.
    """
    world, start, stop = max(recording.segments(), key=lambda segment: segment.stop - segment.start)
    frames = round(seconds * FPS) + 1
    start = max(start, min(start + round(skip * FPS), stop - frames))
    stop = min(stop, start + frames)
    if stop - start < _FEWEST:
        raise ValueError(f"the longest stretch between two falls has {stop - start} frames; a clip needs {_FEWEST}")
    return Segment(world, start, stop)


def clip_of(recording: Recording, segment: Segment, joint_names: Sequence[str], name: str) -> MotionClip:
    """A stretch of a rollout as a clip called `name`; `joint_names` are the joints in the order of `qpos`.

    On uneven ground every frame is moved up or down as if the ground below the root were z = 0.
    """
    rows = slice(segment.start, segment.stop)
    qpos = recording.qpos[rows, segment.world].copy()
    qpos[:, 2] -= recording.floor[rows, segment.world]
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    return MotionClip(name, qpos, tuple(joint_names), origin="rollout of a policy")


def performance_of(recording: Recording, segment: Segment, model: mujoco.MjModel) -> Performance:
    """A stretch of a rollout as a skeleton's motion for animation tools; `model` is the character that made it."""
    qpos = recording.qpos[segment.start : segment.stop, segment.world]
    return perform(model, qpos, FPS, float(recording.floor[segment.start, segment.world]))


def typical_clip(recording: Recording, reference: MotionClip, joint_names: Sequence[str], name: str) -> MotionClip:
    """As much of a straight rollout as the reference lasts (1.2 to 4 s), after the first 2 s: for a contact sheet.

    `joint_names` are the joints in the order of the recording's `qpos`: the reference may have more.
    """
    seconds = min(max(reference.period / FPS, 1.2), 4.0) if reference.cyclic else 1.2
    segment = longest(recording, seconds, skip=SETTLING_SECONDS)
    return clip_of(recording, segment, joint_names, name)
