"""The value network: like the policy's, with its own GRU and one output per objective (paper, fig. 6b)."""

import torch
from torch import nn

from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.backbone import make_hidden_layers
from sb3_adaptnet.modules.encoder import StateEncoder
from sb3_adaptnet.modules.heightmap import CODE_SIZE, HeightmapEncoder, require_heightmap
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer
from sb3_adaptnet.modules.layers.popart import PopArtHead
from sb3_adaptnet.modules.observation import Observation


class Critic(nn.Module):
    """Normaliser, GRU, optional heightmap encoder, fully connected layers with ReLU6, K values.

    Attributes:
        normalizer: statistics of one frame.
        encoder: its own state encoder.
        heightmap: its own encoder of the heightmap, or None.
        layers: from [E(o), g, G(c)] to the last hidden layer.
        head: K outputs with the statistics of the returns.
    """

    def __init__(self, architecture: Architecture, heightmap: bool, objectives: int) -> None:
        super().__init__()
        self.normalizer = RunningNormalizer(architecture.frame_size)
        self.encoder = StateEncoder(architecture.frame_size, architecture.gru_size)
        self.heightmap = HeightmapEncoder() if heightmap else None
        first, *hidden = architecture.latent_sizes
        self.layers = make_hidden_layers([first + (CODE_SIZE if heightmap else 0), *hidden])
        self.head = PopArtHead(hidden[-1], objectives)

    def forward(self, observation: Observation) -> torch.Tensor:
        """Normalised values (B, K) of the objectives."""
        code = self.encoder(self.normalizer(observation.frames)).float()
        parts = [code, observation.goal]
        if self.heightmap is not None:
            parts.append(self.heightmap(require_heightmap(observation.heightmap)).float())
        latent = torch.cat(parts, dim=1)
        for layer in self.layers:
            latent = nn.functional.relu6(layer(latent))
        return self.head(latent)

    def set_objectives(self, count: int) -> None:
        """Replace the head by a fresh one with `count` outputs."""
        old = self.head.linear
        self.head = PopArtHead(old.in_features, count).to(old.weight.device)
