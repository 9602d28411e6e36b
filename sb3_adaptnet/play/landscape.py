"""What surrounds the character in the browser: the ground, its obstacles and the goal."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.geom_mesh import colour_of
from adapt_envs.model.ground import Ground
from sb3_adaptnet.play.extra import pil_image, trimesh
from sb3_adaptnet.play.figure import rgb
from sb3_adaptnet.play.ground_mesh import Mesh, Tile, TileKey, goal_ring, tile, tiles_near

ROOT = "/ground"
"""Name of the frame that all of it hangs on; its position is the world's origin as seen from the character."""
REACH, KEPT = 12.0, 24.0
"""Tiles within this distance of the character [m] are shown; those beyond the second one are taken away."""
_TILES_PER_STEP = 2
"""Tiles added at once: each costs about 15 ms, and steps follow each other at 30 Hz."""
_GRID, _CELL = 30.0, 1.0
"""Side of the flat ground that moves along, and of its squares [m]."""
_BELOW = 0.005
"""The flat ground lies this far [m] below its lines."""
_DIMMED = 0.8
"""Brightness of the paint: viser's lights are brighter than the renderer's."""
_PAPER = 235
"""Brightness of flat ground, up to 255, before the model tints it."""
_GOAL_COLOUR = (41, 158, 90)


class Landscape:
    """Ground, obstacles and goal in a viser scene; they move while the character stays in the middle.

    Flat ground is endless: a square with lines that moves along. Of uneven ground the tiles around the character are
    there.
    """

    def __init__(self, scene: Any, model: mujoco.MjModel, ground: Ground) -> None:
        """Add what does not change to `scene`, a viser `SceneApi`."""
        self._scene, self._ground = scene, ground
        self._frame = scene.add_frame(ROOT, show_axes=False)
        self._tint = colour_of(model, model.geom("floor").id)
        self._tiles: dict[TileKey, Any] = {}
        self._lines = _add_flat(scene, self._tint) if ground.surface is None else None
        self._goal = _add_mesh(scene, f"{ROOT}/goal", goal_ring(ground, np.zeros(2)), _GOAL_COLOUR)
        for geom in obstacles(model):
            handle = scene.add_box(
                f"{ROOT}/obstacle_{geom}",
                color=rgb(colour_of(model, geom)),
                dimensions=tuple(2 * model.geom_size[geom]),
            )
            handle.position, handle.wxyz = model.geom_pos[geom], model.geom_quat[geom]

    def place(self, middle: NDArray[np.float64], target: NDArray[np.floating]) -> None:
        """Show what lies around the point `middle` (3,), with the goal at `target` (2,) [m, world frame]."""
        self._frame.position = -middle
        if self._lines is None:
            self._renew_tiles(middle[:2])
        else:
            self._lines.position = np.append(-np.mod(middle[:2], _CELL), -middle[2])
        self._goal.vertices = goal_ring(self._ground, target).vertices

    def _renew_tiles(self, xy: NDArray[np.float64]) -> None:
        """Add a few of the tiles that are missing around `xy` (2,), the nearest first, and drop those far away."""
        missing = [key for key in tiles_near(xy, REACH) if key not in self._tiles]
        for key in missing[:_TILES_PER_STEP]:
            name = f"{ROOT}/tile_{key[0]}_{key[1]}"
            self._tiles[key] = _add_tile(self._scene, name, tile(self._ground, key), self._tint)
        for key in set(self._tiles) - set(tiles_near(xy, KEPT)):
            self._tiles.pop(key).remove()


def obstacles(model: mujoco.MjModel) -> list[int]:
    """Numbers of the geoms that are obstacles: the world's boxes."""
    count = int(model.body_geomnum[0])
    return [geom for geom in range(count) if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_BOX]


def _add_flat(scene: Any, tint: NDArray[np.float64]) -> Any:
    """Add a plain square, which stays, and lines; return the handle of the lines, which move along."""
    side = _GRID / 2
    corners = np.array([(-side, -side, -_BELOW), (side, -side, -_BELOW), (side, side, -_BELOW), (-side, side, -_BELOW)])
    faces = np.array([(0, 1, 2), (0, 2, 3)], np.int32)
    _add_mesh(scene, "/floor", Mesh(corners.astype(np.float32), faces), rgb(_PAPER / 255 * tint))
    return scene.add_grid("/lines", width=_GRID, height=_GRID, cell_size=_CELL)


def _add_mesh(scene: Any, name: str, mesh: Mesh, colour: tuple[int, int, int]) -> Any:
    return scene.add_mesh_simple(name, mesh.vertices, mesh.faces, color=colour)


def _add_tile(scene: Any, name: str, made: Tile, tint: NDArray[np.float64]) -> Any:
    """Add a tile in its paint, tinted as the model's ground is; return its handle."""
    # Textures count rows from below, pictures from above.
    paint = pil_image.fromarray(np.round(made.picture[::-1] * (_DIMMED * tint)).astype(np.uint8))
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=paint, metallicFactor=0.0, roughnessFactor=1.0)
    visual = trimesh.visual.TextureVisuals(uv=made.texture_xy, material=material)
    mesh = trimesh.Trimesh(made.mesh.vertices, made.mesh.faces, visual=visual, process=False)
    return scene.add_mesh_trimesh(name, mesh)
