"""A value head that normalises its targets without changing its outputs (PopArt, van Hasselt et al. 2016)."""

import torch
from torch import nn

HORIZON = 20
"""Updates over which the statistics average: returns drift while the policy learns."""
SMALLEST_STD = 1e-2
"""Smallest standard deviation, in units of the return; without it a constant return would blow up its noise."""


class PopArtHead(nn.Module):
    """Linear head with K outputs and running statistics of the K returns.

    Before the first `update` it is a plain linear head, mean 0 and standard deviation 1.

    Attributes:
        linear: latent -> K normalised values.
        mean, std: (K,) statistics of the returns.
        count: () number of updates so far.
    """

    mean: torch.Tensor
    std: torch.Tensor
    count: torch.Tensor

    def __init__(self, inputs: int, objectives: int) -> None:
        super().__init__()
        self.linear = nn.Linear(inputs, objectives)
        nn.init.orthogonal_(self.linear.weight, gain=1.0)
        nn.init.zeros_(self.linear.bias)
        self.register_buffer("mean", torch.zeros(objectives))
        self.register_buffer("std", torch.ones(objectives))
        self.register_buffer("count", torch.zeros(()))

    def forward(self, latent: torch.Tensor) -> torch.Tensor:
        """Normalised values (B, K), always in float32."""
        with torch.autocast(latent.device.type, enabled=False):
            return self.linear(latent.float())

    def normalize(self, values: torch.Tensor) -> torch.Tensor:
        """Real returns or values (..., K) in normalised units."""
        return (values - self.mean) / self.std

    def denormalize(self, values: torch.Tensor) -> torch.Tensor:
        """Normalised values (..., K) in real units."""
        return values * self.std + self.mean

    @torch.no_grad()
    def update(self, returns: torch.Tensor) -> None:
        """Move the statistics towards those of new returns (M, K), and rescale the head so that its real outputs stay.

        Raises:
            ValueError: if the returns do not have K columns.
        """
        if returns.ndim != 2 or returns.shape[1] != len(self.mean):
            raise ValueError(f"returns must be (M, {len(self.mean)}), not {tuple(returns.shape)}")
        self.count.add_(1).clamp_(max=HORIZON)
        new_var, new_mean = torch.var_mean(returns, dim=0, correction=0)
        weight = 1.0 / self.count
        shift = new_mean - self.mean
        variance = self.std.square().lerp(new_var, weight) + shift.square() * weight * (1 - weight)
        self._rescale(self.mean + shift * weight, variance.sqrt().clamp_min(SMALLEST_STD))

    def _rescale(self, mean: torch.Tensor, std: torch.Tensor) -> None:
        self.linear.weight.mul_((self.std / std).unsqueeze(1))
        self.linear.bias.copy_((self.std * self.linear.bias + self.mean - mean) / std)
        self.mean.copy_(mean)
        self.std.copy_(std)
