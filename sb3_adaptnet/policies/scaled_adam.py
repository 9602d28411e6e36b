"""Adam with a step size per group that survives Stable-Baselines3's learning-rate updates."""

from typing import Any

import torch


class ScaledAdam(torch.optim.Adam):
    """Adam whose parameter groups carry an `lr_scale`: the effective step size is `lr * lr_scale`.

    `PPO` overwrites `lr` of every group before each update, so two learning rates (the paper's Table 4 has
    one for the policy and one for the critic) and a step size adjusted by the KL divergence cannot live there.
    `lr_scale` is a plain entry of the group: it is saved and restored with `state_dict`.
    """

    def __init__(self, params: Any, lr: float = 1e-3, **kwargs: Any) -> None:
        """Build the optimiser.

        Args:
            params: tensors, or groups `{"params": [...], "name": str, "lr_scale": float}`; the scale defaults to 1.
            lr: learning rate before scaling, per update.
            **kwargs: passed on to `torch.optim.Adam`.
        """
        super().__init__(params, lr=lr, **kwargs)

    def add_param_group(self, param_group: dict[str, Any]) -> None:
        """Add a group as `torch.optim.Adam` does, with `lr_scale` 1 where none is given."""
        param_group.setdefault("lr_scale", 1.0)
        super().add_param_group(param_group)

    @torch.no_grad()
    def step(self, closure: Any = None) -> Any:
        """Take one step with `lr * lr_scale` in every group; `lr` itself is left as it was."""
        rates = [group["lr"] for group in self.param_groups]
        for group in self.param_groups:
            group["lr"] = group["lr"] * group["lr_scale"]
        try:
            return super().step(closure)
        finally:
            for group, rate in zip(self.param_groups, rates, strict=True):
                group["lr"] = rate
