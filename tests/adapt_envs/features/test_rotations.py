"""Quaternions against MuJoCo's and against each other."""

import mujoco
import numpy as np

from adapt_envs.features import rotations


def test_rotations_round_trip():
    rng = np.random.default_rng(1)
    angles = rng.uniform(-1.5, 1.5, (100, 3))
    quats = rotations.from_intrinsic_xyz(angles)
    assert np.allclose(rotations.to_intrinsic_xyz(quats), angles)
    vectors = rng.normal(size=(100, 3))
    matrix, turned = np.zeros(9), rotations.rotate(quats, vectors)
    for quat, vector, expected in zip(quats, turned, vectors, strict=True):
        mujoco.mju_quat2Mat(matrix, quat)
        assert np.allclose(matrix.reshape(3, 3) @ expected, vector)
    assert np.allclose(rotations.multiply(quats, rotations.conjugate(quats)), [1, 0, 0, 0], atol=1e-12)


def test_points_of_placed_frames():
    """A quarter turn about z takes x to y; many frames with points of their own are placed at once."""
    quarter = rotations.from_yaw(np.array(np.pi / 2))
    found = rotations.placed(np.array([1.0, 2.0, 3.0]), quarter, np.array([[1.0, 0, 0], [0, 0, 1]]))
    assert np.allclose(found, [[1, 3, 3], [1, 2, 4]])
    rng = np.random.default_rng(2)
    pos, angles, points = rng.normal(size=(7, 2, 3)), rng.uniform(-1, 1, (7, 2, 3)), rng.normal(size=(2, 5, 3))
    quat = rotations.from_intrinsic_xyz(angles)
    found = rotations.placed(pos, quat, points)
    assert found.shape == (7, 2, 5, 3)
    assert np.allclose(rotations.rotate(rotations.conjugate(quat[3, 1]), found[3, 1] - pos[3, 1]), points[1])
