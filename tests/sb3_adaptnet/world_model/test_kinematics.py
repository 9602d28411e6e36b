"""The differentiable kinematics equal MuJoCo's, for every body and lock, and so do their slopes."""

import json

import mujoco
import numpy as np
import pytest
import torch
from world_cases import random_configurations

from adapt_envs.features import rotations
from adapt_envs.features.heading_frame import heading_frame_features
from adapt_envs.features.kinematics import Kinematics as MujocoKinematics
from adapt_envs.model.build import build_character, compile_model
from adapt_envs.model.humanoid import LINKS
from adapt_envs.model.morphology import MORPHOLOGIES
from adapt_envs.model.soles import sole_corners
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.kinematics import Kinematics
from sb3_adaptnet.world_model.links import from_observed, heading_view, to_observed
from sb3_adaptnet.world_model.state import State

LOCKS = [("abdomen",), ("elbow",), ("ankle",), ("right_knee",), ("right_hip_x", "left_hip_y", "neck")]
BODIES = [(None, ()), *((shape, ()) for shape in MORPHOLOGIES), *((None, lock) for lock in LOCKS)]


def body(shape, locked):
    return compile_model(build_character(MORPHOLOGIES.get(shape), locked))


@pytest.mark.parametrize(("shape", "locked"), BODIES)
def test_links_equal_mujocos(shape, locked):
    model = body(shape, locked)
    qpos, qvel = random_configurations(model, 50)
    expected = MujocoKinematics(model).link_states(qpos, qvel)
    state = State.from_mujoco(torch.tensor(qpos), torch.tensor(qvel))
    found = to_observed(Kinematics(Character.of(model)).double()(state)).reshape(expected.shape)
    assert np.abs(found.numpy() - expected).max() < 1e-5
    single = to_observed(Kinematics(Character.of(model))(state.map(torch.Tensor.float))).reshape(expected.shape)
    assert np.abs(single.numpy() - expected).max() < 3e-5


@pytest.mark.parametrize("locked", [(), ("right_knee", "ankle")])
def test_slopes_equal_finite_differences(locked):
    model = body(None, locked)
    state = State.from_mujoco(*(torch.tensor(part) for part in random_configurations(model, 1)))
    kinematics = Kinematics(Character.of(model)).double()
    parts = tuple(part.clone().requires_grad_() for part in state)
    assert torch.autograd.gradcheck(lambda *parts: heading_view(kinematics(State(*parts)), len(LINKS)).links, parts)


def test_the_heading_view_equals_the_observations():
    model = body(None, ())
    links = MujocoKinematics(model).link_states(*random_configurations(model, 40)).reshape(10, 4, 15, 13)
    frames = from_observed(torch.as_tensor(links.reshape(10, 60, 13)))
    found = heading_view(frames, len(LINKS))
    assert np.allclose(to_observed(found.links), heading_frame_features(links).reshape(10, -1), atol=1e-5)
    heading = rotations.heading(links[:, -1, 0, 3:7])
    assert np.allclose(np.stack([found.cos, found.sin]), [np.cos(heading), np.sin(heading)], atol=1e-6)
    assert torch.equal(from_observed(to_observed(frames).reshape(10, 60, 13)), frames)


def test_a_character_is_plain_data():
    model = body("long_shins", ("elbow",))
    character = Character.of(model)
    assert character.links == LINKS
    assert character.joints == tuple(model.actuator(i).name for i in range(model.nu))
    assert Character.from_dict(json.loads(json.dumps(character.to_dict()))) == character
    assert Character.of(body(None, ("elbow",))) != character
    corners = np.array([point for _, point in character.corners]).reshape(2, 4, 3)
    assert np.allclose(corners, sole_corners(model))
    assert [link for link, _ in character.corners[::4]] == [LINKS.index("right_foot"), LINKS.index("left_foot")]


ROOT = (
    '<mujoco><worldbody><body name="a"><freejoint/><geom size=".1"/>{}</body></worldbody>'
    "<actuator>{}</actuator></mujoco>"
)
SERVO = '<position joint="j" kp="1"/>'
PART = '<body name="b" {}><joint name="j" {}/><geom size=".1"/></body>'


@pytest.mark.parametrize(
    ("xml", "words"),
    [
        (ROOT.format(PART.format("", 'axis="1 1 0"'), SERVO), "'j' turns about"),
        (ROOT.format(PART.format("", 'type="slide"'), SERVO), "'j' is no hinge"),
        (ROOT.format(PART.format("", 'pos="0 0 1"'), SERVO), "'j' must turn about its link's origin"),
        (ROOT.format(PART.format('euler="0 0 9"', ""), SERVO), "'b' is turned"),
        (ROOT.format(PART.format("", ""), ""), "one servo"),
        (ROOT.replace("<freejoint/>", "").format("", ""), "free root"),
    ],
)
def test_other_models_are_refused(xml, words):
    with pytest.raises(ValueError, match=words):
        Character.of(mujoco.MjModel.from_xml_string(xml))
