"""The ground of all worlds: flat and endless, or one shared atlas of uneven patches, with or without obstacles.

MuJoCo triangulates a heightfield; so does every height here, which makes it the height that feet meet.
"""

from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.ground_paint import paint
from adapt_envs.model.obstacles import ObstacleField, Obstacles
from adapt_envs.model.patch_grid import INSET, PATCH, STRIP, Patches
from adapt_envs.model.terrain import GRID, Terrain

PATCHES_PER_SIDE, PATCHES_WITH_OBSTACLES = 4, 2
"""Patches in a row of the atlas; fewer with obstacles, each of which costs the physics."""
_APRON = 100
"""Flat cells around the atlas (10 m): nobody gets to its end before being lost."""
_DEPTH = 1.0
"""Thickness of the ground below its lowest point [m]."""
_TRIES = 24
"""Draws of a goal's or spawn's place before the nearest known good one is taken."""
TARGET_MARGIN, SPAWN_MARGIN = 0.4, 0.6
"""Goals and spawns keep this distance [m] from obstacles."""
_RUNWAY = np.array([0.0, 0.6, 1.2, 1.8])
"""Distances ahead of a spawn [m] at which no obstacle may be: the motion carries the character on."""
_ICE = (0.66, 0.84, 1.0)
_SHADE_AMONG_OBSTACLES = 0.72
"""They are looked at from above, where the headlight brightens the ground."""
_FRICTION = 1.0

Array = NDArray[np.floating]


class Surface:
    """Heights on a grid of 0.1 m, triangulated as MuJoCo does.

    Attributes:
        heights: (rows along y, columns along x) float32 [m].
        low: (2,) world position x, y of the first height [m].
        shaded: whether a model shows it coloured by height, which costs memory that physics does not need.
    """

    def __init__(self, heights: NDArray[np.floating], low: tuple[float, float], shaded: bool = False) -> None:
        """Keep the heights; `low` is where the first one lies."""
        self.heights = np.ascontiguousarray(heights, np.float32)
        self.low, self.shaded = low, shaded

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

    @staticmethod
    def _cells(values: NDArray[np.float32], low: float, count: int) -> NDArray[np.float32]:
        cells = values - np.float32(low)
        cells *= np.float32(1 / GRID)
        np.maximum(cells, np.float32(0), out=cells)
        # Just short of the last height, so that the cell's other corners exist.
        return np.minimum(cells, np.float32(count - 1.001), out=cells)

    def add_to(self, spec: mujoco.MjSpec, friction: float) -> None:
        """Add the surface to a model's world as its floor."""
        material = paint(spec, self.heights, self.low) if self.shaded else "ground"
        rows, columns = self.heights.shape
        lowest, highest = float(self.heights.min()), float(self.heights.max())
        half = ((columns - 1) * GRID / 2, (rows - 1) * GRID / 2)
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
        cells = round(side / GRID)
        first = np.round((np.asarray(middle) - self.low) / GRID).astype(int) - cells // 2
        column, row = (int(i) for i in np.clip(first, 0, np.array(self.heights.shape[::-1]) - cells - 1))
        low = (self.low[0] + column * GRID, self.low[1] + row * GRID)
        return Surface(self.heights[row : row + cells + 1, column : column + cells + 1], low, self.shaded)


def atlas(terrain: Terrain, patches: Patches, rng: np.random.Generator) -> Surface:
    """Patches of a terrain, side by side on one surface; they pass into each other, and into a flat apron, at height 0.

    Raises:
        ValueError: if the terrain's function returns something else than finite heights (size, size).
    """
    side = range(patches.per_side)
    heights = np.block([[_patch(terrain, rng) for _ in side] for _ in side])
    heights = np.pad(heights, (_APRON, _APRON + 1))
    edge = -patches.half - _APRON * GRID
    return Surface(heights, (edge, edge))


def _patch(terrain: Terrain, rng: np.random.Generator) -> NDArray[np.float64]:
    """A patch with half the strip around it; its last row and column are the next patch's first."""
    size = round(PATCH / GRID) + 1
    heights = np.asarray(terrain(rng, size), np.float64)
    if heights.shape != (size, size) or not np.isfinite(heights).all():
        raise ValueError(f"the terrain's function returned {heights.shape}, expected finite heights ({size}, {size})")
    return np.pad(heights, round(STRIP / GRID / 2), "linear_ramp")[:-1, :-1]


