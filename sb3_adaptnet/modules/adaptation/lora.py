"""Low-rank adaptors (Hu et al. 2021), the paper's ablation of the full-rank ones (sec. 8.3)."""

import math

import torch
from torch import nn


class LowRankAdaptor(nn.Module):
    """Delta W = up @ down of rank r, zero at the start because `up` is.

    Attributes:
        down: (rank, in), random.
        up: (out, rank), zero.
        bias: (out,), zero.
    """

    def __init__(self, inputs: int, outputs: int, rank: int) -> None:
        super().__init__()
        self.down = nn.Parameter(torch.empty(rank, inputs))
        self.up = nn.Parameter(torch.zeros(outputs, rank))
        self.bias = nn.Parameter(torch.zeros(outputs))
        nn.init.kaiming_uniform_(self.down, a=math.sqrt(5.0))

    def delta(self, down: torch.Tensor, up: torch.Tensor, bias: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """The increment (weight, bias) that given parameter values stand for."""
        return up @ down, bias
