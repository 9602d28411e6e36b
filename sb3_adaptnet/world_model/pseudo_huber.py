"""A robust loss: square for small errors, straight for large ones, smooth everywhere."""

import torch


def pseudo_huber(square: torch.Tensor, scale: float) -> torch.Tensor:
    """sqrt(1 + square / scale^2) - 1 of squared errors, or squared lengths of errors, in units of `scale`."""
    return torch.sqrt(square / scale**2 + 1) - 1
