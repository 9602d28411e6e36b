"""The ground of all worlds: flat and endless, or one shared atlas of uneven patches, with or without obstacles."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.obstacles import ObstacleField, Obstacles
from adapt_envs.model.patch_grid import INSET, PATCH, Patches
from adapt_envs.model.surface import Surface, atlas
from adapt_envs.model.terrain import Terrain

PATCHES_PER_SIDE, PATCHES_WITH_OBSTACLES = 4, 2
"""Patches in a row of the atlas; fewer with obstacles, each of which costs the physics."""
_TRIES = 24
"""How often a place for a goal or spawn is sampled before the nearest known good one is taken."""
_TRIES_AHEAD = 12
"""The first tries keep to where goals may lie; near a border nothing there may do."""
TARGET_MARGIN, SPAWN_MARGIN = 0.4, 0.6
"""Goals and spawns keep this distance [m] from obstacles."""
_RUNWAY = np.array([0.0, 0.6, 1.2, 1.8])
"""Distances ahead of a spawn [m] at which no obstacle may be: the motion carries the character on."""
_ICE = (0.66, 0.84, 1.0)
_SHADE_AMONG_OBSTACLES = 0.72
"""They are looked at from above, where the headlight brightens the ground."""
_FRICTION = 1.0

Array = NDArray[np.floating]


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
        whole = Surface(self.surface.heights, self.surface.low, shaded=True, grid=self.surface.grid)
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

    def distance_to_obstacles(self, xy: Array) -> NDArray[np.float32]:
        """Distances (...) [m] of points (..., 2) from the nearest obstacle's sides, infinite without obstacles."""
        return np.full(xy.shape[:-1], np.inf, np.float32) if self.obstacles is None else self.obstacles.distance(xy)

    def kept_targets(
        self, targets: Array, root_xy: Array, rng: np.random.Generator, root_heading: Array, spread: Array
    ) -> NDArray[np.float32]:
        """Targets (n, 2) that lie 3 m inside the root's patch and in no obstacle.

        Bad ones are sampled again at the same distance in another direction, at first within `spread` (n,), a share of
        the circle centred straight ahead of `root_heading` (n,) [rad]; where none is found, the nearest good place is
        taken. On endless ground they stay as they are.
        """
        if self.patches is None:
            return targets.astype(np.float32)
        targets = targets.astype(np.float64)
        distance = np.hypot(*(targets - root_xy).T)
        for number in range(_TRIES):
            bad = np.flatnonzero(~self._good_target(targets, root_xy))
            if not len(bad):
                return targets.astype(np.float32)
            angle = rng.uniform(0, 2 * np.pi, len(bad))
            if number < _TRIES_AHEAD:
                ahead = root_heading[bad] + spread[bad] * (angle - np.pi)
                angle = np.where(spread[bad] < 1, ahead, angle)
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


def make_ground(terrain: Terrain | None, obstacles: ObstacleField | None, seed: int, scale: float = 1.0) -> Ground:
    """The ground of a task: endless and flat without either, else bounded to patches sampled from `seed`.

    The terrain's heights are multiplied by `scale`.
    """
    if terrain is None and obstacles is None:
        return Ground()
    patches = Patches(PATCHES_PER_SIDE if obstacles is None else PATCHES_WITH_OBSTACLES)
    heights_rng, blocks_rng = np.random.default_rng(seed).spawn(2)
    surface = None if terrain is None else atlas(terrain, patches, heights_rng, scale)
    blocks = None if obstacles is None else Obstacles(obstacles, patches, blocks_rng)
    if surface is not None and blocks is not None:
        blocks.stand_on(surface.height_at(*blocks.centre.T.astype(np.float32)), float(surface.heights.min()))
    return Ground(surface, blocks, patches)
