"""Grounds as files: small enough to send, and exactly the suite's where they are."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.ground import Ground, make_ground
from adapt_envs.model.obstacles import OBSTACLES
from adapt_envs.model.surface import Surface
from adapt_envs.model.terrain import TERRAINS
from adapt_envs.portable.choices import GROUNDS
from adapt_envs.tables import entry

SIDE = 64.0
"""Side of the square of uneven ground that is sent [m], around the world's origin."""
_SPAWN_SEED = 4
"""Seed of the place where characters start on bounded ground."""


@dataclass(frozen=True)
class SiteGround:
    """A ground to send.

    Attributes:
        ground: what characters stand on.
        friction: its sliding friction.
        fall_height: links that touch from higher than this [m] have not fallen; None if any touch is a fall.
        reach: targets stay within this distance [m] from the origin along x and y; infinite on endless ground.
        spawn: x, y [m] and heading [rad] of where characters start.
    """

    ground: Ground
    friction: float
    fall_height: float | None
    reach: float
    spawn: tuple[float, float, float]

    @property
    def heights(self) -> NDArray[np.float32] | None:
        """(rows along y, columns along x) heights [m] on the surface's grid, or None for flat ground."""
        return None if self.ground.surface is None else self.ground.surface.heights

    def to_json(self) -> dict[str, Any]:
        """JSON values: heights go into a file of their own."""
        surface, blocks = self.ground.surface, self.ground.obstacles
        reach = self.reach if np.isfinite(self.reach) else None
        values: dict[str, Any] = {"friction": self.friction, "fall_height": self.fall_height, "reach": reach}
        if surface is not None:
            rows, columns = surface.heights.shape
            low = [float(v) for v in surface.low]
            values["surface"] = {"rows": rows, "columns": columns, "grid": surface.grid, "low": low}
        if blocks is not None:
            columns_ = (*blocks.centre.T, *blocks.half.T, blocks.yaw, blocks.top)
            names = ("x", "y", "half_x", "half_y", "yaw", "top")
            values["blocks"] = {name: column.tolist() for name, column in zip(names, columns_, strict=True)}
        return values


@lru_cache
def site_ground(name: str) -> SiteGround:
    """The ground called `name` in `GROUNDS`.

    Raises:
        ValueError: if there is none, listing the names.
    """
    row = entry("ground", GROUNDS, name).row
    terrain, obstacles = entry("terrain", TERRAINS, row.terrain), entry("obstacles", OBSTACLES, row.obstacles)
    ground = make_ground(terrain, obstacles, row.terrain_seed, row.terrain_scale)
    if ground.patches is None:
        return SiteGround(ground, row.friction, row.fall_height, np.inf, (0.0, 0.0, 0.0))
    rng, reach = np.random.default_rng(_SPAWN_SEED), ground.patches.half
    if ground.surface is not None:
        ground, reach = Ground(_middle(ground.surface), ground.obstacles, ground.patches), SIDE / 2
    xy, heading = ground.spawns(200, rng)
    nearest = int(np.abs(xy).max(axis=1).argmin())
    spawn = float(xy[nearest, 0]), float(xy[nearest, 1]), float(heading[nearest])
    return SiteGround(ground, row.friction, row.fall_height, reach, spawn)


def _middle(surface: Surface) -> Surface:
    """The square of `SIDE` around the origin.

    Its first and last height are the lowest and the highest of the whole: MuJoCo stores heights as shares of this
    range, and so they stay the same to the last bit. Nobody gets to these corners.
    """
    part = surface.cut(np.zeros(2), SIDE)
    heights = part.heights.copy()
    heights[0, 0], heights[-1, -1] = surface.heights.min(), surface.heights.max()
    return Surface(heights, part.low, grid=part.grid)
