"""The fast GRU against torch's."""

import pytest
import torch
from torch import nn

from sb3_adaptnet.modules.layers.gru import last_state


@pytest.mark.parametrize("steps", [1, 4])
def test_gru_and_its_gradients_equal_torch(steps):
    gru = nn.GRU(7, 5, batch_first=True).double()
    frames = torch.randn(3, steps, 7, dtype=torch.float64, requires_grad=True)
    wanted = gru(frames)[1][0]
    weights = (*gru.parameters(), frames)
    direction = torch.randn(3, 5, dtype=torch.float64)
    expected = torch.autograd.grad((wanted * direction).sum(), weights)
    # last_state returns float32; the computation itself is in the frames' type
    state = last_state(frames, gru)
    assert torch.allclose(state.double(), wanted, atol=1e-6)
    found = torch.autograd.grad((state * direction.float()).sum(), weights)
    for ours, theirs in zip(found, expected, strict=True):
        assert torch.allclose(ours.double(), theirs, atol=1e-6)


def test_gru_in_bfloat16_is_close_and_differentiable():
    gru = nn.GRU(20, 16, batch_first=True)
    frames = torch.randn(64, 4, 20)
    with torch.autocast("cpu", torch.bfloat16):
        state = last_state(frames, gru)
    assert state.dtype == torch.float32
    assert torch.allclose(state, gru(frames)[1][0], atol=0.03)
    state.square().sum().backward()
    found = gru.weight_hh_l0.grad.clone()
    gru.zero_grad()
    gru(frames)[1][0].square().sum().backward()
    assert (found - gru.weight_hh_l0.grad).norm() < 0.03 * gru.weight_hh_l0.grad.norm()


def test_a_frozen_gru_hands_on_the_gradient_of_its_input():
    gru = nn.GRU(7, 5, batch_first=True).double()
    frames = torch.randn(4, 3, 7, dtype=torch.float64, requires_grad=True)
    wanted = torch.autograd.grad(last_state(frames, gru).square().sum(), frames)[0]
    last_state(frames, gru.requires_grad_(False)).square().sum().backward()
    assert torch.allclose(frames.grad, wanted)
    assert all(p.grad is None for p in gru.parameters())
