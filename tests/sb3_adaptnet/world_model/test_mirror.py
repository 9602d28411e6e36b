"""In a mirror a character does what it would do: its two sides, and physics, are alike."""

import mujoco
import numpy as np
import pytest
import torch
from world_cases import CHARACTER, MODEL, random_configurations

from adapt_envs import make_vector
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.kinematics import Kinematics
from sb3_adaptnet.world_model.links import to_observed
from sb3_adaptnet.world_model.mirror import Mirror
from sb3_adaptnet.world_model.state import State

MIRROR = Mirror.of(CHARACTER)


def test_a_mirror_image_of_a_mirror_image_is_the_thing_itself():
    qpos, qvel = random_configurations(MODEL, 5)
    assert np.allclose(MIRROR.of_qpos(MIRROR.of_qpos(qpos)), qpos)
    assert np.allclose(MIRROR.of_qvel(MIRROR.of_qvel(qvel)), qvel)
    assert not np.allclose(MIRROR.of_qpos(qpos), qpos)


def test_links_are_where_the_mirrored_joints_put_them():
    qpos, qvel = random_configurations(MODEL, 5)
    here, there = links(qpos, qvel), links(MIRROR.of_qpos(qpos), MIRROR.of_qvel(qvel))
    mirrored = MIRROR.of_links(here)
    turns = np.sign((mirrored[..., 3:7] * there[..., 3:7]).sum(-1, keepdims=True))  # q and -q turn alike
    mirrored[..., 3:7] *= turns
    assert np.allclose(mirrored, there, atol=1e-9)


def links(qpos, qvel):
    state = State.from_mujoco(torch.tensor(qpos), torch.tensor(qvel))
    numbers = to_observed(Kinematics(CHARACTER).double()(state)).numpy()
    return numbers.reshape(len(qpos), len(CHARACTER.links), -1)


def test_physics_goes_on_in_the_mirror():
    rng, data = np.random.default_rng(0), mujoco.MjData(MODEL)
    qpos, qvel = MODEL.qpos0.copy(), rng.normal(size=MODEL.nv)
    qpos[7:] = rng.uniform(-0.1, 0.1, MODEL.nu)
    action = rng.uniform(-0.3, 0.3, MODEL.nu)

    def after(qpos, qvel, action):
        mujoco.mj_resetData(MODEL, data)
        data.qpos[:], data.qvel[:] = qpos, qvel
        data.ctrl[:] = np.array(CHARACTER.middles) + action * np.array(CHARACTER.widths)
        mujoco.mj_step(MODEL, data, 120)
        return data.qpos.copy(), data.qvel.copy(), data.ncon

    here = after(qpos, qvel, action)
    there = after(MIRROR.of_qpos(qpos), MIRROR.of_qvel(qvel), MIRROR.of_joints(action))
    assert here[2] > 0  # it stands or lies on the ground
    assert np.allclose(MIRROR.of_qpos(here[0]), there[0], atol=1e-6)
    assert np.allclose(MIRROR.of_qvel(here[1]), there[1], atol=1e-4)


@pytest.mark.parametrize("body", ["LockedRightKnee", "AsymmetricUpperArms"])
def test_who_has_two_different_sides_has_no_mirror(body):
    env = make_vector(f"AdaptNet/Humanoid-{body}-v0", 1, num_threads=1)
    assert Mirror.of(Character.of(env.worlds.physics.model)) is None


def test_a_larger_body_has_one():
    env = make_vector("AdaptNet/Humanoid-LongShins-v0", 1, num_threads=1)
    assert Mirror.of(Character.of(env.worlds.physics.model)) is not None
