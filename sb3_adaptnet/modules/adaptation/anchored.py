"""Finetuning with regularisation to the base's weights, the paper's baseline FT + Reg (sec. 8.1)."""

from collections.abc import Sequence

import torch

from sb3_adaptnet.modules.actor import Actor
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer
from sb3_adaptnet.modules.layers.regularizers import AnchorPenalty
from sb3_adaptnet.modules.observation import Observation


class AnchoredActor(Actor):
    """A network that learns, pulled to the weights of the base it started from.

    Attributes:
        network: the network that learns; it may have a heightmap encoder that the base lacks.
        base: the frozen base.
        kappa: coefficient of the penalty kappa * ||theta - theta_base||_2.
    """

    def __init__(self, network: Backbone, base: Backbone, kappa: float) -> None:
        super().__init__()
        self.architecture = network.architecture
        self.network = network
        self.base = base.requires_grad_(False)
        self.kappa = kappa
        known = dict(base.named_parameters())
        learning = ((name, p) for name, p in network.named_parameters() if p.requires_grad and name in known)
        self._penalty = AnchorPenalty([(p, known[name]) for name, p in learning], kappa)

    def forward(self, observation: Observation) -> tuple[torch.Tensor, torch.Tensor]:
        """Mean and log standard deviation (B, action_size) of the Gaussian over actions."""
        if torch.is_grad_enabled():
            self._penalty.arm()
        return self.network(observation)

    def normalizers(self) -> Sequence[RunningNormalizer]:
        """The normaliser of the network that learns."""
        return self.network.normalizers()
