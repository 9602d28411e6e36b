"""Uneven ground as heights on a grid: looked up for any point, and put into a model.

MuJoCo triangulates a heightfield; so does every height here, which makes it the height that feet meet.
"""

from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.ground_paint import paint
from adapt_envs.model.patch_grid import PATCH, STRIP, Patches
from adapt_envs.model.terrain import GRID, Terrain

_APRON = 100
"""Flat cells around the atlas (10 m): nobody gets to its end before being lost."""
_DEPTH = 1.0
"""Thickness of the ground below its lowest point [m]."""

Array = NDArray[np.floating]


class Surface:
    """Heights on a grid, triangulated as MuJoCo does.

    Attributes:
        heights: (rows along y, columns along x) float32 [m].
        low: (2,) world position x, y of the first height [m].
        shaded: whether a model shows it coloured by height, which costs memory that physics does not need.
        grid: distance of neighbouring heights [m].
    """

    def __init__(
        self, heights: NDArray[np.floating], low: tuple[float, float], shaded: bool = False, grid: float = GRID
    ) -> None:
        """Keep the heights; `low` is where the first one lies."""
        self.heights = np.ascontiguousarray(heights, np.float32)
        self.low, self.shaded, self.grid = low, shaded, grid

    @cached_property
    def _flat(self) -> NDArray[np.float32]:
        return self.heights.ravel()

    def height_at(self, x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.float32]:
        """Heights [m] at points, given as float32 arrays of one shape; beyond the edge, the edge's."""
        rows, columns = self.heights.shape
        u, v = (self._cells(*along) for along in ((x, self.low[0], columns), (y, self.low[1], rows)))
        column, row = u.astype(np.int32), v.astype(np.int32)
        u -= column
        v -= row
        # Each cell has two triangles that share the diagonal from its first to its last corner.
        first = row * np.int32(columns) + column
        between = first + np.where(u > v, np.int32(1), np.int32(columns))
        a, b, c = (self._flat.take(index) for index in (first, between, first + np.int32(columns + 1)))
        c -= b
        c *= np.minimum(u, v)
        b -= a
        b *= np.maximum(u, v)
        return a + b + c

    def _cells(self, values: NDArray[np.float32], low: float, count: int) -> NDArray[np.float32]:
        cells = values - np.float32(low)
        cells *= np.float32(1 / self.grid)
        np.maximum(cells, np.float32(0), out=cells)
        # Just short of the last height, so that the cell's other corners exist.
        return np.minimum(cells, np.float32(count - 1.001), out=cells)

    def add_to(self, spec: mujoco.MjSpec, friction: float) -> None:
        """Add the surface to a model's world as its floor."""
        material = paint(spec, self.heights, self.low, self.grid) if self.shaded else "ground"
        rows, columns = self.heights.shape
        lowest, highest = float(self.heights.min()), float(self.heights.max())
        half = ((columns - 1) * self.grid / 2, (rows - 1) * self.grid / 2)
        spec.add_hfield(
            name="terrain", nrow=rows, ncol=columns, size=(*half, max(highest - lowest, 1e-3), _DEPTH),
            userdata=self.heights.ravel(),
        )  # fmt: skip
        spec.worldbody.add_geom(
            name="floor", type=mujoco.mjtGeom.mjGEOM_HFIELD, hfieldname="terrain", material=material, priority=1,
            pos=(self.low[0] + half[0], self.low[1] + half[1], lowest), friction=(friction, 0.005, 0.0001), condim=3,
        )  # fmt: skip

    def cut(self, middle: Array, side: float) -> "Surface":
        """The square of `side` [m] around the point `middle` (2,), moved to stay within the surface."""
        cells = round(side / self.grid)
        first = np.round((np.asarray(middle) - self.low) / self.grid).astype(int) - cells // 2
        column, row = (int(i) for i in np.clip(first, 0, np.array(self.heights.shape[::-1]) - cells - 1))
        low = (self.low[0] + column * self.grid, self.low[1] + row * self.grid)
        piece = self.heights[row : row + cells + 1, column : column + cells + 1]
        return Surface(piece, low, self.shaded, self.grid)


def atlas(terrain: Terrain, patches: Patches, rng: np.random.Generator, scale: float = 1.0) -> Surface:
    """Patches of a terrain, side by side on one surface; they pass into each other, and into a flat apron, at height 0.

    Their heights are the function's times `scale`.

    Raises:
        ValueError: if the terrain's function returns something else than finite heights (size, size) or on a finer
            grid, or now one grid and now another.
    """
    side = range(patches.per_side)
    rows = [[_patch(terrain, rng) for _ in side] for _ in side]
    sizes = sorted({len(patch) for row in rows for patch in row})
    if len(sizes) > 1:
        raise ValueError(f"the terrain's function returned patches {sizes} heights wide, expected one grid for all")
    heights = scale * np.block(rows)
    fine = round(len(heights) * GRID / (2 * patches.half))
    heights = np.pad(heights, (_APRON * fine, _APRON * fine + 1))
    edge = -patches.half - _APRON * GRID
    return Surface(heights, (edge, edge), grid=GRID / fine)


def _patch(terrain: Terrain, rng: np.random.Generator) -> NDArray[np.float64]:
    """A patch with half the strip around it; its last row and column are the next patch's first."""
    size = round(PATCH / GRID) + 1
    heights = np.asarray(terrain(rng, size), np.float64)
    fine = max(1, (heights.shape[0] - 1) // (size - 1)) if heights.ndim else 1
    side = fine * (size - 1) + 1
    if heights.shape != (side, side) or not np.isfinite(heights).all():
        found = heights.shape if np.isfinite(heights).all() else f"{heights.shape} with some that are not finite"
        raise ValueError(f"the terrain's function returned {found}, expected finite heights ({size}, {size})")
    return np.pad(heights, fine * round(STRIP / GRID / 2), "linear_ramp")[:-1, :-1]
