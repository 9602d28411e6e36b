"""The soles of the feet: where they are on the feet's links, and when they touch the ground."""

from functools import cache
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.humanoid import FEET, FOOT_LINKS, load_spec

TOUCHING = 0.015
"""A corner of a sole lower than this touches the ground [m]."""
_CORNERS = ((1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0))
"""Corners of a sole, counter-clockwise from below: share of the half length ahead, of the half width to the left."""


class SoleEdges(NamedTuple):
    """Distances of a sole from its ankle [m]: the sole below it, the toe edge ahead of it, the heel edge behind it."""

    below: float
    ahead: float
    behind: float


def foot_boxes(character: mujoco.MjModel | mujoco.MjSpec) -> NDArray[np.float64]:
    """Middles and half sides (2, 2, 3) [m] of the right and the left foot's box, in the feet's link frames."""
    return np.array([[character.geom(foot).pos, character.geom(foot).size] for foot in FEET])


def sole_corners(character: mujoco.MjModel | mujoco.MjSpec) -> NDArray[np.float64]:
    """The lower corners of the right and the left sole (2, 4, 3) [m], in the feet's link frames."""
    return _points(character, np.array(_CORNERS))


def sole_grid(character: mujoco.MjModel | mujoco.MjSpec, along: int, across: int) -> NDArray[np.float64]:
    """Points spread evenly over both soles (2, along * across, 3) [m], edges included, in the feet's link frames."""
    x, y = np.meshgrid(np.linspace(-1, 1, along), np.linspace(-1, 1, across))
    return _points(character, np.stack([x.ravel(), y.ravel()], axis=-1))


def _points(character: mujoco.MjModel | mujoco.MjSpec, places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (2, P, 3) of the soles at `places` (P, 2), in [-1, 1] along and across the foot."""
    shares = np.column_stack([places, np.full(len(places), -1.0)])
    return np.stack([middle + shares * half for middle, half in foot_boxes(character)])


@cache
def sole_edges() -> SoleEdges:
    """The edges of the plain character's soles; both feet are alike."""
    corners = sole_corners(load_spec())[0]
    return SoleEdges(-float(corners[0, 2]), float(corners[:, 0].max()), -float(corners[:, 0].min()))


def lowest_corner(character: mujoco.MjModel, links: NDArray[np.floating]) -> NDArray[np.float64]:
    """Height (n,) [m] of the lowest corner of both feet's boxes, from link states (n, 15, 13), world frame."""
    lowest = np.full(len(links), np.inf)
    for link, (middle, half) in zip(FOOT_LINKS, foot_boxes(character), strict=True):
        w, x, y, z = links[:, link, 3:7].T
        # Third row of the rotation matrix: how much each local axis adds to the height.
        up = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1)
        lowest = np.minimum(lowest, links[:, link, 2] + up @ middle - np.abs(up) @ half)
    return lowest
