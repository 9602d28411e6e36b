"""Obstacles: blocks too high to step on, at most one to a square cell, with free lanes between them (paper, 8.3)."""

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.patch_grid import PATCH, Patches

_BOTTOM = -1.0
"""The blocks reach down to here [m], and at least so far below the lowest ground."""
_RASTER = 0.1
"""Side [m] of the cells of the raster that finds blocks."""
_COLOUR = (0.72, 0.45, 0.30, 1.0)


@dataclass(frozen=True)
class ObstacleField:
    """How obstacles are laid out.

    Attributes:
        cell: side [m] of the cells that hold one block at most; it divides 24 m.
        lane: what stays free between the blocks of neighbouring cells [m].
        side: range of the blocks' horizontal sides [m].
        height: range of the blocks' heights over the ground at their middle [m].
        density: share of the cells that hold a block.
    """

    cell: float = 4.0
    lane: float = 1.2
    side: tuple[float, float] = (0.6, 1.6)
    height: tuple[float, float] = (0.9, 1.4)
    density: float = 0.85

    def __post_init__(self) -> None:
        """Check that blocks fit into their cells.

        Raises:
            ValueError: if they do not, if the cells do not fill a patch, a range does not rise, or the density is no
                share.
        """
        for name, (low, high) in (("side", self.side), ("height", self.height)):
            if not 0 < low <= high < float("inf"):
                raise ValueError(f"{name} is {(low, high)!r} m, expected 0 < low <= high")
        if not 0 <= self.density <= 1:
            raise ValueError(f"density is {self.density!r}, expected a share from 0 to 1")
        if not 0 < self.cell <= PATCH:
            raise ValueError(f"cell is {self.cell!r} m, expected a divisor of the patch's {PATCH:g} m")
        if abs(PATCH / self.cell - round(PATCH / self.cell)) > 1e-6:
            raise ValueError(f"cell is {self.cell!r} m, expected a divisor of the patch's {PATCH:g} m")
        if self.lane < 2 * _RASTER:
            raise ValueError(f"lane is {self.lane!r} m, expected at least {2 * _RASTER} m")
        if self.side[1] * np.sqrt(2) > self.cell - self.lane:
            found = f"{self.side[1]!r} m, lane {self.lane!r} m and cell {self.cell!r} m"
            raise ValueError(f"side is up to {found}: a block's diagonal and a lane must fit into a cell")


OBSTACLES: dict[str, ObstacleField] = {"blocks": ObstacleField()}
"""Layouts by name."""


