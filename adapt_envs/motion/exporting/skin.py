"""The character's geoms as one skin: triangles that each follow one bone."""

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.model.geom_mesh import colour_of, geom_mesh
from adapt_envs.model.humanoid import LINKS
from adapt_envs.motion.exporting.performance import Performance, y_up


@dataclass(frozen=True)
class Patch:
    """Triangles of one colour, at rest; y up, z ahead.

    Attributes:
        colour: (3,) red, green and blue in [0, 1], as screens show it.
        points: (V, 3) corners [m], world.
        normals: (V, 3) unit vectors, world.
        faces: (F, 3) numbers of corners, counter-clockwise from outside.
        bones: (V,) number of the bone that each corner follows.
    """

    colour: tuple[float, ...]
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    faces: NDArray[np.uint32]
    bones: NDArray[np.uint8]


def patches(trimesh: Any, model: mujoco.MjModel, performed: Performance) -> list[Patch]:
    """The geoms of all links, one patch for each colour.

    Args:
        trimesh: the package of that name.
        model: the character.
        performed: its skeleton.
    """
    by_colour: dict[tuple[float, ...], list[Patch]] = {}
    for bone, link in enumerate(LINKS):
        body = model.body(link)
        for geom in range(int(body.geomadr[0]), int(body.geomadr[0] + body.geomnum[0])):
            patch = _patch(trimesh, model, geom, bone, performed.rest[bone])
            if patch is not None:
                by_colour.setdefault(patch.colour, []).append(patch)
    return [_joined(same) for same in by_colour.values()]


def _patch(trimesh: Any, model: mujoco.MjModel, geom: int, bone: int, place: NDArray[np.float64]) -> Patch | None:
    mesh = geom_mesh(trimesh, model, geom)
    if mesh is None:
        return None
    points, normals, faces = mesh.vertices, mesh.vertex_normals, mesh.faces
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_BOX:  # edges stay sharp: no corner is shared
        points, faces = points[faces.ravel()], np.arange(faces.size).reshape(-1, 3)
        normals = np.repeat(mesh.face_normals, 3, axis=0)
    turn = model.geom_quat[geom][None]
    points = rotations.rotate(turn, np.asarray(points)) + model.geom_pos[geom]
    return Patch(
        colour=tuple(float(value) for value in colour_of(model, geom)),
        points=(y_up(points) + place).astype(np.float32),
        normals=y_up(rotations.rotate(turn, np.asarray(normals))).astype(np.float32),
        faces=np.asarray(faces, np.uint32),
        bones=np.full(len(points), bone, np.uint8),
    )


def _joined(parts: list[Patch]) -> Patch:
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    return Patch(
        parts[0].colour,
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.faces + np.uint32(start) for part, start in zip(parts, starts, strict=False)]),
        np.concatenate([part.bones for part in parts]),
    )
