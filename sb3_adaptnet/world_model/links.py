"""States of links, component-first, and their view from the heading frame.

A *link array* is (13, n, B): 13 channels of n links (the last frame's L links last, the root first among them) of B
characters. Its channels are ordered so that turning about z takes four operations on blocks:

    x, vx, wx,  y, vy, wy,  z, vz, wz,  qw, qx, qz, qy

with position [m], velocity of the link's origin [m/s], angular velocity [rad/s] and orientation.
"""

from typing import NamedTuple

import torch

POSITION, VELOCITY, SPIN = slice(0, 9, 3), slice(1, 9, 3), slice(2, 9, 3)
"""Channels of the vectors."""
ORIENTATION = slice(9, 13)
"""Channels of the quaternions, in the order w, x, z, y."""
LINK_NUMBERS = 13
"""Numbers per link, here and in an observation."""
_OBSERVED = (0, 3, 6, 9, 10, 12, 11, 1, 4, 7, 2, 5, 8)
"""Channels in the order of observations: position, quaternion (w, x, y, z), velocity, angular velocity."""
_CHANNELS = tuple(_OBSERVED.index(channel) for channel in range(LINK_NUMBERS))
_LEAST_SQUARE = 1e-9
"""Added to the squared length of the root's forward axis on the ground, which is zero where the root looks up."""


class HeadingView(NamedTuple):
    """Links seen from the heading frame of the latest root: origin on the ground below it, z up, x where it faces.

    Attributes:
        links: link array (13, n, B) in this frame; quaternions have w >= 0.
        cos, sin: (B,) of the heading [rad], world.
    """

    links: torch.Tensor
    cos: torch.Tensor
    sin: torch.Tensor

    def latest(self, count: int) -> torch.Tensor:
        """The last frame's link array (13, count, B)."""
        return self.links[:, -count:]


def heading_view(frames: torch.Tensor, count: int) -> HeadingView:
    """The view of frames of `count` links each.

    Args:
        frames: link array (13, F * count, B), world frame, oldest frame first.
        count: L, links per frame.

    Returns:
        The links in the heading frame of the last frame's root, on flat ground at height 0.
    """
    root = frames[:, -count]
    w, x, z, y = root[ORIENTATION].unbind(0)
    forward_x, forward_y = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z)
    scale = torch.rsqrt(forward_x * forward_x + forward_y * forward_y + _LEAST_SQUARE)
    cos, sin = forward_x * scale, forward_y * scale
    half = torch.atan2(sin, cos) / 2
    half_cos, half_sin = torch.cos(half), torch.sin(half)
    nothing = torch.zeros_like(cos)
    ahead = frames[0:3] - torch.stack((root[0], nothing, nothing)).unsqueeze(1)
    aside = frames[3:6] - torch.stack((root[3], nothing, nothing)).unsqueeze(1)
    wx, zy = frames[9:11], frames[11:13]
    turned_wx, turned_zy = half_cos * wx + half_sin * zy, half_cos * zy - half_sin * wx
    sign = torch.where(turned_wx[:1] < 0, -1.0, 1.0).to(frames.dtype)
    blocks = (cos * ahead + sin * aside, cos * aside - sin * ahead, frames[6:9], turned_wx * sign, turned_zy * sign)
    return HeadingView(torch.cat(blocks), cos, sin)


def to_observed(links: torch.Tensor) -> torch.Tensor:
    """A link array (13, n, B) in the layout of observations, (B, n * 13)."""
    order = torch.tensor(_OBSERVED, device=links.device)
    return links.index_select(0, order).permute(2, 1, 0).reshape(links.shape[-1], -1)


def from_observed(numbers: torch.Tensor) -> torch.Tensor:
    """A link array (13, n, B) from link states (B, n, 13) in the order of observations."""
    order = torch.tensor(_CHANNELS, device=numbers.device)
    return numbers.permute(2, 1, 0).index_select(0, order)
