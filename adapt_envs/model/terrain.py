"""Heights of uneven ground (paper, appendix C): pure functions that draw one square patch.

A terrain is a function `(rng, size) -> heights`: an array (size, size) [m] on a grid of 0.1 m, rows along y and columns
along x. Only the world's generator `rng` may be random in it.
"""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

GRID = 0.1
"""Distance of neighbouring heights [m]; that of the heightmap, too."""
HIGHEST = 0.75
"""Heights are normalised to +- this [m]; paper, appendix C."""
_WAVELENGTH = 6.0
"""Wavelength of the Perlin noise [m]."""
_NOISE, _NOISE_GRID = 0.1, 0.4
"""Greatest uniform noise [m] and the distance of its draws [m]; in between it is interpolated."""
_STEP_SIDE, _STEP_HEIGHT, _STEPS_PER_M2 = (0.6, 2.4), (-0.15, 0.15), 0.12
"""Rectangular steps: side lengths [m], heights [m] and their number per square metre."""
_SLOPE, _SLOPE_LENGTH = 0.3, 2.5
"""Steepest of the rugged terrain's surfaces and their length [m]."""
_SLOPE_LIMIT = 0.5
"""Bulges of the rugged terrain are cut off where they are steeper."""

Heights = NDArray[np.float64]
Terrain = Callable[[np.random.Generator, int], Heights]


def hills(rng: np.random.Generator, size: int) -> Heights:
    """Smooth hills: Perlin noise, normalised."""
    return normalised(perlin(rng, size, _WAVELENGTH))


def rocky(rng: np.random.Generator, size: int) -> Heights:
    """Perlin noise with uniform noise and rectangular steps, normalised."""
    smooth = 0.5 * normalised(perlin(rng, size, _WAVELENGTH))
    return normalised(smooth + uniform_noise(rng, size) + rectangular_steps(rng, size))


def rugged(rng: np.random.Generator, size: int) -> Heights:
    """Surfaces of slopes -0.3 to 0.3 with uniform noise, normalised; bulges steeper than 0.5 are cut off."""
    return without_bulges(normalised(sloped_surfaces(rng, size) + uniform_noise(rng, size)), _SLOPE_LIMIT)


TERRAINS: dict[str, Terrain] = {"hills": hills, "rocky": rocky, "rugged": rugged}
"""The paper's three kinds of terrain, by name."""


def normalised(heights: Heights) -> Heights:
    """Heights moved and scaled to reach from -0.75 m to 0.75 m; a flat patch becomes zero."""
    low, high = heights.min(), heights.max()
    if high - low < 1e-9:
        return np.zeros_like(heights)
    return (2 * (heights - low) / (high - low) - 1) * HIGHEST


def perlin(rng: np.random.Generator, size: int, wavelength: float) -> Heights:
    """Perlin's gradient noise (Perlin 2002) with random unit gradients every `wavelength` [m]; zero at these nodes."""
    along = np.arange(size) * GRID / wavelength
    cell = along.astype(int)
    inside = along - cell
    angle = rng.uniform(0, 2 * np.pi, (cell[-1] + 2, cell[-1] + 2))
    slope_x, slope_y = np.cos(angle), np.sin(angle)

    def corner(row: int, column: int) -> Heights:
        node = np.ix_(cell + row, cell + column)
        return slope_x[node] * (inside - column) + slope_y[node] * (inside - row)[:, None]

    fade = inside**3 * (inside * (6 * inside - 15) + 10)
    lower, upper = (corner(row, 0) + fade * (corner(row, 1) - corner(row, 0)) for row in (0, 1))
    return wavelength * (lower + fade[:, None] * (upper - lower))


def uniform_noise(rng: np.random.Generator, size: int) -> Heights:
    """Noise uniform in +-0.1 m, sampled every 0.4 m and interpolated linearly, so that a foot can stand on it."""
    nodes = int((size - 1) * GRID / _NOISE_GRID) + 2
    offsets = rng.uniform(-_NOISE, _NOISE, (nodes, nodes))
    # Exact: OpenCV's weights are multiples of 1/32, and so are quarters of a cell.
    to_nodes = np.diag([GRID / _NOISE_GRID, GRID / _NOISE_GRID, 0])[:2]
    return np.asarray(cv2.warpAffine(offsets, to_nodes, (size, size), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP))


def rectangular_steps(rng: np.random.Generator, size: int) -> Heights:
    """Rectangles raised or sunk by up to 0.15 m; where several lie, the last one counts."""
    heights = np.zeros((size, size))
    count = round(_STEPS_PER_M2 * (size * GRID) ** 2)
    low = rng.uniform(0, size * GRID, (count, 2))
    high = low + rng.uniform(*_STEP_SIDE, (count, 2))
    for (x, y), (x_end, y_end), height in zip(low, high, rng.uniform(*_STEP_HEIGHT, count), strict=True):
        heights[int(y / GRID) : int(y_end / GRID), int(x / GRID) : int(x_end / GRID)] = height
    return heights


def sloped_surfaces(rng: np.random.Generator, size: int) -> Heights:
    """Planes of 2.5 m that join without steps, each with slopes sampled from -0.3 to 0.3 along x and along y."""
    return _broken_line(rng, size) + _broken_line(rng, size)[:, None]


def _broken_line(rng: np.random.Generator, size: int) -> Heights:
    """(size,) heights of a path whose slope changes every 2.5 m and turns back where it would leave +-0.4 m."""
    length = round(_SLOPE_LENGTH / GRID)
    slopes, height = rng.uniform(-_SLOPE, _SLOPE, -(-size // length)), 0.0
    for i, slope in enumerate(slopes):
        if abs(height + slope * _SLOPE_LENGTH) > 0.4:
            slopes[i] = -slope
        height += slopes[i] * _SLOPE_LENGTH
    return np.cumsum(np.repeat(slopes, length)[:size]) * GRID


def without_bulges(heights: Heights, limit: float) -> Heights:
    """The highest surface nowhere above `heights` (n, m) whose slopes along x and y are at most `limit`."""
    for axis in (0, 1):
        shape = (-1, 1) if axis == 0 else (1, -1)
        climb = limit * GRID * np.arange(heights.shape[axis]).reshape(shape)
        ahead = np.minimum.accumulate(heights - climb, axis=axis) + climb
        behind = np.flip(np.minimum.accumulate(np.flip(heights + climb, axis), axis=axis), axis) - climb
        heights = np.minimum(ahead, behind)
    return heights
