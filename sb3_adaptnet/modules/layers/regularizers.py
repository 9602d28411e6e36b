"""The regularisers of paper eq. 12, added to the gradient so that stock PPO needs no change to its loss.

A penalty such as `beta * ||I||_2` only matters through its gradient. `add_gradient` is the identity on the way forward
and adds that gradient on the way back, which equals having the penalty in a loss that is the batch's mean.
"""

from collections.abc import Callable, Sequence
from typing import Any

import torch
from torch import nn
from torch.autograd.function import once_differentiable

DISTANCE_COST = 0.01
"""What a nat beyond the free ones costs, in advantages, which are standardised: 0.003 of every nat slowed learning."""


class _AddGradient(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, x: torch.Tensor, scale: torch.Tensor) -> torch.Tensor:
        ctx.save_for_backward(x, scale)
        return x.view_as(x)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: torch.Tensor) -> tuple[torch.Tensor, None]:
        x, scale = ctx.saved_tensors
        return torch.addcmul(grad, x, scale.expand_as(x)), None


def add_gradient(x: torch.Tensor, scale: torch.Tensor) -> torch.Tensor:
    """The identity, whose backward pass adds `scale * x` to the gradient; `scale` broadcasts against x."""
    return _AddGradient.apply(x, scale)


def inverse_norm(norm: torch.Tensor) -> torch.Tensor:
    """1 / norm, and 0 where the norm is 0: the subgradient of ||x|| that autograd also takes there."""
    return torch.where(norm > 0, norm.clamp_min(torch.finfo(norm.dtype).tiny).reciprocal(), torch.zeros_like(norm))


def penalise_injections(injections: dict[int, torch.Tensor], beta: float) -> dict[int, torch.Tensor]:
    """Penalty beta * mean over the batch of ||I||_2, the norm of each sample's injection (eq. 12, second term).

    Args:
        injections: latent space index -> (B, width); with several spaces the norm is that of all offsets together.
        beta: coefficient; 0 changes nothing.

    Returns:
        The same values, with the penalty's gradient attached.
    """
    if beta == 0 or not torch.is_grad_enabled():
        return injections
    with torch.no_grad():
        norms = torch.stack([torch.linalg.vector_norm(x, dim=1) for x in injections.values()])
        total = torch.linalg.vector_norm(norms, dim=0)
        scale = (beta / max(len(total), 1)) * inverse_norm(total).unsqueeze(1)
    return {space: add_gradient(x, scale) for space, x in injections.items()}


def penalise_distance(
    mean: torch.Tensor, other: torch.Tensor, log_std: torch.Tensor, free: float, passes: int = 1
) -> torch.Tensor:
    """Penalty 0.01 / passes * the batch's mean of max(KL - free, 0), KL of Gaussians with the same standard deviations.

    Args:
        mean: (B, n) means that learn.
        other: (B, n) means that they must stay near.
        log_std: (B, n) log standard deviations of both.
        free: how much divergence [nat] costs nothing.
        passes: how many passes of an update pay it, each its share.

    Returns:
        The means, with the penalty's gradient attached.
    """
    with torch.no_grad():
        precision = torch.exp(-2.0 * log_std)
        divergence = 0.5 * ((mean - other).square() * precision).sum(dim=1, keepdim=True)
        scale = (DISTANCE_COST / passes / max(len(mean), 1)) * precision * (divergence > free)
    return other + add_gradient(mean - other, scale)


def penalise_parameters(parameters: Sequence[torch.Tensor], kappa: float) -> list[torch.Tensor]:
    """Penalty kappa * ||eta||_2, the norm of all given parameters as one vector (eq. 12, third term).

    Args:
        parameters: the adaptors' parameters.
        kappa: coefficient; 0 changes nothing.

    Returns:
        The same values, with the penalty's gradient attached.
    """
    if kappa == 0 or not torch.is_grad_enabled():
        return list(parameters)
    scale = kappa * inverse_norm(_joint_norm([p.detach() for p in parameters]))
    return [add_gradient(p, scale) for p in parameters]


class AnchorPenalty:
    """Penalty kappa * ||theta - theta_0||_2 on a network's weights: finetuning with regularisation (paper, sec. 8.1).

    The gradient is added as each parameter's own gradient arrives, so the network's forward pass stays as it is.
    `arm` must be called in every forward pass that is differentiated.

    Attributes:
        kappa: coefficient of the penalty.
    """

    def __init__(self, pairs: Sequence[tuple[nn.Parameter, torch.Tensor]], kappa: float) -> None:
        """Attach to pairs of (parameter that learns, value that it is pulled to)."""
        self.kappa = kappa
        self._pairs = list(pairs)
        self._scale: torch.Tensor | None = None
        for parameter, anchor in self._pairs:
            parameter.register_post_accumulate_grad_hook(self._pull_to(anchor))

    def _pull_to(self, anchor: torch.Tensor) -> Callable[[torch.Tensor], None]:
        @torch.no_grad()
        def pull(parameter: torch.Tensor) -> None:
            if self._scale is not None and parameter.grad is not None:
                parameter.grad.add_((parameter - anchor) * self._scale)

        return pull

    @torch.no_grad()
    def arm(self) -> None:
        """Measure the distance to the anchor, from which the coming backward pass takes the penalty's gradient."""
        distance = _joint_norm([parameter - anchor for parameter, anchor in self._pairs])
        self._scale = self.kappa * inverse_norm(distance)


def _joint_norm(tensors: Sequence[torch.Tensor]) -> torch.Tensor:
    return torch.linalg.vector_norm(torch.stack([torch.linalg.vector_norm(t) for t in tensors]))
