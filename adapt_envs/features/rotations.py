"""Unit quaternions (w, x, y, z) and heading frames, vectorised over leading axes.

A *heading frame* has its origin on the ground below the root, z up, and x along the root's forward axis projected on
the ground. Every function keeps the dtype of its input.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]


def multiply(a: Array, b: Array) -> Array:
    """Hamilton product a * b of quaternions, (..., 4) each (broadcast)."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def conjugate(q: Array) -> Array:
    """Inverse of unit quaternions (..., 4)."""
    return q * np.array([1, -1, -1, -1], dtype=q.dtype)


def rotate(q: Array, v: Array) -> Array:
    """Vectors (..., 3) turned by unit quaternions (..., 4) (broadcast)."""
    xyz = q[..., 1:]
    t = 2 * np.cross(xyz, v)
    return v + q[..., :1] * t + np.cross(xyz, t)


def placed(pos: Array, quat: Array, points: Array) -> Array:
    """Points (..., P, 3) of frames that lie at `pos` (..., 3), turned by `quat` (..., 4), in the world (broadcast)."""
    return pos[..., None, :] + rotate(quat[..., None, :], points)


def from_axis_angle(axis: Array, angle: Array) -> Array:
    """Quaternions (..., 4) of turns by `angle` (...) in radians about the unit vectors `axis` (..., 3)."""
    half = np.asarray(angle)[..., None] / 2
    return np.concatenate([np.cos(half) * np.ones_like(axis[..., :1]), np.sin(half) * axis], axis=-1)


def from_yaw(yaw: Array) -> Array:
    """Quaternions (..., 4) of turns by `yaw` (...) in radians about z."""
    half = np.asarray(yaw) / 2
    zero = np.zeros_like(half)
    return np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1)


def heading(q: Array) -> Array:
    """Heading angle (...) in radians of root orientations (..., 4): the direction of their x axis on the ground."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def wrapped(angle: Array) -> Array:
    """Angles (...) in radians brought into [-pi, pi)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def from_intrinsic_xyz(angles: Array) -> Array:
    """Quaternions (..., 4) of Rx Ry Rz from angles (..., 3) in radians: the order of the character's joints."""
    x, y, z = np.eye(3)
    qx, qy, qz = (from_axis_angle(np.broadcast_to(a, angles.shape), angles[..., i]) for i, a in enumerate((x, y, z)))
    return multiply(multiply(qx, qy), qz)


def to_intrinsic_xyz(q: Array) -> Array:
    """Angles (..., 3) in radians with q = Rx Ry Rz; y in [-pi/2, pi/2]."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    sin_y = np.clip(2 * (x * z + w * y), -1, 1)
    return np.stack(
        [
            np.arctan2(2 * (w * x - y * z), 1 - 2 * (x * x + y * y)),
            np.arcsin(sin_y),
            np.arctan2(2 * (w * z - x * y), 1 - 2 * (y * y + z * z)),
        ],
        axis=-1,
    )


def positive(q: Array) -> Array:
    """The same rotations with w >= 0: of the two quaternions of a rotation, the one a network should see."""
    return np.where(q[..., :1] < 0, -q, q)
