"""Full-rank adaptors: increments to the base's fully connected layers (paper, sec. 5, eqs. 7 and 8)."""

from collections.abc import Sequence

import torch
from torch import nn

from sb3_adaptnet.modules.adaptation.lora import LowRankAdaptor
from sb3_adaptnet.modules.architecture import AdaptationShape


class FullAdaptor(nn.Module):
    """Delta W (out, in) and delta b (out,) of one layer, zero at the start."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.zeros(outputs, inputs))
        self.bias = nn.Parameter(torch.zeros(outputs))

    def delta(self, weight: torch.Tensor, bias: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """The increment that given values of `weight` and `bias` stand for: themselves."""
        return weight, bias


def make_adaptors(shape: AdaptationShape, latent_sizes: Sequence[int]) -> nn.ModuleList | None:
    """One adaptor per hidden layer, none on the heads; None if the shape has none."""
    if shape.adaptors is None:
        return None
    pairs = zip(latent_sizes[:-1], latent_sizes[1:], strict=True)
    if shape.adaptors == "lora":
        return nn.ModuleList(LowRankAdaptor(inputs, outputs, shape.rank) for inputs, outputs in pairs)
    return nn.ModuleList(FullAdaptor(inputs, outputs) for inputs, outputs in pairs)
