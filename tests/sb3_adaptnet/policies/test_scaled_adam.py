"""ScaledAdam: two learning rates that Stable-Baselines3's overwriting leaves alone."""

import pytest
import torch
from stable_baselines3.common.utils import update_learning_rate

from sb3_adaptnet.policies.optimizer_groups import group_named
from sb3_adaptnet.policies.scaled_adam import ScaledAdam


def parameters():
    torch.manual_seed(0)
    return [torch.nn.Parameter(torch.randn(4)) for _ in range(2)]


def give_gradients(params, seed):
    generator = torch.Generator().manual_seed(seed)
    for p in params:
        p.grad = torch.randn(p.shape, generator=generator)


@pytest.mark.parametrize("fused", [False, True])
def test_equals_adam_with_two_learning_rates(fused):
    ours, theirs = parameters(), parameters()
    steered = ScaledAdam([{"params": ours[:1], "lr_scale": 0.2}, {"params": ours[1:], "lr_scale": 3.0}], fused=fused)
    plain = torch.optim.Adam([{"params": theirs[:1], "lr": 2e-4}, {"params": theirs[1:], "lr": 3e-3}])
    for seed in range(5):
        update_learning_rate(steered, 1e-3)  # as PPO does before every update
        give_gradients(ours, seed)
        give_gradients(theirs, seed)
        steered.step()
        plain.step()
    for a, b in zip(ours, theirs, strict=True):
        torch.testing.assert_close(a, b, rtol=1e-6, atol=1e-8)
    assert [group["lr"] for group in steered.param_groups] == [1e-3, 1e-3]


def test_scale_is_saved_and_restored():
    first = ScaledAdam([{"params": parameters(), "name": "actor", "lr_scale": 0.5}], lr=1e-3)
    group_named(first, "actor")["lr_scale"] = 0.125
    second = ScaledAdam([{"params": parameters(), "name": "actor"}], lr=1e-3)
    assert group_named(second, "actor")["lr_scale"] == 1.0
    second.load_state_dict(first.state_dict())
    assert group_named(second, "actor")["lr_scale"] == 0.125
