"""Small networks, observations and shapes of adaptations that several tests share; not a test itself."""

import torch
from torch import nn

from sb3_adaptnet.modules import AdaptationShape, Architecture, Backbone, Observation
from sb3_adaptnet.modules.adaptation import Adaptation, AdaptedActor, Penalties
from sb3_adaptnet.modules.layers import moments_of
from sb3_adaptnet.modules.observation import split_observation

JOINTS = tuple(f"joint_{i}" for i in range(6))
SMALL = Architecture(JOINTS, gru_size=8, hidden_sizes=(16, 12))
SHAPES = {
    "adaptnet": AdaptationShape(),
    "z1": AdaptationShape(injection="z1"),
    "z2": AdaptationShape(injection="z2"),
    "all": AdaptationShape(injection="all"),
    "no_encoder": AdaptationShape(own_encoder=False),
    "no_adaptors": AdaptationShape(adaptors=None),
    "no_injector": AdaptationShape(injector=False),
    "lora": AdaptationShape(adaptors="lora", rank=3),
    "heightmap": AdaptationShape(heightmap=True),
}
NO_PENALTY = Penalties(0.0, 0.0)


def observation(batch=7, heightmap=True, seed=0) -> Observation:
    generator = torch.Generator().manual_seed(seed)
    flat = torch.randn(batch, SMALL.observation_size, generator=generator)
    heights = torch.randn(batch, 1, 35, 35, generator=generator) if heightmap else None
    return split_observation(flat, SMALL, heights)


def make_base() -> Backbone:
    """A base that has seen data and whose actions are not near zero, as after training."""
    base = Backbone(SMALL)
    nn.init.normal_(base.mean.weight, std=0.3)
    base.normalizer.observe(moments_of(torch.randn(50, SMALL.frame_size) * 2 + 1))
    return base


def adapt(base: Backbone, shape: AdaptationShape, penalties: Penalties = NO_PENALTY) -> AdaptedActor:
    adaptation = Adaptation(SMALL, shape)
    adaptation.start_from(base)
    return AdaptedActor(base, {"main": adaptation}, penalties)


def disturb(module: nn.Module, scale: float = 0.1) -> None:
    """As if trained: no parameter is left at zero."""
    with torch.no_grad():
        for parameter in module.parameters():
            parameter.add_(torch.randn_like(parameter) * scale)


def two_adaptations() -> tuple[Backbone, AdaptedActor]:
    base = make_base()
    parts = {"stoop": Adaptation(SMALL, AdaptationShape()), "limp": Adaptation(SMALL, SHAPES["lora"])}
    for part in parts.values():
        part.start_from(base)
        disturb(part)
    return base, AdaptedActor(base, parts, NO_PENALTY)


def loss_of(actor: nn.Module, obs: Observation) -> torch.Tensor:
    mean, _ = actor(obs)
    return (mean * torch.linspace(-1, 1, mean.numel()).view_as(mean)).mean()


def gradients(actor: nn.Module, loss: torch.Tensor) -> list[torch.Tensor]:
    actor.zero_grad()
    loss.backward()
    return [p.grad.clone() for p in actor.parameters() if p.requires_grad]
