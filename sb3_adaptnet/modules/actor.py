"""What every policy network offers, whatever it is made of."""

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext

import torch
from torch import nn

from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer
from sb3_adaptnet.modules.observation import Observation


class Actor(nn.Module):
    """Observation -> Gaussian over actions.

    Attributes:
        architecture: sizes of the network, or of the base it is built around.
    """

    architecture: Architecture

    def forward(self, observation: Observation) -> tuple[torch.Tensor, torch.Tensor]:
        """Mean and log standard deviation (B, action_size), float32."""
        raise NotImplementedError

    def one_update(self, passes: int) -> AbstractContextManager[None]:
        """Context of `passes` forward passes that are differentiated together, as one minibatch is by PPO.

        Within it, weights must not change; penalties count as in a single pass.
        """
        del passes
        return nullcontext()

    def normalizers(self) -> Sequence[RunningNormalizer]:
        """The normalisers that learn while samples are collected; those of a frozen base are not among them."""
        raise NotImplementedError
