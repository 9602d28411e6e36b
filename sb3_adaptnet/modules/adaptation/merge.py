"""Folding adaptors into the base's layers: one network, one pass (paper, sec. 8.2.1 on merging)."""

import copy
from dataclasses import replace
from typing import cast

import torch
from torch import nn

from sb3_adaptnet.modules.adaptation.adaptation import Adaptation
from sb3_adaptnet.modules.adaptation.adapted import AdaptedActor


@torch.no_grad()
def merge(actor: AdaptedActor) -> AdaptedActor:
    """A copy of an adapted network whose adaptors, at their present scale, are part of the layers.

    The injectors remain (the GRU makes them state dependent), at their present weights and alpha. The result can no
    longer change alpha or the blend, because the layers have taken up the present ones.

    Args:
        actor: the adapted network; not changed.

    Returns:
        A network with the same outputs and standard deviations up to rounding.
    """
    base = copy.deepcopy(actor.base)
    for layer, (weight, bias) in zip(cast(list[nn.Linear], base.layers), actor.hidden_layers(), strict=True):
        layer.weight.copy_(weight)
        layer.bias.copy_(bias)
    adaptations: dict[str, Adaptation] = {}
    for name, adaptation in actor.parts().items():
        injector_only = Adaptation(actor.architecture, replace(adaptation.shape, adaptors=None))
        injector_only.injector = copy.deepcopy(adaptation.injector)
        adaptations[name] = injector_only
    merged = AdaptedActor(base, adaptations, actor.penalties)
    merged.weights, merged.alpha = dict(actor.weights), actor.alpha
    merged.log_noise, merged.companions = actor.log_noise, actor.companions
    return merged.to(base.mean.weight.device)
