"""Scenes and grounds as files: another MuJoCo gets the environments' own models back, to the last bit."""

import json

import mujoco
import numpy as np
import pytest

from adapt_envs.features.heading_frame import heading_frame_features
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model import MORPHOLOGIES
from adapt_envs.portable import BODIES, GROUNDS, LOCKS, portable_scene, site_ground
from adapt_envs.portable.grounds import SIDE
from adapt_envs.simulation import Worlds


def rebuilt(scene):
    """The model that a scene's text and exact numbers give, after a passage through JSON."""
    scene = json.loads(json.dumps(scene))
    model = mujoco.MjModel.from_xml_string(scene["mjcf"])
    model.opt.timestep = scene["exact"].pop("timestep")
    for name, values in scene["exact"].items():
        field = getattr(model, name)
        field[:] = np.reshape(values, field.shape)
    return model


def test_the_choices_are_those_of_the_suite():
    assert set(BODIES) == {"plain", *MORPHOLOGIES}
    assert list(LOCKS) == ["plain", "abdomen", "elbow", "ankle", "right_knee"]
    assert list(GROUNDS) == ["flat", "ice", "hills", "blocks"]
    assert all(choice.words for choice in (BODIES | LOCKS | GROUNDS).values())


def test_a_scene_steps_as_its_environment_does():
    names = "long_shins", "right_knee", "ice"
    body, lock, ground = names
    row = GROUNDS[ground].row
    scene = portable_scene(*names)
    model = rebuilt(scene)
    shape, locked = BODIES[body].row.morphology, LOCKS[lock].row.locked
    worlds = Worlds(type(row)("walk", friction=row.friction, morphology=shape, locked=locked), 1, 1)
    start, data = scene["starts"]["walk"], mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = start["qpos"], start["qvel"]
    worlds.reset(np.array([0]))
    worlds.physics.set_states(np.array([0]), data.qpos[None], data.qvel[None])
    assert scene["joints"] == list(worlds.reference.joint_names)
    for step in range(20):
        data.ctrl[:] = 0.1 * np.sin(step + np.arange(model.nu))
        worlds.physics.step(data.ctrl[None])
        mujoco.mj_step(model, data, nstep=4)
    np.testing.assert_array_equal(data.qpos, worlds.physics.qpos[0])


def test_hills_are_the_suites_where_they_are():
    whole, part = Worlds(GROUNDS["hills"].row, 1, 1), site_ground("hills")
    rng = np.random.default_rng(0)
    xy = rng.uniform(-SIDE / 2 + 1, SIDE / 2 - 1, (500, 2))
    np.testing.assert_allclose(part.ground.height_at(xy), whole.ground.height_at(xy), rtol=0, atol=5e-6)
    model = rebuilt(portable_scene("plain", "plain", "hills"))
    np.testing.assert_array_equal(model.hfield_size[0, 2:], whole.model.hfield_size[0, 2:])
    values = part.to_json()
    assert values["surface"]["rows"] == values["surface"]["columns"] == round(SIDE / 0.1) + 1 and values["reach"] == 32


@pytest.mark.parametrize("ground", ["hills", "blocks"])
def test_starts_stand_on_bounded_ground(ground):
    scene, place = portable_scene("plain", "plain", ground), site_ground(ground)
    start = scene["starts"]["run"]
    assert place.ground.clear(np.array(start["qpos"][:2]), 0.5)
    links = np.reshape(start["history"], (4, 15, 13))
    np.testing.assert_allclose(links[-1, 0, :3], start["qpos"][:3], atol=1e-5)
    feet = links[-1, (11, 14), :3]
    above = feet[:, 2] - place.ground.floor_at(feet[:, :2])
    assert 0.02 < above.min() < 0.12, "an ankle is 5 cm above its sole"


def test_the_history_ends_in_the_start_state():
    scene = portable_scene("long_thighs", "elbow", "flat")
    start = scene["starts"]["walk"]
    links = np.reshape(start["history"], (1, 4, 15, 13)).astype(np.float32)
    now = Kinematics(rebuilt(scene)).link_states(np.array([start["qpos"]]), np.array([start["qvel"]]))
    np.testing.assert_allclose(links[:, -1], now, atol=1e-5)
    assert np.abs(heading_frame_features(links)[0, :, 0, :2]).max() < 0.2, "three frames of a walk are 15 cm"


def test_unknown_names_are_refused():
    with pytest.raises(ValueError, match="no body is named 'giant'; the names are plain"):
        portable_scene("giant", "plain", "flat")
    with pytest.raises(ValueError, match="no lock is named 'neck'"):
        portable_scene("plain", "neck", "flat")
    with pytest.raises(ValueError, match="no ground is named 'moon'"):
        portable_scene("plain", "plain", "moon")
