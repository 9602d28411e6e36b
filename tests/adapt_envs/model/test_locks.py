"""Locked joints: removed, welded, visible."""

import numpy as np
import pytest

from adapt_envs import SUITE, env_id, make_vector
from adapt_envs.features.rotations import conjugate, multiply
from adapt_envs.model.build import build_character, compile_model
from adapt_envs.model.humanoid import LINKS, load_spec
from adapt_envs.model.locks import joints_named, lock
from adapt_envs.motion.library import reference_motion

COUNTS = {"LockedAbdomen": 3, "LockedElbows": 2, "LockedAnkles": 6, "LockedRightKnee": 1}
JOINED = {
    "LockedAbdomen": [("pelvis", "torso")],
    "LockedElbows": [("right_upper_arm", "right_lower_arm"), ("left_upper_arm", "left_lower_arm")],
    "LockedAnkles": [("right_shin", "right_foot"), ("left_shin", "left_foot")],
    "LockedRightKnee": [("right_thigh", "right_shin")],
}
ALL_JOINTS = make_vector(env_id("Walk"), 1).single_action_space.joint_names


@pytest.mark.parametrize("name", COUNTS)
def test_the_action_space_loses_the_joints_and_the_observation_keeps_its_links(name):
    env = make_vector(env_id(name + "Walk"), 2)
    space = env.single_action_space
    assert space.shape == (28 - COUNTS[name],)
    gone = [joint for joint in ALL_JOINTS if joint not in space.joint_names]
    assert len(gone) == COUNTS[name]
    assert [joint for joint in ALL_JOINTS if joint not in gone] == list(space.joint_names)
    assert env.single_observation_space.shape == (784,)
    assert env.worlds.history.shape[2] == len(LINKS)


@pytest.mark.parametrize("name", COUNTS)
def test_locked_links_move_as_one(name):
    env = make_vector(env_id(name + "Walk"), 4)
    env.reset(seed=0)
    rng, relative = np.random.default_rng(0), {pair: [] for pair in JOINED[name]}
    for _ in range(12):
        env.step(rng.uniform(-1, 1, env.action_space.shape).astype(np.float32))
        links = env.worlds.history[:, -1]
        for pair in relative:
            first, second = (links[:, LINKS.index(link), 3:7].astype(float) for link in pair)
            relative[pair].append(multiply(conjugate(first), second))
    for turns in relative.values():
        # As in the rest pose, where all links are parallel.
        assert np.allclose(np.abs(np.concatenate(turns)[:, 0]), 1, atol=1e-6)


@pytest.mark.parametrize("name", COUNTS)
def test_the_other_joints_keep_their_mean_pose(name):
    plain, locked = (reference_motion("walk", None, names) for names in ((), SUITE[name].locked))
    poses = dict(zip(plain.joint_names, plain.mean_pose, strict=True))
    assert np.allclose(locked.mean_pose, [poses[joint] for joint in locked.joint_names])


def test_nothing_but_the_joints_changes_for_the_physics():
    plain, locked = compile_model(), compile_model(build_character(locked=("right_knee", "abdomen")))
    assert np.allclose(plain.body_mass, locked.body_mass)
    assert np.allclose(plain.body_inertia, locked.body_inertia)
    balls = [i for i in range(locked.ngeom) if locked.geom(i).name.endswith("_lock")]
    assert [locked.geom(i).name for i in balls] == ["torso_lock", "right_shin_lock"]
    assert not locked.geom_contype[balls].any()
    assert not locked.geom_conaffinity[balls].any()


def test_one_joint_may_be_given_without_a_tuple():
    assert make_vector(env_id("Walk"), 1, locked="right_knee").single_action_space.shape == (27,)


def test_names_mean_a_joint_a_place_or_a_pair():
    spec = load_spec()
    assert [joint.name for joint in joints_named(spec, "right_hip_x")] == ["right_hip_x"]
    assert [joint.name for joint in joints_named(spec, "elbow")] == ["right_elbow", "left_elbow"]
    assert len(joints_named(spec, "left")) == 11
    for wrong in ("kneee", "kne", ""):
        with pytest.raises(ValueError, match=rf"'{wrong}'.*right_knee"):
            lock(spec, [wrong])