class Ground:
    """What the worlds stand on.

    Attributes:
        surface: uneven heights, or None for the plane z = 0.
        obstacles: blocks on it, or None.
        patches: where goals and spawns must lie, or None for anywhere.
    """

    def __init__(
        self, surface: Surface | None = None, obstacles: Obstacles | None = None, patches: Patches | None = None
    ) -> None:
        """Put the parts together; without any, the ground is flat, free and endless."""
        self.surface, self.obstacles, self.patches = surface, obstacles, patches

    @property
    def plain(self) -> bool:
        """Whether the ground is the endless plane without obstacles."""
        return self.patches is None

    def for_pictures(self, middle: Array | None = None, side: float = 20.0) -> "Ground":
        """The same ground coloured by height; with `middle` (2,) only a square of `side` [m] around it.

        Drawing a whole atlas in software takes seconds.
        """
        if self.surface is None:
            return self
        whole = Surface(self.surface.heights, self.surface.low, shaded=True)
        return Ground(whole if middle is None else whole.cut(middle, side), self.obstacles, self.patches)

    def height_at(self, xy: Array) -> NDArray[np.float32]:
        """Heights (...) [m] of the ground, obstacles included, at points (..., 2) [m]; exact to rounding."""
        return self.heights(xy[..., 0].astype(np.float32), xy[..., 1].astype(np.float32))

    def floor_at(self, xy: Array) -> NDArray[np.float32]:
        """Heights (...) [m] of the ground without its obstacles at points (..., 2) [m]: what one stands on."""
        if self.surface is None:
            return np.zeros(xy.shape[:-1], np.float32)
        return self.surface.height_at(xy[..., 0].astype(np.float32), xy[..., 1].astype(np.float32))

    def heights(self, x: NDArray[np.float32], y: NDArray[np.float32]) -> NDArray[np.float32]:
        """As `height_at`, of float32 coordinates given apart: the fast way for many points."""
        found = np.zeros(x.shape, np.float32) if self.surface is None else self.surface.height_at(x, y)
        if self.obstacles is not None:
            self.obstacles.raise_heights(found, x, y)
        return found

    def add_to(self, spec: mujoco.MjSpec, friction: float = _FRICTION) -> None:
        """Add the ground to a model; its priority makes its friction the contact's (else the larger of two counts)."""
        material = spec.material("ground")
        slippery = float(np.clip(1 - friction, 0, 1))
        shade = 1.0 if self.obstacles is None else _SHADE_AMONG_OBSTACLES
        material.rgba = (*(shade * (1 - slippery * (1 - np.array(_ICE)))), 1)
        material.reflectance += 0.25 * slippery
        if self.surface is not None:
            self.surface.add_to(spec, friction)
        else:
            spec.worldbody.add_geom(
                name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0, 0, 0.25), material="ground", priority=1,
                friction=(friction, 0.005, 0.0001), condim=3,
            )  # fmt: skip
        if self.obstacles is not None:
            self.obstacles.add_to(spec, friction)

    def clear(self, xy: Array, margin: float) -> NDArray[np.bool_]:
        """(...) whether points (..., 2) lie farther than `margin` [m] from every obstacle."""
        return np.ones(xy.shape[:-1], bool) if self.obstacles is None else self.obstacles.clear(xy, margin)

    def kept_targets(self, targets: Array, root_xy: Array, rng: np.random.Generator) -> NDArray[np.float32]:
        """Targets (n, 2) that lie 3 m inside the root's patch and in no obstacle.

        Bad ones are drawn anew at the same distance in another direction; where none is found, the nearest good place
        is taken. On endless ground they stay as they are.
        """
        if self.patches is None:
            return targets.astype(np.float32)
        targets = targets.astype(np.float64)
        distance = np.hypot(*(targets - root_xy).T)
        for _ in range(_TRIES):
            bad = np.flatnonzero(~self._good_target(targets, root_xy))
            if not len(bad):
                return targets.astype(np.float32)
            angle = rng.uniform(0, 2 * np.pi, len(bad))
            targets[bad] = root_xy[bad] + distance[bad, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        bad = np.flatnonzero(~self._good_target(targets, root_xy))
        targets[bad] = self._nearest_good(targets[bad], root_xy[bad])
        return targets.astype(np.float32)

    def _good_target(self, targets: Array, root_xy: Array) -> NDArray[np.bool_]:
        assert self.patches is not None
        inside = (np.abs(self.patches.clipped(targets, root_xy) - targets) < 1e-6).all(axis=-1)
        return inside & self.clear(targets, TARGET_MARGIN)

    def _nearest_good(self, targets: Array, root_xy: Array) -> Array:
        """The nearest place inside the patch; among obstacles, the nearest corner of their cells: lanes cross there."""
        assert self.patches is not None
        inside = self.patches.clipped(targets, root_xy)
        if self.obstacles is None:
            return inside
        cell, low = self.obstacles.layout.cell, self.patches.centres_1d[self.patches.split(root_xy)[0]] - PATCH / 2
        corner = np.clip(np.round((inside - low) / cell), 1, round(PATCH / cell) - 1)
        return np.where(self.clear(inside, TARGET_MARGIN)[:, None], inside, low + corner * cell)

    def inside_square(self, targets: Array) -> Array:
        """Targets (n, 2) moved to lie 3 m inside the whole square of patches; on endless ground as they are."""
        if self.patches is None:
            return targets
        reach = self.patches.half - INSET
        return np.clip(targets, -reach, reach)

    def spawns(self, n: int, rng: np.random.Generator) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Places (n, 2) [m] 3 m inside the patches and headings (n,) [rad] with nothing in the way.

        Not on endless ground, where any place is as good.
        """
        assert self.patches is not None
        xy, heading = np.empty((n, 2)), np.empty(n)
        left = np.arange(n)
        for _ in range(_TRIES):
            xy[left], heading[left] = self.patches.sample(len(left), rng), rng.uniform(0, 2 * np.pi, len(left))
            course = np.stack([np.cos(heading[left]), np.sin(heading[left])], axis=-1)
            ahead = xy[left, None] + _RUNWAY[:, None] * course[:, None]
            left = left[~self.clear(ahead, SPAWN_MARGIN).all(axis=1)]
        xy[left] = self._nearest_good(xy[left], xy[left])
        return xy, heading


def make_ground(terrain: Terrain | None, obstacles: ObstacleField | None, seed: int) -> Ground:
    """The ground of a task: endless and flat without either, else bounded to patches drawn from `seed`."""
    if terrain is None and obstacles is None:
        return Ground()
    patches = Patches(PATCHES_PER_SIDE if obstacles is None else PATCHES_WITH_OBSTACLES)
    heights_rng, blocks_rng = np.random.default_rng(seed).spawn(2)
    surface = None if terrain is None else atlas(terrain, patches, heights_rng)
    blocks = None if obstacles is None else Obstacles(obstacles, patches, blocks_rng)
    if surface is not None and blocks is not None:
        blocks.stand_on(surface.height_at(*blocks.centre.T.astype(np.float32)))
    return Ground(surface, blocks, patches)
