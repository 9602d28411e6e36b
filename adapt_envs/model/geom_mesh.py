"""Geoms of the character as triangles, for what draws without MuJoCo."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray


def colour_of(model: mujoco.MjModel, geom: int) -> NDArray[np.float64]:
    """(3,) colour of a geom without its texture, red, green and blue in [0, 1]."""
    material = int(model.geom_matid[geom])
    return np.array((model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom])[:3], np.float64)


def geom_mesh(trimesh: Any, model: mujoco.MjModel, geom: int) -> Any:
    """Mesh of a geom in its own frame [m], a `Trimesh`; None for kinds that bodies of this character do not have.

    Args:
        trimesh: the package of that name, which is optional.
        model: what the geom belongs to.
        geom: its number.
    """
    size, kind = model.geom_size[geom], model.geom_type[geom]
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return trimesh.creation.icosphere(radius=size[0])
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        return trimesh.creation.capsule(radius=size[0], height=2 * size[1])
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return trimesh.creation.cylinder(radius=size[0], height=2 * size[1])
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return trimesh.creation.box(extents=2 * size)
    return None
