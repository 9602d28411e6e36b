"""Analytic inverse kinematics of a leg: three-hinge hip, knee, three-hinge ankle."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
THIGH, SHIN = 0.421546, 0.40987
"""Lengths of thigh and shin [m]; the table of the character."""
HIP = 0.084887
"""Lateral offset of the hip from the pelvis origin [m]."""
REACH = 0.9985 * (THIGH + SHIN)
"""Longest distance from hip to ankle that is used [m]: the knee keeps 6 degrees."""


def rot_x(angle: Array) -> Array:
    """Matrices (..., 3, 3) of turns by angles (...) [rad] about x."""
    return _turn(angle, 1, 2)


def rot_y(angle: Array) -> Array:
    """Matrices (..., 3, 3) of turns by angles (...) [rad] about y."""
    return _turn(angle, 2, 0)


def rot_z(angle: Array) -> Array:
    """Matrices (..., 3, 3) of turns by angles (...) [rad] about z."""
    return _turn(angle, 0, 1)


def _turn(angle: Array, i: int, j: int) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.zeros((*np.shape(angle), 3, 3)) + np.eye(3)
    matrix[..., i, i], matrix[..., j, j], matrix[..., i, j], matrix[..., j, i] = c, c, -s, s
    return matrix


def euler_xyz(matrix: Array) -> Array:
    """Angles (..., 3) [rad] with matrix = Rx Ry Rz: the character's joint order; y in [-pi/2, pi/2]."""
    return np.stack(
        [
            np.arctan2(-matrix[..., 1, 2], matrix[..., 2, 2]),
            np.arcsin(np.clip(matrix[..., 0, 2], -1, 1)),
            np.arctan2(-matrix[..., 0, 1], matrix[..., 0, 0]),
        ],
        axis=-1,
    )


def leg_angles(pelvis: Array, hip: Array, ankle: Array, foot: Array, knee_yaw: Array) -> Array:
    """Joint angles (T, 7) that put the foot where it should be.

    Args:
        pelvis: (T, 3, 3) orientation of the pelvis.
        hip: (T, 3) position of the hip, world [m].
        ankle: (T, 3) position of the ankle, world [m].
        foot: (T, 3, 3) orientation of the foot.
        knee_yaw: (T,) direction on the ground to which the knee points [rad].

    Returns:
        hip x, y, z, knee, ankle x, y, z [rad]. A target out of reach is approached along the line from hip to ankle.
    """
    span = ankle - hip
    distance = np.linalg.norm(span, axis=1)
    down = span / distance[:, None]
    reach = np.clip(soften(distance), 0.3, REACH)
    knee = np.arccos(np.clip((reach**2 - THIGH**2 - SHIN**2) / (2 * THIGH * SHIN), -1, 1))
    lead = np.arctan2(SHIN * np.sin(knee), THIGH + SHIN * np.cos(knee))
    left = np.stack([-np.sin(knee_yaw), np.cos(knee_yaw), np.zeros_like(knee_yaw)], axis=1)
    left -= (left * down).sum(axis=1, keepdims=True) * down
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    plane = np.stack([np.cross(left, -down), left, -down], axis=-1)
    thigh = plane @ rot_y(-lead)
    shin = thigh @ rot_y(knee)
    hip_angles = euler_xyz(np.swapaxes(pelvis, -1, -2) @ thigh)
    ankle_angles = euler_xyz(np.swapaxes(shin, -1, -2) @ foot)
    return np.concatenate([hip_angles, knee[:, None], ankle_angles], axis=1)


def soften(distance: Array, margin: float = 0.004) -> Array:
    """Distances that bend smoothly to `REACH` instead of passing it."""
    excess = (distance - REACH) / margin
    return REACH - margin * np.logaddexp(0.0, -excess)
