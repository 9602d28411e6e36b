"""The value network: like the policy's, with its own GRU and one output per objective (paper, fig. 6b)."""

from typing import cast

import torch
from torch import nn

from sb3_adaptnet.modules.architecture import OWN, Architecture, CriticShape
from sb3_adaptnet.modules.backbone import make_hidden_layers
from sb3_adaptnet.modules.encoder import StateEncoder
from sb3_adaptnet.modules.heightmap import CODE_SIZE, HeightmapEncoder, require_heightmap
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer
from sb3_adaptnet.modules.layers.popart import PopArtHead
from sb3_adaptnet.modules.observation import Observation


class Critic(nn.Module):
    """Normaliser, GRU, optional heightmap encoder, fully connected layers with ReLU6, K values.

    Attributes:
        normalizer, encoder: its own state encoder and the statistics of one frame; None where it reads the base's code.
        heightmap: its own encoder of the heightmap, or None.
        layers: from [E(o), g, G(c)] to the last hidden layer.
        head: K outputs with the statistics of the returns.
    """

    def __init__(
        self, architecture: Architecture, heightmap: bool, objectives: int, shape: CriticShape | None = None
    ) -> None:
        super().__init__()
        shape = shape or CriticShape()
        own = shape.encoder == OWN
        self.normalizer = RunningNormalizer(architecture.frame_size) if own else None
        self.encoder = StateEncoder(architecture.frame_size, architecture.gru_size) if own else None
        self.heightmap = HeightmapEncoder() if heightmap else None
        first, hidden = architecture.latent_sizes[0], shape.hidden_sizes or architecture.hidden_sizes
        self.layers = make_hidden_layers([first + (CODE_SIZE if heightmap else 0), *hidden])
        self.head = PopArtHead(hidden[-1], objectives)

    @property
    def reads_base_code(self) -> bool:
        """Whether observations must come with the base's code."""
        return self.encoder is None

    def code(self, observation: Observation) -> torch.Tensor:
        """The state code (B, gru_size), float32.

        Raises:
            ValueError: if the base's code is missing where it is read.
        """
        if self.encoder is not None and self.normalizer is not None:
            return cast(torch.Tensor, self.encoder(self.normalizer(observation.frames))).float()
        if observation.base_code is None:
            raise ValueError("the critic reads the base's code, and the observation has none")
        return observation.base_code

    def forward(self, observation: Observation) -> torch.Tensor:
        """Normalised values (B, K) of the objectives."""
        parts = [self.code(observation), observation.goal]
        if self.heightmap is not None:
            parts.append(self.heightmap(require_heightmap(observation.heightmap)).float())
        latent = torch.cat(parts, dim=1)
        for layer in self.layers:
            latent = nn.functional.relu6(layer(latent))
        return self.head(latent)

    def normalizers(self) -> list[RunningNormalizer]:
        """Its own normaliser, if it has one."""
        return [] if self.normalizer is None else [self.normalizer]

    def set_objectives(self, count: int) -> None:
        """Replace the head by a fresh one with `count` outputs."""
        old = self.head.linear
        self.head = PopArtHead(old.in_features, count).to(old.weight.device)
