"""Running normalisation of body-state frames, one set of statistics for all frames of the history."""

from typing import NamedTuple

import torch
from torch import nn

CLAMP = 5.0
"""Normalised values are clipped to this many standard deviations."""
EPSILON = 1e-5
"""Added to variances, so that a constant component does not divide by zero."""


class Moments(NamedTuple):
    """Moments of a batch of frames, float64.

    Attributes:
        samples: number of frames.
        mean: (size,).
        var: (size,) population variance.
    """

    samples: int
    mean: torch.Tensor
    var: torch.Tensor


@torch.no_grad()
def moments_of(frames: torch.Tensor) -> Moments:
    """Moments over all but the last axis of frames (..., size).

    Sums are taken about the first frame, so that float32 loses nothing to a mean far from zero.
    """
    samples = frames.reshape(-1, frames.shape[-1])
    origin = samples[0]
    offsets = samples - origin
    shift = offsets.sum(dim=0).double() / len(samples)
    square = offsets.square_().sum(dim=0).double() / len(samples)
    return Moments(len(samples), origin.double() + shift, (square - shift.square()).clamp_min_(0.0))


class RunningNormalizer(nn.Module):
    """Maps x to clamp((x - mean) / std, -5, 5), with statistics collected in two stages.

    `observe` adds samples to the collected statistics; `apply_statistics` makes them the ones that `forward` uses.
    Between two such calls the map is fixed, so that a rollout's log-probabilities and its policy update see the same
    inputs. The very first batch is applied at once.

    Attributes:
        mean: (size,) applied mean, in the input's units.
        scale: (size,) applied 1 / std.
        count: () number of collected samples, float64.
        running_mean: (size,) collected mean, float64.
        running_var: (size,) collected population variance, float64.
    """

    mean: torch.Tensor
    scale: torch.Tensor
    count: torch.Tensor
    running_mean: torch.Tensor
    running_var: torch.Tensor

    def __init__(self, size: int) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(size))
        self.register_buffer("scale", torch.ones(size))
        self.register_buffer("count", torch.zeros((), dtype=torch.float64))
        self.register_buffer("running_mean", torch.zeros(size, dtype=torch.float64))
        self.register_buffer("running_var", torch.ones(size, dtype=torch.float64))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Normalise x (..., size) with the applied statistics."""
        return ((x - self.mean) * self.scale).clamp_(-CLAMP, CLAMP)

    @torch.no_grad()
    def observe(self, moments: Moments) -> None:
        """Add a batch's moments to the collected statistics (Chan et al. 1979, pairwise update)."""
        first = bool(self.count == 0)
        total = self.count + moments.samples
        weight = moments.samples / total
        shift = moments.mean - self.running_mean
        self.running_var.lerp_(moments.var, weight).add_(shift.square() * weight * (1 - weight))
        self.running_mean.add_(shift * weight)
        self.count.copy_(total)
        if first:
            self.apply_statistics()

    @torch.no_grad()
    def apply_statistics(self) -> None:
        """Use the collected statistics from now on; does nothing before the first sample."""
        if self.count > 0:
            self.mean.copy_(self.running_mean)
            self.scale.copy_((self.running_var + EPSILON).rsqrt())

    @torch.no_grad()
    def start_at(self, other: "RunningNormalizer", most_samples: float) -> None:
        """Take over another normaliser's statistics, as if from at most `most_samples` samples.

        The cap lets them follow new data: a base's count of 1e9 would never move again.
        """
        self.load_state_dict(other.state_dict())
        self.count.clamp_(max=most_samples)
