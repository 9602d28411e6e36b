"""A progressive network (Rusu et al. 2016), the paper's baseline PNet (sec. 8.1)."""

from collections.abc import Sequence
from dataclasses import replace

import torch
from torch import nn
from torch.nn import functional

from sb3_adaptnet.modules.actor import Actor
from sb3_adaptnet.modules.adaptation.injector import PRIOR_SAMPLES
from sb3_adaptnet.modules.backbone import HEAD_GAIN, Backbone
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer
from sb3_adaptnet.modules.observation import Observation


class ProgressiveActor(Actor):
    """A new column beside the frozen base; each of its layers also reads the base's latent before it.

    It cannot start as the base does, which is the paper's point. The log standard deviation is the base's, so that
    all methods explore alike.

    Attributes:
        base: the frozen network.
        column: a fresh network of the same sizes, whose own log-std head is not used and does not learn.
        laterals: linear maps from the base's latents Z0, Z1, ..., Zn into the column's layers and mean head.
    """

    def __init__(self, base: Backbone, heightmap: bool = False) -> None:
        super().__init__()
        self.architecture = base.architecture
        self.base = base.requires_grad_(False)
        self.column = Backbone(replace(base.architecture, heightmap=heightmap))
        self.column.log_std.requires_grad_(False)
        sizes = base.architecture.latent_sizes
        outputs = (*sizes[1:], base.architecture.action_size)
        laterals = [nn.Linear(i, o, bias=False) for i, o in zip(sizes, outputs, strict=True)]
        nn.init.orthogonal_(laterals[-1].weight, gain=HEAD_GAIN)
        self.laterals = nn.ModuleList(laterals)
        with torch.no_grad():
            self.column.mean.bias.copy_(base.mean.bias)

    def start_from_base(self) -> None:
        """Take over the base's input statistics; the column's weights stay random."""
        self.column.normalizer.start_at(self.base.normalizer, PRIOR_SAMPLES)

    def forward(self, observation: Observation) -> tuple[torch.Tensor, torch.Tensor]:
        """Mean and log standard deviation (B, action_size) of the Gaussian over actions."""
        base_latents = self.base.latents(observation)
        latent = self.column.encode(observation)
        extra = self.column.first_bias(observation)
        for layer, lateral, known in zip(self.column.layers, self.laterals, base_latents, strict=False):
            output = layer(latent) + lateral(known)
            latent = functional.relu6(output if extra is None else output + extra)
            extra = None
        with torch.autocast(latent.device.type, enabled=False):
            mean = self.column.mean(latent.float()) + self.laterals[-1](base_latents[-1].float())
        return mean, self.base.heads(base_latents[-1])[1]

    def normalizers(self) -> Sequence[RunningNormalizer]:
        """The column's normaliser."""
        return [self.column.normalizer]
