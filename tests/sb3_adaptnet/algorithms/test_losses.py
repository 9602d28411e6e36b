"""The reference itself costs nothing; turning with it costs nothing either; slopes point home."""

import numpy as np
import pytest
import torch

from adapt_envs import make_vector
from sb3_adaptnet.algorithms.gradient_taming import GradientTaming, NormLimit
from sb3_adaptnet.algorithms.svg_loss import smoothness_loss
from sb3_adaptnet.algorithms.svg_settings import Episodes, Exploration, LossWeights, grouped
from sb3_adaptnet.algorithms.tracked_motion import TrackedMotion
from sb3_adaptnet.algorithms.tracking_loss import TrackingWeights, tracking_loss, turned
from sb3_adaptnet.algorithms.travel_loss import TravelWeights, travel_loss
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
    motion = TrackedMotion.of(reference, character, torch.device("cpu"))
    state = State.from_mujoco(torch.tensor(reference.qpos).float(), torch.tensor(reference.qvel).float())
    return motion, state, WorldModel(character, Sizes(8, 1)), env.worlds.spec


def test_the_reference_costs_nothing(case):
    motion, state, model, _ = case
    view, phases, rest = model.view(model.kinematics(state)), torch.arange(len(motion)), torch.zeros(len(motion))
    tracked = tracking_loss(state, view.links, motion, phases, rest, TrackingWeights())
    assert tracked.max() < 1e-4
    headings = torch.atan2(view.sin, view.cos) - motion.facing
    speeds = torch.full((len(motion),), motion.mean_speed)
    assert travel_loss(state.velocity, view, motion, phases, headings, speeds, TravelWeights()).max() < 1e-4
    assert (tracking_loss(state, view.links, motion, (phases + 9) % len(motion), rest, TrackingWeights()) > 0).all()


def test_aims_and_poses_agree(case):
    motion, state, model, spec = case
    assert motion.aims.shape == (len(motion), len(model.character.joints))
    assert torch.allclose(motion.angles, state.angles)
    assert torch.allclose(motion.link_weights.mean(), torch.ones(()))
    assert motion.cyclic == (spec.motion == "GooseStep")
    assert np.array_equal(motion.wrapped(np.array([len(motion)])), [0 if motion.cyclic else len(motion) - 1])


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


def test_tamed_gradients_keep_their_direction_and_lose_their_length():
    x = torch.randn(3, 50, requires_grad=True)
    weight = torch.ones(50)
    weight[7] = 1000.0
    (GradientTaming(cap=3.0, decay=0.5)(x * 1.0) * weight).sum().backward()
    lengths = x.grad.norm(dim=0)
    assert torch.allclose(lengths[:7], torch.full((7,), 0.5 * 3**0.5))
    assert torch.allclose(lengths[7], torch.tensor(3 * 0.5 * 3**0.5))


def test_nothing_that_is_not_a_number_passes():
    x = torch.ones(2, 4, requires_grad=True)
    (GradientTaming()(x * 1.0) * torch.tensor([1.0, float("nan"), 1.0, 1.0])).sum().backward()
    assert torch.isfinite(x.grad).all()


def test_the_norm_limit_follows_the_gradients():
    limit, parameter = NormLimit(), torch.nn.Parameter(torch.zeros(4))
    for length in (1.0, 1.0, 100.0):
        parameter.grad = torch.full((4,), length / 2)
        assert limit.apply([parameter]) == pytest.approx(length)
    assert parameter.grad.norm() < 3


def test_smoothness_is_the_squared_change():
    assert torch.equal(smoothness_loss(torch.ones(2, 3), None), torch.zeros(2))
    assert torch.equal(smoothness_loss(torch.ones(2, 3), torch.zeros(2, 3)), torch.full((2,), 3.0))


def test_settings_come_in_groups():
    assert grouped(Exploration, None) == Exploration()
    assert grouped(Exploration, {"std": 0.1}) == Exploration(std=0.1)
    assert grouped(LossWeights, {"position": 2, "facing": 0}).travel == 0.4
    with pytest.raises(ValueError, match="Exploration has no 'noise'; it has std, share"):
        grouped(Exploration, {"noise": 1})
    with pytest.raises(ValueError, match="episodes of 9 to 3 steps"):
        Episodes(fewest_steps=9, most_steps=3)
    with pytest.raises(ValueError, match="turn_rate"):
        Episodes(turn_rate={0: -1.0})


def test_a_looking_around_reference_is_seen_from_its_own_heading(case):
    motion, state, model, _ = case
    frames = model.kinematics(state)
    assert torch.allclose(heading_view(frames, 15).links, motion.links, atol=1e-4)
