"""Observations as the networks take them: frames, goal and optional heightmap; and as dicts, where there is one."""

from collections.abc import Mapping
from typing import NamedTuple, TypeVar

import torch

from sb3_adaptnet.modules.architecture import Architecture

Part = TypeVar("Part")
"""Array, tensor or space of one kind of observation."""
FLAT = "observation"
"""Key of the flat observations in a dict; where there are no others, they stand alone."""
HEIGHTMAP = "heightmap"
"""Key of the heightmaps in a dict."""
BASE_CODE = "base_code"
"""Key under which a dict may hand back what a frozen base's encoder made of the frames."""


COMPANION = "companion"
"""Key of the number of the frozen adaptation that acts beside what is learned; 0 is none."""
COMPANION_OFFSET = "companion_offset"
"""Key under which a dict may hand back what the companion adds to the latents."""
COMPANION_MEAN = "companion_mean"
"""Key under which a dict may hand back the mean action of the base with the companion alone."""


class Observation(NamedTuple):
    """A batch of observations, split.

    Attributes:
        frames: body states (B, frame_count, frame_size), oldest first, in the latest root's heading frame [m, m/s,
            rad/s].
        goal: (B, goal_size): unit direction in the heading frame, distance [m], preferred speed [m/s].
        heightmap: (B, 1, 35, 35) terrain heights relative to the ground under the root [m], or None.
        base_code: (B, gru_size) what a frozen base's encoder makes of the frames, if it is known already, or None.
        companion: (B,) int64, which frozen adaptation acts beside what is learned, 0 for none; None where none can.
        companion_offset: (B, gru_size + goal_size) what the companions add to z0, if it is known already, or None.
        companion_mean: (B, action_size) the mean action of the base with its companion alone, likewise.
    """

    frames: torch.Tensor
    goal: torch.Tensor
    heightmap: torch.Tensor | None
    base_code: torch.Tensor | None = None
    companion: torch.Tensor | None = None
    companion_offset: torch.Tensor | None = None
    companion_mean: torch.Tensor | None = None

    def remembered(self) -> dict[str, torch.Tensor]:
        """What frozen networks made of it, by the keys under which a dict hands it back."""
        known = {
            BASE_CODE: self.base_code,
            COMPANION_OFFSET: self.companion_offset,
            COMPANION_MEAN: self.companion_mean,
        }
        return {key: values for key, values in known.items() if values is not None}


def parts_of(whole: Part | Mapping[str, Part]) -> dict[str, Part]:
    """Observations, or their space, as a dict; what is none becomes one with the key "observation"."""
    return dict(whole) if isinstance(whole, Mapping) else {FLAT: whole}


def whole_of(parts: dict[str, Part]) -> Part | dict[str, Part]:
    """Inverse of `parts_of`: flat observations stand alone if there are no others."""
    return parts[FLAT] if parts.keys() == {FLAT} else parts


def read_observation(
    observations: torch.Tensor | Mapping[str, torch.Tensor], architecture: Architecture
) -> Observation:
    """Split what a policy is given, in float32.

    Args:
        observations: flat ones (B, observation_size), or a dict of them and of heightmaps and base codes, if any.
        architecture: the sizes.

    Raises:
        ValueError: if the width is not the architecture's.
    """
    parts = parts_of(observations)
    heightmap = parts[HEIGHTMAP].float() if HEIGHTMAP in parts else None
    split = split_observation(parts[FLAT].float(), architecture, heightmap)
    companion = parts[COMPANION].long().flatten() if COMPANION in parts else None  # SB3's buffer has (B, 1)
    return split._replace(
        base_code=parts.get(BASE_CODE),
        companion=companion,
        companion_offset=parts.get(COMPANION_OFFSET),
        companion_mean=parts.get(COMPANION_MEAN),
    )


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
