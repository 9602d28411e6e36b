"""Soles move as MuJoCo says, and stand where a walk stands."""

import mujoco
import numpy as np
import pytest
import torch

from adapt_envs import make_vector
from sb3_adaptnet.algorithms.tracking.soles import corner_motion, corners_of, standing
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.algorithms.tracking.tracking_loss import TrackingWeights, tracking_loss
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.state import State


@pytest.fixture(scope="module")
def walk():
    env = make_vector("AdaptNet/Humanoid-Walk-v0", 1)
    return env, TrackedMotion.of(Character.of(env.model), torch.device("cpu"), env.reference_gaits([1.3]))


def test_corners_move_as_in_mujoco(walk):
    model, rng = walk[0].model, np.random.default_rng(0)
    character, data = Character.of(model), mujoco.MjData(model)
    data.qpos = [0.3, -0.2, 0.9, *rng.normal(size=4), *rng.uniform(*model.jnt_range[1:].T)]
    mujoco.mj_normalizeQuat(model, data.qpos)
    data.qvel = rng.normal(size=model.nv)
    mujoco.mj_forward(model, data)
    state = State.from_mujoco(torch.tensor(data.qpos)[None].float(), torch.tensor(data.qvel)[None].float())
    links = WorldModel(character, Sizes(8, 1)).kinematics(state)
    heights, squares = corner_motion(links, corners_of(character, torch.device("cpu")))
    for number, (link, point) in enumerate(character.corners):
        body, jacobian = model.body(character.links[link]).id, np.zeros((3, model.nv))
        place = data.xpos[body] + data.xmat[body].reshape(3, 3) @ point
        mujoco.mj_jac(model, data, jacobian, None, place, body)
        assert heights[number, 0].item() == pytest.approx(place[2], abs=1e-5)
        assert squares[number, 0].item() == pytest.approx(np.square((jacobian @ data.qvel)[:2]).sum(), rel=1e-4)


def test_a_walk_stands_on_one_foot_or_two(walk):
    stands = walk[1].standing.view(2, 4, -1).amax(dim=1).sum(dim=0)
    assert set(stands.tolist()) == {1.0, 2.0}
    lifted = walk[1].links.clone()
    lifted[6] += 0.1
    assert standing(lifted, walk[1].corners).sum() == 0


def test_sliding_costs_where_the_reference_stands(walk):
    motion = walk[1]
    phases, rest = torch.arange(len(motion)), torch.zeros(len(motion))
    slid = motion.links.clone()
    slid[1] += 0.3  # everything 0.3 m/s too fast
    reference = walk[0].reference_gaits([1.3])[0]
    state = State.from_mujoco(torch.tensor(reference.qpos).float(), torch.tensor(reference.qvel).float())
    plain, footed = (
        tracking_loss(state, slid, motion, phases, rest, TrackingWeights(footing=weight)) for weight in (0.0, 1.0)
    )
    share = motion.standing.mean(0)
    assert torch.allclose(footed - plain, share * (np.sqrt(10.0) - 1), atol=0.4)  # the reference rolls, too
    still = tracking_loss(state, motion.links, motion, phases, rest, TrackingWeights(footing=1.0))
    assert still.max() < 0.25


def test_soles_that_are_too_low_cost(walk):
    motion, reference = walk[1], walk[0].reference_gaits([1.3])[0]
    phases, rest = torch.arange(len(motion)), torch.zeros(len(motion))
    state = State.from_mujoco(torch.tensor(reference.qpos).float(), torch.tensor(reference.qvel).float())
    lowered = motion.links.clone()
    lowered[6] -= 0.09
    plain, cleared = (
        tracking_loss(state, lowered, motion, phases, rest, TrackingWeights(clearance=weight)) for weight in (0.0, 2.0)
    )
    assert torch.allclose(cleared - plain, torch.tensor(2 * (np.sqrt(10.0) - 1)).float(), atol=1e-3)
    assert tracking_loss(state, motion.links, motion, phases, rest, TrackingWeights(clearance=1.0)).max() < 1e-3
