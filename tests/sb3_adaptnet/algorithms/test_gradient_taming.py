"""Gradients keep their direction within bounds."""

import pytest
import torch

from sb3_adaptnet.algorithms.gradient_taming import GradientTaming, NormLimit


def test_tamed_gradients_keep_their_direction_and_lose_their_length():
    x = torch.randn(3, 50, requires_grad=True)
    weight = torch.ones(50)
    weight[7] = 1000.0
    (GradientTaming(cap=3.0, decay=0.5)(x * 1.0) * weight).sum().backward()
    lengths = x.grad.norm(dim=0)
    assert torch.allclose(lengths[:7], torch.full((7,), 0.5 * 3**0.5))
    assert torch.allclose(lengths[7], torch.tensor(3 * 0.5 * 3**0.5))


def test_nothing_that_is_not_a_number_passes():
    x = torch.ones(2, 4, requires_grad=True)
    (GradientTaming()(x * 1.0) * torch.tensor([1.0, float("nan"), 1.0, 1.0])).sum().backward()
    assert torch.isfinite(x.grad).all()


def test_the_norm_limit_follows_the_gradients():
    limit, parameter = NormLimit(), torch.nn.Parameter(torch.zeros(4))
    for length in (1.0, 1.0, 100.0):
        parameter.grad = torch.full((4,), length / 2)
        assert limit.apply([parameter]) == pytest.approx(length)
    assert parameter.grad.norm() < 3
