"""Keeping gradients of long chains of contacts within bounds, sample by sample (cf. Xu et al. 2022, sec. 3)."""

from dataclasses import dataclass

import torch

_TINY = 1e-20
"""Added to lengths of gradients, which are zero for worlds whose episode ended."""


@dataclass(frozen=True)
class GradientTaming:
    """What happens to the gradient of every state on its way back through a step.

    Attributes:
        cap: longest gradient of a world, in medians over the worlds.
        decay: factor per step: what lies farther ahead counts less.
    """

    cap: float = 3.0
    decay: float = 0.98

    def __call__(self, part: torch.Tensor) -> torch.Tensor:
        """Attach to a part (n, B) of the states; the part itself stays as it is."""
        if part.requires_grad:
            part.register_hook(self._tamed)
        return part

    def _tamed(self, grad: torch.Tensor) -> torch.Tensor:
        lengths = grad.norm(dim=0, keepdim=True)
        present = lengths[lengths > 0]
        longest = self.cap * present.median() if len(present) else lengths.new_zeros(())
        return torch.nan_to_num(grad * (self.decay * torch.clamp(longest / (lengths + _TINY), max=1.0)))


class NormLimit:
    """Limits the length of the policy's gradient by its running mean.

    Attributes:
        mean: running mean of the lengths, None before the first.
    """

    LARGEST = 2.0
    """Longest gradient, in running means."""
    _MEMORY = 0.95
    """How much of the running mean an update keeps."""

    def __init__(self, mean: float | None = None) -> None:
        """Go on from a running mean."""
        self.mean = mean

    def apply(self, parameters: list[torch.nn.Parameter]) -> float:
        """Shorten the parameters' gradients if need be; returns their length before."""
        length = float(torch.nn.utils.get_total_norm([p.grad for p in parameters if p.grad is not None]))
        before = length if self.mean is None else self.mean
        self.mean = self._MEMORY * before + (1 - self._MEMORY) * min(length, 3 * before)
        torch.nn.utils.clip_grad_norm_(parameters, self.LARGEST * self.mean)
        return length
