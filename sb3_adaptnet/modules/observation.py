"""An observation as the networks take it: frames, goal and optional heightmap."""

from typing import NamedTuple

import torch

from sb3_adaptnet.modules.architecture import Architecture


class Observation(NamedTuple):
    """A batch of observations, split.

    Attributes:
        frames: body states (B, frame_count, frame_size), oldest first, in the latest root's heading frame [m, m/s,
            rad/s].
        goal: (B, goal_size): unit direction in the heading frame, distance [m], preferred speed [m/s].
        heightmap: (B, 1, 35, 35) terrain heights relative to the ground under the root [m], or None.
        base_code: (B, gru_size) what a frozen base's encoder makes of the frames, if it is known already, or None.
    """

    frames: torch.Tensor
    goal: torch.Tensor
    heightmap: torch.Tensor | None
    base_code: torch.Tensor | None = None


def split_observation(
    flat: torch.Tensor, architecture: Architecture, heightmap: torch.Tensor | None = None
) -> Observation:
    """Split flat observations (B, observation_size) into frames and goal.

    Args:
        flat: observations; index = frame * frame_size + component, then the goal.
        architecture: the sizes.
        heightmap: (B, 1, 35, 35) or None; handed through.

    Returns:
        The parts, as views of the input.

    Raises:
        ValueError: if the width is not the architecture's.
    """
    if flat.shape[-1] != architecture.observation_size:
        raise ValueError(
            f"observations have {flat.shape[-1]} numbers, the network reads {architecture.observation_size}"
        )
    body = flat[:, : -architecture.goal_size]
    frames = body.reshape(-1, architecture.frame_count, architecture.frame_size)
    return Observation(frames, flat[:, -architecture.goal_size :], heightmap)
