"""The ground as triangles: tiles of uneven ground as MuJoCo triangulates them, and a ring that lies on it."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.ground import Ground
from adapt_envs.model.ground_paint import painted
from adapt_envs.model.terrain import GRID
from adapt_envs.tasks.goal import GOAL_RADIUS

TILE = 8.0
"""Side of a tile [m]."""
_RING_WIDTH, _RING_ABOVE, _RING_POINTS = 0.12, 0.03, 48
"""Width of the goal's ring [m], how far it lies above the ground [m], and its corners."""

TileKey = tuple[int, int]
"""Column and row of a tile; tile (0, 0) begins at the world's origin."""


class Mesh(NamedTuple):
    """Triangles in the world's frame.

    Attributes:
        vertices: (V, 3) float32 positions [m].
        faces: (F, 3) numbers of each triangle's vertices, counterclockwise as seen from above.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]


class Tile(NamedTuple):
    """A painted square of the ground.

    Attributes:
        mesh: its triangles.
        picture: (h, w, 3) its paint, rows along y; the renderer's.
        texture_xy: (V, 2) where on the picture each vertex lies: along x and along y, in [0, 1].
    """

    mesh: Mesh
    picture: NDArray[np.uint8]
    texture_xy: NDArray[np.float32]


def tiles_near(xy: NDArray[np.floating], reach: float) -> list[TileKey]:
    """Tiles that lie within `reach` [m] of the point `xy` (2,) along x and y, the nearest first."""
    low, high = (np.floor((np.asarray(xy, float) + side) / TILE).astype(int) for side in (-reach, reach))
    keys = [(x, y) for x in range(low[0], high[0] + 1) for y in range(low[1], high[1] + 1)]
    return sorted(keys, key=lambda key: math.dist((np.array(key) + 0.5) * TILE, xy))


def tile(ground: Ground, key: TileKey) -> Tile:
    """A tile of the ground without its obstacles.

    The heights are those at the corners of the terrain's own cells, so that the triangles are those that feet meet.
    """
    grid = GRID if ground.surface is None else ground.surface.grid
    cells = round(TILE / grid)
    low = (key[0] * TILE, key[1] * TILE)
    x, y = (start + grid * np.arange(cells + 1) for start in low)
    xy = np.stack(np.meshgrid(x, y), axis=-1)
    heights = ground.floor_at(xy)
    vertices = np.concatenate([xy.astype(np.float32), heights[..., None]], axis=-1).reshape(-1, 3)
    picture = painted(heights, low, grid)
    # From the middle of the first pixel to that of the last one: beyond, textures begin again at the other edge.
    edge = 0.5 / len(picture)
    along = np.linspace(edge, 1 - edge, cells + 1, dtype=np.float32)
    texture_xy = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    return Tile(Mesh(vertices, grid_faces(cells + 1, cells + 1)), picture, texture_xy)


def grid_faces(rows: int, columns: int) -> NDArray[np.int32]:
    """Triangles (F, 3) of a grid of vertices numbered row by row, rows along y.

    Each cell has two, which share the diagonal from its first to its last corner, as in MuJoCo's heightfields.
    """
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    below = np.stack([first, first + 1, first + columns + 1], axis=-1)
    above = np.stack([first, first + columns + 1, first + columns], axis=-1)
    return np.concatenate([below, above]).astype(np.int32)


def goal_ring(ground: Ground, target: NDArray[np.floating]) -> Mesh:
    """A flat ring of radius 0.5 m that follows the ground around the `target` (2,) [m]."""
    angles = np.linspace(0, 2 * np.pi, _RING_POINTS + 1)
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    radii = GOAL_RADIUS + _RING_WIDTH * np.array([0.5, -0.5])
    xy = target + radii[:, None, None] * direction
    vertices = np.concatenate([xy, ground.floor_at(xy)[..., None] + _RING_ABOVE], axis=-1)
    return Mesh(vertices.reshape(-1, 3).astype(np.float32), grid_faces(2, _RING_POINTS + 1))
