"""One adaptation: what is added to a frozen base (paper, secs. 4 and 5)."""

from itertools import islice
from typing import cast

import torch
from torch import nn

from sb3_adaptnet.modules.adaptation.adaptors import FullAdaptor, make_adaptors
from sb3_adaptnet.modules.adaptation.injector import Injector
from sb3_adaptnet.modules.adaptation.lora import LowRankAdaptor
from sb3_adaptnet.modules.architecture import AdaptationShape, Architecture
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.modules.layers.regularizers import penalise_injections, penalise_parameters
from sb3_adaptnet.modules.observation import Observation


class Adaptation(nn.Module):
    """What one adaptation adds to its base: an injector and adaptors, each optional.

    Attributes:
        shape: which parts it has.
        injector: edits the latents, or None.
        adaptors: one per hidden layer, or None.
    """

    def __init__(self, architecture: Architecture, shape: AdaptationShape) -> None:
        super().__init__()
        self.shape = shape
        self.injector = Injector(architecture, shape) if shape.injector else None
        self.adaptors = make_adaptors(shape, architecture.latent_sizes)

    @property
    def trained(self) -> bool:
        """Whether its weights learn; further adaptations in a blend do not."""
        return any(p.requires_grad for p in self.parameters())

    def start_from(self, base: Backbone) -> None:
        """Copy the base's encoder into the injector; everything else is zero and stays so."""
        if self.injector is not None:
            self.injector.start_from(base)

    def injections(self, observation: Observation, base_latent: torch.Tensor, beta: float) -> dict[int, torch.Tensor]:
        """Latent space index -> offset (B, width), with the gradient of its penalty attached."""
        if self.injector is None:
            return {}
        return penalise_injections(self.injector(observation, base_latent), beta)

    def increments(self, kappa: float) -> list[tuple[torch.Tensor, torch.Tensor]]:
        """(Delta W, Delta b) of every hidden layer (eq. 8), with the gradient of their penalty attached."""
        if self.adaptors is None:
            return []
        counts = [len(list(adaptor.parameters())) for adaptor in self.adaptors]
        values = iter(penalise_parameters(list(self.adaptors.parameters()), kappa))
        adaptors = cast(list[FullAdaptor | LowRankAdaptor], self.adaptors)
        return [adaptor.delta(*islice(values, n)) for adaptor, n in zip(adaptors, counts, strict=True)]
