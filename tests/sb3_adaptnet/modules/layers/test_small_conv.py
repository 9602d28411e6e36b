"""Convolutions by patches against torch's."""

import pytest
import torch

from sb3_adaptnet.modules.layers.small_conv import relu_conv


@pytest.mark.parametrize("size, channels, kernel, stride", [(35, 1, 5, 5), (7, 8, 3, 1), (9, 4, 3, 2), (3, 8, 3, 1)])
def test_convolutions_by_patches_are_convolutions(size, channels, kernel, stride):
    torch.manual_seed(0)
    conv = torch.nn.Conv2d(channels, 6, kernel, stride).double()
    grid = 16 * torch.randn(5, channels, size, size, dtype=torch.float64)  # some outputs reach both ends of ReLU6
    outs, grads = [], []
    for layer in (
        lambda g: torch.nn.functional.relu6(conv(g)),
        lambda g: relu_conv(g.permute(0, 2, 3, 1), conv).permute(0, 3, 1, 2),
    ):
        leaf = grid.clone().requires_grad_()
        out = layer(leaf)
        grads.append(torch.autograd.grad(out.square().sum(), [leaf, conv.weight, conv.bias]))
        outs.append(out)
    torch.testing.assert_close(outs[1], outs[0])
    assert (outs[0] == 0).any() and (outs[0] == 6).any()
    for ours, theirs in zip(grads[1], grads[0], strict=True):
        torch.testing.assert_close(ours, theirs, check_dtype=False)  # weights' gradients are float32