class Obstacles:
    """Blocks that stand on the ground, found at any point through a raster that names the one block near it.

    Attributes:
        layout: how they were laid out.
        centre: (B, 2) middles of the blocks [m], world.
        half: (B, 2) half lengths along their own axes [m].
        yaw: (B,) how far they are turned [rad].
        top: (B,) heights of their tops [m], world.
        bottom: height that all reach down to [m], world.
    """

    def __init__(self, layout: ObstacleField, patches: Patches, rng: np.random.Generator) -> None:
        """Sample the blocks; they stand at height 0."""
        self.layout = layout
        across = np.arange(layout.cell / 2, PATCH, layout.cell) - PATCH / 2
        middle = (patches.centres_1d[:, None] + across).ravel()
        centre = np.stack(np.meshgrid(middle, middle), axis=-1).reshape(-1, 2)
        half = rng.uniform(*layout.side, centre.shape) / 2
        room = (layout.cell - layout.lane) / 2 - np.hypot(*half.T)
        centre = centre + rng.uniform(-1, 1, centre.shape) * room[:, None]
        there = rng.uniform(size=len(centre)) < layout.density
        self.centre, self.half = centre[there], half[there]
        self.yaw = rng.uniform(0, np.pi, len(self.centre))
        self.top, self.bottom = rng.uniform(*layout.height, len(self.centre)), _BOTTOM
        self._origin = -patches.half
        self._raster = self._covered(round(2 * patches.half / _RASTER))

    def _covered(self, size: int) -> NDArray[np.int16]:
        """(size, size) number of the block that may cover a cell of the raster, -1 where none does."""
        raster = np.full((size, size), -1, np.int16)
        c, s = np.abs(np.cos(self.yaw)), np.abs(np.sin(self.yaw))
        reach = np.stack([c * self.half[:, 0] + s * self.half[:, 1], s * self.half[:, 0] + c * self.half[:, 1]], axis=1)
        low = np.floor((self.centre - reach - self._origin) / _RASTER).astype(int)
        high = np.ceil((self.centre + reach - self._origin) / _RASTER).astype(int)
        for block, ((x, y), (x_end, y_end)) in enumerate(zip(low, high, strict=True)):
            raster[y:y_end, x:x_end] = block
        return raster

    @cached_property
    def _table(self) -> NDArray[np.float32]:
        columns = (self.centre, self.half, np.cos(self.yaw), np.sin(self.yaw), self.top)
        return np.column_stack(columns).astype(np.float32)

    def stand_on(self, ground: NDArray[np.floating], lowest: float) -> None:
        """Lift the blocks by the heights (B,) [m] of the ground below them; `lowest` [m] is its lowest point."""
        self.top, self.bottom = self.top + ground, min(_BOTTOM, lowest + _BOTTOM)
        self.__dict__.pop("_table", None)

    def raise_heights(self, heights: NDArray[np.float32], x: NDArray[np.float32], y: NDArray[np.float32]) -> None:
        """Set `heights` (...) to the blocks' tops where the points x, y (...) [m] lie on blocks that are higher."""
        size = self._raster.shape[0]
        column = np.clip((x - np.float32(self._origin)) * np.float32(1 / _RASTER), 0, size - 1).astype(np.int32)
        row = np.clip((y - np.float32(self._origin)) * np.float32(1 / _RASTER), 0, size - 1).astype(np.int32)
        block = self._raster.ravel().take(row * np.int32(size) + column)
        near = np.nonzero(block >= 0)
        table = self._table[block[near]]
        top = np.where(_inside(x[near], y[near], table, 0.0), table[:, 6], -np.inf)
        heights[near] = np.maximum(heights[near], top)

    def clear(self, xy: NDArray[np.floating], margin: float) -> NDArray[np.bool_]:
        """(...) whether points (..., 2) [m] lie farther than `margin` [m] from every block's sides."""
        x, y = xy[..., 0, None], xy[..., 1, None]
        return np.logical_not(np.any(_inside(x, y, self._table, margin), axis=-1))

    def distance(self, xy: NDArray[np.floating]) -> NDArray[np.float32]:
        """Distances (...) [m] of points (..., 2) [m] from the nearest block's sides; 0 within a block."""
        beyond = _beyond(xy[..., 0, None], xy[..., 1, None], self._table)
        return np.hypot(*(np.maximum(part, 0) for part in beyond)).min(axis=-1, initial=np.inf).astype(np.float32)

    def add_to(self, spec: mujoco.MjSpec, friction: float) -> None:
        """Add the blocks to a model's world."""
        spec.add_material(name="obstacle", rgba=_COLOUR, specular=0.1, shininess=0.1)
        for i, (centre, half, yaw, top) in enumerate(zip(self.centre, self.half, self.yaw, self.top, strict=True)):
            spec.worldbody.add_geom(
                name=f"obstacle_{i}", type=mujoco.mjtGeom.mjGEOM_BOX, material="obstacle",
                pos=(*centre, (top + self.bottom) / 2), size=(*half, (top - self.bottom) / 2),
                quat=(np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)), friction=(friction, 0.005, 0.0001), priority=1,
            )  # fmt: skip


def _inside(
    x: NDArray[np.floating], y: NDArray[np.floating], table: NDArray[np.float32], margin: float
) -> NDArray[np.bool_]:
    along, across = _beyond(x, y, table)
    return (along <= margin) & (across <= margin)


def _beyond(
    x: NDArray[np.floating], y: NDArray[np.floating], table: NDArray[np.float32]
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """How far points lie beyond the blocks' sides along either of the blocks' axes; negative between the sides."""
    dx, dy = x - table[:, 0], y - table[:, 1]
    c, s = table[:, 4], table[:, 5]
    return np.abs(c * dx + s * dy) - table[:, 2], np.abs(c * dy - s * dx) - table[:, 3]
