"""Heights of uneven ground (paper, appendix C): pure functions that draw one square patch.

A terrain is a function `(rng, size) -> heights`: an array (size, size) [m] on a grid of 0.1 m, rows along y and columns
along x; or on a finer one that divides each of these cells into n x n, (n (size - 1) + 1) heights along each side. Only
the world's generator `rng` may be random in it.
"""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

GRID = 0.1
"""Distance of neighbouring heights [m], unless a terrain is finer; that of the heightmap, too."""
HIGHEST = 0.75
"""Heights are normalised to +- this [m]; paper, appendix C."""
_WAVELENGTH = 6.0
"""Wavelength of the Perlin noise [m]."""
_NOISE, _NOISE_GRID = 0.1, 0.4
"""Greatest uniform noise [m] and the distance of its draws [m]; in between it is interpolated."""
_RUGGED_NOISE_GRID, _RUGGED_NOISE_STEP = 0.2, 0.05
"""On rugged ground the noise is drawn every 0.2 m, and is a multiple of 0.05 m, as in the authors' release."""
_STEP_SIDE, _STEP_HEIGHT, _STEPS_PER_M2 = (0.6, 2.4), (-0.15, 0.15), 0.12
"""Rectangular steps: side lengths [m], heights [m] and their number per square metre."""
_SLOPE, _SLOPE_LENGTH, _SLOPE_RISE = 0.3, 1.5, 0.325
"""Steepest of the rugged terrain's surfaces, their length, and how far they rise and sink along one axis [m].

Two axes and the noise together stay within +-0.75 m: normalising them never makes the steps smaller.
"""
_SLOPE_LIMIT = 0.5
"""What is steeper on rugged ground becomes a vertical step."""
_FINE = 2
"""Cells along each side that `stepped` makes of one."""

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
    """Surfaces of slopes -0.3 to 0.3 with uniform noise, normalised; what is steeper than 0.5 becomes steps."""
    noise = uniform_noise(rng, size, _RUGGED_NOISE_GRID, _RUGGED_NOISE_STEP)
    return stepped(normalised(sloped_surfaces(rng, size) + noise), _SLOPE_LIMIT)


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


def uniform_noise(
    rng: np.random.Generator, size: int, apart: float = _NOISE_GRID, step: float | None = None
) -> Heights:
    """Noise uniform in +-0.1 m, sampled every `apart` [m] and interpolated linearly.

    Args:
        rng: the generator.
        size: heights along each side.
        apart: distance of the samples [m]: 0.2 or 0.4, at which a foot can stand on it.
        step: samples are multiples of this [m]; None for any number.
    """
    nodes = int((size - 1) * GRID / apart) + 2
    if step is None:
        offsets = rng.uniform(-_NOISE, _NOISE, (nodes, nodes))
    else:
        most = round(_NOISE / step)
        offsets = np.asarray(step * rng.integers(-most, most, (nodes, nodes), endpoint=True), np.float64)
    # Exact: OpenCV's weights are multiples of 1/32, and so are quarters of a cell.
    to_nodes = np.diag([GRID / apart, GRID / apart, 0])[:2]
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
    """Planes of 1.5 m that join without steps, each with slopes sampled from -0.3 to 0.3 along x and along y."""
    return _broken_line(rng, size) + _broken_line(rng, size)[:, None]


def _broken_line(rng: np.random.Generator, size: int) -> Heights:
    """(size,) heights of a path whose slope changes every 1.5 m; sampled of those that keep it within 0.325 m."""
    length = round(_SLOPE_LENGTH / GRID)
    slopes, height = np.empty(-(-size // length)), 0.0
    for i in range(len(slopes)):
        lowest, highest = ((edge - height) / _SLOPE_LENGTH for edge in (-_SLOPE_RISE, _SLOPE_RISE))
        slopes[i] = rng.uniform(max(-_SLOPE, lowest), min(_SLOPE, highest))
        height += slopes[i] * _SLOPE_LENGTH
    return np.cumsum(np.repeat(slopes, length)[:size]) * GRID


def stepped(heights: Heights, limit: float) -> Heights:
    """Heights (2n - 1, 2m - 1) on the half grid of (n, m) ones, faces steeper than `limit` replaced by steps.

    The authors gave their heights and a `slope_threshold` to a maker of meshes, which moves the vertices below a steep
    face to beneath those above it: lower ground goes on to there and ends at a vertical wall. Here it goes on likewise.
    As MuJoCo's heightfields have no vertical faces, the wall stands in the last half cell before the upper edge, 5 cm.
    What was upper edge on both sides would be a wall without thickness: such a bulge is cut off at the higher side.
    """
    return _stepped_along_x(_stepped_along_x(heights, limit).T, limit).T


def _stepped_along_x(heights: Heights, limit: float) -> Heights:
    """`stepped` along each row, (n, m) to (n, 2m - 1)."""
    first, second = heights[:, :-1], heights[:, 1:]
    steep = np.abs(second - first) > limit * GRID
    lower = np.minimum(first, second)
    # What each cell is at its two ends: in a steep one the lower ground all along.
    begins, ends = np.where(steep, lower, first), np.where(steep, lower, second)
    found = np.empty((len(heights), _FINE * first.shape[1] + 1))
    found[:, :1], found[:, -1:] = heights[:, :1], heights[:, -1:]
    found[:, _FINE:-1:_FINE] = np.maximum(ends[:, :-1], begins[:, 1:])
    for i in range(1, _FINE):
        found[:, i::_FINE] = begins + i / _FINE * (ends - begins)
    return found
