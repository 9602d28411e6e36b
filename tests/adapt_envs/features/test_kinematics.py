"""Link states against MuJoCo, and simulations against clips."""

import mujoco
import numpy as np

from adapt_envs import env_id, make_vector
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.humanoid import LINKS


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
