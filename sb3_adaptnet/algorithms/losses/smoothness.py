"""Whether actions change gently."""

import torch


def smoothness_loss(actions: torch.Tensor, before: torch.Tensor | None) -> torch.Tensor:
    """Loss (B,): squared change of the mean actions (B, J) since those `before`; 0 without any."""
    if before is None:
        return actions.new_zeros(len(actions))
    return (actions - before).square().sum(1)
