"""How uneven ground is painted: by height, with lines every metre."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.terrain import GRID, HIGHEST

_HEIGHTS = (-HIGHEST, -0.3, 0.0, 0.3, HIGHEST)
_COLOURS = np.array([(58, 84, 104), (112, 140, 142), (172, 180, 160), (214, 194, 150), (246, 230, 200)]) / 255
"""Colours of these heights, from valleys to tops."""
_PIXELS = 4
"""Pixels per 0.1 m, on ground up to twice as fine."""
_LARGEST = 2048
"""Widest texture in pixels; larger ground gets coarser ones."""
_LINE = 0.90
"""Brightness of the lines."""


def painted(heights: NDArray[np.float32], low: tuple[float, float], grid: float = GRID) -> NDArray[np.uint8]:
    """Picture (h, w, 3) of heights (rows, columns) [m], `grid` [m] apart from `low` (x, y) [m] on; rows along y."""
    fine = max(1, min(round(_PIXELS * grid / GRID), _LARGEST // max(heights.shape)))
    rows, columns = ((np.arange((count - 1) * fine) + 0.5) / fine for count in heights.shape)
    level = heights[np.ix_(np.round(rows).astype(int), np.round(columns).astype(int))]
    picture = np.stack([np.interp(level, _HEIGHTS, colour) for colour in _COLOURS.T], axis=-1)
    y, x = low[1] + rows * grid, low[0] + columns * grid
    lines = (_near_metre(y)[:, None] | _near_metre(x)) if fine > 1 else np.zeros(level.shape, bool)
    picture[lines] *= _LINE
    return np.round(picture * 255).astype(np.uint8)


def _near_metre(values: NDArray[np.floating]) -> NDArray[np.bool_]:
    return np.abs(values - np.round(values)) < GRID / _PIXELS


def paint(spec: mujoco.MjSpec, heights: NDArray[np.float32], low: tuple[float, float], grid: float) -> str:
    """Add the picture of `heights` to a model, tinted as its ground is; return the material's name."""
    picture = painted(heights, low, grid)
    texture = spec.add_texture(name="relief", type=mujoco.mjtTexture.mjTEXTURE_2D, nchannel=3)
    texture.height, texture.width, texture.data = *picture.shape[:2], picture.tobytes()
    material = spec.add_material(name="relief", rgba=spec.material("ground").rgba, specular=0.05, shininess=0.1)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "relief"
    material.texrepeat = (1, 1)
    return material.name
