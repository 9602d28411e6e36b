"""Features against rotation algebra, and the layout of the observation."""

import numpy as np

from adapt_envs.features import rotations
from adapt_envs.features.heading_frame import heading_frame_features, observations
from adapt_envs.features.kinematics import Kinematics


def test_features_do_not_change_with_place_and_heading(model, states):
    history = Kinematics(model).link_states(*states).reshape(8, 5, 15, 13)
    yaw, shift = 1.234, np.array([3.0, -2.0, 0.0])
    turn = rotations.from_yaw(np.asarray(yaw))
    moved = history.astype(np.float64)
    moved[..., :3] = rotations.rotate(turn, moved[..., :3]) + shift
    moved[..., 3:7] = rotations.multiply(turn, moved[..., 3:7])
    for part in (slice(7, 10), slice(10, 13)):
        moved[..., part] = rotations.rotate(turn, moved[..., part])
    assert np.allclose(heading_frame_features(moved.astype(np.float32)), heading_frame_features(history), atol=2e-4)


def test_features_by_rotation_algebra(model, states):
    """The fast column code equals the plain definition: turn everything by minus the heading."""
    history = Kinematics(model).link_states(*states).reshape(8, 5, 15, 13)
    root = history[:, -1, 0]
    back = rotations.from_yaw(-rotations.heading(root[:, 3:7]))[:, None, None]
    origin = root[:, :3] * (1, 1, 0) + (0, 0, 0.25)
    expected = np.concatenate(
        [
            rotations.rotate(back, history[..., :3] - origin[:, None, None]),
            rotations.positive(rotations.multiply(back, history[..., 3:7])),
            rotations.rotate(back, history[..., 7:10]),
            rotations.rotate(back, history[..., 10:13]),
        ],
        axis=-1,
    )
    found = heading_frame_features(history, np.full(8, 0.25, np.float32))
    upright = np.abs(expected[..., 3]) > 1e-3  # at w = 0 both signs are right
    assert np.allclose(found[upright], expected[upright], atol=1e-4)


def test_observation_layout():
    features = np.arange(2 * 5 * 15 * 13, dtype=np.float32).reshape(2, 5, 15, 13)
    goal = np.array([[1, 0, 2, 1.2], [0, 1, 3, 1.4]], np.float32)
    seen = observations(features, goal)
    assert seen.shape == (2, 784)
    for frame, link, component in ((0, 0, 0), (3, 14, 12), (2, 7, 5)):
        assert seen[1, (frame * 15 + link) * 13 + component] == features[1, frame + 1, link, component]
    assert np.array_equal(seen[:, 780:], goal)
