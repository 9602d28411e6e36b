"""Link states and features against MuJoCo and against each other."""

import mujoco
import numpy as np
import pytest

from adapt_envs import env_id, make_vector
from adapt_envs.features import rotations
from adapt_envs.features.heading_frame import heading_frame_features, observations
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import LINKS, joint_group
from adapt_envs.motion.clip import velocities


@pytest.fixture(scope="module")
def model():
    return compile_model()


@pytest.fixture(scope="module")
def states(model):
    rng = np.random.default_rng(0)
    qpos = np.zeros((40, model.nq))
    qpos[:, :3] = rng.normal(size=(40, 3)) * 3
    qpos[:, 3:7] = rng.normal(size=(40, 4))
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    qpos[:, 7:] = rng.uniform(*model.jnt_range[1:].T, size=(40, model.nu))
    return qpos, rng.normal(size=(40, model.nv)) * 3


def test_link_states_equal_mj_forward(model, states):
    found = Kinematics(model).link_states(*states)
    data, velocity = mujoco.MjData(model), np.zeros(6)
    for row, (qpos, qvel) in enumerate(zip(*states, strict=True)):
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(model, data)
        for link, name in enumerate(LINKS):
            body = model.body(name).id
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, velocity, 0)
            expected = np.concatenate([data.xpos[body], data.xquat[body], velocity[3:], velocity[:3]])
            assert np.allclose(found[row, link], expected, atol=2e-5)


def test_batches_longer_than_a_chunk_equal_short_ones(model, states):
    qpos, qvel = (np.tile(part, (30, 1)) for part in states)
    kinematics = Kinematics(model)
    assert np.array_equal(kinematics.link_states(qpos, qvel)[-40:], kinematics.link_states(*states))


def test_velocities_equal_mujocos_difference(model, states):
    qpos = states[0]
    for a, b in zip(qpos[:-1], qpos[1:], strict=True):
        expected = np.zeros(model.nv)
        mujoco.mj_differentiatePos(model, expected, 1 / 15, a, b)
        assert np.allclose(velocities(a[None], b[None], 1 / 15)[0], expected, atol=1e-10)


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


def test_a_clip_and_a_simulation_set_to_it_look_alike():
    env = make_vector(env_id("Walk"), 16)
    env.reset(seed=0)
    worlds = env.worlds
    from_clip = worlds.history[:, -1].copy()
    simulated = np.empty_like(from_clip)
    worlds.physics.read_links(simulated)
    assert np.allclose(simulated, from_clip, atol=1e-5)
    windows = worlds.reference.sample_windows(2000, np.random.default_rng(0))
    assert np.abs(windows.mean((0, 1)) - worlds.windows.mean((0, 1))).max() < 0.5


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


def test_character_facts(model):
    assert model.nu == 28
    assert abs(model.body_subtreemass[1] - 48.9) < 0.05
    assert tuple(model.body(i).name for i in range(1, 16)) == LINKS
    assert np.allclose(model.qpos0[2], 0.8814, atol=1e-3)
    for joint in range(1, model.njnt):
        name = model.joint(joint).name
        servo = model.actuator(name)
        low, high = model.jnt_range[joint]
        kp, kd = -servo.biasprm[1], -servo.biasprm[2]
        assert np.isclose(kd, kp / 10)
        # torque(action) = kp (middle + action * width - q) - kd qdot
        assert np.isclose(servo.gainprm[0], kp * (high - low))
        assert np.isclose(servo.biasprm[0], kp * (low + high) / 2)
        mirror = name.replace("left", "@").replace("right", "left").replace("@", "right")
        twin = sorted(np.abs(model.joint(mirror).range))
        assert np.allclose(sorted(np.abs([low, high])), twin)
    with pytest.raises(ValueError, match="'tail_x' belongs to no group; the groups are abdomen"):
        joint_group("tail_x")
