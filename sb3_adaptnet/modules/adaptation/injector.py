"""The latent space injector I (paper, sec. 4, eqs. 4-6)."""

from collections.abc import Sequence

import torch
from torch import nn

from sb3_adaptnet.modules.architecture import AdaptationShape, Architecture
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.modules.encoder import StateEncoder
from sb3_adaptnet.modules.heightmap import CODE_SIZE, HeightmapEncoder, require_heightmap
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer
from sb3_adaptnet.modules.observation import Observation

PRIOR_SAMPLES = 1e6
"""Most frames that the base's statistics count for, so that new data can move them."""


class Injector(nn.Module):
    """Offsets to the base's latents: F(Concat(E(s), G(c))), zero at the start.

    Attributes:
        spaces: indices of the latent spaces that are injected.
        normalizer, encoder: own copies of the base's, both of which learn; None without an own encoder.
        heightmap: the encoder G of the additional control input, or None.
        maps: the embedding F: one linear map per injected space, zero at the start.
    """

    def __init__(self, architecture: Architecture, shape: AdaptationShape) -> None:
        super().__init__()
        self.spaces = shape.injected_spaces(len(architecture.latent_sizes))
        self.normalizer = RunningNormalizer(architecture.frame_size) if shape.own_encoder else None
        self.encoder = StateEncoder(architecture.frame_size, architecture.gru_size) if shape.own_encoder else None
        self.heightmap = HeightmapEncoder() if shape.heightmap else None
        width = architecture.latent_sizes[0] + (CODE_SIZE if shape.heightmap else 0)
        maps = [nn.Linear(width, architecture.latent_sizes[space]) for space in self.spaces]
        for linear in maps:
            nn.init.zeros_(linear.weight)
            nn.init.zeros_(linear.bias)
        self.maps = nn.ModuleList(maps)

    def start_from(self, base: Backbone) -> None:
        """Copy the base's encoder and statistics (paper, sec. 4: "copying the original encoder parameters")."""
        if self.encoder is not None and self.normalizer is not None:
            self.encoder.load_state_dict(base.encoder.state_dict())
            self.normalizer.start_at(base.normalizer, PRIOR_SAMPLES)

    def forward(self, observation: Observation, base_latent: torch.Tensor) -> dict[int, torch.Tensor]:
        """The injections.

        Args:
            observation: the batch.
            base_latent: the base's z0 (B, gru_size + goal_size), the state code of an injector without an encoder.

        Returns:
            Latent space index -> offset (B, width of the space), float32.
        """
        code = base_latent
        if self.encoder is not None and self.normalizer is not None:
            code = torch.cat((self.encoder(self.normalizer(observation.frames)).float(), observation.goal), dim=1)
        if self.heightmap is not None:
            code = torch.cat((code, self.heightmap(require_heightmap(observation.heightmap)).float()), dim=1)
        return {space: linear(code).float() for space, linear in zip(self.spaces, self.maps, strict=True)}

    def normalizers(self) -> Sequence[RunningNormalizer]:
        """The normalisers that learn while samples are collected."""
        return [] if self.normalizer is None else [self.normalizer]
