"""Rows of a batch in which the adaptations act at part of their strength, each at its own."""

from typing import NamedTuple, Self

import torch
from torch import nn
from torch.nn import functional


class InPart(NamedTuple):
    """Some rows and their strengths: 0 is the base, 1 what all other rows do.

    Attributes:
        rows: (b,) their numbers.
        strengths: (b, 1) factors on all that the adaptations add there.
    """

    rows: torch.Tensor
    strengths: torch.Tensor

    @classmethod
    def of(cls, strengths: torch.Tensor) -> Self | None:
        """The rows of a batch (B,) whose strength is not 1; None if there are none."""
        rows = (strengths != 1).nonzero()[:, 0]
        return cls(rows, strengths[rows, None]) if len(rows) else None

    def scaled(self, offsets: torch.Tensor) -> torch.Tensor:
        """Offsets (B, width), less in these rows."""
        return offsets.index_copy(0, self.rows, self._share(offsets) * offsets[self.rows])

    def between(self, base: nn.Linear, latent: torch.Tensor, output: torch.Tensor) -> torch.Tensor:
        """Outputs (B, out) of a layer with all adaptors, and in these rows between the base's and those.

        Args:
            base: the base's layer.
            latent: (B, in) what it reads.
            output: (B, out) what it gives with all adaptors.
        """
        alone = functional.linear(latent[self.rows], base.weight, base.bias)
        return output.index_copy(0, self.rows, alone + self._share(output) * (output[self.rows] - alone))

    def _share(self, like: torch.Tensor) -> torch.Tensor:
        return self.strengths.to(like.dtype)
