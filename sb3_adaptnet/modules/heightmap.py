"""The heightmap encoder G (paper, eq. 5 and appendix B)."""

import torch
from torch import nn

from sb3_adaptnet.modules.layers.small_conv import relu_conv

HEIGHTMAP_SIZE = 35
"""Grid points along each side, 0.1 m apart."""
CODE_SIZE = 256
"""Numbers in the code."""

_LAYERS = ((32, 5, 5), (64, 3, 1), (128, 3, 1), (CODE_SIZE, 3, 1))
"""(output channels, kernel, stride) of every layer.

The appendix speaks of three layers. The authors' release has these four: they take the 35x35 grid to 7x7, 5x5, 3x3
and 1x1 points, without pooling, after Mnih et al. (2013). Two things differ. There ReLU follows all layers but the
last; here ReLU6 follows all four, so that a code lies in [0, 6]. There heights are divided by 1.5 first; here they
are metres, and the first layer learns the factor. The weights that ship were trained so, and files hold no such
choice.
"""


class HeightmapEncoder(nn.Module):
    """CNN from a heightmap to a code of 256 numbers."""

    def __init__(self) -> None:
        super().__init__()
        channels = 1
        layers: list[nn.Module] = []
        for width, kernel, stride in _LAYERS:
            layers += [nn.Conv2d(channels, width, kernel, stride), nn.ReLU6()]
            channels = width
        self.layers = nn.Sequential(*layers, nn.Flatten())

    def forward(self, heightmap: torch.Tensor) -> torch.Tensor:
        """Encode heights (B, 1, 35, 35) [m, relative to the ground under the root] as (B, 256)."""
        half = torch.is_autocast_enabled("cpu")
        # In float32 only the products' backward pass is faster.
        if heightmap.device.type != "cpu" or not (half or torch.is_grad_enabled()):
            return self.layers(heightmap)
        grid = heightmap.permute(0, 2, 3, 1)
        if half:
            grid = grid.to(torch.get_autocast_dtype("cpu"))
        for layer in self.layers:
            if isinstance(layer, nn.Conv2d):
                grid = relu_conv(grid, layer)
        return grid.flatten(1)


def require_heightmap(heightmap: torch.Tensor | None) -> torch.Tensor:
    """The heightmap, or a ValueError that says that it is missing."""
    if heightmap is None:
        raise ValueError(
            "this network reads a heightmap: the observation must be a dict with 'observation' and 'heightmap'"
        )
    return heightmap
