"""The network of the dynamics: a normalised, residual multilayer perceptron beside a linear map."""

import torch
from torch import nn
from torch.nn import functional

from sb3_adaptnet.modules.layers.precision import autocast

CLAMP = 6.0
"""Inputs farther than so many standard deviations from their mean are clipped."""
_LEAST_STD = 1e-3
"""Added to standard deviations, in the numbers' own units: what never varies stays finite."""
_FIRST_STD = 0.01
"""Standard deviation of the last layer's weights at the start: the first guess is the mean."""


class Dynamics(nn.Module):
    """Inputs (B, I) -> change (B, O) in physical units.

    Only the hidden layers' products follow `precision`; the linear map, the sum and the statistics keep their type.

    Attributes:
        input_mean, input_scale: (I,) mean and 1 / standard deviation of the inputs.
        output_mean, output_std: (O,) mean and standard deviation of the changes.
        layers: hidden layers with SiLU; from the second on each adds to what it reads.
        last: from the last hidden layer to normalised changes.
        linear: from the normalised inputs straight to normalised changes.
        precision: "fp32", or "bf16" for hidden layers that multiply in bfloat16.
    """

    input_mean: torch.Tensor
    input_scale: torch.Tensor
    output_mean: torch.Tensor
    output_std: torch.Tensor

    def __init__(self, inputs: int, outputs: int, width: int, depth: int) -> None:
        super().__init__()
        self.register_buffer("input_mean", torch.zeros(inputs))
        self.register_buffer("input_scale", torch.ones(inputs))
        self.register_buffer("output_mean", torch.zeros(outputs))
        self.register_buffer("output_std", torch.ones(outputs))
        sizes = (inputs, *[width] * depth)
        self.layers = nn.ModuleList(nn.Linear(a, b) for a, b in zip(sizes[:-1], sizes[1:], strict=True))
        self.last, self.linear = nn.Linear(width, outputs), nn.Linear(inputs, outputs)
        self.precision = "fp32"
        nn.init.normal_(self.last.weight, std=_FIRST_STD)
        for zero in (self.last.bias, self.linear.weight, self.linear.bias):
            nn.init.zeros_(zero)

    @torch.no_grad()
    def set_statistics(self, inputs: torch.Tensor, changes: torch.Tensor) -> None:
        """Normalise by the statistics of inputs (B, I) and changes (B, O) from now on."""
        self.input_mean.copy_(inputs.mean(0))
        self.input_scale.copy_(1 / (inputs.std(0) + _LEAST_STD))
        self.output_mean.copy_(changes.mean(0))
        self.output_std.copy_(changes.std(0) + _LEAST_STD)

    def normalised(self, inputs: torch.Tensor) -> torch.Tensor:
        """Inputs (B, I) in standard deviations from their mean, clipped."""
        return ((inputs - self.input_mean) * self.input_scale).clamp(-CLAMP, CLAMP)

    def normalised_change(self, inputs: torch.Tensor) -> torch.Tensor:
        """The change (B, O) in standard deviations from its mean."""
        seen = self.normalised(inputs)
        with autocast(seen.device, self.precision):
            hidden = functional.silu(self.layers[0](seen.to(self.last.weight.dtype)))
            for layer in self.layers[1:]:
                hidden = hidden + functional.silu(layer(hidden))
            nonlinear = self.last(hidden)
        return nonlinear.to(seen.dtype) + self.linear(seen)

    def forward(self, inputs: torch.Tensor) -> torch.Tensor:
        """The change (B, O) in physical units."""
        return self.normalised_change(inputs) * self.output_std + self.output_mean

    def normalise(self, changes: torch.Tensor) -> torch.Tensor:
        """Changes (B, O) in standard deviations from their mean."""
        return (changes - self.output_mean) / self.output_std

    def shorten(self) -> None:
        """Keep the hidden layers' weights in the type that they multiply in, once and for all."""
        if self.precision == "bf16":
            for layer in (*self.layers, self.last):
                layer.bfloat16()
