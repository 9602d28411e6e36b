"""The reference itself costs nothing; turning with it costs nothing either; slopes point home."""

import numpy as np
import pytest
import torch

from adapt_envs import make_vector
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.tasks.goal import goal_reward
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.algorithms.tracking.tracking_loss import TrackingWeights, tracking_loss, turned
from sb3_adaptnet.algorithms.tracking.travel_loss import TravelWeights, goal_loss, travel_errors, travel_loss
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.links import heading_view
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.rotations import about_z
from sb3_adaptnet.world_model.state import State


@pytest.fixture(scope="module", params=[("GooseStep", {}), ("Walk", {"locked": ("right_knee",)})])
def case(request):
    name, overrides = request.param
    env = make_vector(f"AdaptNet/Humanoid-{name}-v0", 1, **overrides)
    character, reference = Character.of(env.model), env.reference_states
    motion = TrackedMotion.of(character, torch.device("cpu"), [reference])
    state = State.from_mujoco(torch.tensor(reference.qpos).float(), torch.tensor(reference.qvel).float())
    return motion, state, WorldModel(character, Sizes(8, 1)), env.worlds.spec


def test_the_reference_costs_nothing(case):
    motion, state, model, _ = case
    view, phases, rest = model.view(model.kinematics(state)), torch.arange(len(motion)), torch.zeros(len(motion))
    tracked = tracking_loss(state, view.links, motion, phases, rest, TrackingWeights())
    assert tracked.max() < 1e-4
    headings = torch.atan2(view.sin, view.cos) - motion.facing
    speeds = motion.speeds
    errors = travel_errors(state.velocity, view, motion, phases, headings, speeds)
    assert travel_loss(errors, TravelWeights()).max() < 1e-4
    turned_left = travel_errors(state.velocity, view, motion, phases, headings - 0.3, speeds)
    assert torch.allclose(turned_left.turned_left, torch.sin(torch.tensor(0.3)), atol=1e-4)
    assert torch.allclose(turned_left.alike, torch.cos(torch.tensor(0.3)), atol=1e-4)
    assert (tracking_loss(state, view.links, motion, (phases + 9) % len(motion), rest, TrackingWeights()) > 0).all()


def test_aims_and_poses_agree(case):
    motion, state, model, spec = case
    assert motion.aims.shape == (len(motion), len(model.character.joints))
    assert torch.allclose(motion.angles, state.angles)
    assert torch.allclose(motion.link_weights.mean(), torch.ones(()))
    assert motion.gaits.cyclic.tolist() == [spec.motion == "GooseStep"]
    last = np.array([len(motion) - 1])
    assert motion.gaits.shifted(last, 1) == (0 if motion.gaits.cyclic[0] else last)


def test_a_turning_reference_moves_as_a_turning_body(case):
    motion, state, model, _ = case
    links, rate, step = model.view(model.kinematics(state)).links.double(), 0.7, 1e-5
    found = turned(links, torch.full((len(motion),), rate).double())
    angle = torch.tensor(rate * step).double()
    vector = lambda channels: links[channels]  # noqa: E731
    moved = about_z(torch.cos(angle), torch.sin(angle), vector(slice(0, 9, 3)))
    gained = (moved - vector(slice(0, 9, 3))) / step
    assert torch.allclose(found[1:9:3] - links[1:9:3], gained, atol=1e-4)
    assert torch.allclose(found[8] - links[8], torch.tensor(rate).double())


def test_a_looking_around_reference_is_seen_from_its_own_heading(case):
    motion, state, model, _ = case
    frames = model.kinematics(state)
    assert torch.allclose(heading_view(frames, 15).links, motion.links, atol=1e-4)


def test_the_goal_costs_what_the_reward_falls_short_of_1():
    rng = np.random.default_rng(5)
    before, target, speed = rng.normal(size=(50, 2)), rng.normal(size=(50, 2)), rng.uniform(0.5, 2.0, 50)
    ahead = (target - before) / np.linalg.norm(target - before, axis=1, keepdims=True)
    velocity = speed[:, None] * ahead + 0.5 * rng.normal(size=(50, 2))
    after = before + CONTROL_DT * velocity
    expected = 1 - goal_reward(before, after, target, speed)
    assert (expected == 0).any() and (expected > 0.2).any()  # within the goal's radius, and outside

    def loss(position):
        flat = torch.tensor(np.stack([*position.T, np.ones(50)]), requires_grad=True)
        moving = torch.tensor(np.stack([*velocity.T, np.zeros(50)]), requires_grad=True)
        return goal_loss(flat, moving, torch.tensor(target), torch.tensor(speed)), moving

    outside = np.linalg.norm(target - after, axis=1) > 0.5
    assert np.allclose(loss(before)[0].detach().numpy()[outside], expected[outside])
    found, moving = loss(after)
    assert np.array_equal(found.detach().numpy() == 0, ~outside)
    found.sum().backward()
    assert moving.grad[:, torch.tensor(outside)].abs().sum(0).min() > 0
    at_the_goal, _ = loss(target)
    at_the_goal.sum().backward()  # no direction there, and no slope that is not a number
