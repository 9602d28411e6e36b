"""Convolutions over small grids as matrix products of patches, with ReLU6: on a CPU faster than nn.Conv2d.

A heightmap's grids have 7x7 points and fewer, where the library's convolutions spend their time on layout instead of
products: in bfloat16 both ways, in float32 in the backward pass. Here channels come last, a layer is one product of its
patches (B x points, kernel^2 x channels), and the backward pass adds the patches' gradients back point by point.
"""

from typing import Any

import torch
from torch import nn
from torch.autograd.function import once_differentiable

CEILING = 6.0
"""Largest output of ReLU6."""


def patches_of(grid: torch.Tensor, kernel: int, stride: int) -> torch.Tensor:
    """Patches (B, h, w, kernel^2 C) of grids (B, H, W, C), the channels of one point together."""
    batch, height, width, channels = grid.shape
    rows, columns = (height - kernel) // stride + 1, (width - kernel) // stride + 1
    if kernel == stride:
        tiles = grid[:, : rows * stride, : columns * stride].reshape(batch, rows, kernel, columns, kernel * channels)
        return tiles.transpose(2, 3).reshape(batch, rows, columns, kernel * kernel * channels)
    parts = [grid[:, rows_, columns_] for rows_, columns_ in _windows(kernel, stride, rows, columns)]
    return torch.cat(parts, dim=-1)


def _windows(kernel: int, stride: int, rows: int, columns: int) -> list[Any]:
    """Where each of the kernel's points reads the grid."""
    return [
        (slice(i, i + stride * rows, stride), slice(j, j + stride * columns, stride))
        for i in range(kernel)
        for j in range(kernel)
    ]


class _ReluConv(torch.autograd.Function):
    """ReLU6 of a convolution without padding."""

    @staticmethod
    def forward(ctx: Any, grid: torch.Tensor, weight: torch.Tensor, bias: torch.Tensor, stride: int) -> torch.Tensor:
        """Outputs (B, h, w, O) for grids (B, H, W, C), weights (O, C, k, k) and biases (O,)."""
        kernel = weight.shape[-1]
        patches = patches_of(grid, kernel, stride)
        matrix = weight.permute(0, 2, 3, 1).reshape(len(weight), -1).to(grid.dtype)
        out = torch.addmm(bias.to(grid.dtype), patches.view(-1, patches.shape[-1]), matrix.t()).clamp_(0, CEILING)
        ctx.save_for_backward(patches, matrix, out)
        ctx.shapes = grid.shape, weight.shape, stride
        return out.view(*patches.shape[:3], -1)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, grad: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        """Gradients of grid, weight and bias."""
        patches, matrix, out = ctx.saved_tensors
        shape, (outputs, channels, kernel, _), stride = ctx.shapes
        flat = torch.ops.aten.hardtanh_backward(grad.reshape(out.shape), out, 0.0, CEILING)
        d_matrix = (flat.t() @ patches.view(-1, patches.shape[-1])).float()
        d_weight = d_matrix.view(outputs, kernel, kernel, channels).permute(0, 3, 1, 2)
        d_bias = (flat.new_ones(1, len(flat)) @ flat)[0].float()  # a product sums bfloat16 in float32
        d_grid = None
        if ctx.needs_input_grad[0]:
            d_grid = _scattered((flat @ matrix).view(*patches.shape[:3], kernel**2, channels), shape, kernel, stride)
        return d_grid, d_weight, d_bias, None


def _scattered(grads: torch.Tensor, shape: torch.Size, kernel: int, stride: int) -> torch.Tensor:
    """Gradients of patches (B, h, w, kernel^2, C) added up to the grid's (B, H, W, C)."""
    out = grads.new_zeros(shape)
    for point, window in enumerate(_windows(kernel, stride, *grads.shape[1:3])):
        out[:, window[0], window[1]] += grads[..., point, :]
    return out


def relu_conv(grid: torch.Tensor, conv: nn.Conv2d) -> torch.Tensor:
    """ReLU6 of `conv`, a convolution without padding and with equal strides, of grids (B, H, W, C): (B, h, w, O).

    It computes in the grid's type and equals `relu6(conv(...))` up to rounding.
    """
    return _ReluConv.apply(grid, conv.weight, conv.bias, conv.stride[0])
