"""Ice: the contacts' friction, and what it does."""

import mujoco
import numpy as np
import pytest

from adapt_envs import env_id, make_vector


def contact_frictions(env, steps=20):
    """Friction of every contact with the floor over some steps."""
    worlds, found = env.worlds, []
    env.reset(seed=0)
    data, floor = mujoco.MjData(worlds.model), worlds.model.geom("floor").id
    for _ in range(steps):
        worlds.step(worlds.reference.mean_pose[None], None)
        worlds.physics.mujoco_data(0, data)
        found += [contact.friction[:2].copy() for contact in data.contact if floor in contact.geom]
    return np.array(found)


@pytest.mark.parametrize(
    ("name", "overrides", "asked"),
    [("IceWalk", {}, 0.15), ("IceRun", {}, 0.35), ("LongShinsWalk", {"friction": 0.2}, 0.2),
     ("TerrainHills", {"friction": 0.4}, 0.4), ("Walk", {}, 1.0)],
)  # fmt: skip
def test_contacts_have_the_friction_that_was_asked_for(name, overrides, asked):
    found = contact_frictions(make_vector(env_id(name), 1, **overrides))
    assert len(found)
    assert np.allclose(found, asked)


def test_a_sliding_character_loses_speed_as_coulomb_says():
    """A limp character that glides on its back loses mu g of speed per second."""
    slowed = []
    for friction in (0.15, 0.6):
        env = make_vector(env_id("Walk"), 1, friction=friction)
        env.reset(seed=0)
        model, data = env.worlds.model, mujoco.MjData(env.worlds.model)
        model.actuator_gainprm[:], model.actuator_biasprm[:] = 0, 0
        data.qpos[2:7] = 0.2, np.sqrt(0.5), 0, -np.sqrt(0.5), 0
        for _ in range(240):
            mujoco.mj_step(model, data)
        data.qvel[:] = 0
        data.qvel[1] = 3.0  # to its side, where its shape is the same at every moment
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        before = data.subtree_linvel[1, 1]
        for _ in range(24):
            mujoco.mj_step(model, data)
        mujoco.mj_subtreeVel(model, data)
        slowed.append((before - data.subtree_linvel[1, 1]) / 0.2)
    assert slowed[0] == pytest.approx(0.15 * 9.81, rel=0.25)
    assert slowed[1] > 2 * slowed[0]


@pytest.mark.parametrize("wrong", [0, -1.0, "ice", None])
def test_a_wrong_friction_is_named(wrong):
    with pytest.raises(ValueError, match="friction"):
        make_vector(env_id("Walk"), 1, friction=wrong)
