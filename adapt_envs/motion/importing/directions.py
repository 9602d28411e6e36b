"""Orientations from directions: frames spanned by two vectors, shortest turns between vectors."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from adapt_envs.features import rotations

Array = NDArray[np.floating]


def swung(vectors: Array, start: Array, end: Array) -> Array:
    """Vectors (T, 3), turned as the shortest turn takes the unit vectors `start` to `end` (T, 3)."""
    axis = np.cross(start, end)
    cosine = np.sum(start * end, axis=1, keepdims=True)
    first = np.cross(axis, vectors)
    return vectors + first + np.cross(axis, first) / np.maximum(1 + cosine, 1e-6)


def local(parent: Array, child: Array) -> Array:
    """Orientations (T, 4) of children in their parents' frames, from both in the world (T, 4)."""
    return rotations.multiply(rotations.conjugate(parent), child)


def unit(vectors: Array) -> Array:
    """Vectors (..., 3) scaled to unit length; zero stays zero."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)


def frame(up: Array, left: Array, exact: Literal["up", "left"]) -> Array:
    """Quaternions (T, 4) of frames with z along `up` and y along `left` (T, 3); the `exact` one is kept as it is."""
    forward = unit(np.cross(left, up))
    z, y = unit(up), unit(left)
    if exact == "up":
        y = np.cross(z, forward)
    else:
        z = np.cross(forward, y)
    return from_matrices(np.stack([forward, y, z], axis=-1))


def from_matrices(matrices: Array) -> Array:
    """Quaternions (T, 4), wxyz, of rotation matrices (T, 3, 3)."""
    return np.roll(Rotation.from_matrix(matrices).as_quat(), 1, axis=-1)
