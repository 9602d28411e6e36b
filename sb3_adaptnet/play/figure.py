"""The character in the browser: a frame for each body, with the meshes of its geoms."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.geom_mesh import colour_of, geom_mesh
from sb3_adaptnet.play.extra import trimesh


class Figure:
    """The bodies of a character in a viser scene."""

    def __init__(self, scene: Any, model: mujoco.MjModel) -> None:
        """Add them to `scene`, a viser `SceneApi`."""
        self._bodies = [_add_body(scene, model, body) for body in range(1, model.nbody)]

    def place(self, data: mujoco.MjData, middle: NDArray[np.float64]) -> None:
        """Move them to where they are in `data`, as seen from the point `middle` (3,) [m, world frame]."""
        for handle, position, quat in zip(self._bodies, data.xpos[1:], data.xquat[1:], strict=True):
            handle.position, handle.wxyz = position - middle, quat


def rgb(colour: NDArray[np.float64]) -> tuple[int, int, int]:
    """A colour (3,) in [0, 1] as viser takes it: numbers up to 255."""
    red, green, blue = (round(255 * float(value)) for value in colour)
    return red, green, blue


def _add_body(scene: Any, model: mujoco.MjModel, body: int) -> Any:
    """Add a frame with the meshes of one body's geoms; return its handle."""
    frame = scene.add_frame(f"/body_{body}", show_axes=False)
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    for geom in range(first, first + count):
        shape = geom_mesh(trimesh, model, geom)
        if shape is not None:
            name, colour = f"/body_{body}/geom_{geom}", rgb(colour_of(model, geom))
            handle = scene.add_mesh_simple(name, np.asarray(shape.vertices), np.asarray(shape.faces), color=colour)
            handle.position, handle.wxyz = model.geom_pos[geom], model.geom_quat[geom]
    return frame
